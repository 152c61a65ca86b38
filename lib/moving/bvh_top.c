/* SPDX-License-Identifier: MIT */
/*
 * The nodes above the objects' BVHs, made on the host: there are few. The root has the static mesh and seven groups of
 * objects; a group has objects that are neighbors in Morton order, in eight groups of the same size again, and so on
 * (after Lauterbach et al., "Fast BVH Construction on GPUs", 2009, for nodes of eight).
 */
#include "moving/bvh_top.h"

#include <math.h>
#include <stdlib.h>

#include "core/tree.h"

#define CODE_BITS 10u /* of each axis */

/* An object that rays can meet. */
typedef struct item {
    float low[3], high[3]; /* grid units */
    uint32_t node; /* its root */
    uint32_t code; /* of the box's center */
} item;

/* A node, and the items below it. */
typedef struct group {
    uint32_t first, count;
} group;

typedef struct top {
    uint32_t snap_bits, begin; /* of the grid; the first node below the root */
    item *items;
    svo_ray_node *nodes;
    group *groups; /* of the nodes */
    uint32_t item_count, node_count;
} top;

/* ---- items ---- */

static uint32_t spread_bits(uint32_t value)
{
    uint32_t code = 0;
    for (uint32_t bit = 0; bit < CODE_BITS; ++bit) {
        code |= (value >> bit & 1u) << 3 * bit;
    }
    return code;
}

static item item_of(const svo_i_object_bvh *object, uint32_t snap_bits)
{
    item made = {.node = object->bvh.node_begin};
    for (int axis = 0; axis < 3; ++axis) {
        made.low[axis] = object->extent.low[axis];
        made.high[axis] = -object->extent.high[axis];
        const float center = 0.5F * (made.low[axis] + made.high[axis]); /* 0 .. 2^snap_bits */
        const uint32_t cell = (uint32_t)ldexpf(center, (int)CODE_BITS - (int)snap_bits);
        made.code |= spread_bits(cell < 1u << CODE_BITS ? cell : (1u << CODE_BITS) - 1) << axis;
    }
    return made;
}

static int compare_items(const void *a, const void *b)
{
    const item *first = a;
    const item *second = b;
    return first->code != second->code ? (first->code < second->code ? -1 : 1)
                                       : (first->node > second->node) - (first->node < second->node);
}

/* The static mesh, if it has triangles, then the others in Morton order. Returns how many of the former there are. */
static uint32_t collect_items(const svo_moving *moving, top *t)
{
    uint32_t still = 0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_object_bvh *object = &moving->bvhs->objects[i];
        if (moving->objects[i].part.is_there && object->bvh.item_count > 0) {
            t->items[t->item_count++] = item_of(object, t->snap_bits);
            still += i == 0 ? 1 : 0;
        }
    }
    qsort(t->items + still, t->item_count - still, sizeof *t->items, compare_items);
    return still;
}

/* ---- nodes ---- */

/* Both bounds are rounded down, as by kernels/bvh/refit.cl. */
static uint32_t step_of(const top *t, float bound)
{
    const uint32_t step = (uint32_t)bound >> (t->snap_bits - SVO_RAY_BOX_BITS);
    return step < 0xffffu ? step : 0xffffu;
}

static void set_bound(uint32_t words[12], uint32_t place, int axis, uint32_t step)
{
    const uint32_t shift = 16u * (place % 2u);
    uint32_t *word = &words[4 * axis + (int)(place / 2u)];
    *word = (*word & ~(0xffffu << shift)) | step << shift;
}

/* Sets a child of a node: items that have one box, below a node of their own unless there is one alone. */
static void set_child(top *t, uint32_t node, uint32_t place, group of)
{
    svo_ray_node *to = &t->nodes[node];
    for (int axis = 0; axis < 3; ++axis) {
        float low = t->items[of.first].low[axis];
        float high = t->items[of.first].high[axis];
        for (uint32_t i = of.first + 1; i < of.first + of.count; ++i) {
            low = fminf(low, t->items[i].low[axis]);
            high = fmaxf(high, t->items[i].high[axis]);
        }
        set_bound(to->low, place, axis, step_of(t, low));
        set_bound(to->high, place, axis, step_of(t, high));
    }
    if (of.count == 1) {
        to->child[place] = t->items[of.first].node;
    } else {
        to->child[place] = t->begin + t->node_count - 1;
        t->groups[t->node_count++] = of;
    }
}

/* A node without children: their low bounds are above the high ones. */
static void clear_node(svo_ray_node *node)
{
    for (int i = 0; i < 12; ++i) {
        node->low[i] = 0xffffffffu;
        node->high[i] = 0;
    }
    for (int i = 0; i < 8; ++i) {
        node->child[i] = SVO_RAY_LEAF;
    }
}

/* Divides a node's items among its children from a place on. */
static void divide(top *t, uint32_t node, uint32_t place, group of)
{
    const uint32_t places = 8 - place;
    for (uint32_t i = 0; i < places; ++i) {
        const uint32_t begin = (uint32_t)((uint64_t)of.count * i / places);
        const uint32_t end = (uint32_t)((uint64_t)of.count * (i + 1) / places);
        if (begin < end) {
            set_child(t, node, place + i, (group){of.first + begin, end - begin});
        }
    }
}

/* Nodes are numbered in the order in which their parents are made. still: items of the static mesh, 0 or 1. */
static void make_nodes(top *t, uint32_t still)
{
    clear_node(&t->nodes[0]);
    t->node_count = 1;
    if (still > 0) {
        set_child(t, 0, 0, (group){0, 1});
    }
    divide(t, 0, still, (group){still, t->item_count - still});
    for (uint32_t node = 1; node < t->node_count; ++node) {
        clear_node(&t->nodes[node]);
        divide(t, node, 0, t->groups[node]);
    }
}

/* ---- all of it ---- */

static svo_status write_nodes(const svo_moving *moving, const char *function, cl_command_queue queue, uint64_t begin,
                              uint32_t count, const svo_ray_node *nodes)
{
    const size_t bytes = sizeof *nodes;
    const cl_int error = count > 0 ? clEnqueueWriteBuffer(queue, moving->bvhs->nodes, CL_TRUE, (size_t)begin * bytes,
                                                          count * bytes, nodes, 0, NULL, NULL)
                                   : CL_SUCCESS;
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(moving->device, function, "clEnqueueWriteBuffer", error);
}

svo_status svo_i_moving_make_top(svo_moving *moving, const char *function, cl_command_queue queue)
{
    const svo_i_memory *memory = &moving->device->memory;
    const size_t room = (size_t)moving->object_count + 1;
    svo_status status = SVO_OK;
    top t = {.snap_bits = moving->tree->info.snap_bits,
             .begin = (uint32_t)moving->bvhs->top_begin,
             .items = svo_i_alloc_zeroed(memory, room, sizeof *t.items),
             .nodes = svo_i_alloc_zeroed(memory, room, sizeof *t.nodes),
             .groups = svo_i_alloc_zeroed(memory, room, sizeof *t.groups)};
    if (t.items == NULL || t.nodes == NULL || t.groups == NULL) {
        status = svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects", function,
                                   moving->object_count);
        goto cleanup;
    }
    make_nodes(&t, collect_items(moving, &t));
    SVO_I_TRY_CLEANUP(write_nodes(moving, function, queue, 0, 1, t.nodes));
    SVO_I_TRY_CLEANUP(write_nodes(moving, function, queue, moving->bvhs->top_begin, t.node_count - 1, t.nodes + 1));
cleanup:
    svo_i_free(t.items);
    svo_i_free(t.nodes);
    svo_i_free(t.groups);
    return status;
}
