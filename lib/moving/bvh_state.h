/* SPDX-License-Identifier: MIT */
/*
 * The BVH of a scene that moves: one for each object, in common buffers, below common nodes. So kernels traverse it as
 * that of any tree.
 */
#ifndef SVO_LIB_MOVING_BVH_STATE_H
#define SVO_LIB_MOVING_BVH_STATE_H

#include "moving/state.h"
#include "rays/bvh_fit.h"

/* Most levels of the common nodes: the root, and five below it, since 7 * 8^5 is above SVO_I_MOVING_OBJECTS. */
#define SVO_I_MOVING_TOP_LEVELS 6

/* The BVH of an object. */
typedef struct svo_i_object_bvh {
    svo_i_device_bvh bvh;
    uint64_t identity; /* of the object; 0: there is no BVH */
    uint64_t version; /* of its vertices, in the records */
    uint32_t first_id; /* of its triangles, in the records */
    bool is_placed; /* it has a place in the buffers */
    bool is_written; /* its records are there */
    uint32_t node_room, leaf_room, item_room; /* of its place: nodes, units of 16 bytes, and items of the shape */
    uint32_t item_begin; /* of its place */
    float made_cost; /* what rays cost when it was made, see cost_of in bvh.c */
    svo_bvh_extent extent; /* as it was written last */
} svo_i_object_bvh;

typedef struct svo_i_moving_bvhs {
    svo_i_object_bvh *objects; /* by their indices in the scene */
    uint32_t object_count;
    cl_mem nodes, leaves; /* node 0 is the root */
    cl_mem shape[SVO_I_BVH_SHAPE_BUFFERS]; /* of all but the static mesh, which is not refit */
    uint64_t node_capacity, node_end; /* room, and where places can begin */
    uint64_t leaf_capacity, leaf_end; /* the same of the leaves, in units */
    uint64_t item_capacity, item_end; /* the same of the items of shapes */
    uint64_t still_end; /* where the static mesh's nodes end; the nodes of shapes are those from there on */
    uint64_t top_begin, top_room; /* the common nodes below the root */
} svo_i_moving_bvhs;

/* The objects of the newest tree, with the static mesh. */
static inline uint32_t svo_i_moving_count_parts(const svo_moving *moving)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        count += moving->objects[i].part.is_there ? 1 : 0;
    }
    return count;
}

#endif
