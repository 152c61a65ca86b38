/* SPDX-License-Identifier: MIT */
/*
 * The sparse voxel octree.
 *
 * Nodes are stored breadth-first and in Morton order inside each level, so the same occupancy always gives the same
 * bytes. Level 0 is the root, level depth holds the leaves. Node i of an inner level has child_mask[i] (bit o: octant
 * o = x | y << 1 | z << 2 is occupied) and first_child[i], an index into the whole tree; the child in octant o is
 * first_child[i] + popcount(child_mask[i] & ((1 << o) - 1)). Leaves have neither. Payload arrays run parallel to the
 * nodes, leaves included; on the device, payload that is the same in every node is stored once
 * (svo_tree_info.constant).
 *
 * Thread-safety: reading is safe from several threads; upload, download, destroy and what trace.h makes when it is
 * first asked for need exclusive use.
 */
#ifndef SVOCL_TREE_H
#define SVOCL_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/device.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_LEVELS_MAX 18 /* level_begin has depth + 2 entries */

typedef struct svo_tree svo_tree;

/* Header data: plain values. */
typedef struct svo_tree_info {
    size_t struct_size; /* sizeof(svo_tree_info) */
    uint32_t depth;
    uint32_t snap_bits; /* G */
    uint32_t coverage; /* svo_coverage */
    uint32_t need; /* svo_need bits the tree holds */
    uint32_t constant; /* of those, payload that is the same in every node: one element in device buffers and files */
    uint32_t weights; /* svo_weights of its payload */
    uint32_t
        payload_level; /* the first level whose nodes have payload; the arrays begin with that level's first node */
    double origin[3], edge, scale; /* world; q = rint((v - origin) * scale) */
    double snap_error; /* world */
    uint64_t triangles, refused_triangles, fragments;
    uint64_t node_count, inner_count, leaf_count; /* node_count = inner_count + leaf_count */
    uint64_t list_count; /* entries of all leaf lists; 0 without SVO_NEED_RAYS */
    uint64_t vertex_count, list_triangle_count; /* geometry kept for rays: snapped vertices, accepted triangles */
    uint32_t level_begin[SVO_LEVELS_MAX]; /* level_begin[l] .. level_begin[l + 1]: nodes of level l */
} svo_tree_info;
#define SVO_TREE_INFO_INIT SVO_STRUCT_INIT(svo_tree_info)

/* Host copies of the arrays; NULL where the tree does not hold them. Owned by the tree. */
typedef struct svo_tree_arrays {
    size_t struct_size; /* sizeof(svo_tree_arrays) */
    const uint8_t *child_mask; /* inner_count */
    const uint32_t *first_child; /* inner_count */
    /* Of payload_count = node_count - level_begin[payload_level] nodes, all of them unless that was asked for
       otherwise: */
    const uint8_t *colors; /* payload_count * 4: RGBA8 */
    const int16_t *normals; /* payload_count * 3: mean normal, 32767 = 1; its length is at most 1 */
    const uint32_t *list_begin; /* leaf_count + 1: leaf k's triangles are list[list_begin[k] .. list_begin[k + 1]) */
    const uint32_t *list; /* list_count: indices into triangle_ids, ascending inside a leaf */
    const int32_t *vertices; /* vertex_count * 3: snapped */
    const uint32_t *indices; /* list_triangle_count * 3 */
    const uint32_t *triangle_ids; /* list_triangle_count: the mesh's triangle, ascending */
    const uint16_t *materials; /* payload_count: into the mesh's materials */
    const uint16_t
        *fills; /* payload_count: area of the surface inside, 4096 = one face of the node; 65535: that or more */
} svo_tree_arrays;
#define SVO_TREE_ARRAYS_INIT SVO_STRUCT_INIT(svo_tree_arrays)

typedef enum svo_tree_buffer {
    SVO_TREE_CHILD_MASK = 0,
    SVO_TREE_FIRST_CHILD,
    SVO_TREE_COLORS,
    SVO_TREE_NORMALS,
    SVO_TREE_LIST_BEGIN,
    SVO_TREE_LIST,
    SVO_TREE_VERTICES,
    SVO_TREE_INDICES,
    SVO_TREE_TRIANGLE_IDS,
    SVO_TREE_MATERIALS,
    SVO_TREE_FILLS,
    SVO_TREE_BUFFER_COUNT
} svo_tree_buffer;
SVO_API const char *svo_tree_buffer_name(svo_tree_buffer buffer); /* "child_mask", ...; static string */

SVO_API void svo_tree_destroy(svo_tree **tree);
SVO_API svo_status svo_tree_get_info(const svo_tree *tree, svo_tree_info *info);

/* The device buffer, laid out as the host array of the same name, but with one element where the payload is constant;
   NULL where the tree does not hold it or was not uploaded. Nothing writes to it any more. It is the tree's;
   clRetainMemObject makes it yours too, and it then outlives tree and device handle until you release it. */
SVO_API cl_mem svo_tree_get_buffer(const svo_tree *tree, svo_tree_buffer buffer);

/* Copies the arrays to the host, once; later calls do nothing. queue: on the context of the tree's device.
   Returns SVO_CL_ERROR, SVO_OUT_OF_HOST_MEMORY. */
SVO_API svo_status svo_tree_download(svo_tree *tree, cl_command_queue queue);

/* Copies the arrays of a tree that came from a file to a device, once. The device must outlive the tree.
   Returns SVO_CL_ERROR, SVO_OUT_OF_DEVICE_MEMORY. */
SVO_API svo_status svo_tree_upload(svo_tree *tree, svo_device *device, cl_command_queue queue);

/* Host arrays; all NULL before svo_tree_download. */
SVO_API svo_status svo_tree_get_arrays(const svo_tree *tree, svo_tree_arrays *arrays);

typedef enum svo_hash_scope { SVO_HASH_ALL = 0, SVO_HASH_NODES = 1 } svo_hash_scope;
#define SVO_HASH_TEXT_BYTES 33 /* 32 hexadecimal digits and a terminator */

/*
 * XXH3-128 over depth, coverage, snap_bits, origin, edge, level_begin, child masks and first children, then, for
 * SVO_HASH_ALL, over list_begin, list, colors, normals, materials and fills as far as the tree holds them:
 * little-endian, no device, front end or time. Written as 32 lowercase hexadecimal digits, high half first.
 * Returns SVO_INVALID_ARGUMENT before svo_tree_download.
 */
SVO_API svo_status svo_tree_hash(const svo_tree *tree, svo_hash_scope scope, char text[SVO_HASH_TEXT_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
