/* SPDX-License-Identifier: MIT */
/* BVHs below common nodes. */
#ifndef SVO_LIB_RAYS_BVH_PART_H
#define SVO_LIB_RAYS_BVH_PART_H

#include "rays/bvh_device.h"

/* Says where the records of a BVH without any are to lie; svo_i_bvh_refit writes them. It keeps the buffers alive. */
svo_status svo_i_bvh_place(svo_device *device, const char *function, svo_i_device_bvh *bvh, cl_mem nodes, cl_mem leaves,
                           uint32_t node_begin, uint32_t leaf_begin);

/* The root's box in grid units, and what rays through it cost. */
typedef struct svo_i_bvh_extent {
    cl_float low[3];
    cl_float area; /* half those of all nodes and leaves; over half the root's, how many a random ray visits */
    cl_float high[3]; /* negated */
    cl_float unused;
} svo_i_bvh_extent;

/* Enqueues the reading of a BVH's extent after a refit. */
svo_status svo_i_bvh_read_extent(svo_device *device, const char *function, cl_command_queue queue,
                                 const svo_i_device_bvh *bvh, cl_event wait, svo_i_bvh_extent *extent, cl_event *event);

#endif
