/* SPDX-License-Identifier: MIT */
/* Percentile intervals of 200 draws. */
#include "tune/resample.h"

#include <math.h>
#include <string.h>

#include "measure/spread.h"
#include "scenes/maths.h"

#define DRAWS 200u

static random_stream begin_draw(draw which)
{
    random_stream of_stream = {.state = which.stream};
    random_stream of_draw = {.state = random_bits(&of_stream) + which.number};
    return (random_stream){.state = random_bits(&of_draw)};
}

double resample_median(const double *rounds, size_t count)
{
    double values[RESAMPLE_ROUNDS_MAX];
    memcpy(values, rounds, count * sizeof *values);
    return count > 0 ? spread_of(values, count).median : (double)NAN;
}

double resample_time(const double *rounds, size_t count, draw which)
{
    double values[RESAMPLE_ROUNDS_MAX];
    random_stream random = begin_draw(which);
    for (size_t i = 0; i < count; ++i) {
        values[i] = rounds[random_index(&random, (uint32_t)count)];
    }
    return count > 0 ? spread_of(values, count).median : (double)NAN;
}

double resample_error(const tune_errors *errors, const tune_measure *measure, draw which)
{
    const samples *of = &errors->of[measure->quantity];
    random_stream random = begin_draw(which);
    sample_block sum = {0, 0, 0, 0};
    for (size_t i = 0; i < SAMPLE_BLOCKS; ++i) {
        const sample_block *block = &of->blocks[random_index(&random, SAMPLE_BLOCKS)];
        sum.count += block->count;
        sum.sum += block->sum;
        sum.square_sum += block->square_sum;
        sum.most = fmax(sum.most, block->most);
    }
    return fabs(tune_measure_value(measure, errors, &sum));
}

static interval middle_of(double *values, double estimate)
{
    (void)spread_of(values, DRAWS); /* sorts */
    return (interval){fmin(spread_quantile(values, DRAWS, 0.025), estimate), estimate,
                      fmax(spread_quantile(values, DRAWS, 0.975), estimate)};
}

interval interval_of_time(const double *rounds, size_t count)
{
    double values[DRAWS];
    if (count == 0) {
        return (interval){NAN, NAN, NAN};
    }
    for (size_t i = 0; i < DRAWS; ++i) {
        values[i] = resample_time(rounds, count, (draw){i, 1});
    }
    return middle_of(values, resample_median(rounds, count));
}

interval interval_of_error(const tune_errors *errors, const tune_measure *measure)
{
    double values[DRAWS];
    const sample_block sum = samples_sum(&errors->of[measure->quantity]);
    const double estimate = fabs(tune_measure_value(measure, errors, &sum));
    if (!(sum.count > 0)) {
        return (interval){NAN, NAN, NAN};
    }
    for (size_t i = 0; i < DRAWS; ++i) {
        values[i] = resample_error(errors, measure, (draw){i, 2});
        values[i] = isfinite(values[i]) ? values[i] : estimate;
    }
    return middle_of(values, estimate);
}
