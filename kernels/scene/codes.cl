/* SPDX-License-Identifier: MIT */
/*
 * Morton codes of the instances, from the centers of their world boxes: the list that sort.cl sorts, stably, so that
 * equal codes stay in the order of the instances.
 *
 * Launch: one work-item per instance, one dimension, rounded up to whole groups. Reads the boxes; writes a fragment
 * (fragment.clh, with SVO_CODE48) per instance, whose triangle is the instance. No atomics, no local memory. Nothing is
 * contracted to fused multiply-adds, so the codes are the same on every device.
 */
#include "shared/fragment.clh"
#include "shared/scene_layout.h"

#pragma OPENCL FP_CONTRACT OFF

/* A coordinate of the center of a box, in cells. */
static uint svo_scene_cell(float low, float high, float code_low, float code_scale)
{
    const float cell = (0.5f * low + 0.5f * high - code_low) * code_scale;
    const float last = (float)((1u << SVO_SCENE_CODE_BITS) - 1u);
    return cell > 0.0f ? (uint)min(cell, last) : 0u;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scene_codes(__global const svo_scene_instance *instances, __global uint *list, svo_scene_params params)
{
    const uint i = (uint)get_global_id(0);
    if (i >= params.instance_count) {
        return;
    }
    __global const svo_scene_instance *instance = instances + i;
    svo_code code = 0;
    for (uint axis = 0; axis < 3u; ++axis) {
        const uint cell =
            svo_scene_cell(instance->low[axis], instance->high[axis], params.code_low[axis], params.code_scale);
        code |= svo_axis_code(cell) << axis;
    }
    svo_fragment_store(list, i, code, i);
}
