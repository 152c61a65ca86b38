/* SPDX-License-Identifier: MIT */
/*
 * Launches all levels without reading anything back between them. A blocking build reads the counts once, at the end,
 * and runs the stage again if the nodes did not fit.
 */
#include "stages/subdivide.h"

#include "plan/estimate.h"
#include "stages/scan.h"

typedef struct subdivider {
    svo_i_build *build;
    cl_kernel mark, descend, reduce, partials, add;
    cl_mem masks, first_child;
} subdivider;

static svo_status create_kernels(subdivider *s)
{
    cl_program program = s->build->programs[SVO_I_PROGRAM_SUBDIVIDE];
    const struct {
        const char *name;
        cl_kernel *kernel;
    } kernels[] = {{"svo_k_mark", &s->mark},
                   {"svo_k_descend", &s->descend},
                   {"svo_k_scan_masks_reduce", &s->reduce},
                   {"svo_k_scan_masks_partials", &s->partials},
                   {"svo_k_scan_masks_add", &s->add}};
    for (unsigned i = 0; i < sizeof kernels / sizeof kernels[0]; ++i) {
        SVO_I_TRY(svo_i_commands_kernel(&s->build->commands, program, kernels[i].name, kernels[i].kernel));
    }
    return SVO_OK;
}

static void release_kernels(subdivider *s)
{
    cl_kernel kernels[5] = {s->mark, s->descend, s->reduce, s->partials, s->add};
    for (unsigned i = 0; i < 5; ++i) {
        if (kernels[i] != NULL) {
            clReleaseKernel(kernels[i]);
        }
    }
}

/* Clears the masks and initializes the state to a root without children. */
static svo_status begin(subdivider *s)
{
    svo_i_build *build = s->build;
    uint32_t root_alone[SVO_LEVELS_MAX] = {0};
    for (unsigned level = 1; level < SVO_LEVELS_MAX; ++level) {
        root_alone[level] = 1;
    }
    SVO_I_TRY(svo_i_build_put_state(build, root_alone));
    SVO_I_TRY(svo_i_scan_alloc(build));
    return svo_i_commands_fill_zero(&build->commands, s->masks, (build->inner_capacity + 3) / 4 * 4);
}

static svo_status mark_root(subdivider *s, svo_subdivide_params params)
{
    for (uint32_t i = 0; i < s->build->list.chunk_count; ++i) {
        const svo_i_fragments *chunk = &s->build->list.chunks[i];
        params.fragment_count = (cl_uint)chunk->needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(chunk->buffer), SVO_I_ARGUMENT(s->masks),
                                            SVO_I_ARGUMENT(s->build->state), SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_commands_launch(&s->build->commands, s->mark, SVO_I_ARGUMENTS(arguments), chunk->needed));
    }
    return SVO_OK;
}

/* Scans a level's masks: sets first_child of its nodes and the beginning of the level after the next. */
static svo_status scan_level(subdivider *s, svo_subdivide_params params)
{
    svo_i_build *build = s->build;
    const uint64_t items = (uint64_t)params.scan_groups * SVO_GROUP_ITEMS;
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    const svo_i_argument reduce[] = {SVO_I_ARGUMENT(s->masks), SVO_I_ARGUMENT(build->partials),
                                     SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument partials[] = {SVO_I_ARGUMENT(build->partials), SVO_I_ARGUMENT(build->state),
                                       SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument add[] = {SVO_I_ARGUMENT(s->masks),       SVO_I_ARGUMENT(build->partials),
                                  SVO_I_ARGUMENT(s->first_child), SVO_I_ARGUMENT(build->state),
                                  SVO_I_ARGUMENT(params),         scratch};
    SVO_I_TRY(svo_i_commands_launch(&build->commands, s->reduce, SVO_I_ARGUMENTS(reduce), items));
    SVO_I_TRY(svo_i_commands_launch(&build->commands, s->partials, SVO_I_ARGUMENTS(partials), SVO_GROUP_ITEMS));
    return svo_i_commands_launch(&build->commands, s->add, SVO_I_ARGUMENTS(add), items);
}

static svo_status descend(subdivider *s, svo_subdivide_params params)
{
    for (uint32_t i = 0; i < s->build->list.chunk_count; ++i) {
        const svo_i_fragments *chunk = &s->build->list.chunks[i];
        params.fragment_count = (cl_uint)chunk->needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(chunk->buffer),   SVO_I_ARGUMENT(s->build->cursors[i]),
                                            SVO_I_ARGUMENT(s->masks),        SVO_I_ARGUMENT(s->first_child),
                                            SVO_I_ARGUMENT(s->build->state), SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_commands_launch(&s->build->commands, s->descend, SVO_I_ARGUMENTS(arguments), chunk->needed));
    }
    return SVO_OK;
}

/* Copies the fragment count, which the host does not know, to the state. */
static svo_status take_count(subdivider *s, svo_subdivide_params params)
{
    params.fragment_count = (cl_uint)s->build->list.chunks[0].capacity;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(s->build->list.counters), SVO_I_ARGUMENT(s->build->state),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_commands_run(&s->build->commands, s->build->programs[SVO_I_PROGRAM_SUBDIVIDE], "svo_k_take_count",
                              SVO_I_ARGUMENTS(arguments), 1);
}

/* Capacity for the inner nodes of the next level. A blocking build has no limit per level: it sizes later buffers by
   the real counts. */
static uint32_t next_level_capacity(const svo_i_build *build, uint32_t level)
{
    const uint32_t *begin = build->tree->info.level_begin;
    return build->commands.mode == SVO_I_MODE_RUN || level + 1 == build->tree->info.depth
               ? UINT32_MAX
               : begin[level + 2] - begin[level + 1];
}

/* The most nodes that a level can have. */
static uint64_t most_nodes(const svo_i_build *build, uint32_t level)
{
    const uint64_t cells = UINT64_C(1) << (3 * level);
    return cells < build->fragment_count ? cells : build->fragment_count;
}

static svo_status run_levels(subdivider *s)
{
    svo_subdivide_params params = {.depth = s->build->commands.plan->info.depth,
                                   .inner_capacity = (cl_uint)s->build->inner_capacity};
    SVO_I_TRY(s->build->list.counters != NULL ? take_count(s, params) : SVO_OK);
    SVO_I_TRY(mark_root(s, params));
    for (params.level = 0; params.level < params.depth; ++params.level) {
        params.scan_groups = svo_i_scan_groups(most_nodes(s->build, params.level));
        params.level_capacity = next_level_capacity(s->build, params.level);
        SVO_I_TRY(scan_level(s, params));
        SVO_I_TRY(descend(s, params));
    }
    return SVO_OK;
}

/* Fills arrays of build->inner_capacity elements. *fits is false if there are more inner nodes. */
static svo_status run(svo_i_build *build, bool *fits)
{
    svo_status status = SVO_OK;
    svo_i_commands *commands = &build->commands;
    subdivider s = {.build = build,
                    .masks = build->tree->buffers[SVO_TREE_CHILD_MASK],
                    .first_child = build->tree->buffers[SVO_TREE_FIRST_CHILD]};
    svo_build_state state;
    if (commands->mode != SVO_I_MODE_MEASURE && build->inner_capacity >= UINT32_MAX) {
        return svo_i_device_fail(commands->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the tree may have %llu inner nodes, above 2^32 - 1; lower the depth",
                                 (unsigned long long)build->inner_capacity);
    }
    *fits = true; /* other modes do not read the counts here */
    svo_i_stage_begin(commands);
    SVO_I_TRY_CLEANUP(create_kernels(&s));
    SVO_I_TRY_CLEANUP(begin(&s));
    SVO_I_TRY_CLEANUP(run_levels(&s));
    SVO_I_TRY_CLEANUP(svo_i_stage_end(commands, SVO_STAGE_SUBDIVIDE));
    if (commands->mode == SVO_I_MODE_RUN) {
        SVO_I_TRY_CLEANUP(svo_i_commands_read(commands, build->state, &state, sizeof state));
        SVO_I_TRY_CLEANUP(svo_i_build_take_state(build, &state, fits));
    }
cleanup:
    release_kernels(&s);
    return status;
}

/* Replaces a buffer by a copy of its first bytes. */
static svo_status trim(svo_i_build *build, svo_tree_buffer which, uint64_t bytes)
{
    svo_status status = SVO_OK;
    cl_mem *buffer = &build->tree->buffers[which];
    cl_mem exact = NULL;
    SVO_I_TRY_CLEANUP(svo_i_commands_alloc(&build->commands, svo_tree_buffer_name(which), bytes, &exact));
    SVO_I_TRY_CLEANUP(svo_i_commands_copy(&build->commands, *buffer, exact, 0, bytes));
    svo_i_commands_free(&build->commands, buffer);
    *buffer = exact;
    return SVO_OK;
cleanup:
    svo_i_commands_free(&build->commands, &exact);
    return status;
}

/* Allocates arrays for build->inner_capacity nodes. */
static svo_status alloc_nodes(svo_i_build *build, const char *masks, const char *first_child)
{
    cl_mem *buffers = build->tree->buffers;
    const uint64_t mask_bytes = (build->inner_capacity + 3) / 4 * 4;
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, masks, mask_bytes, &buffers[SVO_TREE_CHILD_MASK]));
    return svo_i_commands_alloc(&build->commands, first_child, build->inner_capacity * 4,
                                &buffers[SVO_TREE_FIRST_CHILD]);
}

/* Makes the nodes in the tree's own arrays, of the plan's capacities. */
static svo_status subdivide_in_place(svo_i_build *build)
{
    bool fits = false;
    build->inner_capacity = build->tree->info.inner_count;
    SVO_I_TRY(
        alloc_nodes(build, svo_tree_buffer_name(SVO_TREE_CHILD_MASK), svo_tree_buffer_name(SVO_TREE_FIRST_CHILD)));
    return run(build, &fits);
}

/* Runs again once, with capacity for the worst case, if the fragment estimate was too low. */
svo_status svo_i_subdivide(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    cl_mem *buffers = build->tree->buffers;
    bool fits = false;
    SVO_I_TRY(svo_i_build_alloc_cursors(build));
    if (build->in_place) {
        return subdivide_in_place(build);
    }
    for (unsigned attempt = 0; attempt < 2 && !fits; ++attempt) {
        const bool worst_case = attempt > 0 || plan->options.worst_case_nodes != 0;
        build->inner_capacity = svo_i_plan_inner_nodes(plan, build->fragment_count, worst_case);
        svo_i_commands_free(&build->commands, &buffers[SVO_TREE_CHILD_MASK]);
        svo_i_commands_free(&build->commands, &buffers[SVO_TREE_FIRST_CHILD]);
        SVO_I_TRY(alloc_nodes(build, "child_mask_pool", "first_child_pool"));
        SVO_I_TRY(run(build, &fits));
        build->commands.report->reruns += fits ? 0 : 1;
    }
    if (!fits) {
        return svo_i_device_fail(build->commands.device, SVO_INTERNAL,
                                 "svo_build: %llu fragments made more than %llu inner nodes",
                                 (unsigned long long)build->fragment_count, (unsigned long long)build->inner_capacity);
    }
    SVO_I_TRY(trim(build, SVO_TREE_CHILD_MASK, build->tree->info.inner_count));
    return trim(build, SVO_TREE_FIRST_CHILD, build->tree->info.inner_count * 4);
}
