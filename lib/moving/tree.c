/* SPDX-License-Identifier: MIT */
/*
 * Makes the tree from a list that is sorted and weighed already: nodes by kernels/moving/nodes.cl, then payload by the
 * stages of builds. The plan of the static mesh, with the counts of the whole scene, says what the stages do.
 */
#include "moving/tree.h"

#include <string.h>

#include "pipeline/run.h"
#include "plan/accounts.h"
#include "plan/configuration.h"
#include "plan/update.h"
#include "shared/moving_layout.h"
#include "stages/build_state.h"
#include "stages/filter.h"
#include "stages/material.h"
#include "stages/programs.h"
#include "stages/sort.h"

_Static_assert(SVO_NODE_LEVELS == SVO_LEVELS_MAX, "kernels have all levels of a tree");

/* ---- nodes ---- */

typedef struct node_maker {
    svo_i_build *build;
    cl_program program;
    svo_node_params params;
    cl_mem counted; /* as of the list */
    cl_mem counts, before; /* of (level, strip), and their exclusive sums */
} node_maker;

static svo_status count_begins(node_maker *m)
{
    svo_i_commands *commands = &m->build->commands;
    const uint64_t cells = (uint64_t)(m->params.depth + 1) * m->params.strips;
    const svo_i_request requests[] = {{"level_counts", cells * 4, &m->counts},
                                      {"level_counts", (cells + 1) * 4, &m->before}};
    SVO_I_TRY(svo_i_commands_alloc_all(commands, SVO_I_REQUESTS(requests)));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->build->list.chunks[0].buffer), SVO_I_ARGUMENT(m->counted),
                                        SVO_I_ARGUMENT(m->counts), SVO_I_ARGUMENT(m->params)};
    SVO_I_TRY(
        svo_i_commands_run(commands, m->program, "svo_k_moving_begins", SVO_I_ARGUMENTS(arguments), m->params.strips));
    return svo_i_scan_lists(m->build, &svo_i_program_sort, m->counts, m->before, NULL,
                            (svo_filter_params){.leaf_count = (cl_uint)cells});
}

/* Makes the state of the sums. */
static svo_status make_state(node_maker *m)
{
    svo_i_build *build = m->build;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->before), SVO_I_ARGUMENT(m->counted),
                                        SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(m->params)};
    return svo_i_commands_run(&build->commands, m->program, "svo_k_moving_levels", SVO_I_ARGUMENTS(arguments),
                              SVO_LEVELS_MAX);
}

/* Sets the tree's counts from the state. Sums that have passed 2^32 are less than those of the level above. */
static svo_status take_state(svo_device *device, const svo_build_state *state, svo_tree_info *info)
{
    for (uint32_t level = 0; level <= info->depth + 1; ++level) {
        info->level_begin[level] = state->level_begin[level];
        if (level > 0 && state->level_begin[level] < state->level_begin[level - 1]) {
            return svo_i_device_fail(device, SVO_OUT_OF_DEVICE_MEMORY,
                                     "svo_moving_update: the tree has more than 2^32 - 1 nodes at level %u; lower the "
                                     "depth",
                                     level - 1);
        }
    }
    info->inner_count = info->level_begin[info->depth];
    info->node_count = info->level_begin[info->depth + 1];
    info->leaf_count = info->node_count - info->inner_count;
    return SVO_OK;
}

/* Masks are written by words. */
static svo_status allocate(svo_i_build *build)
{
    svo_i_commands *commands = &build->commands;
    const svo_tree_info *info = &build->tree->info;
    cl_mem *buffers = build->tree->buffers;
    const uint64_t mask_bytes = (info->inner_count + 3) / 4 * 4;
    SVO_I_TRY(svo_i_commands_alloc(commands, "child_mask", mask_bytes, &buffers[SVO_TREE_CHILD_MASK]));
    SVO_I_TRY(svo_i_commands_fill_zero(commands, buffers[SVO_TREE_CHILD_MASK], mask_bytes));
    SVO_I_TRY(svo_i_commands_alloc(commands, "first_child", info->inner_count * 4, &buffers[SVO_TREE_FIRST_CHILD]));
    return svo_i_commands_alloc(commands, "list_begin", (info->leaf_count + 1) * 4, &buffers[SVO_TREE_LIST_BEGIN]);
}

static svo_status make_nodes(node_maker *m)
{
    svo_i_build *build = m->build;
    svo_build_state *state = &build->host_state;
    SVO_I_TRY(svo_i_build_alloc_state(build));
    SVO_I_TRY(count_begins(m));
    SVO_I_TRY(make_state(m));
    if (build->commands.mode == SVO_I_MODE_RUN) {
        SVO_I_TRY(svo_i_commands_read(&build->commands, build->state, state, sizeof *state));
        SVO_I_TRY(take_state(build->commands.device, state, &build->tree->info));
    }
    SVO_I_TRY(allocate(build));
    const cl_mem *buffers = build->tree->buffers;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.chunks[0].buffer),
                                        SVO_I_ARGUMENT(m->counted),
                                        SVO_I_ARGUMENT(m->before),
                                        SVO_I_ARGUMENT(buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(buffers[SVO_TREE_LIST_BEGIN]),
                                        SVO_I_ARGUMENT(m->params)};
    return svo_i_commands_run(&build->commands, m->program, "svo_k_moving_nodes", SVO_I_ARGUMENTS(arguments),
                              m->params.strips);
}

/* Makes the tree's nodes and the ranges of its leaves, in place of the stage bottom_up. The list is that of the build
   and sorted; program: of kernels/moving; counted: of the list. A build that does not wait has set the most nodes of
   each level in the tree's info; another sets the exact ones here. Leaves them in the state. */
static svo_status make_nodes_of_list(svo_i_build *build, cl_program program, cl_mem counted)
{
    const uint64_t pairs = build->fragment_count > 0 ? build->fragment_count : 1; /* a list without pairs has a root */
    node_maker m = {.build = build, .program = program, .counted = counted};
    m.params = (svo_node_params){.count = (cl_uint)build->fragment_count, .depth = build->tree->info.depth};
    m.params.strips = (cl_uint)((pairs + SVO_NODE_STRIP - 1) / SVO_NODE_STRIP);
    const svo_status status = make_nodes(&m);
    svo_i_commands_free(&build->commands, &m.counts);
    svo_i_commands_free(&build->commands, &m.before);
    return status;
}

/* ---- the tree ---- */

typedef struct maker {
    svo_moving *moving;
    svo_i_build build;
    const svo_i_kept_list *list;
    svo_i_kept kept;
    svo_build_report discarded;
    svo_i_chain *chain;
    const svo_i_moving_news *news; /* NULL: the update waits */
    cl_mem firsts; /* the first triangle of each object in the leaf lists, and the end */
} maker;

/* ---- what the mesh brings ---- */

/* The triangles of an object that are in the leaf lists. */
static uint64_t listed_triangles(const svo_i_moving_object *object)
{
    return svo_i_moving_shows(object) ? object->plan->update->kept_triangles : 0;
}

static void count_triangles(const svo_moving *moving, svo_tree_info *info)
{
    info->triangles = 0;
    info->refused_triangles = 0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        if (svo_i_moving_shows(object)) {
            const svo_plan_info *plan = &object->plan->info;
            info->triangles += plan->triangles;
            info->refused_triangles += plan->refused_triangles;
        }
    }
}

/* An array of the tree: one of the object's, behind those of the objects before it. words: of an element. */
typedef struct part {
    svo_tree_buffer buffer;
    bool listed; /* of the triangles in leaf lists, whose number the device has */
    uint32_t words;
    cl_mem from;
    uint64_t first; /* element; where listed, the object */
    uint64_t count; /* elements; where listed, the most */
    uint64_t added; /* to each word */
} part;

static svo_status copy_part(maker *m, const part *p)
{
    const svo_moving_params params = {.count = (cl_uint)(p->count * p->words),
                                      .other_count = p->words,
                                      .object = (cl_uint)p->added,
                                      .first = (cl_uint)(p->listed ? p->first : p->first * p->words)};
    const cl_mem firsts = p->listed ? m->firsts : NULL;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(p->from), SVO_I_ARGUMENT(m->build.tree->buffers[p->buffer]),
                                        SVO_I_ARGUMENT(firsts), SVO_I_ARGUMENT(params)};
    return svo_i_commands_run(&m->build.commands, m->kept.program, "svo_k_moving_shift", SVO_I_ARGUMENTS(arguments),
                              params.count);
}

/* Where an object begins in the scene. */
typedef struct place {
    uint64_t vertex, listed, triangle;
} place;

static svo_status copy_object(maker *m, uint32_t index, const place *at)
{
    const svo_plan *plan = m->moving->objects[index].plan;
    const svo_i_plan_memory *memory = &plan->memory;
    const uint64_t vertices = plan->vertex_count;
    const uint64_t triangles = plan->triangle_count;
    const bool stored = svo_i_plan_stores_positions(plan);
    const cl_mem floats = stored ? memory->positions : NULL;
    const cl_mem doubles = stored ? memory->positions_double : NULL;
    const part parts[] = {{SVO_TREE_VERTICES, false, 3, memory->vertices, at->vertex, vertices, 0},
                          {SVO_TREE_INDICES, true, 3, memory->indices, index, triangles, at->vertex},
                          {SVO_TREE_TRIANGLE_IDS, true, 1, memory->triangle_ids, index, triangles, at->triangle},
                          {SVO_TREE_POSITIONS, false, 3, floats, at->vertex, vertices, 0},
                          {SVO_TREE_POSITIONS_DOUBLE, false, 6, doubles, at->vertex, vertices, 0}};
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
    tree->info.positions = SVO_POSITIONS_ROUNDED; /* of thin voxels */
    SVO_I_TRY(svo_i_commands_alloc(commands, "vertices", end->vertex * 12, &tree->buffers[SVO_TREE_VERTICES]));
    SVO_I_TRY(svo_i_commands_alloc(commands, "indices", end->listed * 12, &tree->buffers[SVO_TREE_INDICES]));
    SVO_I_TRY(svo_i_commands_alloc(commands, "triangle_ids", end->listed * 4, &tree->buffers[SVO_TREE_TRIANGLE_IDS]));
    if (!svo_i_plan_stores_positions(&m->moving->whole)) {
        return SVO_OK;
    }
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

/* news: where not NULL, the device counts the listed triangles, and the place is after as many as there may be. */
static void advance(place *at, const svo_i_moving_object *object, const svo_i_moving_news *news)
{
    if (svo_i_moving_shows(object)) {
        at->vertex += object->plan->vertex_count;
        at->listed += news != NULL ? object->plan->triangle_count : listed_triangles(object);
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
        advance(&end, &moving->objects[i], m->news);
    }
    if (end.vertex * 6 >= UINT32_MAX || end.triangle * 3 >= UINT32_MAX) { /* the kernels count words in 32 bits */
        return svo_i_device_fail(moving->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "%s: %llu vertices and %llu triangles are too many for rays", m->chain->function,
                                 (unsigned long long)end.vertex, (unsigned long long)end.triangle);
    }
    SVO_I_TRY(alloc_geometry(m, &end));
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        if (svo_i_moving_shows(object)) {
            SVO_I_TRY(copy_object(m, i, &at));
        }
        advance(&at, object, m->news);
    }
    return SVO_OK;
}

/* ---- lists ---- */

/* Puts what the host knows of the objects' triangles into a new buffer. */
static svo_status upload_listed(maker *m, cl_mem *out)
{
    const svo_moving *moving = m->moving;
    const size_t bytes = moving->object_count * sizeof(uint32_t);
    cl_mem known = NULL;
    uint32_t *listed = svo_i_alloc_zeroed(&moving->device->memory, moving->object_count, sizeof *listed);
    if (listed == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects",
                                 m->chain->function, moving->object_count);
    }
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        listed[i] = (uint32_t)listed_triangles(&moving->objects[i]);
    }
    svo_status status = svo_i_device_constants(moving->device, m->chain->function, "listed", listed, bytes, &known);
    svo_i_free(listed);
    SVO_I_TRY_CLEANUP(status);
    SVO_I_TRY_CLEANUP(svo_i_commands_alloc(&m->build.commands, "object_triangles", bytes, out));
    SVO_I_TRY_CLEANUP(svo_i_commands_copy(&m->build.commands, known, *out, 0, bytes));
cleanup:
    svo_i_buffer_release(&known);
    return status;
}

/* Replaces what only the device knows. */
static svo_status count_moved(maker *m, cl_mem listed)
{
    for (uint32_t i = 0; m->news != NULL && i < m->news->moved_count; ++i) {
        const svo_plan *plan = m->moving->objects[m->news->moved[i]].plan;
        const svo_moving_params params = {.count = plan->triangle_count, .object = m->news->moved[i]};
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(plan->update->grid.sums), SVO_I_ARGUMENT(listed),
                                            SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_commands_run(&m->build.commands, m->kept.program, "svo_k_moving_listed",
                                     SVO_I_ARGUMENTS(arguments), 1));
    }
    return SVO_OK;
}

static svo_status make_firsts(maker *m)
{
    svo_status status = SVO_OK;
    svo_i_commands *commands = &m->build.commands;
    const uint32_t objects = m->moving->object_count;
    cl_mem listed = NULL;
    SVO_I_TRY_CLEANUP(upload_listed(m, &listed));
    SVO_I_TRY_CLEANUP(count_moved(m, listed));
    SVO_I_TRY_CLEANUP(
        svo_i_commands_alloc(commands, "object_firsts", (objects + UINT64_C(1)) * sizeof(cl_uint), &m->firsts));
    SVO_I_TRY_CLEANUP(svo_i_scan_lists(&m->build, &svo_i_program_sort, listed, m->firsts, NULL,
                                       (svo_filter_params){.leaf_count = objects}));
cleanup:
    svo_i_commands_free(commands, &listed);
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
    SVO_I_TRY(make_firsts(m));
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(m->list->fragments), SVO_I_ARGUMENT(m->list->values), SVO_I_ARGUMENT(m->firsts),
        SVO_I_ARGUMENT(m->list->counted),   SVO_I_ARGUMENT(*list),           SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_commands_run(&build->commands, m->kept.program, "svo_k_moving_number", SVO_I_ARGUMENTS(arguments),
                                 params.count));
    return make_geometry(m);
}

/* ---- edges ---- */

/* The sums of the edges of all objects whose edges the host knows. */
static svo_i_edge_sums sum_known_edges(const maker *m)
{
    svo_i_edge_sums known = {{0}};
    for (uint32_t i = 0; i < m->moving->object_count; ++i) {
        const svo_i_moving_object *object = &m->moving->objects[i];
        for (unsigned word = 0; word < 2 && svo_i_moving_shows(object); ++word) {
            known.words[word] += object->plan->update->edge_sums.words[word];
        }
    }
    for (uint32_t i = 0; m->news != NULL && i < m->news->moved_count; ++i) {
        const svo_plan *moved = m->moving->objects[m->news->moved[i]].plan;
        known.words[0] -= moved->update->edge_sums.words[0];
        known.words[1] -= moved->update->edge_sums.words[1];
    }
    return known;
}

/* The sums of the scene's edges, zero where its mesh is closed. Edges are those of positions in the world, which do
   not depend on the object, so the sums of objects add up. */
static svo_status sum_edges(maker *m)
{
    svo_status status = SVO_OK;
    svo_i_commands *commands = &m->build.commands;
    const svo_i_edge_sums sums = sum_known_edges(m);
    cl_mem known = NULL;
    SVO_I_TRY_CLEANUP(
        svo_i_device_constants(m->moving->device, m->chain->function, "edges", &sums, sizeof sums, &known));
    SVO_I_TRY_CLEANUP(svo_i_commands_alloc(commands, "edges", sizeof sums, &m->kept.edges));
    SVO_I_TRY_CLEANUP(svo_i_commands_copy(commands, known, m->kept.edges, 0, sizeof sums));
    for (uint32_t i = 0; m->news != NULL && i < m->news->moved_count; ++i) {
        const svo_plan *plan = m->moving->objects[m->news->moved[i]].plan;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(plan->update->edges), SVO_I_ARGUMENT(m->kept.edges)};
        SVO_I_TRY_CLEANUP(
            svo_i_commands_run(commands, m->kept.program, "svo_k_moving_edges", SVO_I_ARGUMENTS(arguments), 1));
    }
cleanup:
    svo_i_buffer_release(&known);
    return status;
}

/* ---- all of it ---- */

static svo_status get_programs(maker *m)
{
    static const svo_i_program *const programs[] = {&svo_i_program_sort, &svo_i_program_filter};
    for (size_t i = 0; i < sizeof programs / sizeof programs[0]; ++i) {
        if (svo_i_plan_needs_program(&m->moving->whole, programs[i])) {
            SVO_I_TRY(svo_i_build_get_program(&m->build, m->chain->function, programs[i], NULL));
        }
    }
    return svo_i_moving_program(m->moving, m->chain->function, &m->kept.program);
}

/* Lends the list to the build. */
static svo_status lend_list(maker *m)
{
    svo_i_build *build = &m->build;
    svo_i_fragments *chunk = svo_i_alloc_zeroed(&m->moving->device->memory, 1, sizeof *chunk);
    if (chunk == NULL) {
        return svo_i_device_fail(m->moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a list",
                                 m->chain->function);
    }
    *chunk = (svo_i_fragments){.buffer = m->list->fragments, .needed = m->list->count, .capacity = m->list->count};
    build->list = (svo_i_fragment_list){.chunks = chunk, .chunk_count = 1};
    build->fragment_count = m->list->count;
    m->kept.values = m->list->values;
    m->kept.materials = m->list->materials;
    m->kept.areas = m->list->areas;
    build->kept = &m->kept;
    return SVO_OK;
}

/* Takes the list back, and releases what stages have left. */
static void release(maker *m)
{
    svo_i_build *build = &m->build;
    svo_i_commands_free(&build->commands, &m->kept.edges);
    svo_i_free(build->list.chunks);
    build->list = (svo_i_fragment_list){.chunks = NULL};
    svo_i_order_release_scratch(build);
    svo_i_commands_free(&build->commands, &m->firsts);
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

/* Sets the tree's counts to the most that there may be: the nodes of the tree before, and one for each new pair. */
static svo_status bound_levels(maker *m)
{
    const svo_tree_info *before = &m->moving->tree->info;
    svo_tree_info *info = &m->build.tree->info;
    uint64_t nodes = 0;
    for (uint32_t level = 0; level <= info->depth; ++level) {
        const uint64_t all = UINT64_C(1) << 3 * level;
        const uint64_t most = before->level_begin[level + 1] - before->level_begin[level] + m->news->pairs;
        info->level_begin[level] = (uint32_t)nodes;
        nodes += most < all ? most : all;
        if (nodes >= UINT32_MAX) {
            return svo_i_device_fail(m->moving->device, SVO_OUT_OF_DEVICE_MEMORY,
                                     "%s: the tree may have more than 2^32 - 2 nodes; svo_moving_update counts them",
                                     m->chain->function);
        }
    }
    info->level_begin[info->depth + 1] = (uint32_t)nodes;
    info->inner_count = info->level_begin[info->depth];
    info->node_count = nodes;
    info->leaf_count = nodes - info->inner_count;
    return SVO_OK;
}

static svo_status run(maker *m, svo_moving_report *report)
{
    const svo_i_work *work = &m->moving->whole.work;
    svo_i_build *build = &m->build;
    double start = svo_i_now_ms();
    SVO_I_TRY(get_programs(m));
    SVO_I_TRY(lend_list(m));
    svo_i_build_fill_info(build);
    count_triangles(m->moving, &build->tree->info);
    SVO_I_TRY(m->news != NULL ? bound_levels(m) : SVO_OK);
    SVO_I_TRY(make_nodes_of_list(build, m->kept.program, m->list->counted));
    SVO_I_TRY(work->lists ? make_lists(m) : SVO_OK);
    SVO_I_TRY(tell(m, report != NULL ? &report->nodes_ms : NULL, &start));
    SVO_I_TRY(svo_i_moving_has_areas(m->moving) ? sum_edges(m) : SVO_OK);
    SVO_I_TRY((work->made & SVO_NEED_MATERIAL) != 0 ? svo_i_material(build) : SVO_OK);
    SVO_I_TRY(work->filter ? svo_i_filter(build) : SVO_OK);
    if (!work->lists) {
        svo_i_commands_free(&build->commands, &build->tree->buffers[SVO_TREE_LIST_BEGIN]);
    }
    if (m->news != NULL) {
        return svo_i_commands_read(&build->commands, build->state, m->news->state, sizeof *m->news->state);
    }
    SVO_I_TRY(svo_i_commands_wait(&build->commands));
    return tell(m, report != NULL ? &report->payload_ms : NULL, &start);
}

static svo_status make_tree(maker *m, svo_moving_report *report, svo_tree **out)
{
    svo_moving *moving = m->moving;
    svo_tree *tree = svo_i_tree_new(&moving->device->memory);
    if (tree == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the tree",
                                 m->chain->function);
    }
    tree->device = moving->device;
    svo_i_plan_buffers_reset(&moving->whole);
    m->build = (svo_i_build){.commands = svo_i_chain_begin_commands(m->chain, &moving->whole, &m->discarded),
                             .frontend = moving->frontend,
                             .tree = tree};
    const svo_status status = run(m, report);
    svo_i_chain_end_commands(m->chain, &m->build.commands, status);
    if (status == SVO_OK) {
        *out = tree;
        m->build.tree = NULL;
    }
    release(m);
    return status;
}

svo_status svo_i_moving_tree(svo_moving *moving, svo_i_chain *chain, const svo_i_kept_list *list,
                             const svo_i_moving_news *news, svo_moving_report *report, svo_tree **out)
{
    maker m = {.moving = moving, .chain = chain, .list = list, .news = news};
    return make_tree(&m, report, out);
}

svo_status svo_i_moving_tree_end(const svo_moving *moving, const svo_build_state *state, svo_tree *tree)
{
    svo_tree_info *info = &tree->info;
    SVO_I_TRY(take_state(moving->device, state, info));
    count_triangles(moving, info);
    info->fragments = state->fragments_low;
    if (moving->whole.work.lists) {
        info->list_count = info->fragments;
        info->list_triangle_count = 0;
        for (uint32_t i = 0; i < moving->object_count; ++i) {
            info->list_triangle_count += listed_triangles(&moving->objects[i]);
        }
    }
    return SVO_OK;
}
