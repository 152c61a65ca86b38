/* SPDX-License-Identifier: MIT */
/** \file
 * Solids: the inside of a mesh, found from its octree.
 *
 * A voxel is inside if its center is: the lines from the center along +x, +y and +z each add up the crossings of the
 * mesh as it was given (svo_tree_info.is_exact), 1 where they leave through the front of a triangle and -1 where they
 * enter. Edges belong to one of their triangles by the top-left rule and heights are compared as integers: on a closed
 * mesh every line gives the same number. Where the three lines disagree, two of them decide.
 *
 * No surface passes through an empty child of a node, so one voxel of it decides for all, and there is no dense grid.
 * The result is the tree in the form SVO_FORM_DESCRIPTOR with leaves added: the empty children that are inside, each
 * at its own level, which is the highest. Voxels that the surface touches stay leaves, whatever their center. The built
 * tree does not change.
 *
 * Empty children that are connected by faces make a region. If the mesh is closed, as its edges tell, all of a region
 * has the same number: one line of one voxel decides it, and the work grows with the nodes. Else, and where regions are
 * more than a sixteenth of the leaves, each empty child takes three lines. Each leaf adds up the crossings inside it (a
 * crossing is a point of the surface, so it lies in one voxel and the voxel's list has its triangle), and walks along
 * the octree lead from one such sum to the next. For a closed mesh both give the same.
 *
 * By SVO_SOLID_GENERALIZED (Jacobson, Kavan and Sorkine-Hornung 2013), cells of a mesh that is not closed are decided
 * on the host, in the thread that calls: by the crossings along +z, exact, less the solid angles below the edges of the
 * boundary, in doubles with a bound on their error. The result is that of the sum over all edges; clusters of far ones,
 * for a cell or for a cube of cells, stand in for them only where the bound says that they decide the same.
 *
 * Thread-safety: svo_solid_create needs exclusive use of the tree's device handle.
 */
#ifndef SVOCL_SOLID_H
#define SVOCL_SOLID_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/compact.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Which sums of crossings mean inside. */
typedef enum svo_solid_rule {
    SVO_SOLID_WINDING = 0, /**< "winding": other than 0. Closed parts that overlap make their union */
    SVO_SOLID_PARITY = 1, /**< "parity": odd. Where two closed parts overlap it is hollow */
    /** "generalized": for surfaces with large holes. Not lines decide but the share of all directions in which the
     *  surface is seen from behind, less that from the front: the generalized winding number, above 1/2 */
    SVO_SOLID_GENERALIZED = 2
} svo_solid_rule;

/** Receives the progress of svo_solid_create, and may stop it: at the beginning 0, at the end 1, and in between often
 *  where the host decides (SVO_SOLID_GENERALIZED). It must not use the device.
 *
 * \param user progress_user of the options
 * \param fraction 0 .. 1, never less than in the call before
 * \returns 0 to go on. Else the call ends with SVO_CANCELED, and nothing is made. */
typedef int (*svo_solid_progress_callback)(void *user, double fraction);

/** Options of a solid. */
typedef struct svo_solid_options {
    size_t struct_size; /**< sizeof(svo_solid_options) */
    svo_solid_rule rule; /**< what is inside */
    uint8_t color[4]; /**< RGBA8 of the interior leaves, for trees with colors; all 0: opaque white */
    uint16_t material; /**< of the interior leaves, for trees with materials: below 65535, into the mesh's */
    svo_solid_progress_callback progress; /**< NULL: nothing is called */
    void *progress_user; /**< passed to progress */
} svo_solid_options;

/** All defaults. */
#define SVO_SOLID_OPTIONS_INIT SVO_STRUCT_INIT(svo_solid_options)

/** What a solid consists of, and where its surface is not closed. */
typedef struct svo_solid_info {
    size_t struct_size; /**< sizeof(svo_solid_info) */
    uint64_t surface_voxels; /**< leaves of the built tree */
    uint64_t inside_voxels; /**< voxels inside that no surface touches */
    uint64_t inside_leaves; /**< leaves that hold them */
    uint64_t tests; /**< empty children of inner nodes: the cells that are inside or outside as a whole */
    /** Of those, with lines that disagree, where two of three decided. By SVO_SOLID_GENERALIZED: with a number within
     *  2^-32 of 1/2, or within the bound on its error where that is more; they are outside */
    uint64_t ambiguous_cells;
    uint64_t ambiguous_voxels; /**< voxels of those cells, inside or not */
    /** Columns of voxels along x, y and z whose crossings do not add up to 0: the surface has a hole there, or a tear.
     *  All 0 for a closed mesh; then no cell is ambiguous. */
    uint64_t open_columns[3];
    uint64_t scratch_bytes; /**< device memory that finding the inside took; it is released */
    uint64_t regions; /**< of connected cells, decided by a line each; 0: each cell was decided by itself */
    uint64_t boundary_edges; /**< by SVO_SOLID_GENERALIZED: edges that do not cancel, each as often as it is there */
} svo_solid_info;

/** An empty output. */
#define SVO_SOLID_INFO_INIT SVO_STRUCT_INIT(svo_solid_info)

/** Makes the solid of a tree.
 *
 * Interior leaves have the color and material of the options, the normal 0, 0, 0 and the fill 0. The payload of nodes
 * above stays that of the surface.
 *
 * \param tree on a device, with SVO_NEED_RAYS. The whole mesh must lie inside its grid, as on a fitted grid: what is
 *        outside would be missing in the sums. Coverage half-open or closed: thin leaves out voxels that the surface
 *        passes through, so that cells which seem empty lie on both sides of it
 * \param options NULL means all defaults
 * \param queue on the context of the tree's device, in-order or out-of-order; NULL: the device's own
 * \param out receives the solid, in the form SVO_FORM_DESCRIPTOR
 * \param info receives the counts; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (a tree without lists, with coverage thin, or with payload from a payload_level above
 *          0; triangles outside its grid; options), SVO_UNSUPPORTED (more than 2^31 - 1 inner nodes, or
 *          2^32 - 2 nodes with the interior leaves), SVO_NOT_ON_DEVICE, SVO_COMPILE_FAILED, SVO_OUT_OF_HOST_MEMORY,
 *          SVO_OUT_OF_DEVICE_MEMORY, SVO_CL_ERROR or SVO_CANCELED (the progress callback) on failure. */
SVO_API svo_status svo_solid_create(const svo_tree *tree, const svo_solid_options *options, cl_command_queue queue,
                                    svo_compact **out, svo_solid_info *info);

#ifdef __cplusplus
}
#endif

#endif
