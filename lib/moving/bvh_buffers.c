/* SPDX-License-Identifier: MIT */
/*
 * The common buffers of the objects' BVHs, in which places are taken one after the other: of records, and of the shapes
 * that refits read, so that all objects are refit together. When they are full, larger ones replace them, without gaps:
 * the records of the static mesh, which has the first place, and all shapes are copied, all other records are written
 * anew.
 */
#include "moving/bvh_buffers.h"

#include "core/work.h"
#include "rays/bvh_fit.h"

/* What a place is larger than its BVH, so that a BVH that is made anew often fits into it: an eighth. */
#define ROOM_LOG2 3
/* The buffers of shapes. */
static const struct {
    const char *name;
    size_t element_bytes;
    bool of_nodes, is_scratch;
} shape_buffers[SVO_I_BVH_SHAPE_BUFFERS] = {
    [SVO_I_BVH_CHILDREN] = {"bvh_children", sizeof(svo_bvh_children), true, false},
    [SVO_I_BVH_ORDER] = {"bvh_order", sizeof(cl_uint), false, false},
    [SVO_I_BVH_ITEM_COUNTS] = {"bvh_item_counts", sizeof(cl_uint), false, false},
    [SVO_I_BVH_PLACES] = {"bvh_places", sizeof(cl_uint), false, false},
    [SVO_I_BVH_NODE_BOXES] = {"bvh_node_boxes", sizeof(cl_float8), true, true},
    [SVO_I_BVH_LEAF_BOXES] = {"bvh_leaf_boxes", sizeof(cl_float8), false, true},
};
/* The empty leaf, which comes first and is that of all objects. */
#define EMPTY_LEAF_UNITS (SVO_RAY_LEAF_HEAD_WORDS / 4)

static const uint32_t index_max = SVO_RAY_LEAF - 1u; /* of nodes, and of units of leaves */

static uint32_t nodes_of(const svo_i_object_bvh *object)
{
    return svo_i_bvh_node_count(&object->bvh);
}

/* Items of an object's shape. */
static uint64_t items_of(const svo_i_object_bvh *object)
{
    return (uint64_t)object->bvh.item_count + 1;
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

static bool has_bvh(const svo_i_object_bvh *object)
{
    return object->identity != 0;
}

/* Whether the BVH fits its place. The static mesh, which has no items there, never changes. */
static bool fits(const svo_i_moving_bvhs *bvhs, const svo_i_object_bvh *object)
{
    const bool is_still = object == &bvhs->objects[0];
    return object->is_placed && nodes_of(object) <= object->node_room && units_of(object) <= object->leaf_room &&
           (is_still || items_of(object) <= object->item_room);
}

/* Takes a place at the end of the buffers; false: they are full. */
static bool take_place(svo_i_moving_bvhs *bvhs, svo_i_object_bvh *object)
{
    const bool is_still = object == &bvhs->objects[0];
    const uint64_t nodes = is_still ? nodes_of(object) : with_room(nodes_of(object));
    const uint64_t units = is_still ? units_of(object) : with_room(units_of(object));
    const uint64_t items = is_still ? 0 : with_room(items_of(object));
    if (bvhs->node_end + nodes > bvhs->node_capacity || bvhs->leaf_end + units > bvhs->leaf_capacity ||
        bvhs->item_end + items > bvhs->item_capacity) {
        return false;
    }
    object->bvh.node_begin = (uint32_t)bvhs->node_end;
    object->bvh.leaf_begin = (uint32_t)bvhs->leaf_end;
    object->item_begin = (uint32_t)bvhs->item_end;
    object->node_room = (uint32_t)nodes;
    object->leaf_room = (uint32_t)units;
    object->item_room = (uint32_t)items;
    object->is_placed = true;
    object->is_written = false;
    bvhs->node_end += nodes;
    bvhs->leaf_end += units;
    bvhs->item_end += items;
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
        if (has_bvh(object) && !fits(bvhs, object) && !take_place(bvhs, object)) {
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

/* What buffers have room for. */
typedef struct room {
    uint64_t nodes, units, items;
    uint64_t still_nodes; /* those of the first nodes that have no shape */
} room;

/* Makes buffers of records, with those of the static mesh if they are written. */
static svo_status make_records(svo_i_moving_bvhs *bvhs, svo_i_device_work *work, const room *of)
{
    const svo_i_object_bvh *still = &bvhs->objects[0];
    const uint64_t node_bytes = still->is_written ? (1 + (uint64_t)nodes_of(still)) * sizeof(svo_ray_node) : 0;
    const uint64_t leaf_bytes = still->is_written ? still->bvh.leaf_bytes : 0;
    cl_mem made[2] = {NULL, NULL};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_work_result(work, "ray_nodes", of->nodes * sizeof(svo_ray_node), &made[0]));
    SVO_I_TRY_CLEANUP(svo_i_work_result(work, "ray_leaves", of->units * 16, &made[1]));
    SVO_I_TRY_CLEANUP(copy_first(work, bvhs->nodes, node_bytes, made[0]));
    SVO_I_TRY_CLEANUP(copy_first(work, bvhs->leaves, leaf_bytes, made[1]));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(work));
    svo_i_buffer_release(&bvhs->nodes);
    svo_i_buffer_release(&bvhs->leaves);
    bvhs->nodes = made[0];
    bvhs->leaves = made[1];
    return SVO_OK;
cleanup:
    svo_i_buffer_release(&made[0]);
    svo_i_buffer_release(&made[1]);
    return status;
}

/* Makes buffers of shapes. Objects keep those alive that they have been in. */
static svo_status make_shapes(svo_i_moving_bvhs *bvhs, svo_i_device_work *work, const room *of)
{
    for (int i = 0; i < SVO_I_BVH_SHAPE_BUFFERS; ++i) {
        const uint64_t count = shape_buffers[i].of_nodes ? of->nodes - of->still_nodes : of->items;
        cl_mem made = NULL;
        SVO_I_TRY(svo_i_work_result(work, shape_buffers[i].name, count * shape_buffers[i].element_bytes, &made));
        svo_i_buffer_release(&bvhs->shape[i]);
        bvhs->shape[i] = made;
    }
    return SVO_OK;
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
    bvhs->item_end = 0;
    bvhs->top_room = 0;
}

/* Room for all BVHs, and half as much again for those that come and grow. */
static room find_room(const svo_moving *moving)
{
    const svo_i_object_bvh *objects = moving->bvhs->objects;
    room of = {.nodes = with_room(svo_i_moving_count_parts(moving)), .still_nodes = 1 + (uint64_t)nodes_of(objects)};
    for (uint32_t i = 1; i < moving->object_count; ++i) {
        if (has_bvh(&objects[i])) {
            of.nodes += with_room(nodes_of(&objects[i]));
            of.units += with_room(units_of(&objects[i]));
            of.items += with_room(items_of(&objects[i]));
        }
    }
    of.nodes += of.still_nodes + of.nodes / 2;
    of.units += EMPTY_LEAF_UNITS + units_of(objects) + of.units / 2;
    of.items += 1 + of.items / 2;
    return of;
}

/* Replaces the buffers by larger ones. */
static svo_status grow(svo_moving *moving, const char *function, cl_command_queue queue)
{
    svo_i_moving_bvhs *bvhs = moving->bvhs;
    const room of = find_room(moving);
    svo_status status = SVO_OK;
    svo_i_device_work work;
    if (of.nodes > index_max || of.units > index_max || of.items > index_max) {
        return svo_i_device_fail(moving->device, SVO_UNSUPPORTED,
                                 "%s: room for the BVHs is %llu nodes, %llu units of leaves and %llu items; at most %u "
                                 "of each can be",
                                 function, (unsigned long long)of.nodes, (unsigned long long)of.units,
                                 (unsigned long long)of.items, index_max);
    }
    SVO_I_TRY(svo_i_work_begin(moving->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(make_records(bvhs, &work, &of));
    SVO_I_TRY_CLEANUP(make_shapes(bvhs, &work, &of));
    bvhs->node_capacity = of.nodes;
    bvhs->leaf_capacity = of.units - EMPTY_LEAF_UNITS;
    bvhs->item_capacity = of.items;
    bvhs->still_end = of.still_nodes;
    forget_places(bvhs);
cleanup:
    svo_i_work_end(&work);
    return status;
}

/* Copies a shape from where it is, buffers of its own or the common ones before, to its place. */
static svo_status move_shape(const svo_i_moving_bvhs *bvhs, svo_i_device_work *work, svo_i_object_bvh *object)
{
    svo_i_device_bvh *bvh = &object->bvh;
    const uint32_t child_begin = bvh->node_begin - (uint32_t)bvhs->still_end;
    for (int i = 0; i < SVO_I_BVH_SHAPE_BUFFERS; ++i) {
        const uint64_t bytes = shape_buffers[i].element_bytes;
        const bool of_nodes = shape_buffers[i].of_nodes;
        const uint64_t count = of_nodes ? nodes_of(object) : items_of(object);
        const uint64_t from = of_nodes ? bvh->child_begin : bvh->item_begin;
        const uint64_t to = of_nodes ? child_begin : object->item_begin;
        if (!shape_buffers[i].is_scratch) {
            SVO_I_TRY(svo_i_work_copy(work, bvh->shape[i], from * bytes, bvhs->shape[i], to * bytes, count * bytes));
        }
        const cl_int error = clRetainMemObject(bvhs->shape[i]);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(work->device, work->function, "clRetainMemObject", error);
        }
        svo_i_buffer_release(&bvh->shape[i]);
        bvh->shape[i] = bvhs->shape[i];
    }
    bvh->child_begin = child_begin;
    bvh->item_begin = object->item_begin;
    return SVO_OK;
}

/* Tells the BVHs of their places, where their shapes go too. That of the static mesh has a buffer of its own. */
static svo_status hand_out(svo_moving *moving, svo_i_device_work *work)
{
    svo_i_moving_bvhs *bvhs = moving->bvhs;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        svo_i_object_bvh *object = &bvhs->objects[i];
        svo_i_device_bvh *bvh = &object->bvh;
        if (has_bvh(object)) {
            SVO_I_TRY(svo_i_bvh_place(moving->device, work->function, bvh, bvhs->nodes, bvhs->leaves, bvh->node_begin,
                                      bvh->leaf_begin));
            SVO_I_TRY(i > 0 && bvh->shape[0] != bvhs->shape[0] ? move_shape(bvhs, work, object) : SVO_OK);
        }
    }
    return SVO_OK;
}

svo_status svo_i_moving_place_bvhs(svo_moving *moving, const char *function, cl_command_queue queue)
{
    svo_i_device_work work;
    if (!take_places(moving)) {
        SVO_I_TRY(grow(moving, function, queue));
        (void)take_places(moving); /* there is room for all */
    }
    SVO_I_TRY(svo_i_work_begin(moving->device, function, queue, &work));
    const svo_status status = hand_out(moving, &work);
    svo_i_work_end(&work);
    return status;
}
