/* SPDX-License-Identifier: MIT */
/*
 * E7: errors and times of ambient occlusion and light gathered by cones, against paths through the triangles; and by
 * rays, which is what cones are an alternative to. Kinds of light one by one are in e7_light.c, rays alone in
 * e7_embree.c.
 */
#include "errors/subjects.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "errors/cone_peers.h"
#include "errors/cones.h"
#include "errors/e7_embree.h"
#include "errors/e7_light.h"
#include "measure/spread.h"

#define DEEPEST       9u
#define DEEPEST_QUICK 7u
#define POINTS        2048u
#define POINTS_QUICK  256u
#define SAMPLES       8192u
#define SAMPLES_QUICK 1024u
#define ROUNDS        3u /* where --repeat says nothing: there are two dozen methods */
#define WAYS          15u
#define RAY_METHODS   10u
#define PATH_METHODS  4u
#define METHODS       (WAYS + RAY_METHODS + PATH_METHODS)

static const truth_scene full_scenes[] = {
    {.scene = {"atrium", "atrium"},
     .source = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.35F, -1, -0.3F}, .value = {10, 9.5F, 8.5F}},
     .sky = {0.4F, 0.5F, 0.7F}},
    {.scene = {"cornell", "cornell"},
     .source = {.kind = SVO_SOURCE_POINT, .position = {0.1F, 1.5F, 0.1F}, .value = {3, 2.8F, 2.4F}}},
    {.scene = {"statue", "statue"},
     .source = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {-0.6F, -1, -0.8F}, .value = {10, 9.5F, 8.5F}},
     .sky = {0.4F, 0.5F, 0.7F}}};
#define SCENES (sizeof full_scenes / sizeof full_scenes[0])
static const char *const quick_specs[SCENES] = {"atrium:17000", "cornell:2000", "statue:10000"};

/* The angular floor: what cones of a set err by if each is exact. */
static const unsigned cone_counts[] = {1, 5, 6, 16, 64};
#define CONE_COUNTS (sizeof cone_counts / sizeof cone_counts[0])

typedef struct cone_run {
    error_run *run;
    cone_truth truth;
    cone_lights lights;
    cone_gather ways[WAYS];
    occlusion_rays rays[RAY_METHODS];
    few_paths paths[PATH_METHODS];
    embree *peer;
    size_t way_count, ray_count, path_count;
    interleaved_method methods[WAYS + METHODS]; /* each way's two, then those of rays and paths */
} cone_run;

/* ---- tables ---- */

static void add_error_columns(result_table *table, const char *of)
{
    static const char *const measures[] = {"RMSE", "99th percentile", "largest", "bias"};
    char name[64];
    for (size_t i = 0; i < sizeof measures / sizeof measures[0]; ++i) {
        snprintf(name, sizeof name, "%s, %s", of, measures[i]);
        result_add_column(table, name, "");
    }
}

static void add_error(result_table *table, truth_error error)
{
    result_add_number(table, error.rmse);
    result_add_number(table, error.p99);
    result_add_number(table, error.largest);
    result_add_number(table, error.bias);
}

static void begin_cones(const error_run *run)
{
    result_table *table = result_add_table(run->results, "e7-cones", "E7: cones", "");
    result_set_note(
        table,
        "%u points of each scene, spread over its triangles by area; left out are points where surfaces within 1/64 "
        "of the grid's width leave less than a tenth of the hemisphere open. The truth takes %u paths a point. AO: "
        "ambient occlusion of surfaces within a quarter of the grid's width; 1 is open. Light: irradiance after one "
        "bounce, and the sky's, relative to its mean over the points. Cones are varied one at a time: their number, "
        "their step in widths, depth, coverage of the voxels, opacity and form of the light, and how they march; "
        "without other words there are 16 cones of step 0.5 in faces by area of half-open voxels at the largest "
        "depth. The published march has five cones in isotropic bricks, one sample a node. Exact rays end at any hit;"
        " their directions are stratified and made beforehand. Paths: svo_gather by rays, the default. Embree: "
        "rtcOccluded1 "
        "on %u threads. Time: of all points, gathered or traced. Size: the light. %s; methods run interleaved.",
        run->quick ? POINTS_QUICK : POINTS, path_sample_count(run->quick ? SAMPLES_QUICK : SAMPLES), run->threads,
        run->rounds_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "method", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "cones or rays", "");
    result_add_column(table, "step", "");
    result_add_column(table, "size", "B");
    result_add_column(table, "time", "ms");
    add_error_columns(table, "AO");
    result_add_column(table, "front", "");
    result_add_column(table, "time with light", "ms");
    add_error_columns(table, "light");
}

static void begin_directions(const error_run *run)
{
    result_table *table = result_add_table(run->results, "e7-directions", "E7: cones without any other error",
                                           "Ambient occlusion where each cone of a set is the mean of 64 exact rays: "
                                           "what is left is the error of having so "
                                           "few directions. Standard error: the largest of the truth's.");
    result_add_column(table, "scene", "");
    result_add_column(table, "cones", "");
    add_error_columns(table, "AO");
    result_add_column(table, "standard error", "");
}

static void begin_alternatives(const error_run *run)
{
    result_table *table = result_add_table(
        run->results, "e7-alternatives", "E7: cones, and rays of the same error",
        "The fewest exact rays a point, of 1, 4, 16, 64 and 256, whose ambient occlusion errs no more than that of the "
        "cones, and the fewest paths, of 16, 64, 256 and 1024, whose light errs no more. Ratio: time of the cones to "
        "that of "
        "svocl's rays, Embree's rays, svocl's paths; above 1 cones lose.");
    result_add_column(table, "scene", "");
    result_add_column(table, "cones", "");
    result_add_column(table, "AO, RMSE", "");
    result_add_column(table, "AO, time", "ms");
    result_add_column(table, "rays", "");
    result_add_column(table, "svocl, ratio", "");
    result_add_column(table, "Embree, ratio", "");
    result_add_column(table, "light, RMSE", "");
    result_add_column(table, "light, time", "ms");
    result_add_column(table, "paths", "");
    result_add_column(table, "paths, ratio", "");
}

/* ---- methods ---- */

static cone_way usual_way(const error_run *run, const char *method)
{
    return (cone_way){.method = method,
                      .depth = run->quick ? DEEPEST_QUICK : DEEPEST,
                      .coverage = SVO_COVERAGE_HALF_OPEN,
                      .form = SVO_LIGHT_FACES,
                      .opacity = SVO_OPACITY_AREA,
                      .cones = 16,
                      .step = 0.5F};
}

static size_t list_ways(const error_run *run, cone_way ways[WAYS])
{
    size_t count = 0;
    for (size_t i = 0; i < CONE_COUNTS; ++i) {
        ways[count] = usual_way(run, "cones");
        ways[count++].cones = cone_counts[i];
    }
    for (unsigned quarters = 3; quarters <= 4; ++quarters) {
        ways[count] = usual_way(run, "cones, longer steps");
        ways[count++].step = 0.25F * (float)quarters;
    }
    for (unsigned less = 1; less <= 2; ++less) {
        ways[count] = usual_way(run, "cones, lower depths");
        ways[count++].depth -= less;
    }
    ways[count] = usual_way(run, "cones, full opacity");
    ways[count++].opacity = SVO_OPACITY_FULL;
    ways[count] = usual_way(run, "cones, closed coverage");
    ways[count++].coverage = SVO_COVERAGE_CLOSED;
    ways[count] = usual_way(run, "cones, thin coverage");
    ways[count++].coverage = SVO_COVERAGE_THIN;
    ways[count] = usual_way(run, "cones, bricks");
    ways[count++].form = SVO_LIGHT_BRICKS;
    ways[count] = usual_way(run, "cones, voxels");
    ways[count++].form = SVO_LIGHT_VOXELS;
    ways[count] = usual_way(run, "published march");
    ways[count].form = SVO_LIGHT_BRICKS;
    ways[count].as_published = true;
    ways[count++].cones = 5;
    return count;
}

static bool make_cones(cone_run *work)
{
    cone_way ways[WAYS];
    const size_t count = list_ways(work->run, ways);
    work->lights = (cone_lights){.run = work->run, .truth = &work->truth};
    for (size_t i = 0; i < count; ++i) {
        work->way_count = i + 1;
        if (!cone_gather_make(&work->lights, &ways[i], &work->ways[i])) {
            return false;
        }
    }
    return true;
}

static bool make_rays(cone_run *work)
{
    const svo_mesh *mesh = work->truth.opened.source.mesh;
    work->peer = embree_is_there()
                     ? embree_create(mesh->positions, mesh->vertex_count, mesh->indices, mesh->triangle_count, NULL)
                     : NULL;
    for (unsigned per_point = 1; per_point <= 256; per_point *= 4) {
        for (int peer = 0; peer < (work->peer != NULL ? 2 : 1); ++peer) {
            occlusion_rays *made = &work->rays[work->ray_count++];
            if (!occlusion_rays_make(work->run, &work->truth, per_point, made)) {
                return false;
            }
            made->peer = peer != 0 ? work->peer : NULL;
        }
    }
    return !embree_is_there() || work->peer != NULL;
}

/* 16, 64, 256 and 1024 a point, through the light of the first way. */
static bool make_paths(cone_run *work)
{
    for (unsigned per_point = 16; per_point <= 1024; per_point *= 4) {
        few_paths *made = &work->paths[work->path_count++];
        if (!few_paths_make(work->run, &work->truth, work->ways[0].light, per_point, made)) {
            return false;
        }
    }
    return true;
}

static void release(cone_run *work)
{
    for (size_t i = 0; i < work->way_count; ++i) {
        cone_gather_free(&work->ways[i]);
    }
    for (size_t i = 0; i < work->ray_count; ++i) {
        occlusion_rays_free(&work->rays[i]);
    }
    for (size_t i = 0; i < work->path_count; ++i) {
        few_paths_free(&work->paths[i]);
    }
    embree_destroy(&work->peer);
    cone_lights_free(&work->lights);
    cone_truth_free(&work->truth);
}

static bool time_all(cone_run *work)
{
    size_t count = 0;
    for (size_t i = 0; i < work->way_count; ++i) {
        work->methods[count++] = (interleaved_method){.work_ms = cone_gather_occlusion, .user = &work->ways[i]};
        work->methods[count++] = (interleaved_method){.work_ms = cone_gather_light, .user = &work->ways[i]};
    }
    for (size_t i = 0; i < work->ray_count; ++i) {
        work->methods[count++] = (interleaved_method){.work_ms = occlusion_rays_trace, .user = &work->rays[i]};
    }
    for (size_t i = 0; i < work->path_count; ++i) {
        work->methods[count++] = (interleaved_method){.work_ms = few_paths_trace, .user = &work->paths[i]};
    }
    return interleave_measure(work->methods, count, work->run->rounds);
}

/* ---- rows ---- */

/* What the tables need of a method; NAN where it has no such figure. */
typedef struct measured {
    const char *method;
    unsigned number; /* of cones or rays */
    double depth, step, bytes, ms, light_ms;
    truth_error openness, light;
} measured;

static const measured nothing = {.depth = NAN,
                                 .step = NAN,
                                 .bytes = NAN,
                                 .ms = NAN,
                                 .light_ms = NAN,
                                 .openness = {NAN, NAN, NAN, NAN},
                                 .light = {NAN, NAN, NAN, NAN}};

static bool measure_cones(cone_run *work, size_t i, measured *out)
{
    cone_gather *one = &work->ways[i];
    *out = (measured){.method = one->way.method,
                      .number = one->way.cones,
                      .depth = one->way.depth,
                      .step = one->way.as_published ? NAN : (double)one->way.step,
                      .bytes = (double)one->info.total_bytes,
                      .ms = work->methods[2 * i].median_ms,
                      .light_ms = work->methods[2 * i + 1].median_ms};
    return cone_gather_compare(one, &out->openness, &out->light);
}

static bool measure_rays(cone_run *work, size_t i, measured *out)
{
    const occlusion_rays *one = &work->rays[i];
    double *openness = calloc(work->truth.count, sizeof *openness);
    *out = nothing;
    out->method = one->peer != NULL ? "exact rays, Embree" : "exact rays, svocl";
    out->number = one->per_point;
    out->ms = work->methods[2 * work->way_count + i].median_ms;
    if (openness != NULL) {
        occlusion_rays_openness(one, openness);
        out->openness = cone_truth_openness_error(&work->truth, openness);
    }
    free(openness);
    return openness != NULL;
}

static void measure_paths(const cone_run *work, size_t i, measured *out)
{
    const few_paths *one = &work->paths[i];
    *out = nothing;
    out->method = "paths, svocl";
    out->number = one->per_point;
    out->light_ms = work->methods[2 * work->way_count + work->ray_count + i].median_ms;
    out->light = few_paths_error(one);
}

static bool is_on_front(const measured *all, size_t count, const measured *mine)
{
    for (size_t i = 0; i < count; ++i) { /* what has no ambient occlusion is never as good */
        const bool as_good = all[i].ms <= mine->ms && all[i].openness.rmse <= mine->openness.rmse;
        if (as_good && (all[i].ms < mine->ms || all[i].openness.rmse < mine->openness.rmse)) {
            return false;
        }
    }
    return mine->openness.rmse >= 0;
}

static void add_row(const cone_run *work, const measured *one, bool on_front)
{
    result_table *table = result_find(work->run->results, "e7-cones");
    result_add_text(table, "%s", work->truth.name);
    result_add_text(table, "%s", one->method);
    result_add_number(table, one->depth);
    result_add_number(table, one->number);
    result_add_number(table, one->step);
    result_add_number(table, one->bytes);
    result_add_number(table, one->ms);
    add_error(table, one->openness);
    result_add_text(table, "%s", on_front ? "yes" : "");
    result_add_number(table, one->light_ms);
    add_error(table, one->light);
}

/* The fewest rays of a method with at most the error; NULL where none suffice. Rays ascend. */
static const measured *find_rays(const measured *all, size_t count, const char *method, double rmse)
{
    for (size_t i = 0; i < count; ++i) {
        if (strcmp(all[i].method, method) == 0 && all[i].openness.rmse <= rmse) {
            return &all[i];
        }
    }
    return NULL;
}

static const measured *find_paths(const measured *all, size_t count, double rmse)
{
    for (size_t i = 0; i < count; ++i) {
        if (strcmp(all[i].method, "paths, svocl") == 0 && all[i].light.rmse <= rmse) {
            return &all[i];
        }
    }
    return NULL;
}

static void add_alternative(const cone_run *work, const measured *cones, const measured *all, size_t count)
{
    result_table *table = result_find(work->run->results, "e7-alternatives");
    const measured *own = find_rays(all, count, "exact rays, svocl", cones->openness.rmse);
    const measured *other = find_rays(all, count, "exact rays, Embree", cones->openness.rmse);
    const measured *paths = find_paths(all, count, cones->light.rmse);
    own = own != NULL ? own : &nothing;
    other = other != NULL ? other : &nothing;
    paths = paths != NULL ? paths : &nothing;
    result_add_text(table, "%s", work->truth.name);
    result_add_number(table, cones->number);
    result_add_number(table, cones->openness.rmse);
    result_add_number(table, cones->ms);
    result_add_number(table, own != &nothing ? (double)own->number : NAN);
    result_add_number(table, cones->ms / own->ms);
    result_add_number(table, cones->ms / other->ms);
    result_add_number(table, cones->light.rmse);
    result_add_number(table, cones->light_ms);
    result_add_number(table, paths != &nothing ? (double)paths->number : NAN);
    result_add_number(table, cones->light_ms / paths->light_ms);
}

static bool measure_all(cone_run *work, measured *all)
{
    for (size_t i = 0; i < work->way_count; ++i) {
        if (!measure_cones(work, i, &all[i])) {
            return false;
        }
    }
    for (size_t i = 0; i < work->ray_count; ++i) {
        if (!measure_rays(work, i, &all[work->way_count + i])) {
            return false;
        }
    }
    for (size_t i = 0; i < work->path_count; ++i) {
        measure_paths(work, i, &all[work->way_count + work->ray_count + i]);
    }
    return true;
}

static bool add_rows(cone_run *work)
{
    measured all[METHODS] = {{.method = NULL}};
    const size_t count = work->way_count + work->ray_count + work->path_count;
    if (!measure_all(work, all)) {
        return false;
    }
    for (size_t i = 0; i < count; ++i) {
        add_row(work, &all[i], is_on_front(all, count, &all[i]));
    }
    for (size_t i = 0; i < CONE_COUNTS; ++i) {
        add_alternative(work, &all[i], all, count);
    }
    return true;
}

static bool add_directions(const cone_run *work)
{
    result_table *table = result_find(work->run->results, "e7-directions");
    double *openness = calloc(work->truth.count, sizeof *openness);
    bool worked = openness != NULL;
    for (size_t i = 0; i < CONE_COUNTS && worked; ++i) {
        worked = occlusion_exact_cones(work->run, &work->truth, cone_counts[i], openness);
        if (worked) {
            result_add_text(table, "%s", work->truth.name);
            result_add_number(table, cone_counts[i]);
            add_error(table, cone_truth_openness_error(&work->truth, openness));
            result_add_number(table, work->truth.largest_error);
        }
    }
    free(openness);
    return worked;
}

/* ---- the experiment ---- */

static int measure_scene(error_run *run, const truth_scene *given)
{
    cone_run *work = calloc(1, sizeof *work);
    if (work == NULL) {
        return errors_fail(run);
    }
    work->run = run;
    progress_step(run->state->progress, "E7: paths");
    int exit_code = cone_truth_make(run, given, run->quick ? POINTS_QUICK : POINTS,
                                    run->quick ? SAMPLES_QUICK : SAMPLES, &work->truth);
    if (exit_code == PROGRAM_DONE) {
        progress_step(run->state->progress, "E7: cones");
        const bool worked = make_cones(work) && make_rays(work) && make_paths(work) && add_directions(work) &&
                            time_all(work) && add_rows(work) && e7_embree_measure(run, &work->truth, work->peer) &&
                            e7_light_measure(run, &work->lights, usual_way(run, "").depth);
        exit_code = worked ? PROGRAM_DONE : errors_fail(run);
    }
    release(work);
    free(work);
    return exit_code;
}

static int run_all(suite *all)
{
    error_run run = errors_begin(all);
    int exit_code = PROGRAM_DONE;
    if (!all->state->options.has_repeat && !run.quick) {
        errors_set_rounds(&run, ROUNDS);
    }
    begin_cones(&run);
    begin_directions(&run);
    begin_alternatives(&run);
    e7_light_begin(&run);
    e7_embree_begin(&run);
    for (size_t i = 0; i < SUITE_LIST_MAX && exit_code == PROGRAM_DONE; ++i) {
        const bool own = run.scenes[0] == NULL;
        truth_scene given = full_scenes[own && i < SCENES ? i : 0]; /* others have the light of the first */
        if (own ? i == SCENES : run.scenes[i] == NULL) {
            break;
        }
        given.scene.spec = own && run.quick ? quick_specs[i] : given.scene.spec;
        given.scene = own ? given.scene : (error_scene){.spec = run.scenes[i]};
        exit_code = measure_scene(&run, &given);
    }
    return exit_code;
}

const suite_subject errors_cones = {
    .words = &subject_table[SUBJECT_E7],
    .run_all = run_all,
    .takes_scenes = true,
    .step_count = 2 * SCENES,
};
