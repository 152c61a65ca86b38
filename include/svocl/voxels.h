/* SPDX-License-Identifier: MIT */
/** \file
 * Voxels that are given, not made from triangles: a list of places with color and material becomes a tree, and the
 * leaves of a tree become a list. voxel_files.h (svocl::io) reads and writes such lists as files.
 *
 * A list holds each place once, in Morton order from the list's least corner on. Coordinates are whole numbers; voxel
 * (x, y, z) fills the cube from origin + (x, y, z) * voxel_edge to origin + (x + 1, y + 1, z + 1) * voxel_edge in the
 * world. By default a voxel is one world unit wide and the origin is 0, so that the two are the same.
 *
 * A material is a number that the tree carries along (SVO_NEED_MATERIAL). What it means is the caller's, or that of the
 * file: its properties are pairs of texts.
 *
 * Voxels may have normals (SVO_NEED_NORMAL), as nodes of a tree have them: x, y, z in 32767ths, of a length of at most
 * 1. 0, 0, 0 is none. Files of voxels have no normals.
 *
 * Thread-safety: several threads may read a list.
 */
#ifndef SVOCL_VOXELS_H
#define SVOCL_VOXELS_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/build.h"
#include "svocl/device.h"
#include "svocl/memory.h"
#include "svocl/plan.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_VOXELS_MAX        0x80000000u /**< most voxels of a list */
#define SVO_VOXELS_EXTENT_MAX 0x200000 /**< most voxels along an axis, from the least coordinate to the greatest */

/** A voxel. 20 bytes; it does not grow. */
typedef struct svo_voxel {
    int32_t x; /**< -2^30 .. 2^30 */
    int32_t y; /**< -2^30 .. 2^30 */
    int32_t z; /**< -2^30 .. 2^30 */
    uint8_t rgba[4]; /**< color */
    uint16_t material; /**< below 65535 */
    uint16_t reserved; /**< 0 */
} svo_voxel;

/** One property of a material. */
typedef struct svo_voxel_property {
    uint32_t material; /**< below 65535 */
    const char *key; /**< not empty */
    const char *value; /**< may be empty */
} svo_voxel_property;

/** What a list is made from. All arrays are borrowed and copied. */
typedef struct svo_voxels_source {
    size_t struct_size; /**< sizeof(svo_voxels_source) */
    const svo_voxel *voxels; /**< voxel_count, in any order; of several in one place the last one counts */
    uint64_t voxel_count; /**< at most SVO_VOXELS_MAX */
    const svo_voxel_property *properties; /**< property_count; of several with one material and key the last counts */
    size_t property_count; /**< below 2^32 */
    double origin[3]; /**< world position of the least corner of voxel (0, 0, 0); finite */
    double voxel_edge; /**< width of a voxel, world units, finite and above 0; or 0 for 1 */
    /** Host memory of the list, for its whole life, and of what writes it to files; NULL: malloc and free. */
    const svo_memory_callbacks *memory;
    const int16_t *normals; /**< voxel_count * 3: x, y, z of each voxel; NULL: voxels have none */
} svo_voxels_source;

/** No voxels. */
#define SVO_VOXELS_SOURCE_INIT SVO_STRUCT_INIT(svo_voxels_source)

/** A list of voxels, with arrays of its own. */
typedef struct svo_voxels svo_voxels;

/** Which axis is up in a file. Where it is z, (x, y, z) is turned to (x, z, -y) when it is read, so that y is up in
 *  trees and lists, and back when it is written. A voxel at (x, y, z) goes to (x, z, -1 - y): its corners turn. */
typedef enum svo_axes {
    SVO_AXES_AUTO = 0, /**< what the format says: z in .vox, .bt and .las, y in the others */
    SVO_AXES_KEEP = 1, /**< nothing is turned */
    SVO_AXES_Z_UP = 2 /**< z, whatever the format */
} svo_axes;

/** What a list holds. */
typedef struct svo_voxels_info {
    size_t struct_size; /**< sizeof(svo_voxels_info) */
    uint64_t voxel_count; /**< places, each with one voxel */
    uint64_t given_count; /**< voxels that were given, before those in one place became one */
    int32_t low[3]; /**< least coordinates; 0 without voxels */
    int32_t high[3]; /**< greatest coordinates plus 1; 0 without voxels */
    uint32_t depth; /**< of the smallest tree that holds them: at least 1; 0 when that is deeper than SVO_DEPTH_MAX */
    uint32_t material_count; /**< the greatest material of a voxel plus 1; 0 without voxels */
    double origin[3]; /**< of the source */
    double voxel_edge; /**< of the source, 1 in place of 0 */
    uint64_t property_count; /**< properties of materials */
} svo_voxels_info;

/** An empty output. */
#define SVO_VOXELS_INFO_INIT SVO_STRUCT_INIT(svo_voxels_info)

/** Makes a list: sorts the voxels and leaves out all but the last in each place. While it runs it needs 40 bytes for
 *  each voxel given, and 16 more where they have normals.
 *
 * \param source not NULL
 * \param out receives the list
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (a number, a coordinate or the extent is out of range, or memory is not valid) or
 *          SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_voxels_create(const svo_voxels_source *source, svo_voxels **out, svo_message *message);

/** Says which axis is up in files that a list is written to. A list that was read from a file has what
 *  svo_voxels_load_options said, so that the file can be written as it was; others have SVO_AXES_AUTO.
 *
 * \param voxels not NULL
 * \param axes an svo_axes
 * \returns SVO_INVALID_ARGUMENT if there is no such value. */
SVO_API svo_status svo_voxels_set_axes(svo_voxels *voxels, svo_axes axes);

/** Destroys a list.
 *
 * \param voxels set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_voxels_destroy(svo_voxels **voxels);

/** Describes a list.
 *
 * \param voxels not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_voxels_get_info(const svo_voxels *voxels, svo_voxels_info *info);

/** The voxels, each place once, in Morton order: by svo_cell_to_code of the coordinates less svo_voxels_info.low.
 *
 * \param voxels not NULL
 * \returns svo_voxels_info.voxel_count voxels, which belong to the list. */
SVO_API const svo_voxel *svo_voxels_get(const svo_voxels *voxels);

/** The numbers of points that voxels are of, in a list of a point cloud (points.h).
 *
 * \param voxels not NULL
 * \returns svo_voxels_info.voxel_count numbers, in the order of svo_voxels_get, which belong to the list; NULL: the
 *          list is of no cloud. */
SVO_API const uint64_t *svo_voxels_get_counts(const svo_voxels *voxels);

/** The normals of voxels.
 *
 * \param voxels not NULL
 * \returns svo_voxels_info.voxel_count * 3 numbers, in the order of svo_voxels_get, which belong to the list; NULL: the
 *          voxels have none. */
SVO_API const int16_t *svo_voxels_get_normals(const svo_voxels *voxels);

/** The properties of materials, by material; those of one material by key, as bytes.
 *
 * \param voxels not NULL
 * \returns svo_voxels_info.property_count properties, which belong to the list. */
SVO_API const svo_voxel_property *svo_voxels_get_properties(const svo_voxels *voxels);

/** Plans the tree of a list: one leaf per voxel, with its color, normal and material. A node above has the mean of the
 *  colors and of the normals of its leaves, rounded half up, and the material that most of them have, the smaller one
 *  on ties. A leaf without a normal counts as 0, 0, 0.
 *
 *  The grid begins at the least corner of the voxels and has 2^depth of them along each axis. Voxels go through the
 *  kernels of triangles, as points at their centers; so builds, workspaces, budgets, progress and messages are those of
 *  other plans. svo_tree_info.triangles is 0: there are no triangles for rays, but rays through voxels and pictures
 *  work. The plan needs about 100 bytes a voxel on the host, and 40 more while it is made.
 *
 * \param device not NULL; must outlive the plan
 * \param voxels not NULL; not needed afterwards
 * \param depth svo_voxels_info.depth .. 16; 0: that least one
 * \param options NULL means all defaults, with SVO_BUILDER_SORTED. need: any of SVO_NEED_COLOR, SVO_NEED_MATERIAL and,
 *        if the voxels have normals, SVO_NEED_NORMAL; or SVO_NEED_NONE. SVO_NEED_DEFAULT is all of these. coverage,
 *        edge and origin must be 0, updatable too with normals. weights have no meaning: all voxels weigh the same.
 *        fragment_capacity 0: the number of voxels
 * \param out receives the plan
 * \returns what svo_plan_create returns. SVO_INVALID_ARGUMENT also when depth is too small for the voxels, they need
 *          one above SVO_DEPTH_MAX, or the grid's numbers are not finite. The device has the message. */
SVO_API svo_status svo_voxels_plan(svo_device *device, const svo_voxels *voxels, unsigned depth,
                                   const svo_plan_options *options, svo_plan **out);

/** Builds the tree of a list: svo_voxels_plan, svo_build with OpenCL alone, svo_plan_destroy.
 *
 * \param device not NULL; must outlive the tree
 * \param voxels not NULL
 * \param depth as for svo_voxels_plan
 * \param options as for svo_voxels_plan
 * \param queue on the device's context; NULL: the device's own
 * \param out receives the tree
 * \param report receives times and counts, as from svo_build; NULL allowed
 * \returns what svo_voxels_plan and svo_build return. */
SVO_API svo_status svo_voxels_build(svo_device *device, const svo_voxels *voxels, unsigned depth,
                                    const svo_plan_options *options, cl_command_queue queue, svo_tree **out,
                                    svo_build_report *report);

/** The leaves of a tree as a list of voxels: each with the leaf's color, or white, its material, or 0, and its normal
 *  if the tree has normals. Fills, projected areas and leaf lists are of a mesh, and are left out. On a grid
 *  whose voxels are one world unit wide and begin at whole numbers, as svo_voxels_build makes of lists with the default
 *  origin, coordinates are those of the world. On other grids they count from the grid's least corner, which then is
 *  the origin of the list. Host memory comes from where the tree's does. While it runs it needs 20 bytes for each leaf,
 *  and 20 more where the leaves do not begin at the grid's least corner; with normals, 6 and 10 more.
 *
 * \param tree with host arrays (svo_tree_download), with at most SVO_VOXELS_MAX leaves
 * \param out receives the list
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_tree_get_voxels(const svo_tree *tree, svo_voxels **out, svo_message *message);

#ifdef __cplusplus
}
#endif

#endif
