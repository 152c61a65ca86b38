/* SPDX-License-Identifier: MIT */
/*
 * Launches all levels without reading anything back between them. A blocking build reads the counts once, at the end,
 * and runs the stage again if the nodes did not fit.
 */
#include "stages/subdivide.h"

#include "core/work.h"
#include "plan/estimate.h"
#include "stages/programs.h"
#include "stages/sort.h"

#define BLOCK_BYTES 64u
#define RANK_BYTES  32u /* of a block */
/* A level may have all blocks, empty ones too, so that fragments find them by their codes: at most this many, and one
   per this many fragments. */
#define DENSE_BLOCKS    32768u
#define DENSE_FRAGMENTS 32u
/* The most levels of blocks, with one to spare. */
#define BLOCK_LEVELS_MAX 7
_Static_assert(DENSE_BLOCKS < 1u << 21, "of the levels that have all blocks, the last but one is at most level 3");

typedef struct subdivider {
    svo_i_build *build;
    bool worst_case; /* every fragment may have nodes of its own */
    cl_kernel mark, count, scan, make;
    cl_mem blocks, ranks;
    cl_mem masks, first_child;
    uint32_t block_begin[BLOCK_LEVELS_MAX]; /* the first block of level 0, 3, 6, ... */
    svo_blocks_params params;
    uint32_t last; /* level of the blocks whose bits are leaves */
} subdivider;

static svo_status create_kernels(subdivider *s)
{
    cl_program program = svo_i_build_program(s->build, &svo_i_program_subdivide);
    const struct {
        const char *name;
        cl_kernel *kernel;
    } kernels[] = {{"svo_k_mark", &s->mark},
                   {"svo_k_count_blocks", &s->count},
                   {"svo_k_scan_blocks", &s->scan},
                   {"svo_k_make_nodes", &s->make}};
    for (unsigned i = 0; i < sizeof kernels / sizeof kernels[0]; ++i) {
        SVO_I_TRY(svo_i_commands_kernel(&s->build->commands, program, kernels[i].name, kernels[i].kernel));
    }
    return SVO_OK;
}

static void release_kernels(subdivider *s)
{
    cl_kernel kernels[4] = {s->mark, s->count, s->scan, s->make};
    for (unsigned i = 0; i < 4; ++i) {
        if (kernels[i] != NULL) {
            clReleaseKernel(kernels[i]);
        }
    }
}

/* Launches a kernel that runs once or twice. */
static svo_status run_once(subdivider *s, const char *name, const svo_i_argument *arguments, cl_uint argument_count,
                           uint64_t items)
{
    return svo_i_commands_run(&s->build->commands, svo_i_build_program(s->build, &svo_i_program_subdivide), name,
                              arguments, argument_count, items);
}

/* Whether something reads the leaf of each fragment. */
static bool needs_cursors(const svo_plan *plan)
{
    return plan->work.ranges || plan->work.filter;
}

/* Capacity for the nodes of a level, counted as the blocks' levels are. */
static uint64_t level_nodes(const subdivider *s, uint32_t level)
{
    const uint32_t pad = s->params.pad;
    return svo_i_plan_level_nodes(s->build->commands.plan, level < pad ? 0 : level - pad, s->build->fragment_count,
                                  s->worst_case);
}

/* All nodes that a level could have. */
static uint64_t dense_blocks(const subdivider *s, uint32_t level)
{
    return UINT64_C(1) << (3 * (level < s->params.pad ? 0 : level - s->params.pad));
}

/* Blocks are large beside nodes. Where builds may run again there is no more room for them than the nodes that are
   expected if no two triangles share one. */
static uint64_t sparse_blocks(const subdivider *s, uint32_t level)
{
    const uint64_t nodes = level_nodes(s, level);
    const double expected = svo_i_plan_expected(s->build->commands.plan, level - s->params.pad);
    const uint64_t least = (uint64_t)(expected * 1.0625) + 64;
    return !s->build->in_place && !s->worst_case && least < nodes ? least : nodes;
}

static uint64_t most_blocks(const subdivider *s, uint32_t level)
{
    return level <= s->params.dense ? dense_blocks(s, level) : sparse_blocks(s, level);
}

static uint32_t last_dense(const subdivider *s)
{
    const uint64_t fragments = s->build->fragment_count;
    uint32_t level = 0;
    while (level < s->last && dense_blocks(s, level + 3) <= DENSE_BLOCKS &&
           dense_blocks(s, level + 3) * DENSE_FRAGMENTS <= fragments) {
        level += 3;
    }
    return level;
}

/* Sets where the blocks of each level begin, and allocates them. Leaves need ranks only where cursors do. */
static svo_status alloc_blocks(subdivider *s)
{
    svo_i_commands *commands = &s->build->commands;
    uint64_t total = 0;
    uint64_t ranked = 0;
    s->params.dense = last_dense(s);
    for (uint32_t level = 0; level <= s->last; level += 3) {
        s->block_begin[level / 3] = (uint32_t)total;
        total += most_blocks(s, level);
        ranked = level < s->last || needs_cursors(commands->plan) ? total : ranked;
    }
    s->params.rank_blocks = (cl_uint)ranked;
    s->params.dense_begin = s->block_begin[s->params.dense / 3];
    const svo_i_request requests[] = {{"blocks", total * BLOCK_BYTES, &s->blocks},
                                      {"block_ranks", ranked * RANK_BYTES, &s->ranks}};
    return svo_i_commands_alloc_all(commands, SVO_I_REQUESTS(requests));
}

/* Clears the blocks of the dense levels and initializes the state to a root without children. */
static svo_status begin(subdivider *s)
{
    svo_i_build *build = s->build;
    uint32_t root_alone[SVO_LEVELS_MAX] = {0};
    for (unsigned level = 1; level < SVO_LEVELS_MAX; ++level) {
        root_alone[level] = 1;
    }
    const uint64_t first_blocks = s->params.dense_begin + dense_blocks(s, s->params.dense);
    SVO_I_TRY(svo_i_build_put_state(build, root_alone));
    return svo_i_commands_fill_zero(&build->commands, s->blocks, first_blocks * BLOCK_BYTES);
}

/* Every fragment marks its bit in the blocks of params.level. */
static svo_status mark(subdivider *s)
{
    svo_blocks_params params = s->params;
    for (uint32_t i = 0; i < s->build->list.chunk_count; ++i) {
        const svo_i_fragments *chunk = &s->build->list.chunks[i];
        params.fragment_count = (cl_uint)chunk->needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(chunk->buffer), SVO_I_ARGUMENT(s->blocks),
                                            SVO_I_ARGUMENT(s->ranks), SVO_I_ARGUMENT(s->build->state),
                                            SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_commands_launch(&s->build->commands, s->mark, SVO_I_ARGUMENTS(arguments), chunk->needed));
    }
    return SVO_OK;
}

/* Makes the nodes of params.level and the two levels below. */
static svo_status make_nodes(subdivider *s)
{
    svo_i_build *build = s->build;
    svo_blocks_params params = s->params;
    params.scan_groups =
        svo_i_scan_groups(build->commands.device, most_blocks(s, params.level) * (SVO_SCAN_TILE / SVO_GROUP_ITEMS));
    const uint64_t items = (uint64_t)params.scan_groups * SVO_GROUP_ITEMS;
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint4));
    const svo_i_argument count[] = {SVO_I_ARGUMENT(s->blocks), SVO_I_ARGUMENT(build->partials),
                                    SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument scan[] = {SVO_I_ARGUMENT(build->partials), SVO_I_ARGUMENT(build->state),
                                   SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument make[] = {SVO_I_ARGUMENT(s->blocks),      SVO_I_ARGUMENT(build->partials),
                                   SVO_I_ARGUMENT(s->ranks),       SVO_I_ARGUMENT(s->masks),
                                   SVO_I_ARGUMENT(s->first_child), SVO_I_ARGUMENT(build->state),
                                   SVO_I_ARGUMENT(params),         scratch};
    SVO_I_TRY(svo_i_commands_launch(&build->commands, s->count, SVO_I_ARGUMENTS(count), items));
    SVO_I_TRY(svo_i_commands_launch(&build->commands, s->scan, SVO_I_ARGUMENTS(scan), SVO_GROUP_ITEMS));
    return svo_i_commands_launch(&build->commands, s->make, SVO_I_ARGUMENTS(make), items);
}

/* Copies the fragment count, which the host does not know, to the state. */
static svo_status take_count(subdivider *s)
{
    svo_blocks_params params = s->params;
    params.fragment_count = (cl_uint)s->build->list.chunks[0].capacity;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(s->build->list.counters), SVO_I_ARGUMENT(s->build->state),
                                        SVO_I_ARGUMENT(params)};
    return run_once(s, "svo_k_take_count", SVO_I_ARGUMENTS(arguments), 1);
}

/* Fills the blocks of params.level from those three levels down. */
static svo_status mark_above(subdivider *s)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(s->blocks), SVO_I_ARGUMENT(s->params)};
    return run_once(s, "svo_k_mark_above", SVO_I_ARGUMENTS(arguments), dense_blocks(s, s->params.level + 3) / 8);
}

/* Sets the parameters to blocks of a level. The nodes of the three levels below have limited room: where they have
   blocks, that for blocks. Other levels of a blocking build share the room for all nodes, since it sizes later buffers
   by the real counts. */
static void set_level(subdivider *s, uint32_t level_of_blocks)
{
    s->params.level = level_of_blocks;
    s->params.block_begin = s->block_begin[level_of_blocks / 3];
    s->params.next_begin = s->block_begin[level_of_blocks / 3 + 1];
    for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t level = s->params.level + 1 + k;
        const bool has_blocks = level % 3 == 0 && level > s->params.dense && level <= s->last;
        s->params.level_capacity[k] = has_blocks                                  ? (cl_uint)most_blocks(s, level)
                                      : s->build->commands.mode == SVO_I_MODE_RUN ? UINT32_MAX
                                                                                  : (cl_uint)level_nodes(s, level);
    }
}

/* Makes the nodes of the levels above the last that has all blocks, but at least those of level 0. */
static svo_status make_top(subdivider *s)
{
    set_level(s, 0);
    const svo_blocks_params first = s->params;
    set_level(s, s->params.dense > 3 ? 3 : 0);
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(s->blocks),       SVO_I_ARGUMENT(s->ranks),
        SVO_I_ARGUMENT(s->masks),        SVO_I_ARGUMENT(s->first_child),
        SVO_I_ARGUMENT(s->build->state), SVO_I_ARGUMENT(first),
        SVO_I_ARGUMENT(s->params),       SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint4))};
    return run_once(s, "svo_k_make_top", SVO_I_ARGUMENTS(arguments), SVO_GROUP_ITEMS);
}

static svo_status find_leaves(subdivider *s)
{
    svo_i_build *build = s->build;
    svo_blocks_params params = s->params;
    params.level = s->last;
    for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
        const svo_i_fragments *chunk = &build->list.chunks[i];
        params.fragment_count = (cl_uint)chunk->needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(chunk->buffer), SVO_I_ARGUMENT(s->blocks),
                                            SVO_I_ARGUMENT(s->ranks),      SVO_I_ARGUMENT(build->cursors[i]),
                                            SVO_I_ARGUMENT(build->state),  SVO_I_ARGUMENT(params)};
        SVO_I_TRY(run_once(s, "svo_k_find_leaves", SVO_I_ARGUMENTS(arguments), chunk->needed));
    }
    return SVO_OK;
}

static svo_status run_levels(subdivider *s)
{
    const uint32_t dense = s->params.dense;
    set_level(s, dense);
    SVO_I_TRY(s->build->list.counters != NULL ? take_count(s) : SVO_OK);
    SVO_I_TRY(mark(s));
    for (uint32_t level = dense; level > 3; level -= 3) {
        set_level(s, level - 3);
        SVO_I_TRY(mark_above(s));
    }
    SVO_I_TRY(make_top(s));
    for (uint32_t level = dense > 0 ? dense : 3; level <= s->last; level += 3) {
        set_level(s, level);
        SVO_I_TRY(level > dense ? mark(s) : SVO_OK);
        SVO_I_TRY(make_nodes(s));
    }
    return SVO_OK;
}

/* Releases the blocks, for another attempt or at the end. */
static void free_blocks(subdivider *s)
{
    svo_i_commands_free(&s->build->commands, &s->blocks);
    svo_i_commands_free(&s->build->commands, &s->ranks);
}

/* Fills arrays of build->inner_capacity elements. *fits is false if there are more inner nodes. */
static svo_status run(subdivider *s, bool *fits)
{
    svo_i_build *build = s->build;
    svo_i_commands *commands = &build->commands;
    svo_build_state state;
    if (commands->mode != SVO_I_MODE_MEASURE && build->inner_capacity >= UINT32_MAX) {
        return svo_i_device_fail(commands->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the tree may have %llu inner nodes, above 2^32 - 1; lower the depth",
                                 (unsigned long long)build->inner_capacity);
    }
    s->masks = build->tree->buffers[SVO_TREE_CHILD_MASK];
    s->first_child = build->tree->buffers[SVO_TREE_FIRST_CHILD];
    s->params.inner_capacity = (cl_uint)build->inner_capacity;
    *fits = true; /* other modes do not read the counts here */
    svo_i_stage_begin(commands);
    SVO_I_TRY(alloc_blocks(s));
    SVO_I_TRY(begin(s));
    SVO_I_TRY(run_levels(s));
    SVO_I_TRY(svo_i_stage_end(commands, SVO_STAGE_SUBDIVIDE));
    if (commands->mode == SVO_I_MODE_RUN) {
        SVO_I_TRY(svo_i_commands_read(commands, build->state, &state, sizeof state));
        SVO_I_TRY(svo_i_build_take_state(build, &state, fits));
    }
    return SVO_OK;
}

/* Replaces a buffer by a copy of its first bytes. */
static svo_status trim(svo_i_build *build, svo_tree_buffer which, uint64_t bytes)
{
    svo_status status = SVO_OK;
    cl_mem *buffer = &build->tree->buffers[which];
    cl_mem exact = NULL;
    SVO_I_TRY_CLEANUP(svo_i_commands_alloc(&build->commands, svo_name(SVO_NAME_TREE_BUFFER, which), bytes, &exact));
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
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, masks, build->inner_capacity, &buffers[SVO_TREE_CHILD_MASK]));
    return svo_i_commands_alloc(&build->commands, first_child, build->inner_capacity * 4,
                                &buffers[SVO_TREE_FIRST_CHILD]);
}

/* Makes the nodes in the tree's own arrays, of the plan's capacities. */
static svo_status subdivide_in_place(subdivider *s)
{
    bool fits = false;
    svo_i_build *build = s->build;
    s->worst_case = build->commands.plan->options.worst_case_nodes != 0;
    build->inner_capacity = build->tree->info.inner_count;
    SVO_I_TRY(alloc_nodes(build, svo_name(SVO_NAME_TREE_BUFFER, SVO_TREE_CHILD_MASK),
                          svo_name(SVO_NAME_TREE_BUFFER, SVO_TREE_FIRST_CHILD)));
    return run(s, &fits);
}

/* Runs again once, with capacity for the worst case, if the fragment estimate was too low. */
static svo_status subdivide_and_trim(subdivider *s)
{
    svo_i_build *build = s->build;
    const svo_plan *plan = build->commands.plan;
    cl_mem *buffers = build->tree->buffers;
    bool fits = false;
    for (unsigned attempt = 0; attempt < 2 && !fits; ++attempt) {
        s->worst_case = attempt > 0 || plan->options.worst_case_nodes != 0;
        build->inner_capacity = svo_i_plan_inner_nodes(plan, build->fragment_count, s->worst_case);
        svo_i_commands_free(&build->commands, &buffers[SVO_TREE_CHILD_MASK]);
        svo_i_commands_free(&build->commands, &buffers[SVO_TREE_FIRST_CHILD]);
        free_blocks(s);
        SVO_I_TRY(alloc_nodes(build, "child_mask_pool", "first_child_pool"));
        SVO_I_TRY(run(s, &fits));
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

/* The cursors come last, so that they do not add to the peak of memory that the nodes need. */
svo_status svo_i_subdivide(svo_i_build *build)
{
    svo_status status = SVO_OK;
    const uint32_t depth = build->commands.plan->info.depth;
    const uint32_t pad = (3 - depth % 3) % 3;
    subdivider s = {.build = build, .params = {.depth = depth, .pad = pad}, .last = depth + pad - 3};
    SVO_I_TRY_CLEANUP(create_kernels(&s));
    SVO_I_TRY_CLEANUP(build->in_place ? subdivide_in_place(&s) : subdivide_and_trim(&s));
    if (needs_cursors(build->commands.plan)) {
        SVO_I_TRY_CLEANUP(svo_i_build_alloc_cursors(build));
        svo_i_stage_begin(&build->commands);
        SVO_I_TRY_CLEANUP(find_leaves(&s));
        SVO_I_TRY_CLEANUP(svo_i_stage_end(&build->commands, SVO_STAGE_SUBDIVIDE));
    }
cleanup:
    free_blocks(&s);
    release_kernels(&s);
    return status;
}
