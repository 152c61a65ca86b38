/* SPDX-License-Identifier: MIT */
/** \file
 * Signed distance fields: how far the centers of voxels are from a mesh, negative inside, found from its octree.
 *
 * The distance of a voxel is that from its center to the nearest point of the mesh as it was given
 * (svo_tree_info.is_exact), in world units, computed in doubles and rounded to float. The center of voxel x is at
 * origin + (x + 1/2) edge / 2^depth, exactly. The distance is within an ulp of the exact one, or within 2^-45 of the
 * width of a voxel or of the triangles nearby, whichever is more; of slivers, times their length over their height.
 *
 * The sign is that of the rules of solid.h, for each voxel: an empty cell of the octree is inside or outside as a
 * whole, and a voxel that the surface touches is inside if its own center is. A voxel that is inside has the sign bit,
 * also if its distance is 0.
 *
 * There is no query for each voxel. Candidates, the parts of the surface that may be nearest, are handed down from a
 * cell to its children, breadth-first, down to eight voxels that search together. The bytes do not depend on device,
 * threads or order.
 *
 * Thread-safety: svo_sdf_create needs exclusive use of the tree's device handle, svo_sdf_download of that and the
 * field. Several threads may call functions that take a const field.
 */
#ifndef SVOCL_SDF_H
#define SVOCL_SDF_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/solid.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A signed distance field on a device. */
typedef struct svo_sdf svo_sdf;

/** Options of a field. */
typedef struct svo_sdf_options {
    size_t struct_size; /**< sizeof(svo_sdf_options) */
    /** Above 0, at most 65536: a narrow band, of the voxels whose distance is less than so many voxels'
     *  widths. 0: dense, all voxels of the grid. */
    float band;
    uint32_t is_unsigned; /**< not 0: no distance is negative, and nothing looks for the inside */
    svo_solid_rule rule; /**< what is inside: SVO_SOLID_WINDING or SVO_SOLID_PARITY */
    /** Scratch that candidates of one batch of cells should not exceed: fewer cells are then made at a time, with the
     *  same result. 0: 192 MiB. A single cell of a batch takes what it needs. */
    uint64_t batch_bytes;
} svo_sdf_options;

/** All defaults: a dense field with signs by winding numbers. */
#define SVO_SDF_OPTIONS_INIT SVO_STRUCT_INIT(svo_sdf_options)

/** The bytes that a field takes, before it is made. */
typedef struct svo_sdf_plan_info {
    size_t struct_size; /**< sizeof(svo_sdf_plan_info) */
    uint64_t voxel_count; /**< of the field: exact for a dense one; of a band an estimate, usually too large */
    uint64_t result_bytes; /**< device memory of that many voxels: 4 each, in a band 12 each */
    uint64_t scratch_bytes; /**< the most device memory that making it takes besides, released then; an estimate */
} svo_sdf_plan_info;

/** An empty output. */
#define SVO_SDF_PLAN_INFO_INIT SVO_STRUCT_INIT(svo_sdf_plan_info)

/** What a field consists of. */
typedef struct svo_sdf_info {
    size_t struct_size; /**< sizeof(svo_sdf_info) */
    uint32_t depth; /**< the grid has 2^depth voxels per axis */
    float band; /**< voxels; 0: dense */
    uint32_t is_unsigned; /**< not 0: no distance is negative */
    uint32_t rule; /**< svo_solid_rule */
    double origin[3]; /**< minimum corner of the grid, world coordinates */
    double edge; /**< width of the grid, world units */
    double spacing; /**< width of a voxel: edge / 2^depth */
    double first[3]; /**< center of voxel 0, 0, 0: origin + spacing / 2, rounded */
    uint64_t voxel_count; /**< elements of each array */
    /** As in svo_solid_info: columns of voxels whose crossings do not add up to 0. All 0 for a closed mesh, and without
     *  signs. */
    uint64_t open_columns[3];
    uint64_t bytes; /**< device memory of the arrays */
    uint64_t scratch_bytes; /**< the most device memory that making it took besides; it is released */
} svo_sdf_info;

/** An empty output. */
#define SVO_SDF_INFO_INIT SVO_STRUCT_INIT(svo_sdf_info)

/** The arrays of a field. */
typedef enum svo_sdf_buffer {
    /** "distances": a float for each voxel. Dense: in rows along x, then y, then z: voxel x, y, z is at
     *  x + n (y + n z), n = 2^depth. */
    SVO_SDF_DISTANCES = 0,
    SVO_SDF_CODES, /**< "codes": u64, Morton codes of the band's voxels (svo_code_to_cell), ascending; dense: none */
    SVO_SDF_BUFFER_COUNT /**< number of arrays */
} svo_sdf_buffer;

/** Host arrays, owned by the field; NULL before svo_sdf_download, and where it does not hold them. */
typedef struct svo_sdf_arrays {
    size_t struct_size; /**< sizeof(svo_sdf_arrays) */
    const float *distances; /**< voxel_count: see SVO_SDF_DISTANCES */
    const uint64_t *codes; /**< voxel_count: see SVO_SDF_CODES */
} svo_sdf_arrays;

/** An empty output. */
#define SVO_SDF_ARRAYS_INIT SVO_STRUCT_INIT(svo_sdf_arrays)

/** Says what a field will take, without making it.
 *
 * \param tree see svo_sdf_create
 * \param options NULL means all defaults
 * \param info receives the bytes
 * \returns what svo_sdf_create returns for the tree and the options. */
SVO_API svo_status svo_sdf_plan(const svo_tree *tree, const svo_sdf_options *options, svo_sdf_plan_info *info);

/** Makes the field of a tree and waits for it.
 *
 * The field has the voxels of the tree's grid, and no others. A fitted grid ends at the mesh: a caller that wants the
 * whole band gives the plan a grid with so many voxels of room (svo_plan_options.origin and edge).
 *
 * \param tree on a device, with SVO_NEED_RAYS, coverage half-open or closed, the whole mesh inside its grid, at least a
 *        leaf. Voxels 2^-100 .. 2^100 wide
 * \param options NULL means all defaults
 * \param queue on the context of the tree's device, in-order or out-of-order; NULL: the device's own
 * \param out receives the field
 * \returns SVO_INVALID_ARGUMENT (a tree without lists or leaves, with coverage thin; triangles outside its grid;
 *          options), SVO_UNSUPPORTED (the device has no doubles; more than 2^32 - 1 voxels in a band),
 *          SVO_NOT_ON_DEVICE, SVO_COMPILE_FAILED, SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY or SVO_CL_ERROR on
 *          failure. */
SVO_API svo_status svo_sdf_create(const svo_tree *tree, const svo_sdf_options *options, cl_command_queue queue,
                                  svo_sdf **out);

/** Destroys a field.
 *
 * \param sdf set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_sdf_destroy(svo_sdf **sdf);

/** Describes a field.
 *
 * \param sdf not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_sdf_get_info(const svo_sdf *sdf, svo_sdf_info *info);

/** A device buffer of the field.
 *
 * \param sdf not NULL
 * \param buffer which one
 * \returns the buffer, which belongs to the field; NULL where it does not hold it. Retain it (clRetainMemObject) to
 *          keep it longer than the field and the device handle. */
SVO_API cl_mem svo_sdf_get_buffer(const svo_sdf *sdf, svo_sdf_buffer buffer);

/** Copies the arrays to the host. The first call copies; later calls do nothing.
 *
 * \param sdf not NULL
 * \param queue on the context of the field's device; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT, SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_sdf_download(svo_sdf *sdf, cl_command_queue queue);

/** The host arrays.
 *
 * \param sdf not NULL
 * \param arrays receives the pointers; all NULL before svo_sdf_download
 * \returns SVO_INVALID_ARGUMENT when arrays is NULL or its struct_size is too small. */
SVO_API svo_status svo_sdf_get_arrays(const svo_sdf *sdf, svo_sdf_arrays *arrays);

#ifdef __cplusplus
}
#endif

#endif
