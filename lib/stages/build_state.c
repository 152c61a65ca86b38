/* SPDX-License-Identifier: MIT */
/* Operations on a build in progress that several stages use. */
#include "stages/build_state.h"

#include <string.h>

#include "plan/accounts.h"
#include "plan/configuration.h"
#include "plan/estimate.h"

_Static_assert(sizeof((svo_build_state *)NULL)->level_begin == SVO_LEVELS_MAX * sizeof(uint32_t),
               "the state has every level of a tree");

/* The place of a program among those of the build: where it is, else the first that is free. */
static size_t find_program(const svo_i_build *build, const svo_i_program *program)
{
    size_t i = 0;
    while (i < SVO_I_STAGE_PROGRAMS_MAX && build->programs[i].program != program && build->programs[i].made != NULL) {
        ++i;
    }
    return i;
}

svo_status svo_i_build_get_program(svo_i_build *build, const char *function, const svo_i_program *program, bool *fresh)
{
    char defines[SVO_I_DEFINES_BYTES];
    svo_i_made_program made = {.program = program};
    const svo_plan *plan = build->commands.plan;
    const size_t place = find_program(build, program);
    if (place == SVO_I_STAGE_PROGRAMS_MAX) {
        return svo_i_device_fail(plan->device, SVO_INTERNAL, "%s: a build has more than %d programs", function,
                                 SVO_I_STAGE_PROGRAMS_MAX);
    }
    svo_i_plan_defines(plan, program, defines, sizeof defines);
    SVO_I_TRY(svo_i_program_get(plan->device, function, program, defines, &made.made, fresh));
    build->programs[place] = made;
    return SVO_OK;
}

cl_program svo_i_build_program(const svo_i_build *build, const svo_i_program *program)
{
    const size_t place = find_program(build, program);
    return place < SVO_I_STAGE_PROGRAMS_MAX ? build->programs[place].made : NULL;
}

svo_status svo_i_build_fail_damaged(svo_i_build *build)
{
    return svo_i_device_fail(build->commands.device, SVO_INTERNAL,
                             "svo_build: %s made a fragment outside the grid or of no triangle", build->frontend->name);
}

svo_status svo_i_build_alloc_cursors(svo_i_build *build)
{
    build->cursors = svo_i_alloc_zeroed(&build->commands.device->memory, build->list.chunk_count + 1u, sizeof(cl_mem));
    if (build->cursors == NULL) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u chunks",
                                 build->list.chunk_count);
    }
    for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
        SVO_I_TRY(
            svo_i_commands_alloc(&build->commands, "cursors", build->list.chunks[i].needed * 4, &build->cursors[i]));
    }
    return SVO_OK;
}

svo_status svo_i_build_alloc_state(svo_i_build *build)
{
    const svo_i_request requests[] = {
        {"state", sizeof build->host_state, &build->state},
        {"partials", build->commands.device->scan_groups * sizeof(cl_uint4), &build->partials}};
    return build->state != NULL ? SVO_OK : svo_i_commands_alloc_all(&build->commands, SVO_I_REQUESTS(requests));
}

svo_status svo_i_build_put_state(svo_i_build *build, const uint32_t level_begin[SVO_LEVELS_MAX])
{
    uint64_t fragments = 0; /* in enqueued builds the capacity, which the device replaces */
    for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
        fragments += build->list.chunks[i].needed;
    }
    build->host_state = (svo_build_state){.fragments_low = (uint32_t)fragments,
                                          .fragments_high = (uint32_t)(fragments >> 32),
                                          .triangle_count = build->commands.plan->triangle_count,
                                          .fragment_limit = UINT32_MAX};
    memcpy(build->host_state.level_begin, level_begin, sizeof build->host_state.level_begin);
    SVO_I_TRY(svo_i_build_alloc_state(build));
    return svo_i_commands_write(&build->commands, build->state, &build->host_state, sizeof build->host_state);
}

svo_status svo_i_build_alloc_published(svo_i_build *build)
{
    return svo_i_commands_alloc(&build->commands, SVO_I_TREE_BUILD_STATE, sizeof(svo_build_state),
                                &build->tree->build_state);
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

svo_status svo_i_build_take_state(svo_i_build *build, const svo_build_state *state, bool *fits)
{
    if (state->overflow == SVO_DAMAGED_LIST) {
        return svo_i_build_fail_damaged(build);
    }
    *fits = state->overflow == 0;
    if (*fits) {
        take_counts(build, state);
    } else if (state->level_begin[state->overflow + 1] <= state->level_begin[state->overflow]) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the tree has more than 2^32 - 1 nodes at level %u; lower the depth",
                                 state->overflow);
    }
    return SVO_OK;
}

void svo_i_build_release_list(svo_i_build *build)
{
    svo_frontend *frontend = build->frontend;
    if (build->list.chunks == NULL) {
        return;
    }
    if (build->owns_list) {
        for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
            svo_i_commands_free(&build->commands, &build->list.chunks[i].buffer);
        }
    } else {
        for (uint32_t i = 0; frontend->make_tree == NULL && i < build->list.chunk_count; ++i) {
            svo_i_plan_buffer_remove(build->commands.plan,
                                     build->list.chunks[i].capacity * svo_i_plan_fragment_bytes(build->commands.plan));
        }
        frontend->release(frontend->self, &build->list);
    }
    svo_i_commands_free(&build->commands, &build->list.counters);
    svo_i_free(build->list.chunks);
    build->list = (svo_i_fragment_list){0};
}

void svo_i_build_fill_info(const svo_i_build *build)
{
    const svo_plan_info *from = &build->commands.plan->info;
    svo_tree_info *to = &build->tree->info;
    to->depth = from->depth;
    to->snap_bits = from->snap_bits;
    to->coverage = from->coverage;
    to->need = from->need;
    to->constant = from->constant;
    to->weights = build->commands.plan->options.weights;
    to->payload_level = build->commands.plan->options.payload_level;
    memcpy(to->origin, from->origin, sizeof to->origin);
    to->edge = from->edge;
    to->scale = from->scale;
    to->is_exact = 1;
    to->triangles = from->triangles;
    to->refused_triangles = from->refused_triangles;
    to->fragments = build->fragment_count;
    const svo_i_plan_part *part = &build->commands.plan->part;
    build->tree->part.header = part->header;
    build->tree->part.level = part->level;
    build->tree->part.code = part->code;
}

/* Plans may describe trees of too many nodes; builds refuse them. */
static uint32_t limited(uint64_t nodes)
{
    return nodes < UINT32_MAX ? (uint32_t)nodes : UINT32_MAX;
}

void svo_i_build_assume_counts(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    svo_tree_info *info = &build->tree->info;
    uint64_t nodes = 0;
    for (uint32_t level = 0; level < info->depth; ++level) {
        info->level_begin[level] = limited(nodes);
        nodes += svo_i_plan_level_nodes(plan, level, build->fragment_count, plan->options.worst_case_nodes != 0);
    }
    info->level_begin[info->depth] = limited(nodes);
    info->inner_count = nodes;
    info->leaf_count = build->fragment_count;
    info->node_count = nodes + build->fragment_count;
    info->level_begin[info->depth + 1] = limited(info->node_count);
    info->fragments = build->fragment_count;
}
