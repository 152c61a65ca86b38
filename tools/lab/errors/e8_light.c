/* SPDX-License-Identifier: MIT */
/*
 * Probes take the light of sources where their texels' rays end, shadows included, and no more: what the truth has. So
 * neither a sky nor the light of photons goes into them. Cones gather what photons bring. Irradiance from probes is pi
 * times the mean radiance of cosine-weighted rays, or comes from their prefiltered maps.
 */
#include "errors/e8_light.h"

#include <math.h>
#include <stdlib.h>

#include "errors/cone_peers.h"
#include "errors/cones.h"
#include "errors/hemisphere.h"
#include "measure/spread.h"
#include "support/input.h"
#include "svocl/probes.h"

/* ---- light from probes ---- */

typedef struct probe_gather {
    const error_run *run;
    const cone_truth *truth;
    svo_probes *probes;
    unsigned per_point; /* rays; 0: prefiltered */
    svo_ray *rays;
    svo_probe_hit *hits;
    svo_probe_irradiance *results; /* where prefiltered */
} probe_gather;

#define PI   3.14159265358979323846
#define SEED 3u

/* probes: with a light, and diffuse where strata is 0. strata: of a point's cosine-weighted rays along a side of their
   square; they begin lift world units above the surface. False when memory runs out; what was made then is still
   released by probe_gather_free. */
static bool probe_gather_make(const error_run *run, const cone_truth *truth, svo_probes *probes, unsigned strata,
                              double lift, probe_gather *out)
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

static void probe_gather_free(probe_gather *work)
{
    free(work->rays);
    free(work->hits);
    free(work->results);
    *work = (probe_gather){.per_point = 0};
}

/* Traces the rays, or reads the maps: an interleaved_method's work. */
static double probe_gather_work(void *user)
{
    const probe_gather *work = user;
    const cone_truth *truth = work->truth;
    cl_command_queue queue = work->run->opened.queue;
    const double started_ms = input_now_ms();
    const svo_status status =
        work->per_point == 0
            ? svo_probes_irradiance(work->probes, svo_in_host(truth->points), svo_in_host(work->results), truth->count,
                                    &(svo_submit){.queue = queue})
            : svo_probes_trace(work->probes, svo_in_host(work->rays), svo_in_host(work->hits),
                               truth->count * work->per_point, NULL, &(svo_submit){.queue = queue});
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

/* Of the irradiance of the last run. Unknown rays are left out of a point's mean; where all are, the point is dark. */
static truth_error probe_gather_error(const probe_gather *work)
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

#define RESOLUTION       128u
#define RESOLUTION_QUICK 64u
#define GRIDS            3u /* of 2, 4 and 8 probes an axis */
#define GRIDS_QUICK      1u
#define STRATA           3u /* 4, 8 and 16: 16, 64 and 256 rays a point */
#define PROBE_METHODS    (GRIDS * (STRATA + 1))
#define CONE_METHODS     2u
#define PATH_METHODS     3u
#define METHODS          (PROBE_METHODS + CONE_METHODS + PATH_METHODS)

/* The probes of one grid. */
typedef struct lit_probes {
    svo_probes *probes;
    svo_probe_info info;
    double making_ms, relight_ms;
} lit_probes;

typedef struct light_work {
    const error_run *run;
    cone_lights *lights;
    unsigned depth;
    svo_light *direct; /* the light of the sources alone */
    lit_probes grids[GRIDS];
    probe_gather gathers[PROBE_METHODS]; /* of a grid: its rays by number, then its maps */
    cone_gather cones[CONE_METHODS];
    few_paths paths[PATH_METHODS];
    size_t grid_count, gather_count, cone_count, path_count;
    interleaved_method methods[METHODS]; /* those three after each other */
} light_work;

/* What a row says of a method; NAN where it has no such figure. */
typedef struct light_row {
    const char *method;
    double probes, number, bytes, making_ms, relight_ms, ms;
    truth_error error;
} light_row;

void e8_light_begin(const error_run *run)
{
    static const char *const measures[] = {"RMSE", "99th percentile", "largest", "bias"};
    result_table *table = result_add_table(run->results, "e8-light", "E8: light by probes", "");
    result_set_note(
        table,
        "Irradiance after one bounce at points of each scene, without a sky, relative to its mean over the points, "
        "against "
        "paths. Rays through probes begin a leaf's edge above the surface, cosine-weighted and stratified, made "
        "beforehand; unknown ones are left out of the mean. Prefiltered: maps of irradiance and of distances. Probes "
        "hold the light of the sources where their texels' rays end, at %u x %u texels. Cones: faces, photons, half "
        "steps. Paths: svo_gather by rays, the default. Making: probes, or the light that cones gather. Relighting: "
        "once the "
        "sources have changed. Time: of all points. %s; methods run interleaved.",
        run->quick ? RESOLUTION_QUICK : RESOLUTION, run->quick ? RESOLUTION_QUICK : RESOLUTION, run->rounds_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "method", "");
    result_add_column(table, "probes", "");
    result_add_column(table, "rays or cones", "");
    result_add_column(table, "size", "B");
    result_add_column(table, "making", "ms");
    result_add_column(table, "relighting", "ms");
    result_add_column(table, "time", "ms");
    for (size_t i = 0; i < sizeof measures / sizeof measures[0]; ++i) {
        result_add_column(table, measures[i], "");
    }
}

/* ---- methods ---- */

static bool make_direct_light(light_work *work)
{
    svo_light_setup setup = work->lights->truth->setup;
    svo_tree *tree = cone_lights_tree(work->lights, work->depth, SVO_COVERAGE_HALF_OPEN);
    setup.no_photons = 1;
    return tree != NULL && svo_light_create(tree, NULL, work->run->opened.queue, &work->direct) == SVO_OK &&
           svo_light_set_sources(work->direct, &setup, work->run->opened.queue) == SVO_OK;
}

/* The least probes: so that no kernel is compiled where time counts. */
static bool warm_up(light_work *work)
{
    svo_tree *tree = cone_lights_tree(work->lights, work->depth, SVO_COVERAGE_HALF_OPEN);
    const svo_probe_options least = {.struct_size = sizeof least,
                                     .counts = {1, 1, 1},
                                     .resolution = SVO_PROBES_RESOLUTION_MIN,
                                     .diffuse = 1,
                                     .cones = 1,
                                     .light = work->direct,
                                     .tree = tree};
    svo_probes *probes = NULL;
    const bool worked = svo_probes_create(&least, work->run->opened.queue, &probes) == SVO_OK;
    svo_probes_destroy(&probes);
    return worked;
}

static bool make_grid(light_work *work, unsigned count)
{
    lit_probes *made = &work->grids[work->grid_count++];
    svo_tree *tree = cone_lights_tree(work->lights, work->depth, SVO_COVERAGE_HALF_OPEN);
    const svo_probe_options asked = {.struct_size = sizeof asked,
                                     .counts = {count, count, count},
                                     .resolution = work->run->quick ? RESOLUTION_QUICK : RESOLUTION,
                                     .diffuse = 1,
                                     .cones = 1, /* they have nothing to gather */
                                     .light = work->direct,
                                     .tree = tree};
    const double started_ms = input_now_ms();
    made->info = (svo_probe_info)SVO_PROBE_INFO_INIT;
    if (svo_probes_create(&asked, work->run->opened.queue, &made->probes) != SVO_OK) {
        return false;
    }
    const double made_ms = input_now_ms();
    made->making_ms = made_ms - started_ms;
    if (svo_probes_relight(made->probes, work->run->opened.queue) != SVO_OK) {
        return false;
    }
    made->relight_ms = input_now_ms() - made_ms;
    return svo_probes_get_info(made->probes, &made->info) == SVO_OK;
}

static bool make_probes(light_work *work)
{
    const size_t grid_count = work->run->quick ? GRIDS_QUICK : GRIDS;
    for (size_t grid = 0; grid < grid_count; ++grid) {
        if (!make_grid(work, 2U << grid)) {
            return false;
        }
        const lit_probes *made = &work->grids[grid];
        for (unsigned i = 0; i <= STRATA; ++i) {
            const unsigned strata = i < STRATA ? 4U << i : 0;
            if (!probe_gather_make(work->run, work->lights->truth, made->probes, strata, (double)made->info.leaf_edge,
                                   &work->gathers[work->gather_count++])) {
                return false;
            }
        }
    }
    return true;
}

/* The sources are set twice: the second time no kernel is compiled. */
static bool make_cones(light_work *work)
{
    static const unsigned cones[CONE_METHODS] = {5, 16};
    for (unsigned i = 0; i < CONE_METHODS; ++i) {
        const cone_way way = {.method = "cones", .depth = work->depth, .cones = cones[i], .step = 0.5F};
        cone_gather *made = &work->cones[work->cone_count++];
        if (!cone_gather_make(work->lights, &way, made) ||
            svo_light_set_sources(made->light, &work->lights->truth->setup, work->run->opened.queue) != SVO_OK ||
            svo_light_get_info(made->light, &made->info) != SVO_OK) {
            return false;
        }
    }
    return true;
}

/* Through the light that cones gather. */
static bool make_paths(light_work *work)
{
    for (unsigned per_point = 16; per_point <= 256; per_point *= 4) {
        few_paths *made = &work->paths[work->path_count++];
        if (!few_paths_make(work->run, work->lights->truth, work->cones[0].light, per_point, made)) {
            return false;
        }
    }
    return true;
}

static void release(light_work *work)
{
    for (size_t i = 0; i < work->gather_count; ++i) {
        probe_gather_free(&work->gathers[i]);
    }
    for (size_t i = 0; i < work->cone_count; ++i) {
        cone_gather_free(&work->cones[i]);
    }
    for (size_t i = 0; i < work->path_count; ++i) {
        few_paths_free(&work->paths[i]);
    }
    for (size_t i = 0; i < work->grid_count; ++i) {
        svo_probes_destroy(&work->grids[i].probes);
    }
    svo_light_destroy(&work->direct);
}

static bool time_all(light_work *work)
{
    size_t count = 0;
    for (size_t i = 0; i < work->gather_count; ++i) {
        work->methods[count++] = (interleaved_method){.work_ms = probe_gather_work, .user = &work->gathers[i]};
    }
    for (size_t i = 0; i < work->cone_count; ++i) {
        work->methods[count++] = (interleaved_method){.work_ms = cone_gather_light, .user = &work->cones[i]};
    }
    for (size_t i = 0; i < work->path_count; ++i) {
        work->methods[count++] = (interleaved_method){.work_ms = few_paths_trace, .user = &work->paths[i]};
    }
    return interleave_measure(work->methods, count, work->run->rounds);
}

/* ---- rows ---- */

static void add_row(const light_work *work, const light_row *row)
{
    result_table *table = result_find(work->run->results, "e8-light");
    result_add_text(table, "%s", work->lights->truth->name);
    result_add_text(table, "%s", row->method);
    result_add_number(table, row->probes);
    result_add_number(table, row->number);
    result_add_number(table, row->bytes);
    result_add_number(table, row->making_ms);
    result_add_number(table, row->relight_ms);
    result_add_number(table, row->ms);
    result_add_number(table, row->error.rmse);
    result_add_number(table, row->error.p99);
    result_add_number(table, row->error.largest);
    result_add_number(table, row->error.bias);
}

static void add_probes(const light_work *work)
{
    static const char *const of_rays[GRIDS] = {"rays through 2³ probes", "rays through 4³ probes",
                                               "rays through 8³ probes"};
    static const char *const of_maps[GRIDS] = {"2³ prefiltered probes", "4³ prefiltered probes",
                                               "8³ prefiltered probes"};
    for (size_t i = 0; i < work->gather_count; ++i) {
        const size_t grid = i / (STRATA + 1);
        const lit_probes *made = &work->grids[grid];
        const probe_gather *one = &work->gathers[i];
        const light_row row = {.method = one->per_point > 0 ? of_rays[grid] : of_maps[grid],
                               .probes = made->info.probe_count,
                               .number = one->per_point > 0 ? (double)one->per_point : (double)NAN,
                               .bytes = (double)made->info.total_bytes,
                               .making_ms = made->making_ms,
                               .relight_ms = made->relight_ms,
                               .ms = work->methods[i].median_ms,
                               .error = probe_gather_error(one)};
        add_row(work, &row);
    }
}

static bool add_cones(light_work *work)
{
    for (size_t i = 0; i < work->cone_count; ++i) {
        cone_gather *one = &work->cones[i];
        truth_error openness;
        light_row row = {.method = "cones",
                         .probes = NAN,
                         .number = one->way.cones,
                         .bytes = (double)one->info.total_bytes,
                         .ms = work->methods[work->gather_count + i].median_ms};
        for (int stage = 0; stage < (int)SVO_LIGHT_STAGE_COUNT; ++stage) {
            row.making_ms += one->info.stage_ms[stage];
            row.relight_ms += stage < (int)SVO_LIGHT_STAGE_VIEW ? 0 : one->info.stage_ms[stage];
        }
        if (!cone_gather_compare(one, &openness, &row.error)) {
            return false;
        }
        add_row(work, &row);
    }
    return true;
}

static void add_paths(const light_work *work)
{
    for (size_t i = 0; i < work->path_count; ++i) {
        const few_paths *one = &work->paths[i];
        const light_row row = {.method = "paths",
                               .probes = NAN,
                               .number = one->per_point,
                               .bytes = NAN,
                               .making_ms = NAN,
                               .relight_ms = NAN,
                               .ms = work->methods[work->gather_count + work->cone_count + i].median_ms,
                               .error = few_paths_error(one)};
        add_row(work, &row);
    }
}

bool e8_light_measure(const error_run *run, cone_lights *lights, unsigned depth)
{
    light_work work = {.run = run, .lights = lights, .depth = depth};
    bool worked = make_direct_light(&work) && warm_up(&work) && make_probes(&work) && make_cones(&work) &&
                  make_paths(&work) && time_all(&work);
    if (worked) {
        add_probes(&work);
        worked = add_cones(&work);
        add_paths(&work);
    }
    release(&work);
    return worked;
}
