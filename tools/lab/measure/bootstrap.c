/* SPDX-License-Identifier: MIT */
/* Percentile intervals of 200 draws. */
#include "measure/bootstrap.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "measure/spread.h"

random_stream bootstrap_begin(draw which)
{
    random_stream of_stream = {.state = which.stream};
    random_stream of_draw = {.state = random_bits(&of_stream) + which.number};
    return (random_stream){.state = random_bits(&of_draw)};
}

interval bootstrap_interval(double *values, double estimate)
{
    (void)spread_of(values, BOOTSTRAP_DRAWS); /* sorts */
    return (interval){fmin(spread_quantile(values, BOOTSTRAP_DRAWS, 0.025), estimate), estimate,
                      fmax(spread_quantile(values, BOOTSTRAP_DRAWS, 0.975), estimate)};
}

double bootstrap_median(const double *rounds, size_t count)
{
    double values[BOOTSTRAP_ROUNDS_MAX];
    memcpy(values, rounds, count * sizeof *values);
    return count > 0 ? spread_of(values, count).median : (double)NAN;
}

double bootstrap_time(const double *rounds, size_t count, draw which)
{
    double values[BOOTSTRAP_ROUNDS_MAX];
    random_stream random = bootstrap_begin(which);
    for (size_t i = 0; i < count; ++i) {
        values[i] = rounds[random_index(&random, (uint32_t)count)];
    }
    return count > 0 ? spread_of(values, count).median : (double)NAN;
}

interval interval_of_time(const double *rounds, size_t count)
{
    double values[BOOTSTRAP_DRAWS];
    if (count == 0) {
        return (interval){NAN, NAN, NAN};
    }
    for (size_t i = 0; i < BOOTSTRAP_DRAWS; ++i) {
        values[i] = bootstrap_time(rounds, count, (draw){i, 1});
    }
    return bootstrap_interval(values, bootstrap_median(rounds, count));
}

void interval_add(result_table *table, interval of)
{
    result_add_number(table, of.middle);
    result_add_number(table, of.low);
    result_add_number(table, of.high);
}

void interval_add_columns(result_table *table, const char *name, const char *unit)
{
    static const char *const suffixes[] = {"", " low", " high"};
    for (size_t i = 0; i < 3; ++i) {
        char text[64];
        snprintf(text, sizeof text, "%.48s%s", name, suffixes[i]);
        result_add_column(table, text, unit);
    }
}
