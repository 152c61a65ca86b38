/* SPDX-License-Identifier: MIT */
/*
 * Runs kernels/subdivide.cl and the mask scans of kernels/scan.cl: all levels in one go, without reading anything back
 * between them. The counts come to the host once, at the end.
 */
#include <string.h>

#include "build/build.h"

typedef struct subdivider {
    svo_i_build *build;
    cl_kernel mark, descend, reduce, partials, add;
    cl_mem masks, first_child;
} subdivider;

static svo_status create_kernels(subdivider *s)
{
    svo_status status = svo_i_build_kernel(s->build, "svo_k_mark", &s->mark);
    if (status == SVO_OK) {
        status = svo_i_build_kernel(s->build, "svo_k_descend", &s->descend);
    }
    if (status == SVO_OK) {
        status = svo_i_build_kernel(s->build, "svo_k_scan_masks_reduce", &s->reduce);
    }
    if (status == SVO_OK) {
        status = svo_i_build_kernel(s->build, "svo_k_scan_masks_partials", &s->partials);
    }
    return status == SVO_OK ? svo_i_build_kernel(s->build, "svo_k_scan_masks_add", &s->add) : status;
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

/* Clears the masks and sets the state to a root without children. */
static svo_status begin(subdivider *s)
{
    svo_i_build *build = s->build;
    uint32_t root_alone[SVO_LEVELS_MAX] = {0};
    for (unsigned level = 1; level < SVO_LEVELS_MAX; ++level) {
        root_alone[level] = 1;
    }
    svo_status status = svo_i_build_put_state(build, root_alone);
    if (status == SVO_OK && build->partials == NULL) {
        status = svo_i_build_alloc(build, "partials", SVO_SCAN_GROUPS * sizeof(cl_uint), &build->partials);
    }
    return status == SVO_OK ? svo_i_build_fill_zero(build, s->masks, (build->inner_capacity + 3) / 4 * 4) : status;
}

static svo_status mark_root(subdivider *s, svo_subdivide_params params)
{
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < s->build->list.chunk_count && status == SVO_OK; ++i) {
        const svo_i_fragments *chunk = &s->build->list.chunks[i];
        params.fragment_count = (cl_uint)chunk->needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(chunk->buffer), SVO_I_ARGUMENT(s->masks),
                                            SVO_I_ARGUMENT(s->build->state), SVO_I_ARGUMENT(params)};
        status = svo_i_build_launch(s->build, s->mark, arguments, 4, chunk->needed);
    }
    return status;
}

/* first_child of the level's nodes, and where the level below the next begins. */
static svo_status scan_level(subdivider *s, svo_subdivide_params params)
{
    svo_i_build *build = s->build;
    const uint64_t items = (uint64_t)SVO_SCAN_GROUPS * SVO_GROUP_ITEMS;
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    const svo_i_argument reduce[] = {SVO_I_ARGUMENT(s->masks), SVO_I_ARGUMENT(build->partials),
                                     SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument partials[] = {SVO_I_ARGUMENT(build->partials), SVO_I_ARGUMENT(build->state),
                                       SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument add[] = {SVO_I_ARGUMENT(s->masks),       SVO_I_ARGUMENT(build->partials),
                                  SVO_I_ARGUMENT(s->first_child), SVO_I_ARGUMENT(build->state),
                                  SVO_I_ARGUMENT(params),         scratch};
    svo_status status = svo_i_build_launch(build, s->reduce, reduce, 5, items);
    if (status == SVO_OK) {
        status = svo_i_build_launch(build, s->partials, partials, 4, SVO_GROUP_ITEMS);
    }
    return status == SVO_OK ? svo_i_build_launch(build, s->add, add, 6, items) : status;
}

static svo_status descend(subdivider *s, svo_subdivide_params params)
{
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < s->build->list.chunk_count && status == SVO_OK; ++i) {
        const svo_i_fragments *chunk = &s->build->list.chunks[i];
        params.fragment_count = (cl_uint)chunk->needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(chunk->buffer),   SVO_I_ARGUMENT(s->build->cursors[i]),
                                            SVO_I_ARGUMENT(s->masks),        SVO_I_ARGUMENT(s->first_child),
                                            SVO_I_ARGUMENT(s->build->state), SVO_I_ARGUMENT(params)};
        status = svo_i_build_launch(s->build, s->descend, arguments, 6, chunk->needed);
    }
    return status;
}

/* The count of a list that the host has not seen. */
static svo_status take_count(subdivider *s, svo_subdivide_params params)
{
    params.fragment_count = (cl_uint)s->build->list.chunks[0].capacity;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(s->build->counters), SVO_I_ARGUMENT(s->build->state),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_build_run(s->build, "svo_k_take_count", arguments, 3, 1);
}

/* Room for the inner nodes below a level. A build that waits sizes what depends on a level by its count. */
static uint32_t next_level_capacity(const svo_i_build *build, uint32_t level)
{
    const uint32_t *begin = build->tree->info.level_begin;
    return build->mode == SVO_I_BUILD_RUNS || level + 1 == build->tree->info.depth
               ? UINT32_MAX
               : begin[level + 2] - begin[level + 1];
}

static svo_status run_levels(subdivider *s)
{
    svo_subdivide_params params = {.depth = s->build->plan->info.depth,
                                   .inner_capacity = (cl_uint)s->build->inner_capacity};
    svo_status status = s->build->counters != NULL ? take_count(s, params) : SVO_OK;
    status = status == SVO_OK ? mark_root(s, params) : status;
    for (params.level = 0; params.level < params.depth && status == SVO_OK; ++params.level) {
        params.level_capacity = next_level_capacity(s->build, params.level);
        status = scan_level(s, params);
        if (status == SVO_OK) {
            status = descend(s, params);
        }
    }
    return status;
}

svo_status svo_i_build_put_state(svo_i_build *build, const uint32_t level_begin[SVO_LEVELS_MAX])
{
    build->host_state = (svo_build_state){.triangle_count = build->plan->triangle_count, .fragment_limit = UINT32_MAX};
    memcpy(build->host_state.level_begin, level_begin, sizeof build->host_state.level_begin);
    return build->state == NULL
               ? svo_i_build_upload(build, "state", &build->host_state, sizeof build->host_state, &build->state)
               : svo_i_build_write(build, build->state, &build->host_state, sizeof build->host_state);
}

static void take_counts(svo_i_build *build, const svo_build_state *state)
{
    svo_tree_info *info = &build->tree->info;
    for (uint32_t level = 0; level <= info->depth + 1; ++level) {
        info->level_begin[level] = state->level_begin[level];
    }
    info->inner_count = info->level_begin[info->depth];
    info->node_count = info->level_begin[info->depth + 1];
    info->leaf_count = info->node_count - info->inner_count;
}

svo_status svo_i_take_state(svo_i_build *build, const svo_build_state *state, bool *fits)
{
    if (state->overflow == SVO_DAMAGED_LIST) {
        return svo_i_build_fail_damaged(build);
    }
    *fits = state->overflow == 0;
    if (*fits) {
        take_counts(build, state);
    } else if (state->level_begin[state->overflow + 1] <= state->level_begin[state->overflow]) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the tree has more than 2^32 - 1 nodes at level %u; lower the depth",
                                 state->overflow);
    }
    return SVO_OK;
}

svo_status svo_i_subdivide(svo_i_build *build, bool *fits)
{
    subdivider s = {.build = build,
                    .masks = build->tree->buffers[SVO_TREE_CHILD_MASK],
                    .first_child = build->tree->buffers[SVO_TREE_FIRST_CHILD]};
    if (build->mode != SVO_I_BUILD_MEASURES && build->inner_capacity >= UINT32_MAX) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the tree may have %llu inner nodes, above 2^32 - 1; lower the depth",
                                 (unsigned long long)build->inner_capacity);
    }
    svo_build_state state;
    svo_i_build_stage_begin(build);
    svo_status status = create_kernels(&s);
    if (status == SVO_OK) {
        status = begin(&s);
    }
    if (status == SVO_OK) {
        status = run_levels(&s);
    }
    if (status == SVO_OK) {
        status = svo_i_build_stage_end(build, SVO_STAGE_SUBDIVIDE);
    }
    if (status == SVO_OK && build->mode == SVO_I_BUILD_RUNS) {
        status = svo_i_build_read(build, build->state, &state, sizeof state);
    }
    release_kernels(&s);
    if (build->mode != SVO_I_BUILD_RUNS) { /* counts stay capacities until the end */
        *fits = true;
        return status;
    }
    return status == SVO_OK ? svo_i_take_state(build, &state, fits) : status;
}
