/* SPDX-License-Identifier: MIT */
/*
 * The common buffers of the objects' BVHs, in which places are taken one after the other. When they are full, larger
 * ones replace them: the records of the static mesh, which has the first place, are copied, and all others are written
 * anew, without gaps.
 */
#include "moving/bvh_buffers.h"

#include "core/work.h"

/* What a place is larger than its BVH, so that a BVH that is made anew often fits into it: an eighth. */
#define ROOM_LOG2 3
/* The empty leaf, which comes first and is that of all objects. */
#define EMPTY_LEAF_UNITS (SVO_RAY_LEAF_HEAD_WORDS / 4)

static const uint32_t index_max = SVO_RAY_LEAF - 1u; /* of nodes, and of units of leaves */

static uint32_t nodes_of(const svo_i_object_bvh *object)
{
    return object->bvh.level_begin[object->bvh.level_count];
}

/* Units of an object's leaves, and of what follows the last. */
static uint64_t units_of(const svo_i_object_bvh *object)
{
    return object->bvh.leaf_bytes / 16 - EMPTY_LEAF_UNITS;
}

static uint64_t with_room(uint64_t count)
{
    return count + (count >> ROOM_LOG2);
}

/* Whether the object is in the tree that the BVH is for. */
static bool is_there(const svo_moving *moving, uint32_t index)
{
    return moving->objects[index].part.is_there;
}

static bool fits(const svo_i_object_bvh *object)
{
    return object->is_placed && nodes_of(object) <= object->node_room && units_of(object) <= object->leaf_room;
}

/* Takes a place at the end of the buffers; false: they are full. */
static bool take_place(svo_i_moving_bvhs *bvhs, svo_i_object_bvh *object, bool with_spare)
{
    const uint64_t nodes = with_spare ? with_room(nodes_of(object)) : nodes_of(object);
    const uint64_t units = with_spare ? with_room(units_of(object)) : units_of(object);
    if (bvhs->node_end + nodes > bvhs->node_capacity || bvhs->leaf_end + units > bvhs->leaf_capacity) {
        return false;
    }
    object->bvh.node_begin = (uint32_t)bvhs->node_end;
    object->bvh.leaf_begin = (uint32_t)bvhs->leaf_end;
    object->node_room = (uint32_t)nodes;
    object->leaf_room = (uint32_t)units;
    object->is_placed = true;
    object->is_written = false;
    bvhs->node_end += nodes;
    bvhs->leaf_end += units;
    return true;
}

/* Room for the common nodes, of which there are fewer than objects. */
static bool take_top(svo_i_moving_bvhs *bvhs, uint32_t parts)
{
    if (parts <= bvhs->top_room) {
        return true;
    }
    if (bvhs->node_end + with_room(parts) > bvhs->node_capacity) {
        return false;
    }
    bvhs->top_begin = bvhs->node_end;
    bvhs->top_room = with_room(parts);
    bvhs->node_end += bvhs->top_room;
    return true;
}

/* Places what has no place. The static mesh comes first, and never moves. */
static bool take_places(svo_moving *moving)
{
    svo_i_moving_bvhs *bvhs = moving->bvhs;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        svo_i_object_bvh *object = &bvhs->objects[i];
        if (is_there(moving, i) && !fits(object) && !take_place(bvhs, object, i > 0)) {
            return false;
        }
    }
    return take_top(bvhs, svo_i_moving_count_parts(moving));
}

/* Copies the first records from one buffer to another. */
static svo_status copy_first(svo_i_device_work *work, cl_mem from, uint64_t bytes, cl_mem to)
{
    return from != NULL && bytes > 0 ? svo_i_work_copy(work, from, 0, to, 0, bytes) : SVO_OK;
}

/* Makes buffers of so many nodes and units, with the records of the static mesh if they are written. */
static svo_status make_buffers(svo_i_moving_bvhs *bvhs, svo_i_device_work *work, uint64_t nodes, uint64_t units)
{
    const svo_i_object_bvh *still = &bvhs->objects[0];
    const uint64_t node_bytes = still->is_written ? (1 + (uint64_t)nodes_of(still)) * sizeof(svo_ray_node) : 0;
    const uint64_t leaf_bytes = still->is_written ? still->bvh.leaf_bytes : 0;
    cl_mem made[2] = {NULL, NULL};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_work_result(work, "ray_nodes", nodes * sizeof(svo_ray_node), &made[0]));
    SVO_I_TRY_CLEANUP(svo_i_work_result(work, "ray_leaves", units * 16, &made[1]));
    SVO_I_TRY_CLEANUP(copy_first(work, bvhs->nodes, node_bytes, made[0]));
    SVO_I_TRY_CLEANUP(copy_first(work, bvhs->leaves, leaf_bytes, made[1]));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(work));
    svo_i_buffer_release(&bvhs->nodes);
    svo_i_buffer_release(&bvhs->leaves);
    bvhs->nodes = made[0];
    bvhs->leaves = made[1];
    bvhs->node_capacity = nodes;
    bvhs->leaf_capacity = units - EMPTY_LEAF_UNITS;
    return SVO_OK;
cleanup:
    svo_i_buffer_release(&made[0]);
    svo_i_buffer_release(&made[1]);
    return status;
}

/* Forgets all places but that of the static mesh, if its records are written. */
static void forget_places(svo_i_moving_bvhs *bvhs)
{
    const svo_i_object_bvh *still = &bvhs->objects[0];
    for (uint32_t i = still->is_written ? 1 : 0; i < bvhs->object_count; ++i) {
        bvhs->objects[i].is_placed = false;
        bvhs->objects[i].is_written = false;
        svo_i_buffer_release(&bvhs->objects[i].bvh.nodes);
        svo_i_buffer_release(&bvhs->objects[i].bvh.leaves);
    }
    bvhs->node_end = still->is_placed ? 1 + (uint64_t)still->node_room : 1;
    bvhs->leaf_end = still->is_placed ? still->leaf_room : 0;
    bvhs->top_room = 0;
}

/* Larger buffers: for all objects that are there, and half as much again for those that come and grow. */
static svo_status grow(svo_moving *moving, const char *function, cl_command_queue queue)
{
    svo_i_moving_bvhs *bvhs = moving->bvhs;
    const uint64_t still_nodes = 1 + (uint64_t)nodes_of(&bvhs->objects[0]);
    const uint64_t still_units = EMPTY_LEAF_UNITS + units_of(&bvhs->objects[0]);
    uint64_t nodes = with_room(svo_i_moving_count_parts(moving));
    uint64_t units = 0;
    for (uint32_t i = 1; i < moving->object_count; ++i) {
        nodes += is_there(moving, i) ? with_room(nodes_of(&bvhs->objects[i])) : 0;
        units += is_there(moving, i) ? with_room(units_of(&bvhs->objects[i])) : 0;
    }
    nodes += still_nodes + nodes / 2;
    units += still_units + units / 2;
    if (nodes > index_max || units > index_max) {
        return svo_i_device_fail(moving->device, SVO_UNSUPPORTED, "%s: the scene's triangles are too many for rays",
                                 function);
    }
    svo_i_device_work work;
    SVO_I_TRY(svo_i_work_begin(moving->device, function, queue, &work));
    const svo_status status = make_buffers(bvhs, &work, nodes, units);
    svo_i_work_end(&work);
    SVO_I_TRY(status);
    forget_places(bvhs);
    return SVO_OK;
}

/* Tells the BVHs of their places. */
static svo_status hand_out(svo_moving *moving, const char *function)
{
    svo_i_moving_bvhs *bvhs = moving->bvhs;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        svo_i_device_bvh *bvh = &bvhs->objects[i].bvh;
        SVO_I_TRY(is_there(moving, i) ? svo_i_bvh_place(moving->device, function, bvh, bvhs->nodes, bvhs->leaves,
                                                        bvh->node_begin, bvh->leaf_begin)
                                      : SVO_OK);
    }
    return SVO_OK;
}

svo_status svo_i_moving_place_bvhs(svo_moving *moving, const char *function, cl_command_queue queue)
{
    if (!take_places(moving)) {
        SVO_I_TRY(grow(moving, function, queue));
        (void)take_places(moving); /* there is room for all */
    }
    return hand_out(moving, function);
}
