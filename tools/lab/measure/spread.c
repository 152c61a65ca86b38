/* SPDX-License-Identifier: MIT */
/* Medians and quartiles of repeated measurements, and their columns in a table; rounds over all methods. */
#include "measure/spread.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int compare_doubles(const void *a, const void *b)
{
    const double left = *(const double *)a;
    const double right = *(const double *)b;
    return (left > right) - (left < right);
}

double spread_quantile(const double *sorted, size_t count, double fraction)
{
    const double at = fraction * (double)(count - 1);
    const size_t below = (size_t)at;
    const size_t above = below + 1 < count ? below + 1 : below;
    return sorted[below] + (at - (double)below) * (sorted[above] - sorted[below]);
}

spread spread_none(void)
{
    return (spread){.median = NAN, .low = NAN, .high = NAN};
}

spread spread_of(double *values, size_t count)
{
    if (count == 0) {
        return spread_none();
    }
    qsort(values, count, sizeof *values, compare_doubles);
    return (spread){.median = spread_quantile(values, count, 0.5),
                    .low = spread_quantile(values, count, 0.25),
                    .high = spread_quantile(values, count, 0.75)};
}

double spread_median(const double *values, size_t count, double *scratch)
{
    memcpy(scratch, values, count * sizeof *values);
    return spread_of(scratch, count).median;
}

void spread_add_columns(result_table *table, const char *name, const char *unit)
{
    static const char *const suffixes[] = {"", " q1", " q3"};
    for (size_t i = 0; i < sizeof suffixes / sizeof suffixes[0]; ++i) {
        char text[64];
        snprintf(text, sizeof text, "%.48s%s", name, suffixes[i]);
        result_add_column(table, text, unit);
    }
}

void spread_add(result_table *table, spread measured)
{
    result_add_number(table, measured.median);
    result_add_number(table, measured.low);
    result_add_number(table, measured.high);
}

void spread_add_ratio(result_table *table, const double *other_ms, const double *ms, size_t round_count,
                      double *scratch)
{
    for (size_t round = 0; round < round_count; ++round) {
        scratch[round] = other_ms[round] / ms[round];
    }
    spread_add(table, spread_of(scratch, round_count));
}

/* ---- rounds ---- */

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
