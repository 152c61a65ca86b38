/* SPDX-License-Identifier: MIT */
/*
 * The stages of light in each form, next to the figures that a master's thesis on voxel cone tracing published in 2016
 * for grids of the same size (Radeon HD 5850); its bytes next to those of a dense pyramid of six directions, whose
 * passes run on the same device; and frames gathered by five cones.
 */
#include "bench/subjects.h"

#include <math.h>
#include <stdlib.h>

#include "bench/dense_faces.h"
#include "measure/spread.h"
#include "support/query_table.h"
#include "svocl/light.h"

#define ROUNDS_MAX      3u /* views of millions of photons take seconds on a processor */
#define VIEW            4096u /* photons along a side of the first form's view, as published */
#define VIEW_OTHERS     1024u
#define VIEW_QUICK      512u
#define FRAME_WIDTH     800u /* as published */
#define FRAME_HEIGHT    600u
#define FRAME_CONES     5u
#define WARM_UP_POINTS  4096u
#define PUBLISHED_FIRST 7u /* the depth of the first of three figures */

static const char stages_id[] = "light-stages";
static const char bytes_id[] = "light-bytes";
static const char frames_id[] = "light-frames";

/* For 128, 256 and 512 voxels per axis; NAN: there is no such stage. */
typedef struct published_stage {
    const char *name;
    int stage; /* svo_light_stage; NO_STAGE: svocl needs none */
    double ms[3];
} published_stage;
#define NO_STAGE (-1)

static const published_stage published_stages[] = {{"neighbors", NO_STAGE, {2, 10, 76}},
                                                   {"opacity", SVO_LIGHT_STAGE_OPACITY, {114, 2012, 7092}},
                                                   {"opacity filter", SVO_LIGHT_STAGE_OPACITY_FILTER, {18, 132, 1038}},
                                                   {"light view", SVO_LIGHT_STAGE_VIEW, {8, 253, 233}},
                                                   {"photons", SVO_LIGHT_STAGE_PHOTONS, {10718, 9833, 10855}},
                                                   {"exchange", SVO_LIGHT_STAGE_EXCHANGE, {NAN, NAN, NAN}},
                                                   {"border exchange", NO_STAGE, {1, 6, 31}},
                                                   {"radiance filter", SVO_LIGHT_STAGE_FILTER, {16, 123, 982}}};

static const double published_dense_kb[3] = {8192, 65536, 524288};
static const double published_neighbors_kb[3] = {1345, 6398, 27460};
static const double published_bricks_kb[3] = {8192, 65536, 65536};
static const double published_frames[3] = {28, 19, 12};

typedef struct light_bench {
    suite *all;
    const input *source;
    unsigned depth;
    size_t rounds; /* after the warm-up */
    svo_tree *tree;
    svo_tree_info info;
    svo_light *light; /* of the form that is measured */
    svo_light_info lit; /* of the last round */
    svo_light_info counted; /* of the run that counts */
    double *times; /* by stage, round */
    double *scratch; /* a number for each round */
} light_bench;

/* ---- tables ---- */

typedef struct table_column {
    const char *name, *unit;
} table_column;

static const table_column stage_columns[] = {
    {"scene", ""}, {"depth", ""}, {"form", ""}, {"stage", ""}, {"photons", ""}};
static const table_column published_columns[] = {{"published", "ms"}, {"ratio", ""}, {"rate", "M/s"}};
static const table_column byte_columns[] = {{"scene", ""},
                                            {"depth", ""},
                                            {"nodes", ""},
                                            {"form", ""},
                                            {"lit leaves", ""},
                                            {"lit nodes", ""},
                                            {"missed leaves", ""},
                                            {"opacity", "B"},
                                            {"radiance", "B"},
                                            {"all", "B"},
                                            {"scratch", "B"},
                                            {"dense", "B"},
                                            {"share", "%"},
                                            {"RGBA8 pyramid", "B"},
                                            {"filters", "ms"},
                                            {"RGBA8 pyramid, passes", "ms"},
                                            {"published dense", "B"},
                                            {"published neighbors", "B"},
                                            {"published bricks", "B"}};
static const table_column frame_columns[] = {{"scene", ""},   {"depth", ""},     {"form", ""},
                                             {"pixels", ""},  {"points", ""},    {"first hits", "ms"},
                                             {"cones", "ms"}, {"frames", "1/s"}, {"published", "1/s"}};

static void add_columns(result_table *table, const table_column *columns, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        result_add_column(table, columns[i].name, columns[i].unit);
    }
}
#define ADD_COLUMNS(table, columns) add_columns(table, columns, sizeof(columns) / sizeof(columns)[0])

static void begin_stages(suite *all, size_t rounds)
{
    result_table *table = result_add_table(all->results, stages_id, "Light: stages", "");
    result_set_note(
        table,
        "Medians and quartiles (q1, q3) of %zu runs after a warm-up run. One directional light. Published: Voxel cone "
        "tracing thesis (2016), Radeon HD 5850, the corresponding stage on a grid of the same size, with a view of "
        "4,096 photons along a side. Ratio: published time to svocl's; above 1 svocl is quicker. svocl needs no "
        "neighbors, and no exchange between the borders of bricks; its own exchange makes radiance of the photons' "
        "sums. Rate: rays per second of the light view.",
        rounds);
    ADD_COLUMNS(table, stage_columns);
    spread_add_columns(table, "time", "ms");
    ADD_COLUMNS(table, published_columns);
}

static void begin_bytes(suite *all)
{
    result_table *table = result_add_table(
        all->results, bytes_id, "Light: bytes",
        "Lit leaves and nodes: those with radiance; bricks: inner nodes alone. Missed leaves: in the light without "
        "a photon. Dense: every voxel of the grid and of all levels, with the same numbers a voxel as the light stores "
        "a node. RGBA8 pyramid: a dense one of six directions on all levels but the finest, as public engines hold it; "
        "its passes from level to level run on the same device. Share: of the dense bytes. Published: dense voxels, "
        "neighbors and bricks of a master's thesis on voxel cone tracing (2016) on a grid of the same size.");
    ADD_COLUMNS(table, byte_columns);
}

static void begin_frames(suite *all)
{
    result_table *table = result_add_table(
        all->results, frames_id, "Light: frames",
        "First hits by exact rays, then five cones for each of them. Published: frames of 800 x 600 per second on a "
        "grid of the same size (thesis, 2016, Radeon HD 5850); 83 without cones.");
    ADD_COLUMNS(table, frame_columns);
}

static size_t rounds_of(const suite *all)
{
    return all->repeats < ROUNDS_MAX ? all->repeats : ROUNDS_MAX;
}

static int begin(suite *all)
{
    begin_stages(all, rounds_of(all));
    begin_bytes(all);
    begin_frames(all);
    return PROGRAM_DONE;
}

/* One of three figures; NAN on other grids. */
static double published_at(const double figures[3], unsigned depth)
{
    return depth >= PUBLISHED_FIRST && depth < PUBLISHED_FIRST + 3 ? figures[depth - PUBLISHED_FIRST] : NAN;
}

/* ---- the tree and its light ---- */

static svo_status build_tree(light_bench *bench)
{
    const session *opened = &bench->all->opened;
    svo_plan_options asked = SVO_PLAN_OPTIONS_INIT;
    svo_plan *plan = NULL;
    asked.need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS | SVO_NEED_PROJECTED_AREA;
    svo_status status = svo_plan_create(opened->device, bench->source->mesh, bench->depth, &asked, &plan);
    if (status == SVO_OK) {
        status = svo_build(plan, opened->cl, opened->queue, &bench->tree, NULL);
    }
    svo_plan_destroy(&plan);
    if (status != SVO_OK) {
        return status;
    }
    bench->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(bench->tree, &bench->info);
    return svo_tree_download(bench->tree, opened->queue);
}

/* Photons do not depend on the form: one form shoots as many as published. */
static uint32_t view_of(const suite *all, svo_light_form form)
{
    return all->quick ? VIEW_QUICK : form == SVO_LIGHT_FACES ? VIEW : VIEW_OTHERS;
}

static bool shoots(int stage)
{
    return stage == SVO_LIGHT_STAGE_VIEW || stage == SVO_LIGHT_STAGE_PHOTONS;
}

/* Makes the light anew. counts: also what setup.diagnose counts. */
static svo_status make_light(light_bench *bench, svo_light_form form, bool counts, svo_light_info *info)
{
    const svo_light_options stored = {.struct_size = sizeof stored, .form = form};
    const svo_light_source sun = {
        .kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.35F, -1, -0.3F}, .value = {10, 9.5F, 8.5F}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = &sun;
    setup.source_count = 1;
    setup.view_resolution = view_of(bench->all, form);
    setup.diagnose = counts;
    svo_light_destroy(&bench->light);
    svo_status status = svo_light_create(bench->tree, &stored, bench->all->opened.queue, &bench->light);
    if (status == SVO_OK) {
        status = svo_light_set_sources(bench->light, &setup, bench->all->opened.queue);
    }
    if (status != SVO_OK) {
        return status;
    }
    *info = (svo_light_info)SVO_LIGHT_INFO_INIT;
    return svo_light_get_info(bench->light, info);
}

/* The first round counts and warms up; the others are timed. */
static svo_status measure_form(light_bench *bench, svo_light_form form)
{
    svo_status status = make_light(bench, form, true, &bench->counted);
    if (status != SVO_OK) {
        return status;
    }
    for (size_t round = 0; round < bench->rounds; ++round) {
        status = make_light(bench, form, false, &bench->lit);
        if (status != SVO_OK) {
            return status;
        }
        for (size_t stage = 0; stage < SVO_LIGHT_STAGE_COUNT; ++stage) {
            bench->times[stage * bench->rounds + round] = bench->lit.stage_ms[stage];
        }
    }
    return SVO_OK;
}

/* ---- rows of stages and bytes ---- */

static spread stage_spread(const light_bench *bench, size_t stage)
{
    for (size_t round = 0; round < bench->rounds; ++round) {
        bench->scratch[round] = bench->times[stage * bench->rounds + round];
    }
    return spread_of(bench->scratch, bench->rounds);
}

static void add_stage(const light_bench *bench, const published_stage *given)
{
    result_table *table = result_find(bench->all->results, stages_id);
    const bool runs = given->stage != NO_STAGE;
    const spread ms = runs ? stage_spread(bench, (size_t)given->stage) : spread_none();
    const bool fewer = shoots(given->stage) && view_of(bench->all, bench->lit.form) != VIEW;
    const double published = fewer ? NAN : published_at(given->ms, bench->depth);
    result_add_text(table, "%s", suite_scene_name(bench->source));
    result_add_number(table, bench->depth);
    result_add_text(table, "%s", svo_name(SVO_NAME_LIGHT_FORM, bench->lit.form));
    result_add_text(table, "%s", given->name);
    result_add_number(table, shoots(given->stage) ? (double)bench->lit.photons : NAN);
    spread_add(table, ms);
    result_add_number(table, published);
    result_add_number(table, published / ms.median);
    result_add_number(table,
                      given->stage == SVO_LIGHT_STAGE_VIEW ? (double)bench->lit.photons / ms.median * 1e-3 : NAN);
}

/* Every voxel of all levels with the numbers of one node. Bricks: of one sample, which is one voxel's. */
static double dense_bytes(const light_bench *bench)
{
    static const double of_voxel[SVO_LIGHT_FORM_COUNT] = {
        [SVO_LIGHT_FACES] = 6 * (2 + 2 + 4), [SVO_LIGHT_BRICKS] = 2 + 4, [SVO_LIGHT_VOXELS] = 2 + 4};
    double voxels = 0;
    for (unsigned level = 0; level <= bench->depth; ++level) {
        voxels += ldexp(1, 3 * (int)level);
    }
    return voxels * of_voxel[bench->lit.form];
}

static void add_bytes(const light_bench *bench, double dense_ms)
{
    result_table *table = result_find(bench->all->results, bytes_id);
    const uint64_t *bytes = bench->lit.bytes;
    const double dense = dense_bytes(bench);
    result_add_text(table, "%s", suite_scene_name(bench->source));
    result_add_number(table, bench->depth);
    result_add_number(table, (double)bench->info.node_count);
    result_add_text(table, "%s", svo_name(SVO_NAME_LIGHT_FORM, bench->lit.form));
    result_add_number(table, (double)bench->counted.lit_leaves);
    result_add_number(table, (double)bench->counted.lit_nodes);
    result_add_number(table, (double)bench->counted.missed_leaves);
    result_add_number(table, (double)(bytes[SVO_LIGHT_OPACITY] + bytes[SVO_LIGHT_COVER]));
    result_add_number(table, (double)(bytes[SVO_LIGHT_LIT] + bytes[SVO_LIGHT_RADIANCE]));
    result_add_number(table, (double)bench->lit.total_bytes);
    result_add_number(table, (double)bench->lit.scratch_bytes);
    result_add_number(table, dense);
    result_add_number(table, 100.0 * (double)bench->lit.total_bytes / dense);
    result_add_number(table, (double)dense_faces_bytes(bench->depth));
    result_add_number(table, stage_spread(bench, SVO_LIGHT_STAGE_OPACITY_FILTER).median +
                                 stage_spread(bench, SVO_LIGHT_STAGE_FILTER).median);
    result_add_number(table, dense_ms);
    result_add_number(table, 1024 * published_at(published_dense_kb, bench->depth));
    result_add_number(table, 1024 * published_at(published_neighbors_kb, bench->depth));
    result_add_number(table, 1024 * published_at(published_bricks_kb, bench->depth));
}

/* The median of the dense pyramid's passes; NAN where the device cannot hold it. */
static double measure_dense(const light_bench *bench)
{
    dense_faces *pyramid = dense_faces_create(&bench->all->opened, bench->tree);
    bool worked = pyramid != NULL;
    for (size_t round = 0; round <= bench->rounds && worked; ++round) {
        const double ms = dense_faces_merge(pyramid);
        worked = ms >= 0;
        bench->scratch[round > 0 ? round - 1 : 0] = ms;
    }
    dense_faces_destroy(&pyramid);
    return worked ? spread_of(bench->scratch, bench->rounds).median : NAN;
}

/* ---- frames ---- */

typedef struct frame_points {
    svo_gather_point *points;
    svo_gather_result *results;
    size_t count, pixels; /* a point for each pixel that shows a surface */
    double first_hit_ms;
} frame_points;

static void free_frame(frame_points *frame)
{
    free(frame->points);
    free(frame->results);
    *frame = (frame_points){.count = 0};
}

/* Normals look towards the eye. */
static svo_gather_point point_of(const svo_ray *ray, const svo_hit *hit)
{
    svo_gather_point point = {.exponent = 0};
    float along = 0;
    for (int axis = 0; axis < 3; ++axis) {
        point.position[axis] = ray->origin[axis] + hit->t * ray->direction[axis];
        along += hit->normal[axis] * ray->direction[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        point.normal[axis] = along > 0 ? -hit->normal[axis] : hit->normal[axis];
    }
    return point;
}

static int fill_frame(const light_bench *bench, const ray_table *cast, svo_hit *hits, frame_points *frame)
{
    program *state = bench->all->state;
    for (size_t round = 0; round <= bench->rounds; ++round) { /* the first makes what rays need */
        const double started_ms = input_now_ms();
        if (svo_trace_triangles(svo_tree_target(bench->tree), svo_in_host(cast->rays), svo_in_host(hits), cast->count,
                                SVO_TRACE_CLOSEST, &(svo_submit){.queue = bench->all->opened.queue}) != SVO_OK) {
            return program_fail_library(state, svo_device_message(bench->all->opened.device));
        }
        bench->scratch[round > 0 ? round - 1 : 0] = input_now_ms() - started_ms;
    }
    frame->first_hit_ms = spread_of(bench->scratch, bench->rounds).median;
    for (size_t i = 0; i < cast->count; ++i) {
        if (hits[i].triangle != SVO_NO_TRIANGLE) {
            frame->points[frame->count++] = point_of(&cast->rays[i], &hits[i]);
        }
    }
    return PROGRAM_DONE;
}

static int make_frame(const light_bench *bench, frame_points *frame)
{
    program *state = bench->all->state;
    svo_camera camera = {.vertical_fov = 0};
    ray_table cast = {0};
    const uint32_t scale = bench->all->quick ? 8 : 1;
    if (svo_camera_fit(svo_tree_target(bench->tree), (float)FRAME_WIDTH / FRAME_HEIGHT, &camera) != SVO_OK) {
        return program_fail_library(state, svo_device_message(bench->all->opened.device));
    }
    int exit_code = ray_table_from_camera(state, &camera, FRAME_WIDTH / scale, FRAME_HEIGHT / scale, NULL, &cast);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    frame->pixels = cast.count;
    svo_hit *hits = calloc(cast.count, sizeof *hits);
    frame->points = calloc(cast.count, sizeof *frame->points);
    frame->results = calloc(cast.count, sizeof *frame->results);
    exit_code = hits != NULL && frame->points != NULL && frame->results != NULL
                    ? fill_frame(bench, &cast, hits, frame)
                    : program_fail(state, PROGRAM_FAILED, "out of memory for %zu points", cast.count);
    free(hits);
    ray_table_free(&cast);
    return exit_code;
}

/* Milliseconds for the first points; below 0 on failure. */
static double gather_frame(const light_bench *bench, const frame_points *frame, size_t count)
{
    const svo_gather_options asked = {.struct_size = sizeof asked, .cones = FRAME_CONES};
    const double started_ms = input_now_ms();
    const svo_status status = svo_gather(bench->light, svo_in_host(frame->points), svo_in_host(frame->results), count,
                                         &asked, &(svo_submit){.queue = bench->all->opened.queue});
    return status == SVO_OK ? input_now_ms() - started_ms : -1.0;
}

static int add_frame(const light_bench *bench, const frame_points *frame)
{
    result_table *table = result_find(bench->all->results, frames_id);
    const bool warm = gather_frame(bench, frame, frame->count < WARM_UP_POINTS ? frame->count : WARM_UP_POINTS) >= 0;
    const double ms = warm ? gather_frame(bench, frame, frame->count) : -1.0;
    if (ms < 0) {
        return program_fail_library(bench->all->state, svo_device_message(bench->all->opened.device));
    }
    result_add_text(table, "%s", suite_scene_name(bench->source));
    result_add_number(table, bench->depth);
    result_add_text(table, "%s", svo_name(SVO_NAME_LIGHT_FORM, bench->lit.form));
    result_add_number(table, (double)frame->pixels);
    result_add_number(table, (double)frame->count);
    result_add_number(table, frame->first_hit_ms);
    result_add_number(table, ms);
    result_add_number(table, 1e3 / (frame->first_hit_ms + ms));
    result_add_number(table, bench->all->quick ? NAN : published_at(published_frames, bench->depth));
    return PROGRAM_DONE;
}

/* ---- the subject ---- */

static int measure_forms(light_bench *bench, const frame_points *frame)
{
    const double dense_ms = measure_dense(bench);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        if (measure_form(bench, (svo_light_form)form) != SVO_OK) {
            return program_fail_library(bench->all->state, svo_device_message(bench->all->opened.device));
        }
        for (size_t i = 0; i < sizeof published_stages / sizeof published_stages[0]; ++i) {
            if (published_stages[i].stage != NO_STAGE || form == SVO_LIGHT_BRICKS) {
                add_stage(bench, &published_stages[i]);
            }
        }
        add_bytes(bench, dense_ms);
        const int exit_code = add_frame(bench, frame);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    }
    return PROGRAM_DONE;
}

static int measure(light_bench *bench)
{
    frame_points frame = {.count = 0};
    if (build_tree(bench) != SVO_OK) {
        return program_fail_library(bench->all->state, svo_device_message(bench->all->opened.device));
    }
    int exit_code = make_frame(bench, &frame);
    if (exit_code == PROGRAM_DONE) {
        exit_code = measure_forms(bench, &frame);
    }
    free_frame(&frame);
    return exit_code;
}

static int run(suite *all, const input *source, unsigned depth)
{
    light_bench bench = {.all = all, .source = source, .depth = depth, .rounds = rounds_of(all)};
    bench.times = calloc(SVO_LIGHT_STAGE_COUNT * bench.rounds, sizeof *bench.times);
    bench.scratch = calloc(bench.rounds, sizeof *bench.scratch);
    const int exit_code = bench.times != NULL && bench.scratch != NULL
                              ? measure(&bench)
                              : program_fail(all->state, PROGRAM_FAILED, "out of memory");
    svo_light_destroy(&bench.light);
    svo_tree_destroy(&bench.tree);
    free(bench.times);
    free(bench.scratch);
    return exit_code;
}

const suite_subject bench_light = {
    .words = &subject_table[SUBJECT_LIGHT],
    .full = {.scenes = {"atrium"}, .depths = {7, 8, 9}},
    .quick = {.scenes = {"atrium:17000"}, .depths = {7}},
    .begin = begin,
    .run = run,
};
