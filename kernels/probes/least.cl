/* SPDX-License-Identifier: MIT */
/*
 * Least distances of blocks of texels, which rays skip at once.
 *
 * Launch: one work-item per block of 16 x 16 texels. Reads texels, writes one code per block. No atomics, no local
 * memory.
 */
#include "shared/probe_layout.h"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_least(__global const uint *texels, __global ushort *least, svo_probes_params params, svo_probe_step step)
{
    const uint i = step.first + (uint)get_global_id(0);
    if ((uint)get_global_id(0) >= step.count) {
        return;
    }
    const uint blocks = params.resolution / SVO_PROBE_BLOCK;
    /* i / blocks: the row of blocks, among those of all probes. */
    const size_t first = ((size_t)(i / blocks) * params.resolution + i % blocks) * SVO_PROBE_BLOCK;
    uint code = SVO_PROBE_NOTHING;
    for (uint k = 0; k < SVO_PROBE_BLOCK * SVO_PROBE_BLOCK; ++k) {
        const size_t texel = first + (size_t)(k / SVO_PROBE_BLOCK) * params.resolution + k % SVO_PROBE_BLOCK;
        code = min(code, texels[2u * texel] & 0xffffu);
    }
    least[i] = (ushort)code;
}
