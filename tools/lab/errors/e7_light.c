/* SPDX-License-Identifier: MIT */
/*
 * Kinds of light are measured one by one, since methods differ in each: ambient occlusion within a range, the light of
 * the sky, of a source by way of one surface, of both by way of several, of what emits. Cones and rays gather from one
 * light, interleaved. Times are those of the process on all cores together, so that what threads wait for counts for
 * neither.
 */
#include "errors/e7_light.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "measure/spread.h"

#define POINTS        1024u
#define POINTS_QUICK  128u
#define SAMPLES       8192u
#define SAMPLES_QUICK 1024u
#define SEED          5u /* of the truth */
#define BOUNCES       4u /* of several */
#define DARKEST       1e-9 /* a mean irradiance below it, of sources of about 1, is no light */
#define CLOSED_SHARE  0.001 /* of a sun's irradiance: where a bounce brings less on average, the scene is a room */

static const unsigned cone_counts[] = {1, 5, 6, 16, 64};
static const unsigned path_counts[] = {16, 64, 256, 1024};
#define CONE_METHODS (sizeof cone_counts / sizeof cone_counts[0])
#define PATH_METHODS (sizeof path_counts / sizeof path_counts[0])
#define METHODS      (CONE_METHODS + PATH_METHODS)
#define USUAL_CONES  3u /* 16 */
#define USUAL_PATHS  1u /* 64 */

typedef enum light_kind { AMBIENT_OCCLUSION, SKYLIGHT, ONE_BOUNCE, SEVERAL_BOUNCES, EMITTERS, LIGHT_KINDS } light_kind;
static const char *const kind_names[LIGHT_KINDS] = {"AO", "skylight", "one bounce", "four bounces", "emitters"};

/* A scene's points under one kind of light. */
typedef struct kind_work {
    const error_run *run;
    const cone_truth *scene; /* its mesh, its tree, its range */
    svo_light *light;
    light_kind kind;
    svo_light_source source;
    svo_light_setup setup;
    size_t count;
    svo_gather_point *points;
    path_result *truth;
    double mean; /* irradiance of the truth; 1 for occlusion */
    double *differences; /* three to a point */
} kind_work;

typedef struct kind_method {
    const kind_work *work;
    unsigned cones, paths; /* one of them is 0 */
    svo_gather_result *results; /* count */
} kind_method;

/* ---- the table ---- */

/* One row for a scene and a kind: the cones and the rays that svo_gather takes by default. */
static void begin_equal(const error_run *run)
{
    static const char *const of_method[] = {"16 cones, ", "64 paths, "};
    result_table *table =
        result_add_table(run->results, "e7-equal", "E7: cones, and rays in the time of the same error",
                         "16 cones and 64 paths, the numbers by default, of the table of all methods, and "
                         "the time in which rays err as much as the cones. Ratio: of the cones' "
                         "time to that; above 1 rays win.");
    char name[64];
    result_add_column(table, "scene", "");
    result_add_column(table, "light", "");
    for (size_t i = 0; i < 2; ++i) {
        (void)snprintf(name, sizeof name, "%sRMSE", of_method[i]);
        result_add_column(table, name, "");
        (void)snprintf(name, sizeof name, "%sbias", of_method[i]);
        result_add_column(table, name, "");
        (void)snprintf(name, sizeof name, "%stime", of_method[i]);
        result_add_column(table, name, "µs/point");
    }
    result_add_column(table, "rays, same error", "µs/point");
    result_add_column(table, "ratio", "");
}

void e7_light_begin(const error_run *run)
{
    result_table *table = result_add_table(run->results, "e7-light", "E7: kinds of light, by cones and by rays", "");
    result_set_note(
        table,
        "%u points of each scene, spread over its triangles by area, beside %u paths a point through the triangles, "
        "for "
        "four bounces a quarter of them. AO: openness within a quarter of the grid's width. Other errors are relative "
        "to the mean irradiance. Skylight: a uniform sky, no source. One bounce: a source by way of one surface; a "
        "lamp about the middle where a sun hardly reaches inside. Four bounces: the same with a sky. Emitters: "
        "materials "
        "that "
        "emit, where there are any. Cones: of faces at depth %u, with one bounce at most. Time: of all cores, for each "
        "point. Rays, same error: the time of rays that err as much, interpolated between 16, 64, 256 and 1024 paths; "
        "that of 16 where these err less, none where 1024 err more. Ratio: of the cones' time "
        "to it; above 1 rays win. Truth's error: its standard error, below which no RMSE says anything. "
        "%s; methods run interleaved.",
        run->quick ? POINTS_QUICK : POINTS, path_sample_count(run->quick ? SAMPLES_QUICK : SAMPLES),
        run->quick ? 7U : 9U, run->rounds_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "light", "");
    result_add_column(table, "method", "");
    result_add_column(table, "cones or paths", "");
    result_add_column(table, "RMSE", "");
    result_add_column(table, "bias", "");
    result_add_column(table, "truth's error", "");
    result_add_column(table, "time", "µs/point");
    result_add_column(table, "rays, same error", "µs/point");
    result_add_column(table, "ratio", "");
    begin_equal(run);
}

/* ---- light ---- */

static bool emits(const svo_mesh *mesh)
{
    for (size_t i = 0; i < mesh->material_count && mesh->finishes != NULL; ++i) {
        const float *emission = mesh->finishes[i].emission;
        if (emission[0] + emission[1] + emission[2] > 0) {
            return true;
        }
    }
    return false;
}

static void set_kind(kind_work *work, light_kind kind)
{
    const svo_mesh *mesh = work->scene->opened.source.mesh;
    const bool has_sky = kind == SKYLIGHT || kind == SEVERAL_BOUNCES;
    work->kind = kind;
    work->setup = (svo_light_setup)SVO_LIGHT_SETUP_INIT;
    if (kind == ONE_BOUNCE || kind == SEVERAL_BOUNCES) {
        work->setup.sources = &work->source;
        work->setup.source_count = 1;
    }
    if (kind == EMITTERS) {
        work->setup.finishes = mesh->finishes;
        work->setup.finish_count = mesh->material_count;
    }
    for (int channel = 0; channel < 3; ++channel) {
        work->setup.sky[channel] = has_sky ? 0.4F + 0.15F * (float)channel : 0;
    }
}

static svo_status trace_truth(kind_work *work)
{
    const unsigned samples = work->run->quick ? SAMPLES_QUICK : SAMPLES;
    const path_scene paths = {.tree = work->scene->tree,
                              .mesh = work->scene->opened.source.mesh,
                              .queue = work->run->opened.queue,
                              .setup = &work->setup,
                              .range = work->kind == AMBIENT_OCCLUSION ? work->scene->range : 0,
                              .bounces = work->kind == SEVERAL_BOUNCES ? BOUNCES : 1,
                              .threads = work->run->threads};
    return path_trace(&paths, work->points, work->count, work->kind == SEVERAL_BOUNCES ? samples / 4 : samples, SEED,
                      work->truth);
}

static double mean_of_truth(const kind_work *work)
{
    double sum = 0;
    for (size_t i = 0; i < 3 * work->count; ++i) {
        sum += work->truth[i / 3].irradiance[i % 3];
    }
    return work->kind == AMBIENT_OCCLUSION ? 1 : sum / (3 * (double)work->count);
}

/* The root mean square of the truth's standard errors. */
static double error_of_truth(const kind_work *work)
{
    double sum = 0;
    for (size_t i = 0; i < 3 * work->count; ++i) {
        const path_result *one = &work->truth[i / 3];
        const double error =
            work->kind == AMBIENT_OCCLUSION ? one->openness_error : one->irradiance_error[i % 3] / work->mean;
        sum += error * error;
    }
    return sqrt(sum / (3 * (double)work->count));
}

static double distance_to_points(const kind_work *work, const float place[3])
{
    double least = INFINITY;
    for (size_t i = 0; i < work->count; ++i) {
        const float *at = work->points[i].position;
        const double offset[3] = {(double)(at[0] - place[0]), (double)(at[1] - place[1]), (double)(at[2] - place[2])};
        least = fmin(least, offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]);
    }
    return least;
}

/* A lamp for rooms that no sun reaches: about the middle of the points' bounds, where it is the farthest from all. Next
   to a surface it would light a spot of that alone. */
static void hang_lamp(kind_work *work)
{
    const float power = (float)(work->scene->edge * work->scene->edge);
    float bounds[2][3];
    double farthest = -1;
    work->source = (svo_light_source){.kind = SVO_SOURCE_POINT, .value = {power, 0.95F * power, 0.85F * power}};
    for (int axis = 0; axis < 3; ++axis) {
        bounds[0][axis] = bounds[1][axis] = work->points[0].position[axis];
        for (size_t i = 1; i < work->count; ++i) {
            bounds[0][axis] = fminf(bounds[0][axis], work->points[i].position[axis]);
            bounds[1][axis] = fmaxf(bounds[1][axis], work->points[i].position[axis]);
        }
    }
    for (int i = 0; i < 27; ++i) {
        const int steps[3] = {i % 3, i / 3 % 3, i / 9};
        float place[3];
        for (int axis = 0; axis < 3; ++axis) {
            const float share = 0.5F + 0.1F * (float)(steps[axis] - 1);
            place[axis] = bounds[0][axis] + share * (bounds[1][axis] - bounds[0][axis]);
        }
        const double distance = distance_to_points(work, place);
        if (distance > farthest) {
            farthest = distance;
            memcpy(work->source.position, place, sizeof place);
        }
    }
}

/* ---- methods ---- */

static double gather(void *user)
{
    const kind_method *method = user;
    const kind_work *work = method->work;
    const bool occlusion = work->kind == AMBIENT_OCCLUSION;
    const svo_gather_options asked = {
        .struct_size = sizeof asked,
        .method = method->cones > 0 ? SVO_GATHER_CONES : SVO_GATHER_RAYS,
        .cones = method->cones,
        .paths = method->paths,
        .bounces = method->paths > 0 && work->kind == SEVERAL_BOUNCES ? BOUNCES : 0,
        .range = occlusion ? (float)work->scene->range : 0,
        .no_light = occlusion,
    };
    const clock_t started = clock();
    const svo_status status = svo_gather(work->light, svo_in_host(work->points), svo_in_host(method->results),
                                         work->count, &asked, &(svo_submit){.queue = work->run->opened.queue});
    return status == SVO_OK ? 1e3 * (double)(clock() - started) / CLOCKS_PER_SEC : -1.0;
}

/* Of the last run. */
static truth_error error_of(const kind_method *method)
{
    const kind_work *work = method->work;
    const bool occlusion = work->kind == AMBIENT_OCCLUSION;
    const size_t per_point = occlusion ? 1 : 3;
    for (size_t i = 0; i < per_point * work->count; ++i) {
        const path_result *truth = &work->truth[i / per_point];
        const svo_gather_result *result = &method->results[i / per_point];
        work->differences[i] = occlusion ? (double)result->openness - truth->openness
                                         : ((double)result->irradiance[i % 3] - truth->irradiance[i % 3]) / work->mean;
    }
    return truth_error_of(work->differences, per_point * work->count);
}

/* ---- rows ---- */

/* What was measured of a method. */
typedef struct kind_figures {
    truth_error error;
    double us; /* a point */
} kind_figures;

/* The time of rays with that error: a straight line between neighbors, in logarithms. NAN where the most paths err
   more. */
static double time_of_rays(const kind_figures rays[PATH_METHODS], double rmse)
{
    size_t i = 0;
    if (!(rmse < rays[0].error.rmse)) {
        return rays[0].us;
    }
    while (i < PATH_METHODS && rmse < rays[i].error.rmse) {
        ++i;
    }
    if (i == PATH_METHODS) {
        return NAN;
    }
    const double share = log(rmse / rays[i - 1].error.rmse) / log(rays[i].error.rmse / rays[i - 1].error.rmse);
    return rays[i - 1].us * exp(share * log(rays[i].us / rays[i - 1].us));
}

static void add_equal(const kind_work *work, const kind_figures figures[METHODS])
{
    result_table *table = result_find(work->run->results, "e7-equal");
    const kind_figures *of_default[] = {&figures[USUAL_CONES], &figures[CONE_METHODS + USUAL_PATHS]};
    const double rays_us = time_of_rays(figures + CONE_METHODS, of_default[0]->error.rmse);
    result_add_text(table, "%s", work->scene->name);
    result_add_text(table, "%s", kind_names[work->kind]);
    for (size_t i = 0; i < 2; ++i) {
        result_add_number(table, of_default[i]->error.rmse);
        result_add_number(table, of_default[i]->error.bias);
        result_add_number(table, of_default[i]->us);
    }
    result_add_number(table, rays_us);
    result_add_number(table, of_default[0]->us / rays_us);
}

static void add_rows(const kind_work *work, const kind_figures figures[METHODS])
{
    result_table *table = result_find(work->run->results, "e7-light");
    const double error = error_of_truth(work);
    for (size_t i = 0; i < METHODS; ++i) {
        const bool cones = i < CONE_METHODS;
        const double rays_us = time_of_rays(figures + CONE_METHODS, figures[i].error.rmse);
        result_add_text(table, "%s", work->scene->name);
        result_add_text(table, "%s", kind_names[work->kind]);
        result_add_text(table, "%s", cones ? "cones" : "rays");
        result_add_number(table, cones ? cone_counts[i] : path_counts[i - CONE_METHODS]);
        result_add_number(table, figures[i].error.rmse);
        result_add_number(table, figures[i].error.bias);
        result_add_number(table, error);
        result_add_number(table, figures[i].us);
        result_add_number(table, cones ? rays_us : (double)NAN);
        result_add_number(table, cones ? figures[i].us / rays_us : (double)NAN);
    }
}

static bool measure_methods(const kind_work *work, kind_figures figures[METHODS])
{
    kind_method runs[METHODS];
    interleaved_method methods[METHODS];
    svo_gather_result *results = calloc(METHODS * work->count, sizeof *results);
    for (size_t i = 0; i < METHODS; ++i) {
        runs[i] = (kind_method){.work = work,
                                .cones = i < CONE_METHODS ? cone_counts[i] : 0,
                                .paths = i < CONE_METHODS ? 0 : path_counts[i - CONE_METHODS],
                                .results = results + i * work->count};
        methods[i] = (interleaved_method){.work_ms = gather, .user = &runs[i]};
    }
    const bool worked = results != NULL && interleave_measure(methods, METHODS, work->run->rounds);
    for (size_t i = 0; i < METHODS && worked; ++i) {
        figures[i] =
            (kind_figures){.error = error_of(&runs[i]), .us = 1e3 * methods[i].median_ms / (double)work->count};
    }
    free(results);
    return worked;
}

/* Adds no rows where the kind brings no light. */
static bool measure_kind(kind_work *work, light_kind kind)
{
    kind_figures figures[METHODS];
    set_kind(work, kind);
    if (trace_truth(work) != SVO_OK) {
        return false;
    }
    work->mean = mean_of_truth(work);
    if (kind == ONE_BOUNCE && work->source.kind == SVO_SOURCE_DIRECTIONAL &&
        work->mean < CLOSED_SHARE * (double)work->source.value[0]) {
        hang_lamp(work);
        if (trace_truth(work) != SVO_OK) {
            return false;
        }
        work->mean = mean_of_truth(work);
    }
    if (!(work->mean > DARKEST)) {
        return true;
    }
    if (svo_light_set_sources(work->light, &work->setup, work->run->opened.queue) != SVO_OK ||
        !measure_methods(work, figures)) {
        return false;
    }
    add_rows(work, figures);
    add_equal(work, figures);
    return true;
}

/* ---- a scene ---- */

/* Every so manieth of the scene's points, which are in the order of their triangles. */
static bool take_points(kind_work *work)
{
    const size_t wanted = work->run->quick ? POINTS_QUICK : POINTS;
    work->count = work->scene->count < wanted ? work->scene->count : wanted;
    work->points = calloc(work->count, sizeof *work->points);
    work->truth = calloc(work->count, sizeof *work->truth);
    work->differences = calloc(3 * work->count, sizeof *work->differences);
    if (work->points == NULL || work->truth == NULL || work->differences == NULL) {
        return false;
    }
    for (size_t i = 0; i < work->count; ++i) {
        work->points[i] = work->scene->points[i * work->scene->count / work->count];
    }
    return true;
}

bool e7_light_measure(const error_run *run, cone_lights *lights, unsigned depth)
{
    kind_work work = {.run = run, .scene = lights->truth, .source = lights->truth->source};
    svo_tree *tree = cone_lights_tree(lights, depth, SVO_COVERAGE_HALF_OPEN);
    bool worked = tree != NULL && take_points(&work) &&
                  svo_light_create(tree, NULL, run->opened.queue, &work.light) == SVO_OK &&
                  svo_light_set_mesh(work.light, work.scene->opened.source.mesh, run->opened.queue) == SVO_OK;
    for (light_kind kind = AMBIENT_OCCLUSION; kind < LIGHT_KINDS && worked; ++kind) {
        worked = (kind == EMITTERS && !emits(work.scene->opened.source.mesh)) || measure_kind(&work, kind);
    }
    svo_light_destroy(&work.light);
    free(work.points);
    free(work.truth);
    free(work.differences);
    return worked;
}
