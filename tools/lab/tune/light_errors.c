/* SPDX-License-Identifier: MIT */
/*
 * Settings gather as `svocl gather` does. The truth has as many reflections as a method: one by cones and rays; two by
 * probes, whose texels gather by cones what others reflect.
 */
#include "tune/light_errors.h"

#include <math.h>
#include <stdlib.h>

#include "path/surface_points.h"
#include "support/info_of.h"

#define TRUE_SAMPLES 4096u /* paths of a point */
#define LEAST_LIGHT  1e-9 /* mean irradiance of what is lit */

svo_light *sampler_light(const sampler *made, session *opened, svo_tree *tree, const tune_setting *setting)
{
    const svo_mesh *mesh = made->source->mesh;
    const svo_light_options asked = {.struct_size = sizeof asked,
                                     .form = (svo_light_form)setting->values[DIMENSION_LIGHT_FORM],
                                     .no_cones = gather_how(setting->values[DIMENSION_GATHER]) == GATHER_RAYS};
    const bool has_triangles = setting->values[DIMENSION_COVERAGE] != SVO_COVERAGE_THIN;
    const bool has_looks = mesh->material_count > 0 || mesh->colors != NULL || mesh->normals != NULL;
    svo_light *light = NULL;
    if (svo_light_create(tree, &asked, opened->queue, &light) != SVO_OK ||
        svo_light_set_sources(light, &made->setup, opened->queue) != SVO_OK ||
        (has_triangles && has_looks && svo_light_set_mesh(light, mesh, opened->queue) != SVO_OK)) {
        svo_light_destroy(&light);
    }
    return light;
}

svo_probes *sampler_probes(session *opened, svo_tree *tree, svo_light *light, const tune_setting *setting)
{
    const int gather = setting->values[DIMENSION_GATHER];
    const uint32_t along = gather_along(gather);
    const svo_probe_options asked = {.struct_size = sizeof asked,
                                     .counts = {along, along, along},
                                     .resolution = gather_texels(gather),
                                     .diffuse = 1,
                                     .light = light,
                                     .tree = tree};
    svo_probes *probes = NULL;
    return svo_probes_create(&asked, opened->queue, &probes) == SVO_OK ? probes : NULL;
}

/* ---- gathering ---- */

static bool gather_probes(const sampler *made, session *opened, svo_probes *probes, svo_gather_result *results)
{
    svo_probe_irradiance found[GATHER_POINTS];
    const bool worked = svo_probes_irradiance(probes, svo_in_host(made->points), svo_in_host(found), GATHER_POINTS,
                                              &(svo_submit){.queue = opened->queue}) == SVO_OK;
    for (size_t i = 0; i < GATHER_POINTS && worked; ++i) {
        results[i] = (svo_gather_result){.openness = NAN, .direct = {NAN, NAN, NAN}};
        for (int channel = 0; channel < 3; ++channel) {
            results[i].irradiance[channel] = found[i].irradiance[channel];
        }
    }
    return worked;
}

/* Cones with a range bring no light from beyond it, so that openness takes cones of its own. */
static bool gather_openness(const sampler *made, session *opened, svo_light *light, svo_gather_options asked,
                            svo_gather_result *results)
{
    svo_gather_result open[GATHER_POINTS];
    asked.range = (float)made->range;
    asked.no_light = 1;
    const bool worked = svo_gather(light, svo_in_host(made->points), svo_in_host(open), GATHER_POINTS, &asked,
                                   &(svo_submit){.queue = opened->queue}) == SVO_OK;
    for (size_t i = 0; i < GATHER_POINTS && worked; ++i) {
        results[i].openness = open[i].openness;
    }
    return worked;
}

bool sampler_gather(const sampler *made, session *opened, svo_light *light, svo_probes *probes,
                    const tune_setting *setting, svo_gather_result *results)
{
    const int gather = setting->values[DIMENSION_GATHER];
    const bool by_cones = gather_how(gather) == GATHER_CONES;
    const svo_gather_options asked = {.struct_size = sizeof asked,
                                      .method = by_cones ? SVO_GATHER_CONES : SVO_GATHER_RAYS,
                                      .cones = by_cones ? gather_count(gather) : 0,
                                      .paths = by_cones ? 0 : gather_count(gather),
                                      .range = by_cones ? 0 : (float)made->range};
    if (probes != NULL) {
        return gather_probes(made, opened, probes, results);
    }
    return svo_gather(light, svo_in_host(made->points), svo_in_host(results), GATHER_POINTS, &asked,
                      &(svo_submit){.queue = opened->queue}) == SVO_OK &&
           (!by_cones || gather_openness(made, opened, light, asked, results));
}

/* ---- truth ---- */

static svo_status trace(const sampler *made, unsigned bounces, path_result *results)
{
    const path_scene paths = {.tree = made->truth,
                              .mesh = made->source->mesh,
                              .queue = made->opened->queue,
                              .setup = &made->setup,
                              .range = made->range,
                              .bounces = bounces,
                              .threads = made->threads};
    return path_trace(&paths, made->points, GATHER_POINTS, TRUE_SAMPLES, made->light_seed, results);
}

int sampler_light_truth(sampler *made, uint32_t seed)
{
    if (made->points != NULL && made->light_seed == seed) {
        return PROGRAM_DONE;
    }
    made->points = made->points != NULL ? made->points : calloc(GATHER_POINTS, sizeof *made->points);
    made->lit = made->lit != NULL ? made->lit : calloc(GATHER_POINTS, sizeof *made->lit);
    made->twice_lit = made->twice_lit != NULL ? made->twice_lit : calloc(GATHER_POINTS, sizeof *made->twice_lit);
    made->light_seed = seed;
    if (made->points == NULL || made->lit == NULL || made->twice_lit == NULL ||
        !surface_points(made->source->mesh, GATHER_POINTS, seed, made->points)) {
        return program_fail(made->state, PROGRAM_FAILED, "out of memory for points");
    }
    return trace(made, 1, made->lit) == SVO_OK && (!made->has_probes || trace(made, 2, made->twice_lit) == SVO_OK)
               ? PROGRAM_DONE
               : program_fail_library(made->state, svo_device_message(made->opened->device));
}

/* ---- errors ---- */

/* The mean over points and channels of light that is direct or not. */
static double mean_light(const path_result *lit, bool direct)
{
    double sum = 0;
    for (size_t i = 0; i < 3 * (size_t)GATHER_POINTS; ++i) {
        sum += direct ? lit[i / 3].direct[i % 3] : lit[i / 3].irradiance[i % 3];
    }
    return sum / (3.0 * GATHER_POINTS);
}

bool sampler_is_lit(const sampler *made, tune_quantity quantity)
{
    return mean_light(made->lit, quantity == QUANTITY_DIRECT) > LEAST_LIGHT;
}

void light_errors_add(const sampler *made, const tune_setting *setting, const svo_gather_result *results,
                      tune_errors *errors)
{
    const bool by_probes = gather_how(setting->values[DIMENSION_GATHER]) == GATHER_PROBES;
    const path_result *truth = by_probes ? made->twice_lit : made->lit;
    const double light = mean_light(truth, false);
    const double direct = mean_light(truth, true);
    for (size_t i = 0; i < GATHER_POINTS; ++i) {
        if (!truth[i].is_gathered) {
            continue;
        }
        samples_add(&errors->of[QUANTITY_OCCLUSION], i, (double)results[i].openness - truth[i].openness);
        for (int channel = 0; channel < 3; ++channel) {
            const double own = (double)results[i].irradiance[channel] - truth[i].irradiance[channel];
            const double of_lights = (double)results[i].direct[channel] - truth[i].direct[channel];
            samples_add(&errors->of[QUANTITY_LIGHT], i, light > LEAST_LIGHT ? own / light : NAN);
            samples_add(&errors->of[QUANTITY_DIRECT], i, direct > LEAST_LIGHT ? of_lights / direct : NAN);
        }
    }
}
