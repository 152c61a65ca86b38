/* SPDX-License-Identifier: MIT */
/*
 * Makes the BVH of a scene's newest tree from those of its objects: kept, refit, or made anew. Objects' triangles are
 * in the world, as the tree has them, so a transform is followed by a refit: rays meet the same floats as in a BVH of
 * the whole mesh, and a ray in an object's own coordinates would be rounded.
 */
#include "moving/bvh.h"

#include <math.h>
#include <stdlib.h>

#include "core/staging.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "core/work.h"
#include "moving/bvh_buffers.h"
#include "plan/update.h"
#include "rays/bvh_fit.h"
#include "rays/programs.h"
#include "rays/rays.h"
#include "stages/sort.h"

static const char function[] = "svo_moving_make_bvh";

/* Costs of rays after a refit that are endured, relative to those when the BVH was made. */
#define DEFAULT_COST_RATIO 1.5F
#define CODE_BITS          10u /* of each axis */

/* ---- the scene's BVHs ---- */

static void forget_object(svo_i_object_bvh *object)
{
    svo_i_bvh_release(&object->bvh);
    *object = (svo_i_object_bvh){.identity = 0};
}

void svo_i_moving_free_bvhs(svo_moving *moving)
{
    svo_i_moving_bvhs *bvhs = moving->bvhs;
    if (bvhs == NULL) {
        return;
    }
    for (uint32_t i = 0; i < bvhs->object_count; ++i) {
        forget_object(&bvhs->objects[i]);
    }
    svo_i_buffer_release(&bvhs->nodes);
    svo_i_buffer_release(&bvhs->leaves);
    for (int i = 0; i < SVO_I_BVH_SHAPE_BUFFERS; ++i) {
        svo_i_buffer_release(&bvhs->shape[i]);
    }
    svo_i_free(bvhs->objects);
    svo_i_free(bvhs);
    moving->bvhs = NULL;
}

/* Room for the BVHs of all objects. Those of objects that are gone are released. */
static svo_status open_bvhs(svo_moving *moving)
{
    const svo_i_memory *memory = &moving->device->memory;
    const uint32_t count = moving->object_count;
    svo_i_moving_bvhs *bvhs =
        moving->bvhs != NULL ? moving->bvhs : (moving->bvhs = svo_i_alloc_zeroed(memory, 1, sizeof *bvhs));
    svo_i_object_bvh *objects = bvhs == NULL ? NULL
                                : count > bvhs->object_count
                                    ? svo_i_grow(memory, bvhs->objects, count * sizeof *objects)
                                    : bvhs->objects;
    if (objects == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects", function,
                                 count);
    }
    bvhs->objects = objects;
    while (bvhs->object_count < count) {
        objects[bvhs->object_count++] = (svo_i_object_bvh){.identity = 0};
    }
    for (uint32_t i = 0; i < count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        const bool is_gone = object->plan == NULL || objects[i].identity != object->identity;
        if (!object->part.is_there && is_gone) {
            forget_object(&objects[i]);
        }
    }
    return SVO_OK;
}

/* ---- the common nodes ---- */

/*
 * The nodes above the objects' BVHs, made on the host: there are few. The root has the static mesh and seven groups of
 * objects; a group has objects that are neighbors in Morton order, in eight groups of the same size again, and so on
 * (after Lauterbach et al., "Fast BVH Construction on GPUs", 2009, for nodes of eight).
 */

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

static svo_status write_nodes(const svo_moving *moving, cl_command_queue queue, uint64_t begin, uint32_t count,
                              const svo_ray_node *nodes)
{
    const size_t bytes = sizeof *nodes;
    return svo_i_device_write(moving->device, function, queue, moving->bvhs->nodes, (size_t)begin * bytes, nodes,
                              count * bytes);
}

/* Makes the common nodes, from the extents of the objects of the newest tree. Waits. */
static svo_status make_top(const svo_moving *moving, cl_command_queue queue)
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
    SVO_I_TRY_CLEANUP(write_nodes(moving, queue, 0, 1, t.nodes));
    SVO_I_TRY_CLEANUP(write_nodes(moving, queue, moving->bvhs->top_begin, t.node_count - 1, t.nodes + 1));
cleanup:
    svo_i_free(t.items);
    svo_i_free(t.nodes);
    svo_i_free(t.groups);
    return status;
}

/* ---- one call ---- */

/* What becomes of an object's BVH. */
typedef enum action { KEEP, REWRITE, REFIT, MAKE } action;

typedef struct pass {
    svo_moving *moving;
    cl_command_queue queue;
    svo_bvh_quality quality;
    float cost_ratio;
    svo_i_corners corners;
    action *actions; /* of the objects */
    const svo_i_device_bvh **fitted; /* BVHs that are written together */
    svo_bvh_extent *extents; /* of these */
    svo_moving_bvh_report report;
} pass;

static const svo_i_moving_part *part_of(const pass *p, uint32_t index)
{
    return &p->moving->objects[index].part;
}

static svo_i_object_bvh *bvh_of(const pass *p, uint32_t index)
{
    return &p->moving->bvhs->objects[index];
}

static svo_i_bvh_mesh mesh_of(const pass *p, uint32_t index)
{
    const svo_i_moving_part *part = part_of(p, index);
    svo_i_bvh_mesh mesh = svo_i_rays_mesh(p->moving->tree, &p->corners);
    mesh.first_vertex = part->first_vertex;
    mesh.vertex_count = part->vertex_count;
    mesh.first_triangle = part->first_triangle;
    mesh.triangle_count = part->triangle_count;
    return mesh;
}

/* The nodes and leaves that a random ray through the object visits. */
static float cost_of(const svo_i_object_bvh *object)
{
    const svo_bvh_extent *extent = &object->extent;
    float width[3];
    for (int axis = 0; axis < 3; ++axis) {
        width[axis] = -extent->high[axis] - extent->low[axis];
    }
    const float root = width[0] * width[1] + width[1] * width[2] + width[2] * width[0];
    return root > 0.0F ? extent->area / root : 0.0F;
}

/* What to do first. Triangles that are partly outside are in the BVH as far as they have voxels; these change. */
static action choose(const pass *p, uint32_t index)
{
    const svo_i_object_bvh *object = bvh_of(p, index);
    const svo_i_moving_part *part = part_of(p, index);
    if (!part->is_there) {
        return KEEP;
    }
    if (object->identity != part->identity) {
        return MAKE;
    }
    if (object->version == part->version) {
        return object->is_written && object->first_id == part->first_id ? KEEP : REWRITE;
    }
    return p->cost_ratio < 1.0F || object->bvh.clips || object->bvh.item_count != part->triangle_count ? MAKE : REFIT;
}

/* Makes an object's BVH, without records. Its place stays if there is room. */
static svo_status make_object(const pass *p, uint32_t index)
{
    svo_i_object_bvh *object = bvh_of(p, index);
    const svo_i_bvh_mesh mesh = mesh_of(p, index);
    const svo_i_bvh_options options = {.quality = index == 0 ? SVO_BVH_BEST : p->quality,
                                       .can_refit = true,
                                       .no_records = true,
                                       .halvings = SVO_I_MOVING_TOP_LEVELS};
    svo_i_device_bvh made;
    SVO_I_TRY(svo_i_bvh_make(p->moving->device, function, p->queue, &mesh, &options, &made));
    made.node_begin = object->bvh.node_begin;
    made.leaf_begin = object->bvh.leaf_begin;
    svo_i_bvh_release(&object->bvh);
    object->bvh = made;
    object->identity = part_of(p, index)->identity;
    object->is_written = false;
    return SVO_OK;
}

/* Whether an object's records are to be written. */
static bool is_due(const pass *p, uint32_t index)
{
    return p->actions[index] != KEEP || (part_of(p, index)->is_there && !bvh_of(p, index)->is_written);
}

/* Writes the records of the first BVHs of p->fitted and reads their extents. */
static svo_status fit(const pass *p, uint32_t count)
{
    svo_device *device = p->moving->device;
    const svo_i_bvh_mesh mesh = svo_i_rays_mesh(p->moving->tree, &p->corners);
    svo_status status = SVO_OK;
    svo_i_bvh_tables tables;
    svo_i_device_work work;
    SVO_I_TRY(svo_i_work_begin(device, function, p->queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_bvh_tables_make(device, function, p->fitted, count, &tables));
    SVO_I_TRY_CLEANUP(svo_i_work_use(&work, &svo_i_program_bvh, svo_i_sort_defines(device)));
    SVO_I_TRY_CLEANUP(svo_i_bvh_fit(&work, &mesh, p->fitted[0], &tables));
    SVO_I_TRY_CLEANUP(svo_i_work_read(&work, tables.extents, 0, p->extents, count * sizeof *p->extents));
cleanup:
    svo_i_work_end(&work);
    svo_i_bvh_tables_free(&tables);
    return status;
}

/* Writes together what is due of the records of the objects from first on. */
static svo_status write_objects(const pass *p, uint32_t first, uint32_t end)
{
    uint32_t count = 0;
    for (uint32_t i = first; i < end; ++i) {
        if (is_due(p, i)) {
            svo_i_device_bvh *bvh = &bvh_of(p, i)->bvh;
            bvh->first_triangle = part_of(p, i)->first_triangle;
            p->fitted[count++] = bvh;
        }
    }
    if (count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(fit(p, count));
    for (uint32_t i = end; i-- > first;) {
        if (is_due(p, i)) {
            svo_i_object_bvh *object = bvh_of(p, i);
            object->extent = p->extents[--count];
            object->version = part_of(p, i)->version;
            object->first_id = part_of(p, i)->first_id;
            object->is_written = true;
        }
    }
    return SVO_OK;
}

/* Whether a refit was in vain: the object is outside now, or rays became too costly. */
static bool is_bad(const pass *p, uint32_t index)
{
    const svo_i_object_bvh *object = bvh_of(p, index);
    return object->extent.outside != 0 || cost_of(object) > p->cost_ratio * object->made_cost;
}

/* Makes, places and writes what is due; each refit is judged and stays, or is to be made. */
static svo_status run_round(pass *p)
{
    const uint32_t count = p->moving->object_count;
    for (uint32_t i = 0; i < count; ++i) {
        SVO_I_TRY(p->actions[i] == MAKE ? make_object(p, i) : SVO_OK);
    }
    SVO_I_TRY(svo_i_moving_place_bvhs(p->moving, function, p->queue));
    SVO_I_TRY(write_objects(p, 0, 1)); /* the static mesh has a shape of its own */
    SVO_I_TRY(write_objects(p, 1, count));
    for (uint32_t i = 0; i < count; ++i) {
        if (p->actions[i] == MAKE) {
            bvh_of(p, i)->made_cost = cost_of(bvh_of(p, i));
            ++p->report.made;
        }
        const bool again = p->actions[i] == REFIT && is_bad(p, i);
        p->report.refit += p->actions[i] == REFIT && !again ? 1 : 0;
        p->actions[i] = again ? MAKE : KEEP;
    }
    return SVO_OK;
}

/* Whether a round has anything to do; always before the first. */
static bool has_work(const pass *p)
{
    bool due = p->moving->bvhs->nodes == NULL;
    for (uint32_t i = 0; i < p->moving->object_count; ++i) {
        due = due || p->actions[i] != KEEP;
    }
    return due;
}

/* Gives the tree the BVH. */
static svo_status hand_over(const pass *p)
{
    const svo_i_moving_bvhs *bvhs = p->moving->bvhs;
    svo_device *device = p->moving->device;
    svo_status status = SVO_OK;
    svo_i_device_bvh whole = {.quality = SVO_BVH_BEST,
                              .node_bytes = bvhs->node_capacity * sizeof(svo_ray_node),
                              .leaf_bytes = bvhs->leaf_capacity * 16 + SVO_RAY_LEAF_HEAD_WORDS * sizeof(cl_uint)};
    for (uint32_t i = 0; i < p->moving->object_count; ++i) {
        const svo_i_device_bvh *bvh = &bvh_of(p, i)->bvh;
        if (part_of(p, i)->is_there) {
            whole.clips = whole.clips || bvh->clips;
            whole.reach = bvh->reach > whole.reach ? bvh->reach : whole.reach;
        }
    }
    SVO_I_TRY_CLEANUP(svo_i_bvh_place(device, function, &whole, bvhs->nodes, bvhs->leaves, 0, 0));
    SVO_I_TRY_CLEANUP(svo_i_rays_take(p->moving->tree, function, &whole, p->corners.in_world));
    return SVO_OK;
cleanup:
    svo_i_bvh_release(&whole);
    return status;
}

static svo_status run(pass *p)
{
    svo_moving *moving = p->moving;
    SVO_I_TRY(svo_i_corners_find(moving->tree, function, p->queue, &p->corners));
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        p->actions[i] = choose(p, i);
    }
    while (has_work(p)) {
        SVO_I_TRY(run_round(p));
    }
    svo_i_bvh_forget_refit(&bvh_of(p, 0)->bvh); /* the static mesh stays */
    SVO_I_TRY(make_top(moving, p->queue));
    return hand_over(p);
}

/* After a failure nothing is sure of the records: the next call makes all anew. */
static svo_status run_pass(pass *p)
{
    const svo_i_memory *memory = &p->moving->device->memory;
    const uint32_t count = p->moving->object_count;
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(open_bvhs(p->moving));
    p->actions = svo_i_alloc_zeroed(memory, count, sizeof *p->actions);
    p->fitted = svo_i_alloc_zeroed(memory, count, sizeof *p->fitted);
    p->extents = svo_i_alloc_zeroed(memory, count, sizeof *p->extents);
    if (p->actions == NULL || p->fitted == NULL || p->extents == NULL) {
        status = svo_i_device_fail(p->moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects", function,
                                   count);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(run(p));
cleanup:
    if (status != SVO_OK) {
        svo_i_moving_free_bvhs(p->moving);
    }
    svo_i_corners_release(&p->corners);
    svo_i_free(p->actions);
    svo_i_free(p->fitted);
    svo_i_free(p->extents);
    return status;
}

/* Whether the newest tree has the scene's BVH. */
static bool is_made(const svo_moving *moving)
{
    const cl_mem nodes = svo_i_rays_buffers(moving->tree).nodes;
    return moving->bvhs != NULL && nodes != NULL && nodes == moving->bvhs->nodes;
}

#define SIZES_OF_REPORT SVO_I_STRUCT_SIZES(svo_moving_bvh_report, total_ms)

static svo_status check(const svo_moving *moving, svo_bvh_quality quality, float cost_ratio,
                        const svo_moving_bvh_report *report)
{
    svo_device *device = moving->device;
    if ((unsigned)quality > SVO_BVH_FAST) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: quality %d is not in 0 .. %d", function,
                                 (int)quality, (int)SVO_BVH_FAST);
    }
    if (!(cost_ratio >= 0.0F)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: cost_ratio %g is not 0 or above", function,
                                 (double)cost_ratio);
    }
    SVO_I_TRY(report != NULL ? svo_i_struct_check(&device->message, function, "report", report, SIZES_OF_REPORT)
                             : SVO_OK);
    return svo_i_rays_check(moving->tree, function);
}

svo_status svo_moving_make_bvh(svo_moving *moving, svo_bvh_quality quality, float cost_ratio, cl_command_queue queue,
                               svo_moving_bvh_report *report)
{
    if (moving == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const double start_ms = svo_i_now_ms();
    pass p = {.moving = moving, .quality = quality, .cost_ratio = cost_ratio == 0.0F ? DEFAULT_COST_RATIO : cost_ratio};
    SVO_I_TRY(check(moving, quality, cost_ratio, report));
    SVO_I_TRY(svo_i_device_queue(moving->device, function, queue, &p.queue));
    SVO_I_TRY(is_made(moving) ? SVO_OK : run_pass(&p));
    p.report.kept = svo_i_moving_count_parts(moving) - p.report.refit - p.report.made;
    p.report.total_ms = svo_i_now_ms() - start_ms;
    if (report != NULL) {
        (void)svo_i_struct_write(NULL, function, "report", &p.report, report, SIZES_OF_REPORT);
    }
    return SVO_OK;
}
