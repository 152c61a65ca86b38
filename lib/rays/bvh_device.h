/* SPDX-License-Identifier: MIT */
/* The 8-wide BVH that rays traverse, made on the device from the geometry that a tree has there. */
#ifndef SVO_LIB_RAYS_BVH_DEVICE_H
#define SVO_LIB_RAYS_BVH_DEVICE_H

#include "core/device.h"
#include "shared/layout.h"
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

/* What kernels read, and what a refit needs besides. The records may lie in buffers with those of others. */
typedef struct svo_i_device_bvh {
    cl_mem nodes, leaves;
    uint64_t node_bytes, leaf_bytes; /* as if they were alone */
    uint32_t node_begin, leaf_begin; /* the first node, and the units of 16 bytes of other leaves before its own */
    float reach; /* the largest coordinate of a vertex, at least the grid's width */
    bool clips; /* a vertex lies outside the grid */
    svo_bvh_quality quality;

    /* What a refit reads, and its scratch; NULL unless asked for. */
    cl_mem children, order, item_counts, places, leaf_boxes, node_boxes, state;
    uint32_t item_count;
    uint32_t level_count;
    uint32_t level_begin[SVO_BVH_DEPTH_MAX + 1]; /* the first node of each level of nodes, and the number of all */
} svo_i_device_bvh;

typedef struct svo_i_bvh_options {
    svo_bvh_quality quality;
    bool can_refit; /* keep what svo_i_bvh_refit needs */
    bool no_records; /* with can_refit: no nodes and leaves yet, see svo_i_bvh_place */
    uint32_t halvings; /* levels of other nodes above the root, at most SVO_BVH_DEPTH_MAX - 28 */
    /* 0: as the device likes it; the BVH does not depend on them. subtree_items: of SVO_BVH_BEST, at least 64 */
    uint32_t chunk_items, subtree_items;
} svo_i_bvh_options;

/* Makes a BVH and waits for it. *out is all zero on failure; else the caller releases it. */
svo_status svo_i_bvh_make(svo_device *device, const char *function, cl_command_queue queue, const svo_i_bvh_mesh *mesh,
                          const svo_i_bvh_options *options, svo_i_device_bvh *out);
/* Enqueues the fit of a BVH, made with can_refit, to vertices that have moved inside the grid: its nodes keep their
   children. *state receives, with the event, whether a vertex lies outside; the BVH is of no use then. wait: NULL
   allowed. */
svo_status svo_i_bvh_refit(svo_device *device, const char *function, cl_command_queue queue, const svo_i_bvh_mesh *mesh,
                           svo_i_device_bvh *bvh, cl_event wait, svo_bvh_state *state, cl_event *event);
/* Releases what a refit needs. */
void svo_i_bvh_forget_refit(svo_i_device_bvh *bvh);
void svo_i_bvh_release(svo_i_device_bvh *bvh);

#endif
