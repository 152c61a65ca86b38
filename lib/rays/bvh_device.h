/* SPDX-License-Identifier: MIT */
/* The 8-wide BVH that rays traverse, made on the device from the geometry that a tree has there. */
#ifndef SVO_LIB_RAYS_BVH_DEVICE_H
#define SVO_LIB_RAYS_BVH_DEVICE_H

#include "core/device.h"
#include "shared/layout.h"
#include "svocl/trace.h"

/* The geometry, as the octree holds it. */
typedef struct svo_i_bvh_mesh {
    cl_mem vertices; /* three coordinates each, grid units; boxes are made from these */
    cl_mem floats, doubles; /* what leaves hold of the vertices: svo_i_corners */
    cl_mem indices; /* three per triangle */
    cl_mem triangle_ids;
    cl_mem list; /* the triangles to include if a vertex lies outside the grid, any number of times each */
    uint64_t vertex_count, list_count;
    uint32_t triangle_count;
    uint32_t snap_bits; /* the grid is 2^snap_bits units wide */
} svo_i_bvh_mesh;

/* What kernels read, and what a refit needs besides. */
typedef struct svo_i_device_bvh {
    cl_mem nodes, leaves;
    uint64_t node_bytes, leaf_bytes;
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
void svo_i_bvh_release(svo_i_device_bvh *bvh);

#endif
