/* SPDX-License-Identifier: MIT */
/*
 * Pages along a camera path. At each stop pictures follow each other until one misses nothing or nothing more finds
 * room. Counts are the same in every run; times are those of one flight.
 */
#include "bench/subjects.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench/child.h"
#include "measure/spread.h"
#include "support/picture.h"
#include "svocl/paged.h"

static const char table_id[] = "paged";

#define WIDTH        640u
#define HEIGHT       480u
#define STOPS        24u
#define STOPS_QUICK  6u
#define PICTURES_MAX 96u /* at a stop */
#define TIMES_MAX    ((size_t)STOPS * PICTURES_MAX)
#define PATH_BYTES   300

/* What there is room for, as a share of the file. */
static const unsigned shares[] = {16, 4, 1};
#define SHARE_COUNT (sizeof shares / sizeof shares[0])

static const char note[] =
    "A flight of 24 stops (6 with --quick) from afar to near and half around the scene, 640x480, shaded. Room: for "
    "buffers, as a share of the file, which has colors and normals; too little for its upper levels is left out. At a "
    "stop pictures follow each other until one misses nothing (the stop is complete) or nothing more finds room. "
    "Pictures: per stop, on average and at most. Misses, reads, evictions: of the flight; reads also as a multiple of "
    "the file. Picture, update: medians of wall clock. In core: svo_render of the whole tree at the same stops.";

typedef struct flight {
    suite *all;
    svo_tree *tree; /* on the device and the host */
    svo_tree_info info;
    char path[PATH_BYTES];
    unsigned stops;
    uint8_t *rgba;
    double core_ms; /* median of pictures in core */
} flight;

/* One flight with a budget. */
typedef struct flown {
    svo_paged_info info;
    svo_paged_counts counts;
    bool has_room; /* for the upper levels and a page */
    unsigned complete, most_pictures;
    double picture_ms[TIMES_MAX], update_ms[TIMES_MAX];
    size_t picture_count, update_count;
} flown;

static int fail_library(const flight *of)
{
    return program_fail_library(of->all->state, svo_device_message(of->all->opened.device));
}

static svo_render_options view_at(const flight *of, unsigned stop)
{
    svo_render_options asked = {.struct_size = sizeof asked, .width = WIDTH, .height = HEIGHT};
    svo_camera *camera = &asked.camera;
    const double along = (double)stop / (double)(of->stops - 1);
    const double turn = 3.1 * along;
    const double nearer = 1.6 - 1.3 * along;
    double from[3];
    (void)svo_camera_fit(svo_tree_target(of->tree), (float)WIDTH / (float)HEIGHT, camera);
    for (int axis = 0; axis < 3; ++axis) {
        from[axis] = nearer * ((double)camera->eye[axis] - (double)camera->target[axis]);
    }
    camera->eye[0] = (float)((double)camera->target[0] + from[0] * cos(turn) + from[2] * sin(turn));
    camera->eye[1] = (float)((double)camera->target[1] + from[1]);
    camera->eye[2] = (float)((double)camera->target[2] + from[2] * cos(turn) - from[0] * sin(turn));
    return asked;
}

/* ---- flights ---- */

static int stop_at(const flight *of, svo_paged *paged, unsigned stop, flown *out)
{
    const svo_render_options asked = view_at(of, stop);
    unsigned pictures = 0;
    do {
        const double started_ms = input_now_ms();
        if (svo_paged_render(paged, &asked, of->rgba) != SVO_OK) {
            return fail_library(of);
        }
        const double drawn_ms = input_now_ms();
        out->picture_ms[out->picture_count++] = drawn_ms - started_ms;
        (void)svo_paged_get_counts(paged, &out->counts);
        ++pictures;
        if (out->counts.missed_pages == 0) {
            ++out->complete;
            break;
        }
        if (svo_paged_update(paged) != SVO_OK) {
            return fail_library(of);
        }
        out->update_ms[out->update_count++] = input_now_ms() - drawn_ms;
        (void)svo_paged_get_counts(paged, &out->counts);
    } while (out->counts.read_pages > 0 && pictures < PICTURES_MAX);
    out->most_pictures = pictures > out->most_pictures ? pictures : out->most_pictures;
    return PROGRAM_DONE;
}

static int fly(const flight *of, uint64_t budget_bytes, flown *out)
{
    svo_paged *paged = NULL;
    int exit_code = PROGRAM_DONE;
    *out = (flown){.info = SVO_PAGED_INFO_INIT, .counts = SVO_PAGED_COUNTS_INIT};
    const svo_status status = svo_paged_open(of->all->opened.device, of->path, budget_bytes, NULL, &paged);
    if (status == SVO_CAPACITY_EXCEEDED) {
        return PROGRAM_DONE;
    }
    if (status != SVO_OK) {
        return fail_library(of);
    }
    out->has_room = true;
    (void)svo_paged_get_info(paged, &out->info);
    for (unsigned stop = 0; stop < of->stops && exit_code == PROGRAM_DONE; ++stop) {
        exit_code = stop_at(of, paged, stop, out);
    }
    svo_paged_close(&paged);
    return exit_code;
}

static int fly_in_core(flight *of)
{
    double ms[STOPS];
    for (unsigned stop = 0; stop < of->stops; ++stop) {
        const svo_render_options asked = view_at(of, stop);
        const double started_ms = input_now_ms();
        if (svo_render(svo_tree_target(of->tree), &asked, svo_in_host(of->rgba),
                       &(svo_submit){.queue = of->all->opened.queue}) != SVO_OK) {
            return fail_library(of);
        }
        ms[stop] = input_now_ms() - started_ms;
    }
    of->core_ms = spread_of(ms, of->stops).median;
    return PROGRAM_DONE;
}

/* ---- the table ---- */

static int begin(suite *all)
{
    result_table *table = result_add_table(all->results, table_id, "Paged trees along a camera path", note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "file", "B");
    result_add_column(table, "room", "");
    result_add_column(table, "buffers", "B");
    result_add_column(table, "pages", "");
    result_add_column(table, "held", "");
    result_add_column(table, "complete stops", "");
    result_add_column(table, "pictures", "");
    result_add_column(table, "most", "");
    result_add_column(table, "misses", "");
    result_add_column(table, "read", "B");
    result_add_column(table, "read ratio", "");
    result_add_column(table, "evicted", "");
    result_add_column(table, "picture", "ms");
    result_add_column(table, "update", "ms");
    result_add_column(table, "in core", "ms");
    return PROGRAM_DONE;
}

static void add_row(const flight *of, const input *source, unsigned share, flown *done)
{
    result_table *table = result_find(of->all->results, table_id);
    const svo_paged_counts *counts = &done->counts;
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, of->info.depth);
    result_add_number(table, (double)done->info.file_bytes);
    if (share > 1) {
        result_add_text(table, "1/%u", share);
    } else {
        result_add_text(table, "1");
    }
    result_add_number(table, (double)done->info.device_bytes);
    result_add_number(table, (double)done->info.page_count);
    result_add_number(table, (double)counts->held_pages);
    result_add_number(table, done->complete);
    result_add_number(table, (double)counts->pictures / of->stops);
    result_add_number(table, done->most_pictures);
    result_add_number(table, (double)counts->all_missed_pages);
    result_add_number(table, (double)counts->all_read_bytes);
    result_add_number(table, (double)counts->all_read_bytes / (double)done->info.file_bytes);
    result_add_number(table, (double)counts->all_evicted_pages);
    result_add_number(table, spread_of(done->picture_ms, done->picture_count).median);
    result_add_number(table, spread_of(done->update_ms, done->update_count).median);
    result_add_number(table, of->core_ms);
}

/* ---- the scene ---- */

static int build_tree(flight *of, const input *source, unsigned depth)
{
    const svo_plan_options wanted = {.struct_size = sizeof wanted, .need = picture_need(source, 0)};
    svo_device *device = of->all->opened.device;
    svo_plan *plan = NULL;
    svo_message message = {""};
    svo_status status = svo_plan_create(device, source->mesh, depth, &wanted, &plan);
    if (status == SVO_OK) {
        status = svo_build(plan, of->all->opened.cl, of->all->opened.queue, &of->tree, NULL);
    }
    svo_plan_destroy(&plan);
    if (status != SVO_OK || svo_tree_download(of->tree, of->all->opened.queue) != SVO_OK) {
        return fail_library(of);
    }
    of->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(of->tree, &of->info);
    return svo_tree_save(of->tree, svo_to_path(of->path), NULL, &message) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(of->all->state, message.text);
}

static int measure_file(const flight *of, uint64_t *file_bytes)
{
    svo_paged *paged = NULL;
    svo_paged_info info = SVO_PAGED_INFO_INIT;
    if (svo_paged_open(of->all->opened.device, of->path, UINT64_MAX, NULL, &paged) != SVO_OK) {
        return fail_library(of);
    }
    (void)svo_paged_get_info(paged, &info);
    svo_paged_close(&paged);
    *file_bytes = info.file_bytes;
    return PROGRAM_DONE;
}

static int fly_all(flight *of, const input *source)
{
    flown *done = malloc(sizeof *done);
    uint64_t file_bytes = 0;
    if (done == NULL) {
        return program_fail(of->all->state, PROGRAM_FAILED, "out of memory for the times of a flight");
    }
    int exit_code = measure_file(of, &file_bytes);
    exit_code = exit_code == PROGRAM_DONE ? fly_in_core(of) : exit_code;
    for (size_t i = SHARE_COUNT; i-- > 0 && exit_code == PROGRAM_DONE;) {
        exit_code = fly(of, file_bytes / shares[i], done);
        if (exit_code == PROGRAM_DONE && done->has_room) {
            add_row(of, source, shares[i], done);
        }
    }
    free(done);
    return exit_code;
}

static int run(suite *all, const input *source, unsigned depth)
{
    flight of = {.all = all, .stops = all->quick ? STOPS_QUICK : STOPS};
    child_cache folder = {""};
    if (!child_cache_create(&folder)) {
        return program_fail(all->state, PROGRAM_FAILED, "no folder for temporary files can be made");
    }
    (void)snprintf(of.path, sizeof of.path, "%s/tree.svo", folder.path);
    of.rgba = malloc((size_t)WIDTH * HEIGHT * 4);
    int exit_code = of.rgba != NULL ? build_tree(&of, source, depth)
                                    : program_fail(all->state, PROGRAM_FAILED, "out of memory for a picture");
    if (exit_code == PROGRAM_DONE) {
        exit_code = fly_all(&of, source);
    }
    svo_tree_destroy(&of.tree);
    free(of.rgba);
    child_cache_remove(&folder);
    return exit_code;
}

const suite_subject bench_paged = {
    .words = &subject_table[SUBJECT_PAGED],
    .full = {.scenes = {"atrium", "terrain"}, .depths = {10}},
    .quick = {.scenes = {"atrium"}, .depths = {8}},
    .begin = begin,
    .run = run,
};
