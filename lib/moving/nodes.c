/* SPDX-License-Identifier: MIT */
/* Makes nodes by kernels/moving/nodes.cl. */
#include "moving/nodes.h"

#include "shared/moving_layout.h"
#include "stages/sort.h"

_Static_assert(SVO_NODE_LEVELS == SVO_LEVELS_MAX, "kernels have all levels of a tree");

typedef struct maker {
    svo_i_build *build;
    cl_program program;
    svo_node_params params;
    cl_mem counted; /* see svo_i_moving_nodes */
    cl_mem counts, before; /* of (level, strip), and their exclusive sums */
} maker;

static svo_status count_begins(maker *m)
{
    svo_i_commands *commands = &m->build->commands;
    const uint64_t cells = (uint64_t)(m->params.depth + 1) * m->params.strips;
    SVO_I_TRY(svo_i_commands_alloc(commands, "level_counts", cells * 4, &m->counts));
    SVO_I_TRY(svo_i_commands_alloc(commands, "level_counts", (cells + 1) * 4, &m->before));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->build->list.chunks[0].buffer), SVO_I_ARGUMENT(m->counted),
                                        SVO_I_ARGUMENT(m->counts), SVO_I_ARGUMENT(m->params)};
    SVO_I_TRY(
        svo_i_commands_run(commands, m->program, "svo_k_moving_begins", SVO_I_ARGUMENTS(arguments), m->params.strips));
    return svo_i_scan_lists(m->build, SVO_I_PROGRAM_SORT, m->counts, m->before, NULL,
                            (svo_filter_params){.leaf_count = (cl_uint)cells});
}

/* Makes the state of the sums. */
static svo_status make_state(maker *m)
{
    svo_i_build *build = m->build;
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, "state", sizeof build->host_state, &build->state));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->before), SVO_I_ARGUMENT(m->counted),
                                        SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(m->params)};
    return svo_i_commands_run(&build->commands, m->program, "svo_k_moving_levels", SVO_I_ARGUMENTS(arguments),
                              SVO_LEVELS_MAX);
}

/* Sums that have passed 2^32 are less than those of the level above. */
svo_status svo_i_moving_take_state(svo_device *device, const svo_build_state *state, svo_tree_info *info)
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

static svo_status make_nodes(maker *m)
{
    svo_i_build *build = m->build;
    svo_build_state *state = &build->host_state;
    SVO_I_TRY(svo_i_scan_alloc(build));
    SVO_I_TRY(count_begins(m));
    SVO_I_TRY(make_state(m));
    if (build->commands.mode == SVO_I_MODE_RUN) {
        SVO_I_TRY(svo_i_commands_read(&build->commands, build->state, state, sizeof *state));
        SVO_I_TRY(svo_i_moving_take_state(build->commands.device, state, &build->tree->info));
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

svo_status svo_i_moving_nodes(svo_i_build *build, cl_program program, cl_mem counted)
{
    const uint64_t pairs = build->fragment_count > 0 ? build->fragment_count : 1; /* a list without pairs has a root */
    maker m = {.build = build, .program = program, .counted = counted};
    m.params = (svo_node_params){.count = (cl_uint)build->fragment_count, .depth = build->tree->info.depth};
    m.params.strips = (cl_uint)((pairs + SVO_NODE_STRIP - 1) / SVO_NODE_STRIP);
    const svo_status status = make_nodes(&m);
    svo_i_commands_free(&build->commands, &m.counts);
    svo_i_commands_free(&build->commands, &m.before);
    return status;
}
