/* SPDX-License-Identifier: MIT */
/* Irradiance is pi times the mean radiance of cosine-weighted rays. */
#include "errors/probe_gather.h"

#include <math.h>
#include <stdlib.h>

#include "errors/hemisphere.h"
#include "support/input.h"

#define PI   3.14159265358979323846
#define SEED 3u

bool probe_gather_make(const error_run *run, const cone_truth *truth, svo_probes *probes, unsigned strata, double lift,
                       probe_gather *out)
{
    const hemisphere_set set = {.strata = strata, .seed = SEED, .lift = lift, .length = INFINITY};
    const size_t ray_count = truth->count * strata * strata;
    *out = (probe_gather){.run = run, .truth = truth, .probes = probes, .per_point = strata * strata};
    if (strata == 0) {
        out->results = calloc(truth->count, sizeof *out->results);
        return out->results != NULL;
    }
    out->rays = calloc(ray_count, sizeof *out->rays);
    out->hits = calloc(ray_count, sizeof *out->hits);
    if (out->rays == NULL || out->hits == NULL) {
        return false;
    }
    hemisphere_rays(&set, truth->points, truth->count, out->rays);
    return true;
}

void probe_gather_free(probe_gather *work)
{
    free(work->rays);
    free(work->hits);
    free(work->results);
    *work = (probe_gather){.per_point = 0};
}

double probe_gather_work(void *user)
{
    const probe_gather *work = user;
    const cone_truth *truth = work->truth;
    cl_command_queue queue = work->run->opened.queue;
    const double started_ms = input_now_ms();
    const svo_status status =
        work->per_point == 0
            ? svo_probes_irradiance(work->probes, truth->points, work->results, truth->count, queue)
            : svo_probes_trace(work->probes, work->rays, work->hits, truth->count * work->per_point, NULL, queue);
    return status == SVO_OK ? input_now_ms() - started_ms : -1.0;
}

static void sum_rays(const probe_gather *work, size_t point, double irradiance[3])
{
    const svo_probe_hit *hits = work->hits + point * work->per_point;
    double sums[3] = {0};
    unsigned known = 0;
    for (unsigned i = 0; i < work->per_point; ++i) {
        if (hits[i].state != SVO_PROBE_UNKNOWN) {
            ++known;
            for (int channel = 0; channel < 3; ++channel) {
                sums[channel] += (double)hits[i].radiance[channel];
            }
        }
    }
    for (int channel = 0; channel < 3; ++channel) {
        irradiance[channel] = known > 0 ? PI * sums[channel] / known : 0;
    }
}

truth_error probe_gather_error(const probe_gather *work)
{
    double *irradiance = calloc(3 * work->truth->count, sizeof *irradiance);
    truth_error error = {NAN, NAN, NAN, NAN};
    for (size_t point = 0; point < work->truth->count && irradiance != NULL; ++point) {
        if (work->per_point > 0) {
            sum_rays(work, point, irradiance + 3 * point);
            continue;
        }
        for (size_t channel = 0; channel < 3; ++channel) {
            irradiance[3 * point + channel] = (double)work->results[point].irradiance[channel];
        }
    }
    if (irradiance != NULL) {
        error = cone_truth_irradiance_error(work->truth, irradiance);
    }
    free(irradiance);
    return error;
}
