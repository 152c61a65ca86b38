/* SPDX-License-Identifier: MIT */
/* Sums of blocks that are drawn. */
#include "tune/resample.h"

#include <math.h>

double resample_error(const tune_errors *errors, const tune_measure *measure, draw which)
{
    const samples *of = &errors->of[measure->quantity];
    random_stream random = bootstrap_begin(which);
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

interval interval_of_error(const tune_errors *errors, const tune_measure *measure)
{
    double values[BOOTSTRAP_DRAWS];
    const sample_block sum = samples_sum(&errors->of[measure->quantity]);
    const double estimate = fabs(tune_measure_value(measure, errors, &sum));
    if (!(sum.count > 0)) {
        return (interval){NAN, NAN, NAN};
    }
    for (size_t i = 0; i < BOOTSTRAP_DRAWS; ++i) {
        values[i] = resample_error(errors, measure, (draw){i, 2});
        values[i] = isfinite(values[i]) ? values[i] : estimate;
    }
    return bootstrap_interval(values, estimate);
}
