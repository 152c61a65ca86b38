/* SPDX-License-Identifier: MIT */
/*
 * The builder "sorted": the same tree from the leaves up, by kernels/sort.cl and kernels/ascend.cl. The whole list is
 * put into one buffer and sorted by Morton code, within a voxel by triangle where lists are asked for; then every
 * level's codes follow from those of the level below. All sizes are known after one count, so nodes are never made
 * twice and lists come out packed. It asks for the list in one piece, and once more as much to sort it.
 */
#include <stdlib.h>

#include "build/build.h"

typedef struct sorter {
    svo_i_build *build;
    cl_program program;
    cl_mem spare; /* as large as the list */
    cl_mem counts, before; /* of the sort: digits by blocks, and their exclusive sums */
    cl_mem flags, indices; /* of a level: where nodes begin, and the exclusive sums of that */
    cl_mem codes[2]; /* of nodes of levels whose distance from the leaves is even, and odd */
    cl_mem level_counts;
} sorter;

static svo_status run(sorter *s, const char *name, const svo_i_argument *arguments, cl_uint argument_count,
                      uint64_t items)
{
    cl_kernel kernel = NULL;
    if (s->build->mode == SVO_I_BUILD_MEASURES) {
        return SVO_OK;
    }
    svo_status status = svo_i_kernel_create(s->build->device, SVO_I_BUILD, s->program, name, &kernel);
    if (status == SVO_OK) {
        status = svo_i_build_launch(s->build, kernel, arguments, argument_count, items);
        clReleaseKernel(kernel);
    }
    return status;
}

svo_status svo_i_sorted_prepare(svo_i_build *build)
{
    bool fresh = false;
    cl_program kept = build->program;
    svo_status status = svo_i_program_get(build->device, SVO_I_BUILD, SVO_I_PROGRAM_SORT,
                                          svo_i_plan_sort_defines(build->plan), &build->program, &fresh);
    if (status == SVO_OK && fresh) {
        status = svo_i_build_warm(build, SVO_I_PROGRAM_SORT);
    }
    build->program = kept;
    return status;
}

/* Exclusive sums of count numbers; sums has one entry more, for their total. */
static svo_status scan(sorter *s, cl_mem numbers, cl_mem sums, uint64_t count)
{
    const uint64_t items = (uint64_t)SVO_SCAN_GROUPS * SVO_GROUP_ITEMS;
    const svo_filter_params params = {.leaf_count = (cl_uint)count};
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    cl_mem partials = s->build->partials;
    const cl_mem none = NULL; /* the count is the host's */
    const svo_i_argument reduce[] = {SVO_I_ARGUMENT(numbers), SVO_I_ARGUMENT(partials), SVO_I_ARGUMENT(none),
                                     SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument middle[] = {SVO_I_ARGUMENT(partials), SVO_I_ARGUMENT(sums), SVO_I_ARGUMENT(none),
                                     SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument add[] = {SVO_I_ARGUMENT(numbers), SVO_I_ARGUMENT(partials), SVO_I_ARGUMENT(sums),
                                  SVO_I_ARGUMENT(none),    SVO_I_ARGUMENT(params),   scratch};
    svo_status status = run(s, "svo_k_scan_lists_reduce", reduce, 5, items);
    if (status == SVO_OK) {
        status = run(s, "svo_k_scan_lists_partials", middle, 5, SVO_GROUP_ITEMS);
    }
    return status == SVO_OK ? run(s, "svo_k_scan_lists_add", add, 6, items) : status;
}

/* One pass over a digit; the list and the spare change places. */
static svo_status sort_pass(sorter *s, svo_sort_params params)
{
    cl_mem *list = &s->build->list.chunks[0].buffer;
    const uint64_t items = (uint64_t)SVO_SORT_BLOCKS * SVO_GROUP_ITEMS;
    const svo_i_argument digits = SVO_I_LOCAL(sizeof(cl_uint) * SVO_SORT_DIGITS * SVO_GROUP_ITEMS);
    const svo_i_argument count[] = {SVO_I_ARGUMENT(*list), SVO_I_ARGUMENT(s->counts), SVO_I_ARGUMENT(params), digits};
    const svo_i_argument scatter[] = {SVO_I_ARGUMENT(*list), SVO_I_ARGUMENT(s->spare), SVO_I_ARGUMENT(s->before),
                                      SVO_I_ARGUMENT(params), digits};
    svo_status status = run(s, "svo_k_sort_count", count, 4, items);
    if (status == SVO_OK) {
        status = scan(s, s->counts, s->before, (uint64_t)SVO_SORT_DIGITS * SVO_SORT_BLOCKS);
    }
    if (status == SVO_OK) {
        status = run(s, "svo_k_sort_scatter", scatter, 5, items);
    }
    cl_mem sorted = s->spare;
    s->spare = *list;
    *list = sorted;
    return status;
}

/* Passes over the low bits of a key. */
static svo_status sort_by(sorter *s, bool by_triangle, uint32_t bits)
{
    svo_sort_params params = {.fragment_count = (cl_uint)s->build->fragment_count, .by_triangle = by_triangle ? 1 : 0};
    svo_status status = SVO_OK;
    for (; params.shift < bits && status == SVO_OK; params.shift += SVO_SORT_BITS) {
        status = sort_pass(s, params);
    }
    return status;
}

static svo_status sort(sorter *s)
{
    const svo_plan *plan = s->build->plan;
    const uint64_t cells = (uint64_t)SVO_SORT_DIGITS * SVO_SORT_BLOCKS;
    uint32_t triangle_bits = 0;
    while (triangle_bits < 32 && (plan->triangle_count - 1) >> triangle_bits != 0) {
        ++triangle_bits;
    }
    svo_status status = svo_i_build_alloc(s->build, "sort_counts", cells * 4, &s->counts);
    if (status == SVO_OK) {
        status = svo_i_build_alloc(s->build, "sort_counts", (cells + 1) * 4, &s->before);
    }
    if (status == SVO_OK && plan->work.lists) {
        status = sort_by(s, true, triangle_bits);
    }
    return status == SVO_OK ? sort_by(s, false, 3 * plan->info.depth) : status;
}

/* All chunks into one buffer, whose place in the list the caller gives it. */
static svo_status join_chunks(sorter *s, cl_mem whole)
{
    svo_i_build *build = s->build;
    const uint64_t fragment_bytes = svo_i_plan_fragment_bytes(build->plan);
    uint64_t offset = 0;
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < build->list.chunk_count && status == SVO_OK; ++i) {
        const uint64_t bytes = build->list.chunks[i].needed * fragment_bytes;
        status = svo_i_build_copy(build, build->list.chunks[i].buffer, whole, offset, bytes);
        offset += bytes;
    }
    return status;
}

/* Takes the list over from the front end, in one buffer. */
static svo_status take_list(sorter *s, svo_frontend *frontend)
{
    svo_i_build *build = s->build;
    const uint64_t bytes = build->fragment_count * svo_i_plan_fragment_bytes(build->plan);
    if (bytes > build->device->max_allocation_bytes) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: builder sorted needs the list's %llu bytes in one buffer, above the "
                                 "device's %llu",
                                 (unsigned long long)bytes, (unsigned long long)build->device->max_allocation_bytes);
    }
    cl_mem whole = NULL;
    svo_status status = svo_i_build_alloc(build, "sorted", bytes, &whole);
    if (status == SVO_OK) {
        status = join_chunks(s, whole);
    }
    if (status == SVO_OK) {
        status = svo_i_build_wait(build);
    }
    if (status != SVO_OK) {
        svo_i_build_free(build, &whole);
        return status;
    }
    svo_i_build_release_list(build, frontend);
    build->list.chunks = calloc(1, sizeof *build->list.chunks);
    if (build->list.chunks == NULL) {
        svo_i_build_free(build, &whole);
        return svo_i_device_fail(build->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for a chunk");
    }
    build->list.chunk_count = 1;
    build->list.chunks[0] =
        (svo_i_fragments){.buffer = whole, .needed = build->fragment_count, .capacity = build->fragment_count};
    build->owns_list = true;
    return svo_i_build_alloc(build, "sorted", bytes, &s->spare);
}

/* Sizes of all levels, from where neighbors in the list part. */
static svo_status count_levels(sorter *s)
{
    svo_i_build *build = s->build;
    svo_tree_info *info = &build->tree->info;
    cl_uint counts[SVO_LEVELS_MAX] = {0};
    const svo_bottom_up_params params = {
        .depth = info->depth, .count = (cl_uint)build->fragment_count, .triangle_count = build->plan->triangle_count};
    svo_status status = svo_i_build_alloc(build, "level_counts", sizeof counts, &s->level_counts);
    if (status == SVO_OK) {
        status = svo_i_build_fill_zero(build, s->level_counts, sizeof counts);
    }
    if (status == SVO_OK) {
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.chunks[0].buffer),
                                            SVO_I_ARGUMENT(s->level_counts), SVO_I_ARGUMENT(params),
                                            SVO_I_LOCAL(SVO_LEVELS_MAX * sizeof(cl_uint))};
        status = run(s, "svo_k_bottom_up_count", arguments, 4, build->fragment_count);
    }
    if (status == SVO_OK) {
        status = svo_i_build_read(build, s->level_counts, counts, sizeof counts);
    }
    if (build->mode == SVO_I_BUILD_MEASURES) {
        return status;
    }
    if (status == SVO_OK && counts[info->depth + 1] != 0) {
        return svo_i_build_fail_damaged(build);
    }
    uint64_t nodes = 0;
    uint64_t begin = 0;
    counts[0] = 1; /* also without any fragment */
    for (uint32_t level = 0; level <= info->depth && status == SVO_OK; ++level) {
        nodes += counts[level];
        info->level_begin[level] = (uint32_t)begin;
        begin += level == 0 || build->fragment_count > 0 ? nodes : 0;
        info->level_begin[level + 1] = (uint32_t)begin;
    }
    if (status == SVO_OK && begin >= UINT32_MAX) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the tree has %llu nodes, above 2^32 - 2; lower the depth",
                                 (unsigned long long)begin);
    }
    info->inner_count = info->level_begin[info->depth];
    info->node_count = info->level_begin[info->depth + 1];
    info->leaf_count = info->node_count - info->inner_count;
    return status;
}

static svo_status allocate_nodes(sorter *s)
{
    svo_i_build *build = s->build;
    const svo_tree_info *info = &build->tree->info;
    const uint64_t code_bytes = info->depth > SVO_CODE30_DEPTH_MAX ? 8 : 4;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    svo_status status =
        svo_i_build_alloc(build, "child_mask", info->inner_count, &build->tree->buffers[SVO_TREE_CHILD_MASK]);
    if (status == SVO_OK) {
        status =
            svo_i_build_alloc(build, "first_child", info->inner_count * 4, &build->tree->buffers[SVO_TREE_FIRST_CHILD]);
    }
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "begin_flags", build->fragment_count * 4, &s->flags);
    }
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "begin_flags", (build->fragment_count + 1) * 4, &s->indices);
    }
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "level_codes", info->leaf_count * code_bytes, &s->codes[0]);
    }
    return status == SVO_OK ? svo_i_build_alloc(build, "level_codes", parents * code_bytes, &s->codes[1]) : status;
}

/* The indices of the nodes that begin in a sequence of codes. */
static svo_status number_nodes(sorter *s, cl_mem codes, svo_bottom_up_params params)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(codes), SVO_I_ARGUMENT(s->flags), SVO_I_ARGUMENT(params)};
    const svo_status status = run(s, "svo_k_bottom_up_flags", arguments, 3, params.count);
    return status == SVO_OK ? scan(s, s->flags, s->indices, params.count) : status;
}

static svo_status make_leaves(sorter *s)
{
    svo_i_build *build = s->build;
    cl_mem fragments = build->list.chunks[0].buffer;
    const svo_bottom_up_params params = {.depth = build->tree->info.depth,
                                         .count = (cl_uint)build->fragment_count,
                                         .of_fragments = 1,
                                         .node_begin = (cl_uint)build->tree->info.inner_count};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(fragments), SVO_I_ARGUMENT(s->indices),
                                        SVO_I_ARGUMENT(build->cursors[0]), SVO_I_ARGUMENT(s->codes[0]),
                                        SVO_I_ARGUMENT(params)};
    const svo_status status = number_nodes(s, fragments, params);
    return status == SVO_OK ? run(s, "svo_k_bottom_up_leaves", arguments, 5, params.count) : status;
}

static svo_status make_level(sorter *s, uint32_t level)
{
    const svo_tree *tree = s->build->tree;
    const uint32_t *begin = tree->info.level_begin;
    const bool odd = (tree->info.depth - level) % 2 != 0;
    cl_mem children = s->codes[odd ? 0 : 1];
    cl_mem nodes = s->codes[odd ? 1 : 0];
    const svo_bottom_up_params params = {.depth = tree->info.depth,
                                         .count = begin[level + 2] - begin[level + 1],
                                         .shift = 3,
                                         .node_begin = begin[level],
                                         .child_begin = begin[level + 1]};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(children),
                                        SVO_I_ARGUMENT(s->indices),
                                        SVO_I_ARGUMENT(nodes),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(params)};
    const svo_status status = number_nodes(s, children, params);
    return status == SVO_OK ? run(s, "svo_k_bottom_up_nodes", arguments, 6, params.count) : status;
}

/* A tree without leaves: a root without children. */
static svo_status make_empty_root(sorter *s)
{
    svo_i_build *build = s->build;
    const cl_uint first_child = 1;
    const svo_status status = svo_i_build_fill_zero(build, build->tree->buffers[SVO_TREE_CHILD_MASK], 1);
    return status == SVO_OK ? svo_i_build_fill(build, build->tree->buffers[SVO_TREE_FIRST_CHILD], &first_child,
                                               sizeof first_child, sizeof first_child)
                            : status;
}

static svo_status make_nodes(sorter *s)
{
    svo_status status = count_levels(s);
    if (status == SVO_OK) {
        status = svo_i_build_put_state(s->build, s->build->tree->info.level_begin);
    }
    if (status == SVO_OK) {
        status = allocate_nodes(s);
    }
    if (status != SVO_OK || s->build->fragment_count == 0) {
        return status == SVO_OK ? make_empty_root(s) : status;
    }
    status = make_leaves(s);
    for (uint32_t level = s->build->tree->info.depth; level-- > 0 && status == SVO_OK;) {
        status = make_level(s, level);
    }
    return status;
}

static svo_status open_sorter(svo_i_build *build, sorter *s)
{
    *s = (sorter){.build = build};
    if (build->mode == SVO_I_BUILD_MEASURES) {
        return SVO_OK;
    }
    return svo_i_program_get(build->device, SVO_I_BUILD, SVO_I_PROGRAM_SORT, svo_i_plan_sort_defines(build->plan),
                             &s->program, NULL);
}

static void release(sorter *s)
{
    cl_mem *buffers[] = {&s->spare,   &s->counts,   &s->before,   &s->flags,
                         &s->indices, &s->codes[0], &s->codes[1], &s->level_counts};
    for (unsigned i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_build_free(s->build, buffers[i]);
    }
}

svo_status svo_i_sorted(svo_i_build *build, svo_frontend *frontend)
{
    sorter s;
    svo_status status = open_sorter(build, &s);
    svo_i_build_stage_begin(build);
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "partials", SVO_SCAN_GROUPS * sizeof(cl_uint), &build->partials);
    }
    if (status == SVO_OK) {
        status = take_list(&s, frontend);
    }
    if (status == SVO_OK) {
        status = svo_i_build_alloc_cursors(build);
    }
    if (status == SVO_OK && build->fragment_count > 0) {
        status = sort(&s);
    }
    if (status == SVO_OK) {
        status = make_nodes(&s);
    }
    if (status == SVO_OK) {
        status = svo_i_build_stage_end(build, SVO_STAGE_SUBDIVIDE);
    }
    release(&s);
    return status;
}

svo_status svo_i_sorted_lists(svo_i_build *build, bool with_lists)
{
    sorter s;
    cl_mem *buffers = build->tree->buffers;
    svo_tree_info *info = &build->tree->info;
    const svo_bottom_up_params params = {.count = (cl_uint)build->fragment_count,
                                         .node_begin = (cl_uint)info->inner_count,
                                         .child_begin = (cl_uint)info->leaf_count};
    svo_status status = open_sorter(build, &s);
    svo_i_build_stage_begin(build);
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "list_begin", (info->leaf_count + 1) * 4, &buffers[SVO_TREE_LIST_BEGIN]);
    }
    if (status == SVO_OK && with_lists) {
        info->list_count = build->fragment_count;
        status = svo_i_build_alloc(build, "list", build->fragment_count * 4, &buffers[SVO_TREE_LIST]);
    }
    if (status == SVO_OK && build->fragment_count == 0) {
        status = svo_i_build_fill_zero(build, buffers[SVO_TREE_LIST_BEGIN], sizeof(cl_uint));
    }
    if (status == SVO_OK) {
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.chunks[0].buffer),
                                            SVO_I_ARGUMENT(build->cursors[0]),
                                            SVO_I_ARGUMENT(buffers[SVO_TREE_LIST_BEGIN]),
                                            SVO_I_ARGUMENT(buffers[SVO_TREE_LIST]), SVO_I_ARGUMENT(params)};
        status = run(&s, "svo_k_bottom_up_lists", arguments, 5, params.count);
    }
    return status == SVO_OK ? svo_i_build_stage_end(build, SVO_STAGE_PACK) : status;
}
