/* SPDX-License-Identifier: MIT */
/* Makes nodes by kernels/moving/nodes.cl. */
#include "moving/nodes.h"

#include "shared/moving_layout.h"
#include "stages/scan.h"

_Static_assert(SVO_NODE_LEVELS == SVO_LEVELS_MAX, "kernels have all levels of a tree");

typedef struct maker {
    svo_i_build *build;
    cl_program program;
    svo_node_params params;
    cl_mem counts, before; /* of (level, strip), and their exclusive sums */
    cl_mem levels; /* the sums where levels begin */
} maker;

static svo_status count_begins(maker *m)
{
    svo_i_commands *commands = &m->build->commands;
    const uint64_t cells = (uint64_t)(m->params.depth + 1) * m->params.strips;
    SVO_I_TRY(svo_i_commands_alloc(commands, "level_counts", cells * 4, &m->counts));
    SVO_I_TRY(svo_i_commands_alloc(commands, "level_counts", (cells + 1) * 4, &m->before));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->build->list.chunks[0].buffer), SVO_I_ARGUMENT(m->counts),
                                        SVO_I_ARGUMENT(m->params)};
    SVO_I_TRY(
        svo_i_commands_run(commands, m->program, "svo_k_moving_begins", SVO_I_ARGUMENTS(arguments), m->params.strips));
    return svo_i_scan_lists(m->build, SVO_I_PROGRAM_SORT, m->counts, m->before, NULL,
                            (svo_filter_params){.leaf_count = (cl_uint)cells});
}

/* Reads where the levels begin. */
static svo_status read_levels(maker *m, uint32_t level_begin[SVO_LEVELS_MAX])
{
    svo_i_commands *commands = &m->build->commands;
    const size_t bytes = SVO_LEVELS_MAX * sizeof *level_begin;
    SVO_I_TRY(svo_i_commands_alloc(commands, "level_counts", bytes, &m->levels));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->before), SVO_I_ARGUMENT(m->levels),
                                        SVO_I_ARGUMENT(m->params)};
    SVO_I_TRY(
        svo_i_commands_run(commands, m->program, "svo_k_moving_levels", SVO_I_ARGUMENTS(arguments), SVO_LEVELS_MAX));
    return svo_i_commands_read(commands, m->levels, level_begin, bytes);
}

/* Sets the tree's counts. Sums that have passed 2^32 are less than those of the level above. */
static svo_status take_levels(svo_i_build *build, const uint32_t level_begin[SVO_LEVELS_MAX])
{
    svo_tree_info *info = &build->tree->info;
    for (uint32_t level = 0; level <= info->depth + 1; ++level) {
        info->level_begin[level] = level_begin[level];
        if (level > 0 && level_begin[level] < level_begin[level - 1]) {
            return svo_i_device_fail(build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
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

/* A root without children. */
static svo_status make_empty(svo_i_build *build)
{
    static const uint32_t level_begin[SVO_LEVELS_MAX] = {0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    const cl_uint first_child = 1;
    cl_mem *buffers = build->tree->buffers;
    SVO_I_TRY(take_levels(build, level_begin));
    SVO_I_TRY(allocate(build));
    SVO_I_TRY(svo_i_commands_fill(&build->commands, buffers[SVO_TREE_FIRST_CHILD], &first_child, sizeof first_child,
                                  sizeof first_child));
    return svo_i_commands_fill_zero(&build->commands, buffers[SVO_TREE_LIST_BEGIN], sizeof(cl_uint));
}

static svo_status make_nodes(maker *m)
{
    svo_i_build *build = m->build;
    uint32_t level_begin[SVO_LEVELS_MAX];
    SVO_I_TRY(svo_i_scan_alloc(build));
    SVO_I_TRY(count_begins(m));
    SVO_I_TRY(read_levels(m, level_begin));
    SVO_I_TRY(take_levels(build, level_begin));
    SVO_I_TRY(allocate(build));
    const cl_mem *buffers = build->tree->buffers;
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(build->list.chunks[0].buffer), SVO_I_ARGUMENT(m->before),
        SVO_I_ARGUMENT(buffers[SVO_TREE_CHILD_MASK]), SVO_I_ARGUMENT(buffers[SVO_TREE_FIRST_CHILD]),
        SVO_I_ARGUMENT(buffers[SVO_TREE_LIST_BEGIN]), SVO_I_ARGUMENT(m->params)};
    return svo_i_commands_run(&build->commands, m->program, "svo_k_moving_nodes", SVO_I_ARGUMENTS(arguments),
                              m->params.strips);
}

svo_status svo_i_moving_nodes(svo_i_build *build, cl_program program)
{
    maker m = {.build = build, .program = program};
    m.params = (svo_node_params){.count = (cl_uint)build->fragment_count, .depth = build->tree->info.depth};
    m.params.strips = (cl_uint)((build->fragment_count + SVO_NODE_STRIP - 1) / SVO_NODE_STRIP);
    const svo_status status = build->fragment_count == 0 ? make_empty(build) : make_nodes(&m);
    svo_i_commands_free(&build->commands, &m.counts);
    svo_i_commands_free(&build->commands, &m.before);
    svo_i_commands_free(&build->commands, &m.levels);
    SVO_I_TRY(status);
    return svo_i_build_put_state(build, build->tree->info.level_begin);
}
