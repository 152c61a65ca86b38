/* SPDX-License-Identifier: MIT */
/*
 * Makes the tree of the builder "sorted". The codes of a level follow from those of the level below. One count gives
 * the sizes of all levels, so nothing runs twice. The sorted list already has the order of the leaf lists.
 */
#include "stages/bottom_up.h"

#include "stages/programs.h"
#include "stages/sort.h"

typedef struct level_maker {
    svo_i_build *build;
    cl_mem flags, indices; /* of a level: 1 where a node begins, and the exclusive sums of that */
    cl_mem codes[2]; /* Morton codes of nodes; index: distance of the level from the leaves, modulo 2 */
    cl_mem level_counts;
} level_maker;

static svo_status launch(level_maker *m, const char *name, const svo_i_argument *arguments, cl_uint argument_count,
                         uint64_t items)
{
    return svo_i_commands_run(&m->build->commands, svo_i_build_program(m->build, &svo_i_program_sort), name, arguments,
                              argument_count, items);
}

/* Counts the nodes of all levels. Adjacent fragments have different nodes from some level on. */
static svo_status read_counts(level_maker *m, cl_uint counts[SVO_LEVELS_MAX])
{
    svo_i_build *build = m->build;
    const size_t bytes = SVO_LEVELS_MAX * sizeof *counts;
    const svo_bottom_up_params params = {.depth = build->tree->info.depth,
                                         .count = (cl_uint)build->fragment_count,
                                         .triangle_count = build->commands.plan->triangle_count};
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, "level_counts", bytes, &m->level_counts));
    SVO_I_TRY(svo_i_commands_fill_zero(&build->commands, m->level_counts, bytes));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.chunks[0].buffer), SVO_I_ARGUMENT(m->level_counts),
                                        SVO_I_ARGUMENT(params), SVO_I_LOCAL(SVO_LEVELS_MAX * sizeof(cl_uint))};
    SVO_I_TRY(launch(m, "svo_k_bottom_up_count", SVO_I_ARGUMENTS(arguments), build->fragment_count));
    return svo_i_commands_read(&build->commands, m->level_counts, counts, bytes);
}

/* Sets the tree's counts, and where each level begins. */
static svo_status take_counts(svo_i_build *build, const cl_uint counts[SVO_LEVELS_MAX])
{
    svo_tree_info *info = &build->tree->info;
    uint64_t nodes = 0;
    uint64_t begin = 0;
    for (uint32_t level = 0; level <= info->depth; ++level) {
        nodes += level == 0 ? 1 : counts[level]; /* the root exists even without fragments */
        info->level_begin[level] = (uint32_t)begin;
        begin += level == 0 || build->fragment_count > 0 ? nodes : 0;
        info->level_begin[level + 1] = (uint32_t)begin;
    }
    if (begin >= UINT32_MAX) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the tree has %llu nodes, above 2^32 - 2; lower the depth",
                                 (unsigned long long)begin);
    }
    info->inner_count = info->level_begin[info->depth];
    info->node_count = info->level_begin[info->depth + 1];
    info->leaf_count = info->node_count - info->inner_count;
    return SVO_OK;
}

static svo_status count_levels(level_maker *m)
{
    svo_i_build *build = m->build;
    cl_uint counts[SVO_LEVELS_MAX] = {0};
    SVO_I_TRY(read_counts(m, counts));
    if (build->commands.mode == SVO_I_MODE_MEASURE) {
        return SVO_OK; /* the counts remain capacities */
    }
    return counts[build->tree->info.depth + 1] != 0 ? svo_i_build_fail_damaged(build) : take_counts(build, counts);
}

static svo_status allocate_nodes(level_maker *m)
{
    svo_i_build *build = m->build;
    const svo_tree_info *info = &build->tree->info;
    const uint64_t code_bytes = info->depth > SVO_CODE30_DEPTH_MAX ? 8 : 4;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, "child_mask", info->inner_count,
                                   &build->tree->buffers[SVO_TREE_CHILD_MASK]));
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, "first_child", info->inner_count * 4,
                                   &build->tree->buffers[SVO_TREE_FIRST_CHILD]));
    const svo_i_request requests[] = {{"begin_flags", build->fragment_count * 4, &m->flags},
                                      {"begin_flags", (build->fragment_count + 1) * 4, &m->indices},
                                      {"level_codes", info->leaf_count * code_bytes, &m->codes[0]},
                                      {"level_codes", parents * code_bytes, &m->codes[1]}};
    return svo_i_commands_alloc_all(&build->commands, SVO_I_REQUESTS(requests));
}

/* Numbers the nodes of a sequence of codes, in the order of their first code. */
static svo_status number_nodes(level_maker *m, cl_mem codes, svo_bottom_up_params params)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(codes), SVO_I_ARGUMENT(m->flags), SVO_I_ARGUMENT(params)};
    SVO_I_TRY(launch(m, "svo_k_bottom_up_flags", SVO_I_ARGUMENTS(arguments), params.count));
    return svo_i_scan_lists(m->build, &svo_i_program_sort, m->flags, m->indices, NULL,
                            (svo_filter_params){.leaf_count = params.count});
}

static svo_status make_leaves(level_maker *m)
{
    svo_i_build *build = m->build;
    cl_mem fragments = build->list.chunks[0].buffer;
    const svo_bottom_up_params params = {.depth = build->tree->info.depth,
                                         .count = (cl_uint)build->fragment_count,
                                         .of_fragments = 1,
                                         .node_begin = (cl_uint)build->tree->info.inner_count};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(fragments), SVO_I_ARGUMENT(m->indices),
                                        SVO_I_ARGUMENT(build->cursors[0]), SVO_I_ARGUMENT(m->codes[0]),
                                        SVO_I_ARGUMENT(params)};
    SVO_I_TRY(number_nodes(m, fragments, params));
    return launch(m, "svo_k_bottom_up_leaves", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status make_level(level_maker *m, uint32_t level)
{
    const svo_tree *tree = m->build->tree;
    const uint32_t *begin = tree->info.level_begin;
    const bool odd = (tree->info.depth - level) % 2 != 0;
    cl_mem children = m->codes[odd ? 0 : 1];
    cl_mem nodes = m->codes[odd ? 1 : 0];
    const svo_bottom_up_params params = {.depth = tree->info.depth,
                                         .count = begin[level + 2] - begin[level + 1],
                                         .shift = 3,
                                         .node_begin = begin[level],
                                         .child_begin = begin[level + 1]};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(children),
                                        SVO_I_ARGUMENT(m->indices),
                                        SVO_I_ARGUMENT(nodes),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(params)};
    SVO_I_TRY(number_nodes(m, children, params));
    return launch(m, "svo_k_bottom_up_nodes", SVO_I_ARGUMENTS(arguments), params.count);
}

/* Makes a root without children, for a tree without leaves. */
static svo_status make_empty_root(level_maker *m)
{
    svo_i_build *build = m->build;
    const cl_uint first_child = 1;
    SVO_I_TRY(svo_i_commands_fill_zero(&build->commands, build->tree->buffers[SVO_TREE_CHILD_MASK], 1));
    return svo_i_commands_fill(&build->commands, build->tree->buffers[SVO_TREE_FIRST_CHILD], &first_child,
                               sizeof first_child, sizeof first_child);
}

static svo_status make_nodes(level_maker *m)
{
    const svo_tree *tree = m->build->tree;
    SVO_I_TRY(svo_i_build_alloc_cursors(m->build));
    SVO_I_TRY(count_levels(m));
    SVO_I_TRY(svo_i_build_put_state(m->build, tree->info.level_begin));
    SVO_I_TRY(allocate_nodes(m));
    if (m->build->fragment_count == 0) {
        return make_empty_root(m);
    }
    SVO_I_TRY(make_leaves(m));
    for (uint32_t level = tree->info.depth; level-- > 0;) {
        SVO_I_TRY(make_level(m, level));
    }
    return SVO_OK;
}

svo_status svo_i_bottom_up(svo_i_build *build)
{
    level_maker m = {.build = build};
    cl_mem *buffers[] = {&m.flags, &m.indices, &m.codes[0], &m.codes[1], &m.level_counts};
    svo_i_stage_begin(&build->commands);
    const svo_status status = make_nodes(&m);
    for (unsigned i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_commands_free(&build->commands, buffers[i]);
    }
    SVO_I_TRY(status);
    return svo_i_stage_end(&build->commands, SVO_STAGE_SUBDIVIDE);
}

svo_status svo_i_bottom_up_lists(svo_i_build *build)
{
    svo_i_commands *commands = &build->commands;
    cl_mem *buffers = build->tree->buffers;
    svo_tree_info *info = &build->tree->info;
    level_maker m = {.build = build};
    const svo_bottom_up_params params = {.count = (cl_uint)build->fragment_count,
                                         .node_begin = (cl_uint)info->inner_count,
                                         .child_begin = (cl_uint)info->leaf_count};
    svo_i_stage_begin(commands);
    SVO_I_TRY(svo_i_commands_alloc(commands, "list_begin", (info->leaf_count + 1) * 4, &buffers[SVO_TREE_LIST_BEGIN]));
    if (commands->plan->work.lists) {
        info->list_count = build->fragment_count;
        SVO_I_TRY(svo_i_commands_alloc(commands, "list", build->fragment_count * 4, &buffers[SVO_TREE_LIST]));
    }
    if (build->fragment_count == 0) {
        SVO_I_TRY(svo_i_commands_fill_zero(commands, buffers[SVO_TREE_LIST_BEGIN], sizeof(cl_uint)));
    }
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.chunks[0].buffer), SVO_I_ARGUMENT(build->cursors[0]),
                                        SVO_I_ARGUMENT(buffers[SVO_TREE_LIST_BEGIN]),
                                        SVO_I_ARGUMENT(buffers[SVO_TREE_LIST]), SVO_I_ARGUMENT(params)};
    SVO_I_TRY(launch(&m, "svo_k_bottom_up_lists", SVO_I_ARGUMENTS(arguments), params.count));
    return svo_i_stage_end(commands, SVO_STAGE_PACK);
}
