/* SPDX-License-Identifier: MIT */
/* BVHs on the device, and the geometry of which they are made. */
#ifndef SVO_LIB_RAYS_BVH_DATA_H
#define SVO_LIB_RAYS_BVH_DATA_H

#include "core/device.h"
#include "shared/bvh_layout.h"
#include "svocl/trace.h"

/* The geometry, as the octree holds it: all of it, or consecutive triangles. */
typedef struct svo_i_bvh_mesh {
    cl_mem vertices; /* three coordinates each, grid units; boxes are made from these */
    cl_mem floats, doubles; /* what leaves hold of the vertices: svo_i_corners */
    cl_mem indices; /* three per triangle */
    cl_mem triangle_ids;
    cl_mem list; /* the triangles to include if a vertex lies outside the grid, any number of times each */
    uint64_t list_count;
    uint64_t first_vertex, vertex_count; /* those that the triangles use are among them */
    uint32_t first_triangle, triangle_count; /* the BVH's */
    uint32_t snap_bits; /* the grid is 2^snap_bits units wide */
} svo_i_bvh_mesh;

/* What a refit reads, and its scratch: which nodes have which children and items. BVHs may share these buffers. */
typedef enum svo_i_bvh_shape_buffer {
    SVO_I_BVH_CHILDREN, /* of nodes */
    SVO_I_BVH_ORDER, /* of items, and of one more of each BVH */
    SVO_I_BVH_ITEM_COUNTS,
    SVO_I_BVH_PLACES,
    SVO_I_BVH_NODE_BOXES, /* scratch */
    SVO_I_BVH_LEAF_BOXES,
    SVO_I_BVH_SHAPE_BUFFERS
} svo_i_bvh_shape_buffer;

/* What groups do when BVHs are fit to their triangles together. All owned. */
typedef struct svo_i_bvh_tables {
    cl_mem members; /* svo_bvh_member of each BVH */
    cl_mem tiles; /* of all items, then of the nodes of each level, the lowest level first */
    cl_mem extents; /* receives the svo_bvh_extent of each BVH */
    uint32_t count; /* BVHs */
    uint32_t level_count; /* the most of a BVH */
    uint32_t leaf_tiles, level_tiles[SVO_BVH_DEPTH_MAX];
} svo_i_bvh_tables;

/* What kernels read, and what a refit needs besides. The records may lie in buffers with those of others. */
typedef struct svo_i_device_bvh {
    cl_mem nodes, leaves;
    uint64_t node_bytes, leaf_bytes; /* as if they were alone */
    uint32_t node_begin, leaf_begin; /* the first node, and the units of 16 bytes of other leaves before its own */
    float reach; /* the largest coordinate of a vertex, at least the grid's width */
    bool clips; /* a vertex lies outside the grid */
    svo_bvh_quality quality;

    svo_i_bvh_tables tables; /* of a BVH that was made with records and can be refit; else NULL */
    cl_mem shape[SVO_I_BVH_SHAPE_BUFFERS]; /* NULL unless asked for */
    uint32_t child_begin, item_begin; /* its first node and its first item there */
    uint32_t first_triangle; /* of the mesh */
    uint32_t item_count;
    uint32_t level_count;
    uint32_t level_begin[SVO_BVH_DEPTH_MAX + 1]; /* the first node of each level of nodes, and the number of all */
} svo_i_device_bvh;

static inline uint32_t svo_i_bvh_node_count(const svo_i_device_bvh *of)
{
    return of->level_begin[of->level_count];
}

#endif
