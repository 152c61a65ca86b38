/* SPDX-License-Identifier: MIT */
/* Rounds of all ways, and medians. */
#include "turns.h"

#include <stdlib.h>

static int compare_doubles(const void *a, const void *b)
{
    const double left = *(const double *)a;
    const double right = *(const double *)b;
    return (left > right) - (left < right);
}

double quantile_of_sorted(const double *values, size_t count, double share)
{
    if (count == 0) {
        return 0.0;
    }
    const double at = share * (double)(count - 1);
    const size_t below = (size_t)at;
    const size_t above = below + 1 < count ? below + 1 : below;
    return values[below] + (values[above] - values[below]) * (at - (double)below);
}

double median_of(double *values, size_t count)
{
    qsort(values, count, sizeof *values, compare_doubles);
    return quantile_of_sorted(values, count, 0.5);
}

bool turns_measure(turn *ways, size_t way_count, size_t round_count)
{
    double *times = calloc(way_count * round_count + 1, sizeof *times);
    bool worked = times != NULL;
    for (size_t round = 0; round <= round_count && worked; ++round) {
        for (size_t i = 0; i < way_count && worked; ++i) {
            const double ms = ways[i].work_ms(ways[i].user);
            worked = ms >= 0.0;
            if (round > 0) {
                times[i * round_count + round - 1] = ms;
            }
        }
    }
    for (size_t i = 0; i < way_count && worked; ++i) {
        ways[i].median_ms = median_of(times + i * round_count, round_count);
    }
    free(times);
    return worked;
}
