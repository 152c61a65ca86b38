/* SPDX-License-Identifier: MIT */
/*
 * E8: what rays through light field probes find, beside exact rays in the same rounds, by the number of probes, their
 * resolution, the field and the choice of probes; and light by probes (e8_light.c).
 */
#include "errors/subjects.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "errors/cones.h"
#include "errors/e8_light.h"
#include "errors/probe_rays.h"
#include "errors/published_probes.h"
#include "measure/spread.h"
#include "support/input.h"

#define DEPTH         8u
#define DEPTH_QUICK   6u
#define POINTS        1024u
#define POINTS_QUICK  128u
#define SAMPLES       4096u
#define SAMPLES_QUICK 1024u
#define RAYS_QUICK    4096u /* a set */
#define FEW_RAYS      16384u /* a set: for times, and for all grids but the last */
#define ROUNDS        3u /* where --repeat says nothing: there are a hundred methods */
#define USUAL_FIELD   64u

/* How rays choose their probes: those that see the cell where the ray is; the eight around its origin, as published. */
enum { BY_FIELD, BY_EIGHT, CHOICES };
static const char *const choice_names[CHOICES] = {"field", "eight"};

#define METHODS ((size_t)PROBE_RAYS_COUNT * (1 + CHOICES)) /* exact rays, then each choice, of each set */

/* Probes along each axis, texels along a side, cells of the field along an axis. */
typedef struct probe_grid {
    unsigned count, resolution, field;
} probe_grid;

static const probe_grid full_grids[] = {{2, 128, USUAL_FIELD},  {2, 256, USUAL_FIELD}, {2, 512, USUAL_FIELD},
                                        {2, 1024, USUAL_FIELD}, {4, 128, USUAL_FIELD}, {4, 256, USUAL_FIELD},
                                        {4, 512, USUAL_FIELD},  {4, 256, 16},          {4, 256, 128},
                                        {8, 128, USUAL_FIELD},  {8, 256, USUAL_FIELD}, {8, 512, USUAL_FIELD}};
static const probe_grid quick_grids[] = {
    {2, 64, USUAL_FIELD}, {2, 128, USUAL_FIELD}, {2, 64, 16}, {4, 64, USUAL_FIELD}, {4, 128, USUAL_FIELD}};

/* A scene, its light without a sky, and a camera inside or in front of it. */
typedef struct probe_scene {
    truth_scene lit;
    const char *quick_spec; /* NULL: the same */
    svo_camera camera; /* vertical_fov 0: the one that frames the tree */
} probe_scene;

static const probe_scene scenes[] = {
    {.lit = {.scene = {"atrium", "atrium"},
             .source = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {-0.6F, -1, -0.3F}, .value = {10, 9.5F, 8.5F}}},
     .quick_spec = "atrium:17000",
     .camera = {.eye = {0.6F, 1.7F, 6.2F}, .target = {-0.9F, 1.75F, -3}, .up = {0, 1, 0}, .vertical_fov = 1.08F}},
    {.lit = {.scene = {"cornell", "cornell"},
             .source = {.kind = SVO_SOURCE_POINT, .position = {0.1F, 1.5F, 0.1F}, .value = {3, 2.8F, 2.4F}}},
     .quick_spec = "cornell:2000",
     .camera = {.eye = {0, 1, 3.6F}, .target = {0, 1, 0}, .up = {0, 1, 0}, .vertical_fov = 0.75F}}};
#define SCENES (sizeof scenes / sizeof scenes[0])

typedef struct probe_run {
    error_run *run;
    const probe_scene *scene;
    unsigned depth;
    size_t ray_count, few_count; /* of a set */
    cone_truth truth;
    cone_lights lights;
    svo_tree *tree; /* of lights */
    probe_rays all[PROBE_RAYS_COUNT], few[PROBE_RAYS_COUNT];
    svo_probe_hit *hits; /* ray_count */
    svo_hit *exact; /* few_count: of timed rays */
    size_t *slower, *rows; /* of the whole run: rows where exact rays are faster, and all */
} probe_run;

/* A set of rays, by exact rays or through probes. */
typedef struct ray_method {
    probe_run *work;
    const probe_rays *set;
    svo_probes *probes; /* NULL: not by the field */
    const published_probes *published; /* NULL: not by the eight; both: exact rays */
} ray_method;

/* ---- tables ---- */

static size_t few_of(size_t ray_count)
{
    return ray_count < FEW_RAYS ? ray_count : FEW_RAYS;
}

static void begin_probes(const error_run *run, size_t ray_count)
{
    result_table *table = result_add_table(run->results, "e8-probes", "E8: rays through probes", "");
    result_set_note(
        table,
        "Rays against exact rays: %zu of each kind and scene through the most probes, %zu through others and for "
        "times. The tree has depth %u. Primary: of a camera. Cosine: from what it sees, a leaf's edge above the "
        "surface. Random: from anywhere in the grid, in any direction. Field: the probes that see the cell where a ray "
        "is; eight: those around its origin, as published. Wrong hits: nothing is there, or it is more than two "
        "leaves' edges nearer or farther. Wrong misses: something is there. Shares are of all rays; quantiles of |t - "
        "exact| of those that hit. Ratio: of the time to that of svo_trace_triangles in the same rounds; above 1 "
        "probes lose. Size and making: all buffers of the probes, without light. %s; methods run interleaved.",
        ray_count, few_of(ray_count), run->quick ? DEPTH_QUICK : DEPTH, run->rounds_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "rays", "");
    result_add_column(table, "method", "");
    result_add_column(table, "probes", "");
    result_add_column(table, "resolution", "");
    result_add_column(table, "field", "");
    result_add_column(table, "size", "B");
    result_add_column(table, "making", "ms");
    result_add_column(table, "hit", "%");
    result_add_column(table, "miss", "%");
    result_add_column(table, "unknown", "%");
    result_add_column(table, "wrong hits", "%");
    result_add_column(table, "wrong misses", "%");
    result_add_column(table, "wrong", "%");
    result_add_column(table, "error, median", "leaves");
    result_add_column(table, "error, 90th percentile", "leaves");
    result_add_column(table, "error, 99th percentile", "leaves");
    result_add_column(table, "time", "ns/ray");
    result_add_column(table, "exact", "ns/ray");
    result_add_column(table, "ratio", "");
}

static void begin_choices(const error_run *run)
{
    result_table *table =
        result_add_table(run->results, "e8-choices", "E8: the field and the eight nearest probes",
                         "Both choices at the most probes and texels. Wrong: hits and misses. Share: of what eight "
                         "leaves unknown, what the field does. Ratio: time to that of exact rays.");
    result_add_column(table, "scene", "");
    result_add_column(table, "rays", "");
    result_add_column(table, "probes", "");
    result_add_column(table, "resolution", "");
    result_add_column(table, "wrong, field", "%");
    result_add_column(table, "wrong, eight", "%");
    result_add_column(table, "unknown, field", "%");
    result_add_column(table, "unknown, eight", "%");
    result_add_column(table, "share", "");
    result_add_column(table, "ratio, field", "");
    result_add_column(table, "ratio, eight", "");
}

/* ---- one grid of probes ---- */

/* What was measured of a grid and a choice on one set. */
typedef struct ray_figures {
    probe_verdict verdict;
    double ms, exact_ms;
} ray_figures;

typedef struct grid_figures {
    const probe_grid *grid;
    svo_probe_info info;
    double making_ms;
    ray_figures rays[PROBE_RAYS_COUNT][CHOICES];
} grid_figures;

static double trace_once(void *user)
{
    const ray_method *one = user;
    const probe_run *work = one->work;
    cl_command_queue queue = work->run->opened.queue;
    const svo_ray *rays = one->set->rays;
    const size_t count = one->set->count;
    const double started_ms = input_now_ms();
    const bool worked =
        one->published != NULL ? published_probes_trace(one->published, rays, work->hits, count)
        : one->probes != NULL
            ? svo_probes_trace(one->probes, svo_in_host(rays), svo_in_host(work->hits), count, NULL,
                               &(svo_submit){.queue = queue}) == SVO_OK
            : svo_trace_triangles(svo_tree_target(work->tree), svo_in_host(rays), svo_in_host(work->exact), count,
                                  SVO_TRACE_CLOSEST, &(svo_submit){.queue = queue}) == SVO_OK;
    return worked ? input_now_ms() - started_ms : -1.0;
}

static bool time_grid(probe_run *work, svo_probes *probes, const published_probes *published, grid_figures *out)
{
    ray_method runs[METHODS];
    interleaved_method methods[METHODS];
    for (size_t i = 0; i < METHODS; ++i) {
        const size_t choice = i % (1 + CHOICES);
        runs[i] = (ray_method){.work = work,
                               .set = &work->few[i / (1 + CHOICES)],
                               .probes = choice == 1 + BY_FIELD ? probes : NULL,
                               .published = choice == 1 + BY_EIGHT ? published : NULL};
        methods[i] = (interleaved_method){.work_ms = trace_once, .user = &runs[i]};
    }
    if (!interleave_measure(methods, METHODS, work->run->rounds)) {
        return false;
    }
    for (size_t kind = 0; kind < (size_t)PROBE_RAYS_COUNT; ++kind) {
        for (size_t choice = 0; choice < CHOICES; ++choice) {
            out->rays[kind][choice].exact_ms = methods[kind * (1 + CHOICES)].median_ms;
            out->rays[kind][choice].ms = methods[kind * (1 + CHOICES) + 1 + choice].median_ms;
        }
    }
    return true;
}

static bool judge_grid(probe_run *work, const probe_rays *sets, svo_probes *probes, const published_probes *published,
                       grid_figures *out)
{
    for (size_t i = 0; i < (size_t)PROBE_RAYS_COUNT * CHOICES; ++i) {
        const size_t kind = i / CHOICES;
        ray_method one = {.work = work,
                          .set = &sets[kind],
                          .probes = i % CHOICES == BY_FIELD ? probes : NULL,
                          .published = i % CHOICES == BY_EIGHT ? published : NULL};
        if (trace_once(&one) < 0 || !probe_rays_judge(one.set, work->hits, (double)out->info.leaf_edge,
                                                      &out->rays[kind][i % CHOICES].verdict)) {
            return false;
        }
    }
    return true;
}

/* sets: that decide what is right. */
static bool measure_grid(probe_run *work, const probe_rays *sets, const probe_grid *grid, grid_figures *out)
{
    const svo_probe_options asked = {.struct_size = sizeof asked,
                                     .counts = {grid->count, grid->count, grid->count},
                                     .resolution = grid->resolution,
                                     .field_size = grid->field,
                                     .tree = work->tree};
    svo_probes *probes = NULL;
    published_probes published = {.kernel = NULL};
    *out = (grid_figures){.grid = grid, .info = SVO_PROBE_INFO_INIT};
    const double started_ms = input_now_ms();
    bool worked = svo_probes_create(&asked, work->run->opened.queue, &probes) == SVO_OK;
    out->making_ms = input_now_ms() - started_ms;
    worked = worked && svo_probes_get_info(probes, &out->info) == SVO_OK &&
             published_probes_make(work->run->opened.device, probes, work->run->opened.queue, &published) &&
             judge_grid(work, sets, probes, &published, out) && time_grid(work, probes, &published, out);
    published_probes_free(&published);
    svo_probes_destroy(&probes);
    return worked;
}

/* ---- rows ---- */

/* Curves of charts: a grid's resolutions, and one of other fields. */
static void add_method(result_table *table, const probe_grid *grid, size_t choice)
{
    static const char *const powers[] = {[2] = "2³", [4] = "4³", [8] = "8³"};
    result_add_text(table, "%s%s, %s", grid->field == USUAL_FIELD ? "" : "other ", choice_names[choice],
                    powers[grid->count]);
}

static double per_ray_ns(const probe_run *work, double ms)
{
    return ms * 1e6 / (double)work->few_count;
}

static void add_row(probe_run *work, const grid_figures *of, size_t kind, size_t choice)
{
    result_table *table = result_find(work->run->results, "e8-probes");
    const ray_figures *one = &of->rays[kind][choice];
    const probe_verdict *verdict = &one->verdict;
    result_add_text(table, "%s", work->truth.name);
    result_add_text(table, "%s", probe_rays_name((probe_ray_kind)kind));
    add_method(table, of->grid, choice);
    result_add_number(table, of->info.probe_count);
    result_add_number(table, of->info.resolution);
    result_add_number(table, choice == BY_FIELD ? (double)of->info.field_size : (double)NAN);
    result_add_number(table, (double)of->info.total_bytes);
    result_add_number(table, of->making_ms);
    const double figures[] = {verdict->hit,       verdict->miss,       verdict->unknown,
                              verdict->wrong_hit, verdict->wrong_miss, verdict->wrong_hit + verdict->wrong_miss,
                              verdict->median,    verdict->p90,        verdict->p99};
    for (size_t i = 0; i < sizeof figures / sizeof figures[0]; ++i) {
        result_add_number(table, figures[i]);
    }
    result_add_number(table, per_ray_ns(work, one->ms));
    result_add_number(table, per_ray_ns(work, one->exact_ms));
    result_add_number(table, one->ms / one->exact_ms);
    ++*work->rows;
    *work->slower += one->ms > one->exact_ms;
}

/* Exact rays as the charts show them: without an error. */
static void add_exact(const probe_run *work, const grid_figures *of, size_t kind)
{
    result_table *table = result_find(work->run->results, "e8-probes");
    const double ns = per_ray_ns(work, of->rays[kind][0].exact_ms);
    size_t hits = 0;
    for (size_t i = 0; i < work->ray_count; ++i) {
        hits += work->all[kind].exact[i].triangle != SVO_NO_TRIANGLE;
    }
    const double share = 100.0 * (double)hits / (double)work->ray_count;
    result_add_text(table, "%s", work->truth.name);
    result_add_text(table, "%s", probe_rays_name((probe_ray_kind)kind));
    result_add_text(table, "exact rays");
    const double figures[] = {NAN, NAN, NAN, NAN, NAN, share, 100 - share, 0, 0, 0, 0, 0, 0, 0, ns, ns, 1};
    for (size_t i = 0; i < sizeof figures / sizeof figures[0]; ++i) {
        result_add_number(table, figures[i]);
    }
}

static void add_choices(const probe_run *work, const grid_figures *of, size_t kind)
{
    result_table *table = result_find(work->run->results, "e8-choices");
    const ray_figures *field = &of->rays[kind][BY_FIELD];
    const ray_figures *eight = &of->rays[kind][BY_EIGHT];
    result_add_text(table, "%s", work->truth.name);
    result_add_text(table, "%s", probe_rays_name((probe_ray_kind)kind));
    result_add_number(table, of->info.probe_count);
    result_add_number(table, of->info.resolution);
    result_add_number(table, field->verdict.wrong_hit + field->verdict.wrong_miss);
    result_add_number(table, eight->verdict.wrong_hit + eight->verdict.wrong_miss);
    result_add_number(table, field->verdict.unknown);
    result_add_number(table, eight->verdict.unknown);
    result_add_number(table, field->verdict.unknown / eight->verdict.unknown);
    result_add_number(table, field->ms / field->exact_ms);
    result_add_number(table, eight->ms / eight->exact_ms);
}

/* Other fields do not change what eight does. */
static void add_rows(probe_run *work, const grid_figures *of)
{
    const size_t choices = of->grid->field == USUAL_FIELD ? CHOICES : 1;
    for (size_t i = 0; i < (size_t)PROBE_RAYS_COUNT * choices; ++i) {
        add_row(work, of, i / choices, i % choices);
    }
}

static bool measure_grids(probe_run *work)
{
    const bool quick = work->run->quick;
    const probe_grid *grids = quick ? quick_grids : full_grids;
    const size_t count = quick ? sizeof quick_grids / sizeof *grids : sizeof full_grids / sizeof *grids;
    for (size_t i = 0; i < count; ++i) {
        const bool is_last = i + 1 == count; /* with the most probes */
        grid_figures figures;
        if (!measure_grid(work, is_last ? work->all : work->few, &grids[i], &figures)) {
            return false;
        }
        add_rows(work, &figures);
        for (size_t kind = 0; kind < (size_t)PROBE_RAYS_COUNT && is_last; ++kind) {
            add_exact(work, &figures, kind);
            add_choices(work, &figures, kind);
        }
    }
    return true;
}

/* ---- the experiment ---- */

static bool prepare(probe_run *work)
{
    work->lights = (cone_lights){.run = work->run, .truth = &work->truth};
    work->tree = cone_lights_tree(&work->lights, work->depth, SVO_COVERAGE_HALF_OPEN);
    work->hits = calloc(work->ray_count, sizeof *work->hits);
    work->exact = calloc(work->few_count, sizeof *work->exact);
    if (work->tree == NULL || work->hits == NULL || work->exact == NULL) {
        return false;
    }
    svo_camera camera = work->scene->camera;
    const bool has_camera =
        camera.vertical_fov > 0 || svo_camera_fit(svo_tree_target(work->tree), 1, &camera) == SVO_OK;
    return has_camera && probe_rays_make(work->run, work->tree, &camera, work->ray_count, work->all) &&
           probe_rays_make(work->run, work->tree, &camera, work->few_count, work->few);
}

static void release(probe_run *work)
{
    probe_rays_free(work->all);
    probe_rays_free(work->few);
    free(work->hits);
    free(work->exact);
    cone_lights_free(&work->lights);
    cone_truth_free(&work->truth);
}

static int measure_scene(probe_run *work)
{
    const bool quick = work->run->quick;
    truth_scene given = work->scene->lit;
    given.scene.spec = quick && work->scene->quick_spec != NULL ? work->scene->quick_spec : given.scene.spec;
    progress_step(work->run->state->progress, "E8: light by probes");
    int exit_code = cone_truth_make(work->run, &given, quick ? POINTS_QUICK : POINTS, quick ? SAMPLES_QUICK : SAMPLES,
                                    &work->truth);
    if (exit_code == PROGRAM_DONE && (!prepare(work) || !e8_light_measure(work->run, &work->lights, work->depth))) {
        exit_code = errors_fail(work->run);
    }
    progress_step(work->run->state->progress, "E8: rays through probes");
    if (exit_code == PROGRAM_DONE && !measure_grids(work)) {
        exit_code = errors_fail(work->run);
    }
    release(work);
    return exit_code;
}

static int run_all(suite *all)
{
    error_run run = errors_begin(all);
    const size_t asked = (size_t)all->state->options.ray_count;
    const size_t ray_count = run.quick && asked > RAYS_QUICK ? RAYS_QUICK : asked;
    size_t slower = 0;
    size_t rows = 0;
    int exit_code = PROGRAM_DONE;
    if (!all->state->options.has_repeat && !run.quick) {
        errors_set_rounds(&run, ROUNDS);
    }
    begin_probes(&run, ray_count);
    begin_choices(&run);
    e8_light_begin(&run);
    for (size_t i = 0; i < SUITE_LIST_MAX && exit_code == PROGRAM_DONE; ++i) {
        const bool own = run.scenes[0] == NULL;
        probe_scene chosen = scenes[own && i < SCENES ? i : 0]; /* others have the light of the first */
        if (own ? i == SCENES : run.scenes[i] == NULL) {
            break;
        }
        if (!own) {
            chosen = (probe_scene){.lit = {.scene = {.spec = run.scenes[i]}, .source = chosen.lit.source}};
        }
        probe_run work = {.run = &run,
                          .scene = &chosen,
                          .depth = run.quick ? DEPTH_QUICK : DEPTH,
                          .ray_count = ray_count,
                          .few_count = few_of(ray_count),
                          .slower = &slower,
                          .rows = &rows};
        exit_code = measure_scene(&work);
    }
    result_extend_note(result_find(run.results, "e8-probes"), "Exact rays were faster in %zu of %zu rows.", slower,
                       rows);
    return exit_code;
}

const suite_subject errors_probes = {
    .words = &subject_table[SUBJECT_E8],
    .run_all = run_all,
    .takes_scenes = true,
    .step_count = 2 * SCENES,
};
