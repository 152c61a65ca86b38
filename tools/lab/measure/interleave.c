/* SPDX-License-Identifier: MIT */
/* Rounds over all methods, and their medians. */
#include "measure/interleave.h"

#include <stdlib.h>

#include "measure/spread.h"

bool interleave_measure(interleaved_method *methods, size_t method_count, size_t round_count)
{
    double *times = calloc(method_count * round_count + 1, sizeof *times);
    bool worked = times != NULL;
    const size_t warm_up_count = round_count > 1 ? 1 : 0;
    for (size_t round = 0; round < warm_up_count + round_count && worked; ++round) {
        for (size_t i = 0; i < method_count && worked; ++i) {
            const double ms = methods[i].work_ms(methods[i].user);
            worked = ms >= 0.0;
            if (round >= warm_up_count) {
                times[i * round_count + round - warm_up_count] = ms;
            }
        }
    }
    for (size_t i = 0; i < method_count && worked; ++i) {
        methods[i].median_ms = spread_of(times + i * round_count, round_count).median;
    }
    free(times);
    return worked;
}
