/* SPDX-License-Identifier: MIT */
/*
 * Collects the materials and weights of each leaf, sorts them, and merges them level by level up to the root. Each node
 * gets the material of the largest weight.
 */
#include "stages/material.h"

#include "shared/moving_layout.h"
#include "stages/inputs.h"
#include "stages/programs.h"

/* The entries of a level's nodes: pairs of a material and a weight. */
typedef struct level_entries {
    cl_mem begins, counts, entries;
} level_entries;

typedef struct sorter {
    svo_i_build *build;
    cl_mem list_begin, materials;
    cl_mem long_leaves; /* on GPUs: how many leaves a work-group sorts, and which; else NULL */
    level_entries levels[2]; /* index: distance of the level from the leaves, modulo 2 */
    cl_kernel merge;
    svo_filter_params params;
} sorter;

static uint64_t most_long_leaves(const svo_i_build *build)
{
    return build->fragment_count / (SVO_LONG_LEAF + 1);
}

static svo_status allocate(sorter *s)
{
    svo_i_build *build = s->build;
    const svo_tree_info *info = &build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    const uint64_t grandparents =
        info->depth > 1 ? info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2] : 1;
    const svo_i_request requests[] = {
        {"entry_counts", info->leaf_count * 4, &s->levels[0].counts},
        {"entry_begins", grandparents * 4, &s->levels[0].begins},
        {"entry_counts", parents * 4, &s->levels[1].counts},
        {"entry_begins", parents * 4, &s->levels[1].begins},
        {"entries", build->fragment_count * 8, &s->levels[0].entries},
        {"entries", build->fragment_count * 8, &s->levels[1].entries},
        {"long_leaves", (most_long_leaves(build) + 1) * 4, &s->long_leaves} /* on GPUs */
    };
    const size_t count = sizeof requests / sizeof requests[0] - (build->commands.device->cpu_path ? 1 : 0);
    return svo_i_commands_alloc_all(&build->commands, requests, count);
}

static void release(sorter *s)
{
    if (s->merge != NULL) {
        clReleaseKernel(s->merge);
    }
    svo_i_commands_free(&s->build->commands, &s->long_leaves);
    for (unsigned odd = 0; odd < 2; ++odd) {
        svo_i_commands_free(&s->build->commands, &s->levels[odd].counts);
        svo_i_commands_free(&s->build->commands, &s->levels[odd].begins);
        svo_i_commands_free(&s->build->commands, &s->levels[odd].entries);
    }
}

/* The same from pairs that are weighed already, in the order of the leaves. */
static svo_status take_kept(sorter *s)
{
    svo_i_build *build = s->build;
    const svo_i_kept *kept = build->kept;
    const svo_moving_params params = {.count = (cl_uint)build->fragment_count};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(kept->values), SVO_I_ARGUMENT(kept->materials),
                                        SVO_I_ARGUMENT(s->levels[0].entries), SVO_I_ARGUMENT(params)};
    return svo_i_commands_run(&build->commands, kept->program, "svo_k_moving_entries", SVO_I_ARGUMENTS(arguments),
                              params.count);
}

static svo_status scatter(sorter *s)
{
    svo_i_build *build = s->build;
    if (build->kept != NULL) {
        return take_kept(s);
    }
    SVO_I_TRY(svo_i_commands_fill_zero(&build->commands, s->levels[0].counts, s->params.leaf_count * UINT64_C(4)));
    for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
        s->params.fragment_count = (cl_uint)build->list.chunks[i].needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.chunks[i].buffer),
                                            SVO_I_ARGUMENT(build->cursors[i]),
                                            SVO_I_ARGUMENT(build->surface.vertices),
                                            SVO_I_ARGUMENT(build->surface.remainders),
                                            SVO_I_ARGUMENT(build->surface.indices),
                                            SVO_I_ARGUMENT(build->surface.records),
                                            SVO_I_ARGUMENT(s->list_begin),
                                            SVO_I_ARGUMENT(s->levels[0].counts),
                                            SVO_I_ARGUMENT(s->levels[0].entries),
                                            SVO_I_ARGUMENT(build->state),
                                            SVO_I_ARGUMENT(s->params)};
        SVO_I_TRY(svo_i_commands_run(&build->commands, svo_i_build_program(build, &svo_i_program_filter),
                                     "svo_k_material_scatter", SVO_I_ARGUMENTS(arguments), s->params.fragment_count));
    }
    return SVO_OK;
}

static svo_status sort_leaves(sorter *s)
{
    svo_i_commands *commands = &s->build->commands;
    cl_program program = svo_i_build_program(s->build, &svo_i_program_filter);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(s->list_begin),
                                        SVO_I_ARGUMENT(s->levels[0].counts),
                                        SVO_I_ARGUMENT(s->levels[0].entries),
                                        SVO_I_ARGUMENT(s->levels[1].entries),
                                        SVO_I_ARGUMENT(s->long_leaves),
                                        SVO_I_ARGUMENT(s->materials),
                                        SVO_I_ARGUMENT(s->build->state),
                                        SVO_I_ARGUMENT(s->params),
                                        SVO_I_LOCAL(sizeof(cl_uint) * SVO_DIGITS * SVO_GROUP_ITEMS),
                                        SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint))};
    enum { COUNT = sizeof arguments / sizeof arguments[0], LOCALS = 2 };
    const uint64_t most = most_long_leaves(s->build);
    if (s->long_leaves == NULL) {
        return svo_i_commands_run(commands, program, "svo_k_material_leaves", arguments, COUNT - LOCALS,
                                  s->params.leaf_count);
    }
    SVO_I_TRY(svo_i_commands_fill_zero(commands, s->long_leaves, sizeof(cl_uint)));
    SVO_I_TRY(svo_i_commands_run(commands, program, "svo_k_material_leaves", arguments, COUNT - LOCALS,
                                 s->params.leaf_count));
    return svo_i_commands_run(commands, program, "svo_k_material_long", arguments, COUNT,
                              (most < commands->device->scan_groups ? most : commands->device->scan_groups) *
                                  SVO_GROUP_ITEMS);
}

/* Merges the entries of a level's nodes, or of those and of all levels above. */
static svo_status merge_level(sorter *s, uint32_t level, bool is_top)
{
    svo_tree *tree = s->build->tree;
    const bool odd = (tree->info.depth - level) % 2 != 0;
    const level_entries *children = &s->levels[odd ? 0 : 1];
    const level_entries *nodes = &s->levels[odd ? 1 : 0];
    const bool of_leaves = level + 1 == tree->info.depth;
    svo_i_params_of_level(&s->params, &tree->info, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        of_leaves ? SVO_I_ARGUMENT(s->list_begin) : SVO_I_ARGUMENT(children->begins),
                                        SVO_I_ARGUMENT(children->counts),
                                        SVO_I_ARGUMENT(children->entries),
                                        SVO_I_ARGUMENT(nodes->begins),
                                        SVO_I_ARGUMENT(nodes->counts),
                                        SVO_I_ARGUMENT(nodes->entries),
                                        SVO_I_ARGUMENT(s->materials),
                                        SVO_I_ARGUMENT(s->build->state),
                                        SVO_I_ARGUMENT(s->params)};
    svo_i_commands *commands = &s->build->commands;
    return is_top ? svo_i_commands_run(commands, svo_i_build_program(s->build, &svo_i_program_filter),
                                       "svo_k_material_top", SVO_I_ARGUMENTS(arguments), SVO_GROUP_ITEMS)
                  : svo_i_commands_launch(commands, s->merge, SVO_I_ARGUMENTS(arguments), s->params.level_count);
}

/* From the deepest level up to the first that has payload. One group does the levels from
   SVO_TOP_LEVEL on. */
static svo_status merge_levels(sorter *s)
{
    const uint32_t depth = s->build->tree->info.depth;
    bool is_top = false;
    for (uint32_t level = depth; level-- > s->params.payload_level && !is_top;) {
        is_top = level <= SVO_TOP_LEVEL && level + 1 < depth;
        SVO_I_TRY(merge_level(s, level, is_top));
    }
    return SVO_OK;
}

/* Keeps the root's entries of a part, from which the levels above it are made. They begin at the first slot. */
static svo_status keep_root(sorter *s)
{
    svo_i_build *build = s->build;
    const level_entries *root = &s->levels[build->tree->info.depth % 2];
    cl_uint count = 0;
    SVO_I_TRY(svo_i_commands_read(&build->commands, root->counts, &count, sizeof count));
    if (build->commands.mode != SVO_I_MODE_RUN) {
        return SVO_OK; /* nothing was counted */
    }
    build->tree->part.runs = svo_i_alloc(&build->tree->memory, ((size_t)count + 1) * sizeof(uint64_t));
    if (build->tree->part.runs == NULL) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_HOST_MEMORY,
                                 "svo_build: no memory for %u materials", count);
    }
    build->tree->part.run_count = count;
    return svo_i_commands_read(&build->commands, root->entries, build->tree->part.runs, count * sizeof(uint64_t));
}

static svo_status run(sorter *s)
{
    SVO_I_TRY(allocate(s));
    SVO_I_TRY(svo_i_commands_kernel(&s->build->commands, svo_i_build_program(s->build, &svo_i_program_filter),
                                    "svo_k_material_merge", &s->merge));
    SVO_I_TRY(scatter(s));
    SVO_I_TRY(sort_leaves(s));
    SVO_I_TRY(merge_levels(s));
    return svo_i_part_sums_root(s->build->commands.plan) ? keep_root(s) : SVO_OK;
}

/* Releases the ranges of entries if nothing else needs them. */
static void free_ranges(svo_i_build *build)
{
    if (!build->commands.plan->work.lists && !build->commands.plan->work.order) {
        svo_i_commands_free(&build->commands, &build->tree->buffers[SVO_TREE_LIST_BEGIN]);
    }
}

static svo_status make_materials(svo_i_build *build)
{
    const svo_tree_info *info = &build->tree->info;
    const bool may_be_empty =
        info->leaf_count == 0 || build->commands.mode == SVO_I_MODE_ENQUEUE; /* an enqueued tree may turn out empty */
    cl_mem *materials = &build->tree->buffers[SVO_TREE_MATERIALS];
    const uint64_t nodes = info->node_count - info->level_begin[info->payload_level];
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, "materials", nodes * sizeof(cl_ushort), materials));
    svo_i_stage_begin(&build->commands);
    if (may_be_empty && info->payload_level == 0) {
        SVO_I_TRY(svo_i_commands_fill_zero(&build->commands, *materials, sizeof(cl_ushort)));
    }
    if (info->leaf_count > 0) {
        sorter s = {.build = build,
                    .list_begin = build->tree->buffers[SVO_TREE_LIST_BEGIN],
                    .materials = *materials,
                    .params = svo_i_payload_params(build)};
        s.params.digit_passes = svo_i_digit_passes(build->commands.plan->material_count);
        const svo_status status = run(&s);
        release(&s);
        SVO_I_TRY(status);
    }
    return svo_i_stage_end(&build->commands, SVO_STAGE_FILTER);
}

svo_status svo_i_material(svo_i_build *build)
{
    const svo_status status = make_materials(build);
    free_ranges(build);
    return status;
}
