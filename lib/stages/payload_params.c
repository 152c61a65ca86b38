/* SPDX-License-Identifier: MIT */
/* The parameters that payload kernels share. */
#include "stages/payload_params.h"

svo_filter_params svo_i_payload_params(const svo_i_build *build)
{
    const svo_tree_info *info = &build->tree->info;
    return (svo_filter_params){.depth = info->depth,
                               .leaf_begin = (cl_uint)info->inner_count,
                               .leaf_count = (cl_uint)info->leaf_count,
                               .voxel_log2 = build->commands.plan->voxel_log2,
                               .weight_log2 = build->commands.plan->weight_log2,
                               .both_sides = build->commands.plan->work.both_sides,
                               .payload_level = info->payload_level};
}

void svo_i_params_of_level(svo_filter_params *params, const svo_tree_info *info, uint32_t level)
{
    params->level = level;
    params->level_begin = info->level_begin[level];
    params->level_count = info->level_begin[level + 1] - info->level_begin[level];
    params->child_begin = info->level_begin[level + 1];
    params->fill_shift = params->weight_log2 + 2 * (info->depth - level - 1) - SVO_I_FILL_LOG2;
}

uint32_t svo_i_digit_passes(uint32_t triangle_count)
{
    uint32_t passes = 0;
    while (passes < 32 / SVO_DIGIT_BITS && triangle_count > 1u &&
           ((triangle_count - 1u) >> (SVO_DIGIT_BITS * passes)) != 0) {
        passes += 2;
    }
    return passes;
}
