/* SPDX-License-Identifier: MIT */
/*
 * The light of a scene through which a knot moves, by svo_light_update, beside the light of the same tree from nothing.
 * Knots of several sizes change several shares of the tree.
 */
#include "bench/subjects.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measure/spread.h"
#include "measure/vertex_attributes.h"
#include "scenes/scenes.h"
#include "svocl/light.h"
#include "svocl/moving.h"

static const char table_id[] = "moving-light";
static const char object_spec[] = "knot:20000";

/* Widths of the knot, in widths of the grid. */
static const double widths[] = {0.02, 0.05, 0.1, 0.2};
#define WIDTH_COUNT (sizeof widths / sizeof widths[0])

/* What is timed: the BVH that both need, stages of updates and lights from nothing, all of both, their ratio. */
enum { BVH, AGAIN, ANEW, OPACITY, RADIANCE, UPDATE, NOTHING, RATIO, TIME_COUNT };

static const char note[] =
    "A knot moves by a voxel through the scene, under a sun; the light has the form faces. Width: of the knot, in "
    "widths of the grid. Changed: the share of the (voxel, triangle) pairs that moved. Traced: the share of the "
    "photons that are shot again. BVH: of the moved tree; both need it, and neither includes it. Photons: light "
    "view and photons, of the update and from nothing. Opacity, radiance: of the update, with their filters. "
    "Update: svo_light_update. Nothing: svo_light_create and svo_light_set_sources of the same tree, with the same "
    "bytes. Ratio: of the two within a round.";

static int begin(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Light that follows what moves", note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "photons", "");
    result_add_column(table, "width", "");
    result_add_column(table, "changed", "%");
    result_add_column(table, "traced", "%");
    result_add_column(table, "BVH", "ms");
    result_add_column(table, "photons again", "ms");
    result_add_column(table, "photons anew", "ms");
    result_add_column(table, "opacity", "ms");
    result_add_column(table, "radiance", "ms");
    spread_add_columns(table, "update", "ms");
    spread_add_columns(table, "nothing", "ms");
    spread_add_columns(table, "ratio", "");
    return PROGRAM_DONE;
}

/* A knot of one width in a scene. */
typedef struct lit_run {
    suite *all;
    unsigned depth;
    double width; /* of the knot, world units */
    double middle[3], step;
    svo_moving_options options;
    svo_moving *moving;
    svo_light *light, *anew;
    double *times[TIME_COUNT]; /* of the rounds */
    double changed, traced, photons; /* of the last round */
} lit_run;

static int fail(const lit_run *run)
{
    return program_fail_library(run->all->state, svo_device_message(run->all->opened.device));
}

/* ---- the scene ---- */

static void find_bounds(const svo_mesh *mesh, double low[3], double high[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = INFINITY;
        high[axis] = -INFINITY;
    }
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        const double x = mesh->positions_double != NULL ? mesh->positions_double[i] : (double)mesh->positions[i];
        low[i % 3] = fmin(low[i % 3], x);
        high[i % 3] = fmax(high[i % 3], x);
    }
}

/* A cube around the scene with some room, and the middle of the scene. */
static void choose_grid(const svo_mesh *mesh, lit_run *run)
{
    double low[3];
    double high[3];
    find_bounds(mesh, low, high);
    svo_moving_options *chosen = &run->options;
    chosen->edge = 1.02 * fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    for (int axis = 0; axis < 3; ++axis) {
        chosen->origin[axis] = low[axis] - 0.01 * chosen->edge;
        run->middle[axis] = (low[axis] + high[axis]) / 2;
    }
    chosen->need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS;
    chosen->max_area = 1e3 * chosen->edge * chosen->edge;
    run->width *= chosen->edge;
    run->step = chosen->edge / (double)(1u << run->depth);
}

/* Puts the knot into the middle of the scene, shifted by some steps. */
static void place(const lit_run *run, const svo_mesh *object, double steps, double transform[12])
{
    double low[3];
    double high[3];
    find_bounds(object, low, high);
    const double size = run->width / fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    memset(transform, 0, 12 * sizeof *transform);
    for (size_t axis = 0; axis < 3; ++axis) {
        transform[5 * axis] = size;
        transform[4 * axis + 3] = run->middle[axis] + steps * run->step - size * (low[axis] + high[axis]) / 2;
    }
}

/* ---- a round ---- */

static svo_status make_light(lit_run *run, svo_light **light, uint32_t updatable)
{
    const svo_light_source sun = {
        .kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.35F, -1, -0.3F}, .value = {10, 9.5F, 8.5F}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = &sun;
    setup.source_count = 1;
    setup.updatable = updatable;
    svo_light_destroy(light);
    const svo_status status = svo_light_create(svo_moving_tree(run->moving), NULL, run->all->opened.queue, light);
    if (status != SVO_OK) {
        return status;
    }
    return svo_light_set_sources(*light, &setup, run->all->opened.queue);
}

static svo_status update_light(lit_run *run)
{
    svo_box boxes[2];
    size_t count = 0;
    const svo_status status = svo_moving_get_changes(run->moving, boxes, 2, &count);
    if (status != SVO_OK) {
        return status;
    }
    return svo_light_update(run->light, svo_moving_tree(run->moving), boxes, count, run->all->opened.queue);
}

static svo_status move(lit_run *run, const svo_mesh *object, size_t round, double *times)
{
    double transform[12];
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    place(run, object, round % 2 != 0 ? 1.0 : 0.0, transform);
    svo_status status = svo_moving_set_transform(run->moving, 0, transform);
    if (status == SVO_OK) {
        status = svo_moving_update(run->moving, NULL, &report);
    }
    const double start_ms = input_now_ms();
    if (status == SVO_OK) {
        status = svo_tree_make_bvh(svo_moving_tree(run->moving), SVO_BVH_BEST, run->all->opened.queue);
    }
    times[BVH] = input_now_ms() - start_ms;
    run->changed = 50.0 * (double)report.changed_fragments / (double)report.fragments;
    return status;
}

static double photon_ms(const svo_light_info *info)
{
    return info->stage_ms[SVO_LIGHT_STAGE_VIEW] + info->stage_ms[SVO_LIGHT_STAGE_PHOTONS];
}

/* The same light twice, in turn first and second. */
static svo_status light_both(lit_run *run, size_t round, double *times)
{
    for (size_t turn = 0; turn < 2; ++turn) {
        const bool updates = (round + turn) % 2 == 0;
        const double start_ms = input_now_ms();
        const svo_status status = updates ? update_light(run) : make_light(run, &run->anew, 0);
        if (status != SVO_OK) {
            return status;
        }
        times[updates ? UPDATE : NOTHING] = input_now_ms() - start_ms;
    }
    times[RATIO] = times[UPDATE] / times[NOTHING];
    return SVO_OK;
}

static void describe(lit_run *run, double *times)
{
    svo_light_info info = SVO_LIGHT_INFO_INIT;
    (void)svo_light_get_info(run->anew, &info);
    times[ANEW] = photon_ms(&info);
    (void)svo_light_get_info(run->light, &info);
    times[AGAIN] = photon_ms(&info);
    times[OPACITY] = info.stage_ms[SVO_LIGHT_STAGE_OPACITY] + info.stage_ms[SVO_LIGHT_STAGE_OPACITY_FILTER];
    times[RADIANCE] = info.stage_ms[SVO_LIGHT_STAGE_EXCHANGE] + info.stage_ms[SVO_LIGHT_STAGE_FILTER];
    run->photons = (double)info.photons;
    run->traced = 100.0 * (double)info.traced_photons / (double)info.photons;
}

/* Whether both lights are the same, byte for byte. */
static bool are_same(const lit_run *run)
{
    char hashes[2][SVO_HASH_TEXT_BYTES];
    return svo_light_hash(run->light, run->all->opened.queue, hashes[0]) == SVO_OK &&
           svo_light_hash(run->anew, run->all->opened.queue, hashes[1]) == SVO_OK && strcmp(hashes[0], hashes[1]) == 0;
}

/* The first two rounds are not counted. */
static int run_rounds(lit_run *run, const svo_mesh *object)
{
    for (size_t round = 0; round < run->all->repeats + 2; ++round) {
        double times[TIME_COUNT] = {0.0};
        if (move(run, object, round + 1, times) != SVO_OK || light_both(run, round, times) != SVO_OK) {
            return fail(run);
        }
        if (!are_same(run)) {
            return program_fail(run->all->state, PROGRAM_FAILED,
                                "the light of an update differs from that from nothing");
        }
        describe(run, times);
        for (size_t i = 0; i < (round >= 2 ? TIME_COUNT : 0); ++i) {
            run->times[i][round - 2] = times[i];
        }
    }
    return PROGRAM_DONE;
}

static void add_row(lit_run *run, const input *source, double width)
{
    const size_t repeats = run->all->repeats;
    result_table *table = result_find(run->all->results, table_id);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, run->depth);
    result_add_number(table, run->photons);
    result_add_number(table, width);
    result_add_number(table, run->changed);
    result_add_number(table, run->traced);
    for (size_t i = BVH; i < UPDATE; ++i) {
        result_add_number(table, spread_of(run->times[i], repeats).median);
    }
    for (size_t i = UPDATE; i < TIME_COUNT; ++i) {
        spread_add(table, spread_of(run->times[i], repeats));
    }
}

static int open_scene(lit_run *run, const svo_mesh *fixed, const svo_mesh *object)
{
    uint32_t number = 0;
    double transform[12];
    vertex_attributes made; /* the scene must have what the object has, and no more */
    choose_grid(fixed, run);
    if (!vertex_attributes_create(fixed, &made)) {
        return program_fail(run->all->state, PROGRAM_FAILED, "out of memory for the scene's colors and normals");
    }
    svo_mesh still = fixed->colors != NULL && fixed->normals != NULL && fixed->uvs == NULL ? *fixed : made.mesh;
    still.finishes = NULL;
    place(run, object, 0.0, transform);
    cl_command_queue queue = run->all->opened.queue;
    const bool opened =
        svo_moving_create(run->all->opened.device, &still, run->depth, &run->options, queue, &run->moving) == SVO_OK &&
        svo_moving_add(run->moving, object, transform, &number) == SVO_OK &&
        svo_moving_update(run->moving, NULL, NULL) == SVO_OK && make_light(run, &run->light, 1) == SVO_OK;
    vertex_attributes_free(&made);
    return opened ? PROGRAM_DONE : fail(run);
}

static int run_width(suite *all, const input *source, unsigned depth, const svo_mesh *object, double width)
{
    lit_run run = {.all = all, .depth = depth, .width = width, .options = SVO_MOVING_OPTIONS_INIT};
    double *times = malloc(TIME_COUNT * (all->repeats + 1) * sizeof *times);
    if (times == NULL) {
        return program_fail(all->state, PROGRAM_FAILED, "out of memory for %zu times", all->repeats);
    }
    for (size_t i = 0; i < TIME_COUNT; ++i) {
        run.times[i] = times + i * (all->repeats + 1);
    }
    int exit_code = open_scene(&run, source->mesh, object);
    exit_code = exit_code == PROGRAM_DONE ? run_rounds(&run, object) : exit_code;
    if (exit_code == PROGRAM_DONE) {
        add_row(&run, source, width);
    }
    svo_light_destroy(&run.light);
    svo_light_destroy(&run.anew);
    svo_moving_destroy(&run.moving);
    free(times);
    return exit_code;
}

static int run(suite *all, const input *source, unsigned depth)
{
    scene *knot = NULL;
    svo_message message;
    int exit_code = PROGRAM_DONE;
    if (scene_create(object_spec, &knot, &message) != SVO_OK) {
        return program_fail_library(all->state, message.text);
    }
    for (size_t i = 0; i < WIDTH_COUNT && exit_code == PROGRAM_DONE; ++i) {
        exit_code = run_width(all, source, depth, scene_mesh(knot), widths[i]);
    }
    scene_destroy(&knot);
    return exit_code;
}

const suite_subject bench_moving_light = {
    .words = &subject_table[SUBJECT_MOVING_LIGHT],
    .full = {.scenes = {"atrium"}, .depths = {8, 9}},
    .quick = {.scenes = {"atrium:17000"}, .depths = {7}},
    .begin = begin,
    .run = run,
};
