/* SPDX-License-Identifier: MIT */
/* The truth's own paths, with another seed. */
#include "errors/few_paths.h"

#include <math.h>
#include <stdlib.h>

#include "support/input.h"

#define SEED 2u

bool few_paths_make(const error_run *run, const cone_truth *truth, unsigned per_point, few_paths *out)
{
    *out = (few_paths){.run = run, .truth = truth, .per_point = path_sample_count(per_point)};
    out->results = calloc(truth->count, sizeof *out->results);
    return out->results != NULL;
}

void few_paths_free(few_paths *work)
{
    free(work->results);
    work->results = NULL;
}

double few_paths_trace(void *user)
{
    const few_paths *work = user;
    const cone_truth *truth = work->truth;
    const path_scene paths = {.tree = truth->tree,
                              .mesh = truth->opened.source.mesh,
                              .queue = work->run->opened.queue,
                              .setup = &truth->setup,
                              .threads = work->run->threads};
    const double started_ms = input_now_ms();
    const svo_status status = path_trace(&paths, truth->points, truth->count, work->per_point, SEED, work->results);
    return status == SVO_OK ? input_now_ms() - started_ms : -1.0;
}

truth_error few_paths_error(const few_paths *work)
{
    double *irradiance = calloc(3 * work->truth->count, sizeof *irradiance);
    truth_error error = {NAN, NAN, NAN, NAN};
    for (size_t i = 0; i < 3 * work->truth->count && irradiance != NULL; ++i) {
        irradiance[i] = work->results[i / 3].irradiance[i % 3];
    }
    if (irradiance != NULL) {
        error = cone_truth_irradiance_error(work->truth, irradiance);
    }
    free(irradiance);
    return error;
}
