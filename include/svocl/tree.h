/* SPDX-License-Identifier: MIT */
/** \file
 * The sparse voxel octree.
 *
 * Nodes are stored breadth-first, in Morton order within each level, so that equal occupancy gives equal bytes. Level 0
 * is the root; level depth holds the leaves. Inner node i has child_mask[i], where bit o says whether octant
 * o = x | y << 1 | z << 2 is occupied, and first_child[i], an index into the whole tree. The child in octant o is
 * first_child[i] + popcount(child_mask[i] & ((1 << o) - 1)). Leaves have neither. Payload arrays are parallel to the
 * nodes, leaves included. On the device, payload that is the same in every node is stored once
 * (svo_tree_info.constant).
 *
 * A tree of a workspace (build.h) has no content before its first build, while a build is in flight, and after one that
 * failed. Until svo_tree_finish has returned SVO_OK, every function that reads the tree or takes it for rays returns
 * SVO_INVALID_ARGUMENT with the reason. Exceptions: svo_tree_get_buffer, whose buffers are for kernels that wait for
 * the build's event, svo_camera_fit, and svo_tree_destroy.
 *
 * Thread-safety: several threads may call functions that take a const tree. All others need exclusive use of the tree
 * and of its device handle.
 */
#ifndef SVOCL_TREE_H
#define SVOCL_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/device.h"
#include "svocl/tree_types.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_LEVELS_MAX 18 /**< entries of level_begin: depth + 2 at the largest depth */

/** An octree on a device, on the host, or both. */
typedef struct svo_tree svo_tree;

/** Which mesh rays and nearest points meet. */
typedef enum svo_positions {
    /** The rounded one, svo_tree_arrays.vertices: the tree is from a file of version 1; or it has no rays. */
    SVO_POSITIONS_ROUNDED = 0,
    SVO_POSITIONS_FLOAT = 1, /**< the input's, given as floats */
    SVO_POSITIONS_DOUBLE = 2 /**< the input's, given as doubles */
} svo_positions;

/** What describes a tree besides its arrays. */
typedef struct svo_tree_info {
    size_t struct_size; /**< sizeof(svo_tree_info) */
    uint32_t depth; /**< the grid has 2^depth voxels per axis */
    uint32_t snap_bits; /**< the grid is 2^snap_bits units wide */
    uint32_t coverage; /**< svo_coverage */
    uint32_t need; /**< svo_need bits: what the tree holds */
    uint32_t constant; /**< of those, payload that is the same in every node: one element in device buffers and files */
    uint32_t weights; /**< svo_weights of the payload */
    uint32_t payload_level; /**< first level with payload; payload arrays begin with that level's first node */
    double origin[3]; /**< minimum corner of the grid, world coordinates */
    double edge; /**< width of the grid, world units; nodes.h explains it */
    double scale; /**< grid units per world unit */
    uint64_t triangles; /**< of the mesh */
    uint64_t refused_triangles; /**< of those, not usable: see svo_plan_info */
    uint64_t fragments; /**< (voxel, triangle) pairs */
    uint64_t node_count; /**< inner_count + leaf_count */
    uint64_t inner_count; /**< nodes above level depth */
    uint64_t leaf_count; /**< nodes of level depth */
    uint64_t list_count; /**< entries of all leaf lists; 0 without SVO_NEED_RAYS */
    uint64_t vertex_count; /**< vertices kept for rays */
    uint64_t list_triangle_count; /**< accepted triangles kept for rays */
    uint32_t level_begin[SVO_LEVELS_MAX]; /**< level l has the nodes level_begin[l] .. level_begin[l + 1] - 1 */
    uint32_t positions; /**< svo_positions: which mesh rays meet */
    /** Not 0: voxels and lists are those of the mesh, or the voxels, as given. 0: the tree is from a file of a version
     *  before 4, or from a compact tree's of version 1, and they are those of svo_tree_arrays.vertices, to which the
     *  mesh was rounded. */
    uint32_t is_exact;
    uint64_t ray_bytes; /**< device memory of the BVH; 0 while there is none */
} svo_tree_info;

/** An empty output. */
#define SVO_TREE_INFO_INIT SVO_STRUCT_INIT(svo_tree_info)

/** Host arrays, owned by the tree; NULL where the tree does not hold them. payload_count is
 *  node_count - level_begin[payload_level]: all nodes, unless the plan asked for fewer levels. */
typedef struct svo_tree_arrays {
    size_t struct_size; /**< sizeof(svo_tree_arrays) */
    const uint8_t *child_mask; /**< inner_count */
    const uint32_t *first_child; /**< inner_count */
    const uint8_t *colors; /**< payload_count * 4: RGBA8 */
    const int16_t *normals; /**< payload_count * 3: mean normal, 32767 = 1; its length is at most 1 */
    const uint32_t *list_begin; /**< leaf_count + 1: leaf k has list[list_begin[k]] .. list[list_begin[k + 1] - 1] */
    const uint32_t *list; /**< list_count: indices into triangle_ids, ascending within a leaf */
    /** vertex_count * 3: grid units from origin. Whole numbers of units, if even; an odd number stands for what lies
     *  between its even neighbors. Up to file version 3 the nearest number. */
    const int32_t *vertices;
    const uint32_t *indices; /**< list_triangle_count * 3: into vertices */
    const uint32_t *triangle_ids; /**< list_triangle_count: positions in the mesh's index array, ascending */
    const uint16_t *materials; /**< payload_count: into the mesh's materials */
    const uint16_t *fills; /**< payload_count: surface area inside, 4096 = a face of the node; 65535 = that or more */
    /** leaf_count * 6: the surface inside the leaf that faces rays along +x, -x, +y, -y, +z and -z, as they see it;
     *  4096 = a face of the leaf, 65535 = that or more. See SVO_NEED_PROJECTED_AREA. */
    const uint16_t *areas;
    /** vertex_count * 3: the mesh's own vertices, world units, 0 where no triangle has them; what rays meet. In one of
     *  these arrays, by svo_tree_info.positions. */
    const float *positions;
    const double *positions_double; /**< see positions */
} svo_tree_arrays;

/** An empty output. */
#define SVO_TREE_ARRAYS_INIT SVO_STRUCT_INIT(svo_tree_arrays)

/** The arrays of a tree, with the elements of svo_tree_arrays. */
typedef enum svo_tree_buffer {
    SVO_TREE_CHILD_MASK = 0, /**< "child_mask" */
    SVO_TREE_FIRST_CHILD, /**< "first_child" */
    SVO_TREE_COLORS, /**< "colors" */
    SVO_TREE_NORMALS, /**< "normals" */
    SVO_TREE_LIST_BEGIN, /**< "list_begin" */
    SVO_TREE_LIST, /**< "list" */
    SVO_TREE_VERTICES, /**< "vertices" */
    SVO_TREE_INDICES, /**< "indices" */
    SVO_TREE_TRIANGLE_IDS, /**< "triangle_ids" */
    SVO_TREE_MATERIALS, /**< "materials" */
    SVO_TREE_FILLS, /**< "fills" */
    SVO_TREE_AREAS, /**< "areas" */
    SVO_TREE_POSITIONS, /**< "positions" */
    SVO_TREE_POSITIONS_DOUBLE, /**< "positions_double" */
    SVO_TREE_BUFFER_COUNT, /**< number of arrays */
    /** "build_state": no array, but one svo_build_state, the outcome of the last enqueued build, for kernels that begin
     *  before the host knows it: whether the build succeeded, and the counts of nodes and fragments. Kernels wait for
     *  the event of svo_build_enqueue, before which it is undefined; svo_tree_finish may come later. Trees of a
     *  workspace (svo_workspace_make_tree) have it. A number that new arrays do not move. */
    SVO_TREE_BUILD_STATE = 100
} svo_tree_buffer;

/** Destroys a tree. A build that is filling it is waited for.
 *
 * \param tree set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_tree_destroy(svo_tree **tree);

/** Describes a tree.
 *
 * \param tree not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_tree_get_info(const svo_tree *tree, svo_tree_info *info);

/** A device buffer of the tree. Its elements are those of the host array of the same name, but payload that is constant
 *  has one element. Nothing but svo_build_enqueue writes to it.
 *
 * \param tree not NULL
 * \param buffer which one
 * \returns the buffer, which belongs to the tree; NULL where the tree does not hold it or is not on a device. Retain it
 *          (clRetainMemObject) to keep it longer than the tree and the device handle. */
SVO_API cl_mem svo_tree_get_buffer(const svo_tree *tree, svo_tree_buffer buffer);

/** Copies the arrays to the host. The first call copies; later calls do nothing.
 *
 * \param tree not NULL, without a build in flight
 * \param queue on the context of the tree's device; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT, SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_tree_download(svo_tree *tree, cl_command_queue queue);

/** Copies the arrays of a tree from a file to a device and waits. The first call copies; later calls do nothing.
 *
 * \param tree with host arrays, not on another device
 * \param device must outlive the tree
 * \param queue on the device's context; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT, SVO_CL_ERROR or SVO_OUT_OF_DEVICE_MEMORY on failure. */
SVO_API svo_status svo_tree_upload(svo_tree *tree, svo_device *device, cl_command_queue queue);

/** The host arrays.
 *
 * \param tree not NULL
 * \param arrays receives the pointers; all NULL before svo_tree_download, unless the tree is from a file
 * \returns SVO_INVALID_ARGUMENT when arrays is NULL or its struct_size is too small. */
SVO_API svo_status svo_tree_get_arrays(const svo_tree *tree, svo_tree_arrays *arrays);

/** What a hash covers. */
typedef enum svo_hash_scope {
    SVO_HASH_ALL = 0, /**< nodes, leaf lists and payload */
    SVO_HASH_NODES = 1 /**< nodes alone */
} svo_hash_scope;

#define SVO_HASH_TEXT_BYTES 33 /**< 32 hexadecimal digits and a terminator */

/** Hashes a tree with XXH3-128. The hash does not depend on device, front end or time.
 *
 * It is that of these bytes, one after the other, with seed 0. Numbers are little-endian; names are those of
 * svo_tree_info and svo_tree_arrays.
 *
 *     u32 depth, u32 coverage, u32 0
 *     f64 origin[3], f64 edge
 *     u32 level_begin[0] .. level_begin[depth + 1]
 *     array child_mask: u8 each
 *     array first_child: u32 each
 *
 * and with SVO_HASH_ALL also
 *
 *     array list_begin: u32 each
 *     array list: u32 each
 *     array colors: 4 u8 each
 *     array normals: 3 i16 each
 *     array materials: u16 each
 *     array fills: u16 each
 *     array areas: 6 u16 each, if the tree holds it
 *
 * where snap_bits takes the place of 0 if is_exact is 0, and an array is its length in bytes as u64, then its elements.
 * One that the tree does not hold has length 0, but areas that it does not hold are left out.
 * colors, normals, materials and fills have an element for every node from level_begin[payload_level] on, as on the
 * host: one that is constant, and a single element in files and on the device, is repeated for all of them. vertices,
 * indices, triangle_ids and positions are not covered.
 *
 * \param tree with host arrays
 * \param scope what to cover
 * \param text receives 32 lowercase hexadecimal digits, the high half first
 * \returns SVO_INVALID_ARGUMENT (no host arrays) or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_tree_hash(const svo_tree *tree, svo_hash_scope scope, char text[SVO_HASH_TEXT_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
