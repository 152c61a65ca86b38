/* SPDX-License-Identifier: MIT */
/*
 * Scans of list counts and of digit counts; those of child masks are in subdivide.c. The radix sort of the fragment
 * list, least significant digit first, between two buffers of the list's size.
 */
#include "stages/sort.h"

#include "core/work.h"
#include "plan/estimate.h"
#include "stages/programs.h"

/* ---- scans ---- */

svo_status svo_i_scan_lists(svo_i_build *build, const svo_i_program *program, cl_mem numbers, cl_mem sums, cl_mem state,
                            svo_filter_params params)
{
    svo_i_commands *commands = &build->commands;
    cl_program kernels = svo_i_build_program(build, program);
    const uint64_t items = (uint64_t)svo_i_scan_groups(commands->device, params.leaf_count) * SVO_GROUP_ITEMS;
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    const svo_i_argument reduce[] = {SVO_I_ARGUMENT(numbers), SVO_I_ARGUMENT(build->partials), SVO_I_ARGUMENT(state),
                                     SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument add[] = {SVO_I_ARGUMENT(numbers), SVO_I_ARGUMENT(build->partials), SVO_I_ARGUMENT(sums),
                                  SVO_I_ARGUMENT(state),   SVO_I_ARGUMENT(params),          scratch};
    SVO_I_TRY(svo_i_commands_run(commands, kernels, "svo_k_scan_lists_reduce", SVO_I_ARGUMENTS(reduce), items));
    return svo_i_commands_run(commands, kernels, "svo_k_scan_lists_add", SVO_I_ARGUMENTS(add), items);
}

/* ---- the sort ---- */

typedef struct sorter {
    svo_i_build *build;
    cl_mem spare; /* as large as the list */
    cl_mem counts, before; /* digits by blocks, and their exclusive sums */
    uint32_t bits; /* of a digit, the most */
} sorter;

/* Rough time to count or to move an entry, for the progress. */
#define ENTRY_NS 8.0

static uint64_t sort_items(const sorter *s)
{
    return (uint64_t)s->build->commands.device->sort_groups * SVO_GROUP_ITEMS;
}

/* A count for each digit in the block of each group. */
static uint64_t sort_cells(const sorter *s, uint32_t bits)
{
    return (uint64_t)s->build->commands.device->sort_groups << bits;
}

static svo_status launch(sorter *s, const char *name, const svo_i_argument *arguments, cl_uint argument_count)
{
    return svo_i_commands_run(&s->build->commands, svo_i_build_program(s->build, &svo_i_program_sort), name, arguments,
                              argument_count, sort_items(s));
}

/* One pass over a digit. It swaps the list and the spare buffer. */
static svo_status sort_pass(sorter *s, svo_sort_params params)
{
    svo_i_commands_stage(&s->build->commands, SVO_STAGE_SUBDIVIDE,
                         ENTRY_NS * (double)s->build->fragment_count / (double)sort_items(s));
    cl_mem *list = &s->build->list.chunks[0].buffer;
    const svo_filter_params cells = {.leaf_count = (cl_uint)sort_cells(s, params.bits)};
    const svo_i_argument digits = SVO_I_LOCAL(svo_i_sort_local_bytes(s->build->commands.device));
    const svo_i_argument count[] = {SVO_I_ARGUMENT(*list), SVO_I_ARGUMENT(s->counts), SVO_I_ARGUMENT(params), digits};
    const svo_i_argument scatter[] = {SVO_I_ARGUMENT(*list), SVO_I_ARGUMENT(s->spare), SVO_I_ARGUMENT(s->before),
                                      SVO_I_ARGUMENT(params), digits};
    SVO_I_TRY(launch(s, "svo_k_sort_count", SVO_I_ARGUMENTS(count)));
    SVO_I_TRY(svo_i_scan_lists(s->build, &svo_i_program_sort, s->counts, s->before, NULL, cells));
    SVO_I_TRY(launch(s, "svo_k_sort_scatter", SVO_I_ARGUMENTS(scatter)));
    cl_mem sorted = s->spare;
    s->spare = *list;
    *list = sorted;
    return SVO_OK;
}

/* Sorts by the low bits of the triangle index or of the Morton code. */
static svo_status sort_by(sorter *s, bool by_triangle, uint32_t bits)
{
    svo_sort_params params = {.fragment_count = (cl_uint)s->build->fragment_count, .by_triangle = by_triangle ? 1 : 0};
    for (; params.shift < bits; params.shift += params.bits) {
        params.bits = bits - params.shift < s->bits ? bits - params.shift : s->bits;
        SVO_I_TRY(sort_pass(s, params));
    }
    return SVO_OK;
}

static uint32_t choose_bits(const svo_i_build *build)
{
    const bool is_long = build->fragment_count >= SVO_SORT_LONG_LIST;
    return build->commands.device->cpu_path && is_long ? SVO_SORT_WIDE_BITS : SVO_SORT_BITS;
}

static svo_status sort_list(sorter *s)
{
    const svo_plan *plan = s->build->commands.plan;
    const uint64_t cells = sort_cells(s, s->bits);
    uint32_t triangle_bits = 0;
    while (triangle_bits < 32 && (plan->triangle_count - 1) >> triangle_bits != 0) {
        ++triangle_bits;
    }
    const svo_i_request requests[] = {{"sort_counts", cells * 4, &s->counts},
                                      {"sort_counts", (cells + 1) * 4, &s->before}};
    SVO_I_TRY(svo_i_commands_alloc_all(&s->build->commands, SVO_I_REQUESTS(requests)));
    if (plan->work.lists) {
        SVO_I_TRY(sort_by(s, true, triangle_bits));
    }
    return sort_by(s, false, 3 * plan->info.depth);
}

/* Copies all chunks into one buffer. */
static svo_status join_chunks(sorter *s, cl_mem whole)
{
    svo_i_build *build = s->build;
    const uint64_t fragment_bytes = svo_i_plan_fragment_bytes(build->commands.plan);
    uint64_t offset = 0;
    for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
        const uint64_t bytes = build->list.chunks[i].needed * fragment_bytes;
        SVO_I_TRY(svo_i_commands_copy(&build->commands, build->list.chunks[i].buffer, whole, offset, bytes));
        offset += bytes;
    }
    return SVO_OK;
}

/* Replaces the list by one chunk that the build owns. */
static svo_status take_list(sorter *s, uint64_t bytes)
{
    svo_status status = SVO_OK;
    svo_i_build *build = s->build;
    cl_mem whole = NULL;
    svo_i_fragments *chunk = svo_i_alloc_zeroed(&build->commands.device->memory, 1, sizeof *chunk);
    if (chunk == NULL) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for a chunk");
    }
    SVO_I_TRY_CLEANUP(svo_i_commands_alloc(&build->commands, "sorted", bytes, &whole));
    SVO_I_TRY_CLEANUP(join_chunks(s, whole));
    SVO_I_TRY_CLEANUP(svo_i_commands_wait(&build->commands));
    svo_i_build_release_list(build);
    *chunk = (svo_i_fragments){.buffer = whole, .needed = build->fragment_count, .capacity = build->fragment_count};
    build->list = (svo_i_fragment_list){.chunks = chunk, .chunk_count = 1};
    build->owns_list = true;
    return SVO_OK;
cleanup:
    svo_i_commands_free(&build->commands, &whole);
    svo_i_free(chunk);
    return status;
}

static svo_status run(sorter *s)
{
    svo_i_build *build = s->build;
    const svo_device *device = build->commands.device;
    const uint64_t bytes = build->fragment_count * svo_i_plan_fragment_bytes(build->commands.plan);
    if (bytes > device->max_allocation_bytes) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: builder sorted needs the list's %llu bytes in one buffer, above the "
                                 "device's %llu",
                                 (unsigned long long)bytes, (unsigned long long)device->max_allocation_bytes);
    }
    SVO_I_TRY(svo_i_build_alloc_state(build));
    SVO_I_TRY(take_list(s, bytes));
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, "sorted", bytes, &s->spare));
    return build->fragment_count > 0 ? sort_list(s) : SVO_OK;
}

svo_status svo_i_sort(svo_i_build *build)
{
    sorter s = {.build = build, .bits = choose_bits(build)};
    svo_i_stage_begin(&build->commands);
    const svo_status status = run(&s);
    svo_i_commands_free(&build->commands, &s.spare);
    svo_i_commands_free(&build->commands, &s.counts);
    svo_i_commands_free(&build->commands, &s.before);
    SVO_I_TRY(status);
    return svo_i_stage_end(&build->commands, SVO_STAGE_SUBDIVIDE);
}
