/* SPDX-License-Identifier: MIT */
/* probe.clh in C. The build compiles this file per variant: PROBE_ALL and PROBE_COLUMN_OF name the functions. */
#include "probe.h"

void PROBE_ALL(const probe_input *given, probe_output *found, size_t record_count)
{
    for (size_t i = 0; i < record_count; ++i) {
        found[i] = probe(given[i]);
    }
}

#if !defined(PROBE_INTEGERS) && !defined(PROBE_EXACT)

void PROBE_COLUMN_OF(const probe_input *given, SVO_I32 *first, SVO_I32 *last, SVO_I32 *decided)
{
    const SVO_I32 *k = given->words;
    const SVO_I32 w = k[9];
    const svo_overlap overlap = svo_make_overlap(svo_make_point(k[0], k[1], k[2]), svo_make_point(k[3], k[4], k[5]),
                                                 svo_make_point(k[6], k[7], k[8]), w, k[10], PROBE_AXIS(*given));
    *first = k[14] + 1;
    *last = -1;
    *decided = 0;
    for (SVO_I32 voxel = 0; voxel <= k[14]; ++voxel) {
        const SVO_I32 touches =
            svo_weaker(svo_overlap_column(overlap, k[11], k[12]), svo_overlap_voxel(overlap, k[11], k[12], voxel * w));
        if (touches != SVO_TOUCHES_NOT) {
            *first = voxel < *first ? voxel : *first;
            *last = voxel;
            *decided += touches == SVO_TOUCHES ? 1 : 0;
        }
    }
}

#endif
