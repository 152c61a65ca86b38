/* SPDX-License-Identifier: MIT */
/* The truth is traced once for each scene; methods are compared with it afterwards. Ambient occlusion ends at the
   truth's range; light has none, so the two are gathered apart. */
#include "errors/cones.h"

#include <math.h>
#include <stdlib.h>

#include "measure/spread.h"
#include "path/surface_points.h"
#include "support/input.h"

/* ---- the truth ---- */

#define SEED            1u
#define TREE_DEPTH      6u /* rays do not depend on it */
#define RANGE           0.25 /* of ambient occlusion, in widths of the grid */
#define BURIED_RANGE    0x1p-6 /* in widths of the grid */
#define BURIED_OPENNESS 0.1
#define BURIED_SAMPLES  64u
#define CANDIDATE_SHARE 2u /* points that are tried for each one that is kept */

static bool build_tree(error_run *run, cone_truth *truth)
{
    const session *opened = &run->opened;
    const svo_plan_options plan_options = {.struct_size = sizeof plan_options, .need = SVO_NEED_RAYS};
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_plan *plan = NULL;
    const bool built =
        svo_plan_create(opened->device, truth->opened.source.mesh, TREE_DEPTH, &plan_options, &plan) == SVO_OK &&
        svo_build(plan, opened->cl != NULL ? opened->cl : opened->frontend, opened->queue, &truth->tree, NULL) ==
            SVO_OK;
    svo_plan_destroy(&plan);
    if (built) {
        svo_tree_get_info(truth->tree, &info);
        truth->edge = info.edge;
        truth->range = RANGE * info.edge;
    }
    return built;
}

/* Of ambient occlusion within a range, or with light. */
static svo_status trace(const error_run *run, const cone_truth *truth, double range, const svo_gather_point *points,
                        size_t count, unsigned samples, path_result *results)
{
    const svo_light_setup dark = SVO_LIGHT_SETUP_INIT;
    const path_scene paths = {.tree = truth->tree,
                              .mesh = truth->opened.source.mesh,
                              .queue = run->opened.queue,
                              .setup = samples == BURIED_SAMPLES ? &dark : &truth->setup,
                              .range = range,
                              .threads = run->threads};
    return path_trace(&paths, points, count, samples, SEED, results);
}

/* Keeps point_count of the candidates that are not buried, evenly spread among them; fewer where there are fewer. */
static void keep_points(const svo_gather_point *candidates, const path_result *seen, size_t candidate_count,
                        size_t point_count, cone_truth *truth)
{
    size_t visible = 0;
    size_t passed = 0;
    for (size_t i = 0; i < candidate_count; ++i) {
        visible += seen[i].openness >= BURIED_OPENNESS;
    }
    const size_t wanted = visible < point_count ? visible : point_count;
    for (size_t i = 0; i < candidate_count && truth->count < wanted; ++i) {
        if (seen[i].openness >= BURIED_OPENNESS && passed++ * wanted / visible == truth->count) {
            truth->points[truth->count++] = candidates[i];
        }
    }
}

/* Whether points can be spread over the mesh. */
static bool has_area(const svo_mesh *mesh)
{
    svo_gather_point point;
    return surface_points(mesh, 1, SEED, &point);
}

static bool make_points(const error_run *run, size_t point_count, cone_truth *truth)
{
    const size_t candidate_count = CANDIDATE_SHARE * point_count;
    svo_gather_point *candidates = calloc(candidate_count, sizeof *candidates);
    path_result *seen = calloc(candidate_count, sizeof *seen);
    truth->points = calloc(point_count, sizeof *truth->points);
    truth->results = calloc(point_count, sizeof *truth->results);
    const bool worked =
        candidates != NULL && seen != NULL && truth->points != NULL && truth->results != NULL &&
        surface_points(truth->opened.source.mesh, candidate_count, SEED, candidates) &&
        trace(run, truth, BURIED_RANGE * truth->edge, candidates, candidate_count, BURIED_SAMPLES, seen) == SVO_OK;
    if (worked) {
        keep_points(candidates, seen, candidate_count, point_count, truth);
    }
    free(candidates);
    free(seen);
    return worked && truth->count > 0;
}

static void sum_up(cone_truth *truth)
{
    for (size_t i = 0; i < truth->count; ++i) {
        const path_result *one = &truth->results[i];
        truth->largest_error = fmax(truth->largest_error, one->openness_error);
        for (int channel = 0; channel < 3; ++channel) {
            truth->mean_irradiance += one->irradiance[channel] / (3.0 * (double)truth->count);
        }
    }
}

int cone_truth_make(error_run *run, const truth_scene *given, size_t point_count, unsigned samples, cone_truth *out)
{
    *out = (cone_truth){.source = given->source, .setup = SVO_LIGHT_SETUP_INIT};
    const int exit_code = suite_open(run->state, given->scene.spec, &out->opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    out->name = errors_scene_name(&given->scene, &out->opened.source);
    if (!has_area(out->opened.source.mesh)) {
        const int failed = program_fail(run->state, PROGRAM_FAILED, "%s: no triangle has an area", out->name);
        input_close(&out->opened.source);
        return failed;
    }
    out->setup.sources = &out->source;
    out->setup.source_count = 1;
    for (int channel = 0; channel < 3; ++channel) {
        out->setup.sky[channel] = given->sky[channel];
    }
    out->samples = path_sample_count(samples);
    if (!build_tree(run, out) || !make_points(run, point_count, out) ||
        trace(run, out, out->range, out->points, out->count, samples, out->results) != SVO_OK) {
        cone_truth_free(out);
        return errors_fail(run);
    }
    sum_up(out);
    return PROGRAM_DONE;
}

void cone_truth_free(cone_truth *truth)
{
    svo_tree_destroy(&truth->tree);
    input_close(&truth->opened.source);
    free(truth->points);
    free(truth->results);
    *truth = (cone_truth){.count = 0};
}

/* ---- errors ---- */

static int compare_doubles(const void *a, const void *b)
{
    const double left = *(const double *)a;
    const double right = *(const double *)b;
    return (left > right) - (left < right);
}

truth_error truth_error_of(double *differences, size_t count)
{
    truth_error error = {0};
    for (size_t i = 0; i < count; ++i) {
        error.bias += differences[i] / (double)count;
        error.rmse += differences[i] * differences[i] / (double)count;
        differences[i] = fabs(differences[i]);
    }
    qsort(differences, count, sizeof *differences, compare_doubles);
    error.rmse = sqrt(error.rmse);
    error.p99 = spread_quantile(differences, count, 0.99);
    error.largest = differences[count - 1];
    return error;
}

truth_error cone_truth_openness_error(const cone_truth *truth, const double *openness)
{
    double *differences = calloc(truth->count, sizeof *differences);
    truth_error error = {NAN, NAN, NAN, NAN};
    for (size_t i = 0; i < truth->count && differences != NULL; ++i) {
        differences[i] = openness[i] - truth->results[i].openness;
    }
    if (differences != NULL) {
        error = truth_error_of(differences, truth->count);
    }
    free(differences);
    return error;
}

truth_error cone_truth_irradiance_error(const cone_truth *truth, const double *irradiance)
{
    double *differences = calloc(3 * truth->count, sizeof *differences);
    truth_error error = {NAN, NAN, NAN, NAN};
    for (size_t i = 0; i < 3 * truth->count && differences != NULL; ++i) {
        differences[i] = (irradiance[i] - truth->results[i / 3].irradiance[i % 3]) / truth->mean_irradiance;
    }
    if (differences != NULL) {
        error = truth_error_of(differences, 3 * truth->count);
    }
    free(differences);
    return error;
}

/* ---- trees and lights ---- */

static bool share_light(const cone_way *a, const cone_way *b)
{
    return a->depth == b->depth && a->coverage == b->coverage && a->form == b->form && a->opacity == b->opacity;
}

svo_tree *cone_lights_tree(cone_lights *lights, unsigned depth, svo_coverage coverage)
{
    const session *opened = &lights->run->opened;
    const svo_mesh *mesh = lights->truth->opened.source.mesh;
    const bool has_colors = mesh->colors != NULL || mesh->material_count > 0; /* without: clay, as the truth has it */
    const svo_plan_options plan_options = {.struct_size = sizeof plan_options,
                                           .need = SVO_NEED_NORMAL | SVO_NEED_RAYS | SVO_NEED_PROJECTED_AREA |
                                                   (has_colors ? (uint32_t)SVO_NEED_COLOR : 0U) |
                                                   (mesh->finishes != NULL ? (uint32_t)SVO_NEED_MATERIAL : 0U),
                                           .coverage = coverage};
    for (size_t i = 0; i < lights->tree_count; ++i) {
        if (lights->trees[i].depth == depth && lights->trees[i].coverage == coverage) {
            return lights->trees[i].tree;
        }
    }
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    if (svo_plan_create(opened->device, mesh, depth, &plan_options, &plan) == SVO_OK &&
        svo_build(plan, opened->cl != NULL ? opened->cl : opened->frontend, opened->queue, &tree, NULL) == SVO_OK) {
        lights->trees[lights->tree_count].depth = depth;
        lights->trees[lights->tree_count].coverage = coverage;
        lights->trees[lights->tree_count++].tree = tree;
    }
    svo_plan_destroy(&plan);
    return tree;
}

static svo_light *find_light(cone_lights *lights, const cone_way *way)
{
    const svo_light_options stored = {.struct_size = sizeof stored, .form = way->form, .opacity = way->opacity};
    for (size_t i = 0; i < lights->light_count; ++i) {
        if (share_light(&lights->lights[i].made_for, way)) {
            return lights->lights[i].light;
        }
    }
    svo_tree *tree = cone_lights_tree(lights, way->depth, way->coverage);
    svo_light *light = NULL;
    if (tree != NULL && svo_light_create(tree, &stored, lights->run->opened.queue, &light) == SVO_OK) {
        lights->lights[lights->light_count].made_for = *way;
        lights->lights[lights->light_count++].light = light;
        if (svo_light_set_sources(light, &lights->truth->setup, lights->run->opened.queue) != SVO_OK) {
            return NULL;
        }
    }
    return light;
}

void cone_lights_free(cone_lights *lights)
{
    for (size_t i = 0; i < lights->light_count; ++i) {
        svo_light_destroy(&lights->lights[i].light);
    }
    for (size_t i = 0; i < lights->tree_count; ++i) {
        svo_tree_destroy(&lights->trees[i].tree);
    }
    lights->light_count = lights->tree_count = 0;
}

/* ---- gathering ---- */

static bool gather_by_cones(cone_gather *work, float range, bool with_light)
{
    const cone_truth *truth = work->lights->truth;
    const svo_gather_options asked = {.struct_size = sizeof asked,
                                      .cones = work->way.cones,
                                      .step = work->way.step,
                                      .range = range,
                                      .no_light = !with_light};
    return svo_gather(work->light, svo_in_host(truth->points), svo_in_host(work->results), truth->count, &asked,
                      &(svo_submit){.queue = work->lights->run->opened.queue}) == SVO_OK;
}

static double gather(cone_gather *work, bool with_light)
{
    const cone_truth *truth = work->lights->truth;
    const float range = with_light ? 0 : (float)truth->range;
    const double started_ms = input_now_ms();
    const bool worked = work->way.as_published
                            ? published_march_gather(&work->published, truth->points, work->results, range, with_light)
                            : gather_by_cones(work, range, with_light);
    return worked ? input_now_ms() - started_ms : -1.0;
}

double cone_gather_occlusion(void *user)
{
    return gather(user, false);
}

double cone_gather_light(void *user)
{
    return gather(user, true);
}

bool cone_gather_make(cone_lights *lights, const cone_way *way, cone_gather *out)
{
    *out = (cone_gather){.lights = lights, .way = *way, .info = SVO_LIGHT_INFO_INIT};
    out->light = find_light(lights, way);
    out->results = calloc(lights->truth->count, sizeof *out->results);
    if (out->light == NULL || out->results == NULL || svo_light_get_info(out->light, &out->info) != SVO_OK) {
        return false;
    }
    return !way->as_published || published_march_make(lights->run->opened.device, out->light, lights->truth->count,
                                                      lights->run->opened.queue, &out->published);
}

void cone_gather_free(cone_gather *work)
{
    published_march_free(&work->published);
    free(work->results);
    work->results = NULL;
}

bool cone_gather_compare(cone_gather *work, truth_error *openness, truth_error *irradiance)
{
    const cone_truth *truth = work->lights->truth;
    double *measured = calloc(3 * truth->count, sizeof *measured);
    bool worked = measured != NULL && gather(work, false) >= 0;
    for (size_t i = 0; i < truth->count && worked; ++i) {
        measured[i] = (double)work->results[i].openness;
    }
    if (worked) {
        *openness = cone_truth_openness_error(truth, measured);
        worked = gather(work, true) >= 0;
    }
    for (size_t i = 0; i < 3 * truth->count && worked; ++i) {
        measured[i] = (double)work->results[i / 3].irradiance[i % 3];
    }
    if (worked) {
        *irradiance = cone_truth_irradiance_error(truth, measured);
    }
    free(measured);
    return worked;
}
