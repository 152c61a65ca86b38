/* SPDX-License-Identifier: MIT */
/* Runs kernels/shared/clip_lanes.clh on eight records of clip_probe.clh per work-item. Lanes that are found to fill
   their voxel are not clipped. */
#include "clip_probe.clh"
#include "shared/clip_lanes.clh"

static clip_probe_output clip_lane(long doubled_area, long u, long v, clip_probe_input given)
{
    clip_probe_output found;
    found.area[0] = (uint)(doubled_area & 0x7fffffff);
    found.area[1] = (uint)(doubled_area >> 31);
    found.u = (uint)u;
    found.v = (uint)v;
    found.weight = svo_part_weight(doubled_area, given.stretch, given.weight_log2);
    return found;
}

__kernel void clip_lanes_all(__global const clip_probe_input *given, __global clip_probe_output *found, uint item_count)
{
    const uint i = (uint)get_global_id(0);
    if (i >= item_count / 8u) {
        return;
    }
    given += 8u * i;
    found += 8u * i;
    const double sub_units = (double)(1 << (SVO_SUB_LOG2 - given->voxel_log2));
    double numbers[9][8];
    for (uint lane = 0; lane < 8u; ++lane) {
        for (uint k = 0; k < 9u; ++k) {
            numbers[k][lane] = given[lane].corners[k] * sub_units + given[lane].remainders[k];
        }
    }
    double8 corners[9];
    double8 at[3][3];
    for (uint k = 0; k < 9u; ++k) {
        corners[k] = vload8(0, numbers[k]);
        at[k % 3u][k / 3u] = corners[k];
    }
    const svo_parts parts = svo_clip_lanes(at[0], at[1], at[2]);
    const long8 full = svo_lanes_full(corners);
    long results[3][8];
    vstore8(select(parts.doubled_area, (long8)(2L * SVO_SUB_EDGE * SVO_SUB_EDGE), full), 0, results[0]);
    vstore8(select(parts.u, (long8)(SVO_SUB_EDGE / 2), full), 0, results[1]);
    vstore8(select(parts.v, (long8)(SVO_SUB_EDGE / 2), full), 0, results[2]);
    for (uint lane = 0; lane < 8u; ++lane) {
        found[lane] = clip_lane(results[0][lane], results[1][lane], results[2][lane], given[lane]);
    }
}
