/* SPDX-License-Identifier: MIT */
/* BVHs on the device, the geometry of which they are made, and what rays read of them: leaves, and nodes with boxes. */
#ifndef SVO_LIB_RAYS_BVH_FIT_H
#define SVO_LIB_RAYS_BVH_FIT_H

#include "core/device.h"
#include "core/tree.h"
#include "core/work.h"
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

/* The corners of a tree's triangles as the leaves of its BVH hold them. */

/* Three coordinates per vertex; layout.h says in which units. */
typedef struct svo_i_corners {
    cl_mem floats;
    cl_mem doubles; /* NULL: leaves hold floats alone */
    cl_mem made[2]; /* those of them that are not the tree's; svo_i_corners_release releases them */
    bool in_world; /* the floats are in world units */
} svo_i_corners;

/* Finds the corners, or makes them and waits. queue: NULL for the device's own. */
svo_status svo_i_corners_find(const svo_tree *tree, const char *function, cl_command_queue queue, svo_i_corners *out);
void svo_i_corners_release(svo_i_corners *corners);

/* What follows writes leaves, and nodes with their boxes, of BVHs whose shape is made. */

/* Makes the tables of BVHs, which must know where they lie; waits for nothing. *out is all zero on failure. */
svo_status svo_i_bvh_tables_make(svo_device *device, const char *function, const svo_i_device_bvh *const *bvhs,
                                 uint32_t count, svo_i_bvh_tables *out);
void svo_i_bvh_tables_free(svo_i_bvh_tables *tables);
/* Enqueues the fit of BVHs to their triangles of a mesh, all in one set of launches of a work that uses the program
   svo_i_program_bvh. They have their records in the same buffers, and their shapes too: those of any of them. */
svo_status svo_i_bvh_fit(svo_i_device_work *work, const svo_i_bvh_mesh *mesh, const svo_i_device_bvh *any,
                         const svo_i_bvh_tables *tables);
/* Enqueues the fit of a BVH, made with can_refit, to vertices that have moved inside the grid: its nodes keep their
   children. *extent is received with the event. wait: NULL allowed. */
svo_status svo_i_bvh_refit(svo_device *device, const char *function, cl_command_queue queue, const svo_i_bvh_mesh *mesh,
                           const svo_i_device_bvh *bvh, cl_event wait, svo_bvh_extent *extent, cl_event *event);
/* Says where the records of a BVH without any are to lie; svo_i_bvh_fit writes them. It keeps the buffers alive. */
svo_status svo_i_bvh_place(svo_device *device, const char *function, svo_i_device_bvh *bvh, cl_mem nodes, cl_mem leaves,
                           uint32_t node_begin, uint32_t leaf_begin);

#endif
