/* SPDX-License-Identifier: MIT */
/* Renders the frames of a scene that moves, as support/animation.h makes them. */
#include "svocl/render.h"

#include <string.h>

#include "support/animation.h"
#include "support/options_parse.h"
#include "support/picture.h"
#include "support/scene_file.h"
#include "support/session.h"
#include "support/table.h"

typedef struct animated_render {
    program *state;
    scene_file file;
    session session;
    animation film;
    svo_camera camera;
    picture_stream shown;
    cJSON *frames; /* for --json */
    double update_ms, build_ms; /* of all frames but the first */
} animated_render;

static int fail_library(const animated_render *work)
{
    return program_fail_library(work->state, svo_device_message(work->session.device));
}

/* ---- frames ---- */

static bool hash_of(const animated_render *work, svo_tree *tree, char hash[SVO_HASH_TEXT_BYTES])
{
    return svo_tree_download(tree, work->session.queue) == SVO_OK && svo_tree_hash(tree, SVO_HASH_ALL, hash) == SVO_OK;
}

/* Builds the frame's mesh anew and compares the hashes. */
static int verify(animated_render *work, uint64_t frame, const char *hash)
{
    char expected[SVO_HASH_TEXT_BYTES] = "";
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    svo_mesh mesh;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    if (svo_moving_get_mesh(work->film.moving, &mesh) != SVO_OK ||
        svo_moving_get_info(work->film.moving, &info) != SVO_OK) {
        return fail_library(work);
    }
    svo_plan_options pinned = {.struct_size = sizeof pinned,
                               .need = info.need,
                               .coverage = work->film.grid.coverage,
                               .weights = work->film.grid.weights,
                               .drop_alpha = work->film.grid.drop_alpha,
                               .edge = work->film.grid.edge,
                               .weight_log2 = info.weight_log2};
    memcpy(pinned.origin, work->film.grid.origin, sizeof pinned.origin);
    const double start_ms = input_now_ms();
    const bool built =
        svo_plan_create(work->session.device, &mesh, (unsigned)work->state->options.depth, &pinned, &plan) == SVO_OK &&
        svo_build(plan, work->session.cl, work->session.queue, &tree, NULL) == SVO_OK;
    work->build_ms += frame > 0 ? input_now_ms() - start_ms : 0.0;
    const int exit_code = built && hash_of(work, tree, expected) ? PROGRAM_DONE : fail_library(work);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return exit_code != PROGRAM_DONE || strcmp(hash, expected) == 0
               ? exit_code
               : program_fail(work->state, PROGRAM_FAILED, "frame %llu: hash %s, and %s of a full build",
                              (unsigned long long)frame, hash, expected);
}

static int draw(animated_render *work, const char *path)
{
    const options *given = &work->state->options;
    const svo_render_options view = {.struct_size = sizeof view,
                                     .width = given->width,
                                     .height = given->height,
                                     .camera = work->camera,
                                     .view = (svo_render_view)given->view,
                                     .output = picture_output(given)};
    return svo_render(svo_tree_target(animation_tree(&work->film)), &view, svo_in_host(work->shown.pixels),
                      &(svo_submit){.queue = work->session.queue}) == SVO_OK
               ? picture_add(&work->shown, path)
               : fail_library(work);
}

static void report_frame(animated_render *work, const char *path, const char *hash, const svo_moving_report *report)
{
    cJSON *entry = cJSON_CreateObject();
    json_add_text(entry, "file", path);
    json_add_text(entry, "hash", hash);
    json_add_count(entry, "fragments", report->fragments);
    json_add_count(entry, "changed_fragments", report->changed_fragments);
    cJSON_AddNumberToObject(entry, "update_ms", report->total_ms);
    cJSON_AddItemToArray(work->frames, entry);
}

static int show_frame(animated_render *work, uint64_t frame)
{
    char path[PICTURE_PATH_BYTES];
    char hash[SVO_HASH_TEXT_BYTES] = "";
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    const options *given = &work->state->options;
    int exit_code = animation_update(&work->film, frame, &report) == SVO_OK ? PROGRAM_DONE : fail_library(work);
    work->update_ms += frame > 0 ? report.total_ms : 0.0;
    if (exit_code == PROGRAM_DONE && !hash_of(work, animation_tree(&work->film), hash)) {
        exit_code = fail_library(work);
    }
    if (exit_code == PROGRAM_DONE && given->verify_frames != 0) {
        exit_code = verify(work, frame, hash);
    }
    if (exit_code == PROGRAM_DONE && frame == 0) {
        exit_code =
            animation_camera(&work->film, &work->file, (float)given->width / (float)given->height, &work->camera);
    }
    if (exit_code == PROGRAM_DONE) {
        picture_frame_path(given, frame, path);
        exit_code = draw(work, path);
    }
    if (exit_code == PROGRAM_DONE) {
        report_frame(work, path, hash, &report);
    }
    return exit_code;
}

static int show_frames(animated_render *work)
{
    int exit_code = picture_open(work->state, &work->shown);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    for (uint64_t frame = 0; frame < work->film.frame_count && exit_code == PROGRAM_DONE; ++frame) {
        exit_code = show_frame(work, frame);
    }
    return picture_close(&work->shown, exit_code);
}

/* ---- all of it ---- */

static int open_film(animated_render *work)
{
    program *state = work->state;
    int exit_code = scene_file_open(state, state->options.input, &work->file);
    if (exit_code == PROGRAM_DONE && work->file.motion_count == 0) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%s: no instance has a 'motion'", state->options.input);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    program_begin_progress(state, (unsigned)(work->file.tree_count + animation_frame_count(state)));
    exit_code = session_open(state, &work->session);
    if (exit_code == PROGRAM_DONE && work->session.cl == NULL) {
        exit_code = program_fail(state, PROGRAM_WRONG_USAGE, "--animate takes the front end cl");
    }
    return exit_code == PROGRAM_DONE
               ? animation_open(state, &work->file, work->session.device, work->session.queue, &work->film)
               : exit_code;
}

static void close_film(animated_render *work)
{
    animation_close(&work->film);
    session_close(&work->session);
    scene_file_close(&work->file);
    cJSON_Delete(work->frames);
}

static int report_film(animated_render *work)
{
    const options *given = &work->state->options;
    const double frames = work->film.frame_count > 1 ? (double)(work->film.frame_count - 1) : 1.0;
    if (given->json) {
        cJSON *document = json_document();
        json_add_text(document, "input", given->input);
        json_add_count(document, "width", given->width);
        json_add_count(document, "height", given->height);
        cJSON_AddBoolToObject(document, "verified", given->verify_frames != 0);
        cJSON_AddItemToObject(document, "frames", work->frames);
        work->frames = NULL;
        return json_print(work->state, document);
    }
    if (!given->quiet) {
        progress_hide(work->state->progress);
        table_line("%s: %llu frames of %ux%u pixels, %s an update", given->input,
                   (unsigned long long)work->film.frame_count, given->width, given->height,
                   figure_ms(work->update_ms / frames).text);
        if (given->verify_frames != 0) {
            table_line("each frame's hash is that of its full build, %s", figure_ms(work->build_ms / frames).text);
        }
    }
    return PROGRAM_DONE;
}

int render_animation_check(program *state)
{
    const options *given = &state->options;
    if (given->animate == 0) {
        return !options_is_given(given, "frames") && given->verify_frames == 0
                   ? PROGRAM_DONE
                   : program_fail(state, PROGRAM_WRONG_USAGE, "--frames and --verify require --animate");
    }
    if (!scene_file_is_input(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--animate takes a scene, a .json file");
    }
    return given->through == 0 && given->view < OPTION_VIEW_LIGHT &&
                   (given->given_groups & (unsigned)(OPTION_LIGHT | OPTION_PAGED)) == 0
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--animate takes no lights, cones, probes or pages");
}

int render_animation(program *state)
{
    animated_render work = {.state = state, .frames = cJSON_CreateArray()};
    int exit_code = open_film(&work);
    if (exit_code == PROGRAM_DONE) {
        exit_code = show_frames(&work);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report_film(&work);
    }
    close_film(&work);
    return exit_code;
}
