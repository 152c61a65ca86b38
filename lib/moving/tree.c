/* SPDX-License-Identifier: MIT */
/*
 * Makes the tree from a list that is sorted and weighed already: nodes.c, then the stages of builds that make payload.
 * The plan of the static mesh, with the counts of the whole scene, says what the stages do.
 */
#include "moving/tree.h"

#include <string.h>

#include "build/order.h"
#include "moving/nodes.h"
#include "moving/pairs.h"
#include "plan/buffers.h"
#include "plan/configuration.h"
#include "plan/update.h"
#include "stages/filter.h"
#include "stages/material.h"

typedef struct maker {
    svo_moving *moving;
    svo_i_build build;
    const svo_i_kept_list *list;
    svo_i_kept kept;
    svo_build_report discarded;
    cl_mem firsts; /* the first triangle of each object */
} maker;

/* ---- what the mesh brings ---- */

/* The triangles of an object that are in the leaf lists. */
static uint64_t listed_triangles(const svo_i_moving_object *object)
{
    return svo_i_moving_shows(object) ? object->plan->update->kept_triangles : 0;
}

static void fill_info(const maker *m)
{
    const svo_moving *moving = m->moving;
    svo_tree_info *info = &m->build.tree->info;
    svo_i_build_fill_info(&m->build);
    info->triangles = 0;
    info->refused_triangles = 0;
    info->snap_error = 0.0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        if (svo_i_moving_shows(object)) {
            const svo_plan_info *plan = &object->plan->info;
            info->triangles += plan->triangles;
            info->refused_triangles += plan->refused_triangles;
            info->snap_error = plan->snap_error > info->snap_error ? plan->snap_error : info->snap_error;
        }
    }
}

/* An array of the tree: one of the object's, behind those of the objects before it. words: of an element. */
typedef struct part {
    svo_tree_buffer buffer;
    uint32_t words;
    cl_mem from;
    uint64_t first, count; /* elements */
    uint64_t added; /* to each word */
} part;

static svo_status copy_part(maker *m, const part *p)
{
    const svo_moving_params params = {
        .count = (cl_uint)(p->count * p->words), .object = (cl_uint)p->added, .first = (cl_uint)(p->first * p->words)};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(p->from), SVO_I_ARGUMENT(m->build.tree->buffers[p->buffer]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_commands_run(&m->build.commands, m->kept.program, "svo_k_moving_shift", SVO_I_ARGUMENTS(arguments),
                              params.count);
}

/* Where an object begins in the scene. */
typedef struct place {
    uint64_t vertex, listed, triangle;
} place;

static svo_status copy_object(maker *m, const svo_plan *plan, const place *at)
{
    const svo_i_plan_memory *memory = &plan->memory;
    const uint64_t listed = plan->update->kept_triangles;
    const part parts[] = {{SVO_TREE_VERTICES, 3, memory->vertices, at->vertex, plan->vertex_count, 0},
                          {SVO_TREE_INDICES, 3, memory->indices, at->listed, listed, at->vertex},
                          {SVO_TREE_TRIANGLE_IDS, 1, memory->triangle_ids, at->listed, listed, at->triangle},
                          {SVO_TREE_POSITIONS, 3, memory->positions, at->vertex, plan->vertex_count, 0},
                          {SVO_TREE_POSITIONS_DOUBLE, 6, memory->positions_double, at->vertex, plan->vertex_count, 0}};
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; ++i) {
        SVO_I_TRY(parts[i].from != NULL ? copy_part(m, &parts[i]) : SVO_OK);
    }
    return SVO_OK;
}

static svo_status alloc_geometry(maker *m, const place *end)
{
    svo_i_commands *commands = &m->build.commands;
    svo_tree *tree = m->build.tree;
    const svo_i_plan_memory *memory = &m->moving->whole.memory;
    tree->info.vertex_count = end->vertex;
    tree->info.list_triangle_count = end->listed;
    tree->info.positions = SVO_POSITIONS_SNAPPED; /* of thin voxels */
    SVO_I_TRY(svo_i_commands_alloc(commands, "vertices", end->vertex * 12, &tree->buffers[SVO_TREE_VERTICES]));
    SVO_I_TRY(svo_i_commands_alloc(commands, "indices", end->listed * 12, &tree->buffers[SVO_TREE_INDICES]));
    SVO_I_TRY(svo_i_commands_alloc(commands, "triangle_ids", end->listed * 4, &tree->buffers[SVO_TREE_TRIANGLE_IDS]));
    if (memory->positions != NULL) {
        tree->info.positions = SVO_POSITIONS_FLOAT;
        return svo_i_commands_alloc(commands, "positions", end->vertex * 12, &tree->buffers[SVO_TREE_POSITIONS]);
    }
    if (memory->positions_double != NULL) {
        tree->info.positions = SVO_POSITIONS_DOUBLE;
        return svo_i_commands_alloc(commands, "positions_double", end->vertex * 24,
                                    &tree->buffers[SVO_TREE_POSITIONS_DOUBLE]);
    }
    return SVO_OK;
}

static void advance(place *at, const svo_i_moving_object *object)
{
    if (svo_i_moving_shows(object)) {
        at->vertex += object->plan->vertex_count;
        at->listed += listed_triangles(object);
        at->triangle += object->plan->info.triangles;
    }
}

/* The snapped mesh that rays need, of all objects. */
static svo_status make_geometry(maker *m)
{
    const svo_moving *moving = m->moving;
    place end = {0};
    place at = {0};
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        advance(&end, &moving->objects[i]);
    }
    if (end.vertex * 6 >= UINT32_MAX || end.triangle * 3 >= UINT32_MAX) { /* the kernels count words in 32 bits */
        return svo_i_device_fail(moving->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_moving_update: %llu vertices and %llu triangles are too many for rays",
                                 (unsigned long long)end.vertex, (unsigned long long)end.triangle);
    }
    SVO_I_TRY(alloc_geometry(m, &end));
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        if (svo_i_moving_shows(object)) {
            SVO_I_TRY(copy_object(m, object->plan, &at));
        }
        advance(&at, object);
    }
    return SVO_OK;
}

/* ---- lists ---- */

static svo_status write_firsts(maker *m)
{
    svo_moving *moving = m->moving;
    const size_t bytes = moving->object_count * sizeof(uint32_t);
    uint32_t *firsts = svo_i_alloc_zeroed(&moving->device->memory, moving->object_count, sizeof *firsts);
    place at = {0};
    if (firsts == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "svo_moving_update: no memory for %u objects",
                                 moving->object_count);
    }
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        firsts[i] = (uint32_t)at.listed;
        advance(&at, &moving->objects[i]);
    }
    const svo_status status =
        svo_i_device_constants(moving->device, "svo_moving_update", "object_firsts", firsts, bytes, &m->firsts);
    svo_i_free(firsts);
    return status;
}

/* The leaves' lists, which are in the order of the pairs, and the mesh that they name. */
static svo_status make_lists(maker *m)
{
    svo_i_build *build = &m->build;
    cl_mem *list = &build->tree->buffers[SVO_TREE_LIST];
    const svo_moving_params params = {.count = (cl_uint)build->fragment_count};
    build->tree->info.list_count = build->fragment_count;
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, "list", build->fragment_count * 4, list));
    SVO_I_TRY(write_firsts(m));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->list->fragments), SVO_I_ARGUMENT(m->list->values),
                                        SVO_I_ARGUMENT(m->firsts), SVO_I_ARGUMENT(*list), SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_commands_run(&build->commands, m->kept.program, "svo_k_moving_number", SVO_I_ARGUMENTS(arguments),
                                 params.count));
    return make_geometry(m);
}

/* ---- all of it ---- */

static svo_status get_programs(maker *m)
{
    static const svo_i_program_kind kinds[] = {SVO_I_PROGRAM_SORT, SVO_I_PROGRAM_FILTER};
    const svo_plan *plan = &m->moving->whole;
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        char defines[SVO_I_DEFINES_BYTES];
        if (svo_i_plan_needs_program(plan, kinds[i])) {
            svo_i_plan_defines(plan, kinds[i], defines, sizeof defines);
            SVO_I_TRY(svo_i_program_get(plan->device, "svo_moving_update", kinds[i], defines,
                                        &m->build.programs[kinds[i]], NULL));
        }
    }
    return svo_i_moving_program(m->moving, "svo_moving_update", &m->kept.program);
}

/* Lends the list to the build. */
static svo_status lend_list(maker *m)
{
    svo_i_build *build = &m->build;
    svo_i_fragments *chunk = svo_i_alloc_zeroed(&m->moving->device->memory, 1, sizeof *chunk);
    if (chunk == NULL) {
        return svo_i_device_fail(m->moving->device, SVO_OUT_OF_HOST_MEMORY, "svo_moving_update: no memory for a list");
    }
    *chunk = (svo_i_fragments){.buffer = m->list->fragments, .needed = m->list->count, .capacity = m->list->count};
    build->list = (svo_i_fragment_list){.chunks = chunk, .chunk_count = 1};
    build->fragment_count = m->list->count;
    m->kept.values = m->list->values;
    m->kept.materials = m->list->materials;
    build->kept = &m->kept;
    return SVO_OK;
}

/* Takes the list back, and releases what stages have left. */
static void release(maker *m)
{
    svo_i_build *build = &m->build;
    svo_i_free(build->list.chunks);
    build->list = (svo_i_fragment_list){.chunks = NULL};
    svo_i_order_release_scratch(build);
    svo_i_buffer_release(&m->firsts);
    svo_tree_destroy(&build->tree);
}

/* Adds the time since start to a stage of the report, after waiting for it. */
static svo_status tell(maker *m, double *stage_ms, double *start)
{
    if (stage_ms == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_commands_wait(&m->build.commands));
    const double now = svo_i_now_ms();
    *stage_ms += now - *start;
    *start = now;
    return SVO_OK;
}

static svo_status run(maker *m, svo_moving_report *report)
{
    const svo_i_work *work = &m->moving->whole.work;
    svo_i_build *build = &m->build;
    double start = svo_i_now_ms();
    SVO_I_TRY(get_programs(m));
    SVO_I_TRY(lend_list(m));
    fill_info(m);
    SVO_I_TRY(svo_i_moving_nodes(build, m->kept.program));
    SVO_I_TRY(work->lists ? make_lists(m) : SVO_OK);
    SVO_I_TRY(tell(m, report != NULL ? &report->nodes_ms : NULL, &start));
    SVO_I_TRY((work->made & SVO_NEED_MATERIAL) != 0 ? svo_i_material(build) : SVO_OK);
    SVO_I_TRY(work->filter ? svo_i_filter(build) : SVO_OK);
    if (!work->lists) {
        svo_i_commands_free(&build->commands, &build->tree->buffers[SVO_TREE_LIST_BEGIN]);
    }
    SVO_I_TRY(svo_i_commands_wait(&build->commands));
    return tell(m, report != NULL ? &report->payload_ms : NULL, &start);
}

svo_status svo_i_moving_tree(svo_moving *moving, cl_command_queue queue, const svo_i_kept_list *list,
                             svo_moving_report *report, svo_tree **out)
{
    maker m = {.moving = moving, .list = list};
    svo_i_plan_buffers_reset(&moving->whole);
    m.build = (svo_i_build){.commands = svo_i_commands_begin(&moving->whole, queue, &m.discarded),
                            .frontend = moving->frontend,
                            .tree = svo_i_tree_new(&moving->device->memory)};
    m.build.commands.untimed = true;
    if (m.build.tree == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "svo_moving_update: no memory for the tree");
    }
    m.build.tree->device = moving->device;
    const svo_status status = run(&m, report);
    svo_i_commands_end(&m.build.commands);
    svo_i_stage_collect(&m.build.commands);
    if (status == SVO_OK) {
        *out = m.build.tree;
        m.build.tree = NULL;
    }
    release(&m);
    return status;
}
