/* SPDX-License-Identifier: MIT */
/* Ambient occlusion ends at the range of the sampler; light has none, so that the two are traced apart. */
#include "tune/light_errors.h"

#include <math.h>
#include <stdlib.h>

#include "path/surface_points.h"
#include "support/info_of.h"

#define TRUE_SAMPLES 4096u /* paths of a point */

uint32_t sampler_need(const sampler *made, const tune_setting *setting, uint32_t need)
{
    const svo_mesh *mesh = made->source->mesh;
    if (setting->values[DIMENSION_GATHER] == 0) {
        return need;
    }
    return SVO_NEED_NORMAL | SVO_NEED_RAYS | SVO_NEED_PROJECTED_AREA |
           (made->has_colors ? (uint32_t)SVO_NEED_COLOR : 0U) |
           (mesh->finishes != NULL ? (uint32_t)SVO_NEED_MATERIAL : 0U);
}

svo_light *sampler_light(const sampler *made, session *opened, svo_tree *tree, const tune_setting *setting)
{
    const bool cones = setting->values[DIMENSION_GATHER] > 0;
    const svo_light_options asked = {
        .struct_size = sizeof asked, .form = (svo_light_form)setting->values[DIMENSION_LIGHT_FORM], .no_cones = !cones};
    svo_light_setup setup = made->setup;
    svo_light *light = NULL;
    setup.sources = &made->sun;
    setup.source_count = 1;
    if (svo_light_create(tree, &asked, opened->queue, &light) != SVO_OK ||
        svo_light_set_sources(light, &setup, opened->queue) != SVO_OK) {
        svo_light_destroy(&light);
    }
    return light;
}

svo_status sampler_gather(const sampler *made, session *opened, svo_light *light, const tune_setting *setting,
                          bool with_light, svo_gather_result *results)
{
    const int gather = setting->values[DIMENSION_GATHER];
    const svo_gather_options asked = {.struct_size = sizeof asked,
                                      .method = gather > 0 ? SVO_GATHER_CONES : SVO_GATHER_RAYS,
                                      .cones = gather > 0 ? (uint32_t)gather : 0,
                                      .paths = gather < 0 ? (uint32_t)-gather : 0,
                                      .range = with_light ? 0 : (float)made->range,
                                      .no_light = !with_light};
    return svo_gather(light, svo_in_host(made->points), svo_in_host(results), SAMPLER_LIGHT_POINTS, &asked,
                      &(svo_submit){.queue = opened->queue});
}

static svo_status trace(const sampler *made, double range, path_result *results)
{
    svo_light_setup setup = made->setup;
    setup.sources = &made->sun;
    setup.source_count = 1;
    const path_scene paths = {.tree = made->truth,
                              .mesh = made->source->mesh,
                              .queue = made->opened->queue,
                              .setup = &setup,
                              .range = range,
                              .threads = made->threads};
    return path_trace(&paths, made->points, SAMPLER_LIGHT_POINTS, TRUE_SAMPLES, made->light_seed, results);
}

/* Ambient occlusion has a range, and light has none. */
int sampler_light_truth(sampler *made, uint32_t seed)
{
    if (made->points != NULL && made->light_seed == seed) {
        return PROGRAM_DONE;
    }
    made->points = made->points != NULL ? made->points : calloc(SAMPLER_LIGHT_POINTS, sizeof *made->points);
    made->lit = made->lit != NULL ? made->lit : calloc(SAMPLER_LIGHT_POINTS, sizeof *made->lit);
    path_result *lit = calloc(SAMPLER_LIGHT_POINTS, sizeof *lit);
    made->light_seed = seed;
    made->mean_irradiance = 0;
    if (made->points == NULL || made->lit == NULL || lit == NULL ||
        !surface_points(made->source->mesh, SAMPLER_LIGHT_POINTS, seed, made->points)) {
        free(lit);
        return program_fail(made->state, PROGRAM_FAILED, "out of memory for points");
    }
    const bool traced = trace(made, made->range, made->lit) == SVO_OK && trace(made, 0, lit) == SVO_OK;
    for (size_t i = 0; i < SAMPLER_LIGHT_POINTS && traced; ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            made->lit[i].irradiance[channel] = lit[i].irradiance[channel];
            made->mean_irradiance += lit[i].irradiance[channel] / (3.0 * SAMPLER_LIGHT_POINTS);
        }
    }
    free(lit);
    return traced ? PROGRAM_DONE : program_fail_library(made->state, svo_device_message(made->opened->device));
}
