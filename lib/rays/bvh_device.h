/* SPDX-License-Identifier: MIT */
/* The 8-wide BVH that rays traverse, made on the device from the geometry that a tree has there. */
#ifndef SVO_LIB_RAYS_BVH_DEVICE_H
#define SVO_LIB_RAYS_BVH_DEVICE_H

#include "rays/bvh_fit.h"

typedef struct svo_i_bvh_options {
    svo_bvh_quality quality;
    bool can_refit; /* keep what svo_i_bvh_refit needs */
    bool no_records; /* with can_refit: no nodes and leaves yet; svo_i_bvh_fit writes them */
    uint32_t halvings; /* levels of other nodes above the root, at most SVO_BVH_DEPTH_MAX - 28 */
    /* 0: as the device likes it; the BVH does not depend on them. subtree_items: of SVO_BVH_BEST, at least 64 */
    uint32_t chunk_items, subtree_items;
} svo_i_bvh_options;

/* Makes a BVH and waits for it. *out is all zero on failure; else the caller releases it. */
svo_status svo_i_bvh_make(svo_device *device, const char *function, cl_command_queue queue, const svo_i_bvh_mesh *mesh,
                          const svo_i_bvh_options *options, svo_i_device_bvh *out);
/* Releases what a refit needs. */
void svo_i_bvh_forget_refit(svo_i_device_bvh *bvh);
void svo_i_bvh_release(svo_i_device_bvh *bvh);

#endif
