/* SPDX-License-Identifier: MIT */
/* The loop: events, the tree and its light, the picture, marks, panels, the window. */
#include "view/view.h"

#include <stdlib.h>

#include "support/cleanup.h"
#include "support/info_of.h"
#include "support/input.h"
#include "support/scene_file.h"
#include "view/camera.h"
#include "view/dialogs.h"
#include "view/edit.h"
#include "view/history.h"
#include "view/subject_memory.h"
#include "view/work.h"

/* While nothing changes, frames come this often: panels may still change, and so may what the driver has to say. */
#define IDLE_MS 100u
/* A frame that took longer, as after sleep, moves the camera as if it had taken this. */
#define STEP_SECONDS_MAX 0.25

/* Prints the last line of the log when the program ends. */
static void warn(const viewer *which)
{
    program_log(which->running, SVO_LOG_WARNING, view_log_line(&which->state, 0));
}

/* ---- time ---- */

/* In a script the clock stands still within a frame. */
static double now_ms(void *user)
{
    const viewer *which = user;
    return which->has_script ? (double)which->frame_number * SCRIPT_FRAME_SECONDS * 1e3 : input_now_ms();
}

/* Adds the time since the last call to a stage. */
static void lap(viewer *which, view_stage stage)
{
    const double now = now_ms(which);
    which->frame.stage_ms[stage] += (float)(now - which->lap_ms);
    which->lap_ms = now;
}

/* Returns the seconds since the last frame. */
static double begin_frame(viewer *which)
{
    const double last = which->frame_begin_ms;
    ++which->frame_number;
    which->frame_begin_ms = now_ms(which);
    which->lap_ms = which->frame_begin_ms;
    const double seconds = (which->frame_begin_ms - last) / 1e3;
    which->frame = (view_frame){.ms = (float)(seconds * 1e3)};
    which->state.seconds += seconds;
    return seconds > STEP_SECONDS_MAX ? STEP_SECONDS_MAX : seconds;
}

static void end_frame(viewer *which, bool is_new)
{
    view_state *state = &which->state;
    which->frame.rays = is_new ? which->drawing.rays : 0;
    which->frame.coarse = which->drawing.coarse;
    for (int i = 0; i < VIEW_STAGES; ++i) {
        which->frame.work_ms += which->frame.stage_ms[i];
    }
    if (is_new || !state->is_idle) { /* the others would push those out */
        state->frames[state->frame_count++ % VIEW_FRAMES_KEPT] = which->frame;
    }
}

/* ---- events ---- */

static int take_event(viewer *which, const view_event *event)
{
    view_state *state = &which->state;
    const bool closes_box = event->kind == VIEW_EVENT_KEY && event->is_down && event->key == VIEW_KEY_ESCAPE &&
                            (state->open.is_shown || state->notice[0] != '\0');
    if (event->kind == VIEW_EVENT_BUTTON && event->button >= 0 && event->button < 3) {
        which->held[event->button] = event->is_down;
    }
    if (event->is_down) {
        history_settle(state);
    }
    if (question_take(state, event) || (overlay_take(which->overlay, event) && !closes_box)) {
        state->brush.mouse[0] = -1; /* over no picture */
        return PROGRAM_DONE;
    }
    switch (input_take(&which->mouse, event, state)) {
    case INPUT_PICK:
        return pick_at(which->subject, state, which->mouse.x, which->mouse.y);
    case INPUT_FULLSCREEN:
        state->settings.fullscreen = !state->settings.fullscreen;
        return PROGRAM_DONE;
    case INPUT_NOTHING:
        break;
    }
    return PROGRAM_DONE;
}

/* The brush as a script has it. */
static void take_brush(view_state *state, const script_brush *asked)
{
    state->brush.tool = asked->tool;
    state->brush.shape = asked->shape;
    view_choose_brush_radius(state, asked->radius);
    for (int channel = 0; channel < 3 && asked->has_color; ++channel) {
        state->brush.color[channel] = (float)asked->color[channel] / 255;
    }
    state->brush.material = asked->has_color ? asked->material : state->brush.material;
    if (!state->brush.is_on) {
        view_choose_brush(state, true);
    }
}

/* The script's step of this frame, as far as it comes before the picture. */
static int play(viewer *which)
{
    which->step = script_next(&which->script, &which->state);
    if (which->step.is_loading) {
        return program_fail(which->running, PROGRAM_FAILED, "%s:%u: nothing is being loaded",
                            which->running->options.script_path, which->step.line);
    }
    switch (which->step.kind) {
    case SCRIPT_EVENT:
        return window_push(which->window, &which->step.event)
                   ? PROGRAM_DONE
                   : program_fail(which->running, PROGRAM_FAILED, "an event of the script was refused");
    case SCRIPT_COARSE:
        which->state.settings.coarse = which->step.count;
        return PROGRAM_DONE;
    case SCRIPT_BRUSH:
        take_brush(&which->state, &which->step.brush);
        return PROGRAM_DONE;
    case SCRIPT_END:
        which->state.is_done = true;
        return PROGRAM_DONE;
    case SCRIPT_WAIT:
    case SCRIPT_REFINE:
    case SCRIPT_SHOT:
        break;
    }
    return PROGRAM_DONE;
}

/* Whether the window shows all there is to show until something happens. */
static bool is_idle(const viewer *which)
{
    return !which->has_script && which->lively_frames == 0 && which->state.is_refined &&
           !which->state.film.is_playing && !camera_is_moving(&which->state);
}

static int take_events(viewer *which)
{
    view_event event;
    int exit_code = which->has_script ? play(which) : PROGRAM_DONE;
    which->state.is_idle = is_idle(which);
    if (which->state.is_idle) {
        window_wait(which->window, IDLE_MS);
        which->lap_ms = now_ms(which);
    }
    which->lively_frames -= which->lively_frames > 0 ? 1 : 0;
    while (exit_code == PROGRAM_DONE && window_poll(which->window, &event)) {
        which->lively_frames = LIVELY_FRAMES;
        exit_code = take_event(which, &event);
    }
    if (which->is_fullscreen != which->state.settings.fullscreen) {
        which->is_fullscreen = which->state.settings.fullscreen;
        window_set_fullscreen(which->window, which->is_fullscreen);
    }
    window_size(which->window, &which->state.width, &which->state.height);
    return exit_code;
}

/* ---- scale ---- */

/* Panels for the window's scale. */
static int make_overlay(viewer *which)
{
    const ui_clipboard clipboard = {window_read_clipboard, window_write_clipboard, which->window};
    overlay_destroy(&which->overlay);
    which->overlay = overlay_create(window_gl(which->window), which->state.scale, &clipboard, &which->why);
    return which->overlay != NULL ? PROGRAM_DONE : viewer_fail(which);
}

/* That of --scale, else of the display that the window is on; a script shows the same on all. */
static float scale_of(const viewer *which)
{
    const double given = which->first.scale;
    return given > 0 ? (float)given : which->has_script ? 1 : window_scale(which->window);
}

static int follow_scale(viewer *which)
{
    const float scale = scale_of(which);
    if (!(scale < which->state.scale || scale > which->state.scale)) {
        return PROGRAM_DONE;
    }
    which->state.scale = scale;
    return make_overlay(which);
}

/* ---- a frame ---- */

/* Once for each tree, its BVH, light and scene: plans take time. What moves is followed where it is looked at. */
static int list_memory(viewer *which)
{
    const subject *shown = which->subject;
    const view_state *state = &which->state;
    const uint64_t ray_bytes = shown->has_tree ? info_of_tree(shown->done.result.tree).ray_bytes : 0;
    const uint64_t brush_bytes = shown->brush.mirrored.device_bytes;
    const uint64_t frames = state->settings.open[VIEW_PANEL_MEMORY] ? state->revisions.film : 0;
    const uint64_t changes =
        1 + shown->changes + placed_changes(shown->placed) + ray_bytes + shown->probes.version + frames + brush_bytes;
    if (which->listed == changes) {
        return PROGRAM_DONE;
    }
    which->listed = changes;
    return subject_list_memory(shown, &which->state);
}

static int update_job(void *user)
{
    viewer *which = user;
    cleanup_take();
    return subject_update(which->subject, &which->state);
}

/* A window that was closed meanwhile needs no picture. */
static int update_subject(viewer *which)
{
    const int exit_code = work_run(which, which->state.input, false, update_job, which);
    return which->work.is_closed || (exit_code == PROGRAM_DONE && which->work.exit_code == PROGRAM_DONE)
               ? PROGRAM_DONE
               : work_fail(which, exit_code);
}

/* Makes what the state asks for. is_new: whether there is a new picture. */
static int update(viewer *which, bool *is_new)
{
    view_state *state = &which->state;
    const drawing_clock clock = {now_ms, which};
    int exit_code = opening_take(which);
    exit_code = exit_code == PROGRAM_DONE && !which->work.is_closed ? saving_take(which) : exit_code;
    exit_code = exit_code == PROGRAM_DONE && !which->work.is_closed ? update_subject(which) : exit_code;
    history_look(state, which->held[0] || which->held[1] || which->held[2] || overlay_types(which->overlay));
    if (exit_code == PROGRAM_DONE && !which->work.is_closed) {
        subject_box(which->subject, state);
    }
    lap(which, VIEW_STAGE_TREE);
    if (exit_code == PROGRAM_DONE && !window_use(which->window, &which->why)) {
        exit_code = viewer_fail(which);
    }
    if (exit_code != PROGRAM_DONE || which->work.is_closed) {
        return exit_code;
    }
    exit_code = drawing_next(&which->drawing, which->subject, state, &clock, is_new);
    exit_code = exit_code == PROGRAM_DONE ? ground_update(&which->ground, which->subject, state) : exit_code;
    lap(which, VIEW_STAGE_PICTURE);
    return exit_code == PROGRAM_DONE ? list_memory(which) : exit_code;
}

/* Brings the rows that were drawn last into the window's picture. */
static bool take_rows(viewer *which)
{
    const drawing *drawn = &which->drawing;
    const canvas_rows rows = {.buffer = drawn->pixels.info.name,
                              .offset_bytes = drawn->pixels.info.offset_bytes,
                              .width = drawn->width,
                              .height = drawn->height,
                              .first_row = drawn->rows_done - drawn->row_count,
                              .row_count = drawn->row_count};
    return (!drawn->is_enlarged || canvas_enlarge(which->canvas, drawn->width, drawn->height, &which->why)) &&
           canvas_take_rows(which->canvas, &rows, &which->why);
}

static int draw(viewer *which, double seconds, bool is_new)
{
    view_state *state = &which->state;
    const probe_map *map = &which->subject->probes.map;
    if (is_new && !take_rows(which)) {
        return viewer_fail(which);
    }
    if (map->is_new && !canvas_take_map(which->canvas, map->rgba, map->edge, &which->why)) {
        return viewer_fail(which);
    }
    state->probes.texture = canvas_map(which->canvas);
    lap(which, VIEW_STAGE_UPLOAD);
    marks_make(&which->marks, state);
    if (which->marks.failed) {
        return program_fail(which->running, PROGRAM_FAILED, "out of memory for marks");
    }
    if (!canvas_draw(which->canvas, state->width, state->height, which->marks.vertices, which->marks.count,
                     &which->why)) {
        return viewer_fail(which);
    }
    lap(which, VIEW_STAGE_SHOW);
    shots_save(which, VIEW_SHOT_PICTURE);
    if (!overlay_draw(which->overlay, state, (float)seconds, &which->why)) {
        return viewer_fail(which);
    }
    lap(which, VIEW_STAGE_PANELS);
    shots_save(which, VIEW_SHOT_WINDOW);
    return PROGRAM_DONE;
}

/* Puts what was drawn into the window; waiting for the screen is no work. */
static int show_frame(viewer *which)
{
    if (!canvas_show(which->canvas, &which->why)) {
        return viewer_fail(which);
    }
    window_finish(which->window);
    lap(which, VIEW_STAGE_SHOW);
    return window_show(which->window, &which->why) ? PROGRAM_DONE : viewer_fail(which);
}

/* The window's title has a star while there is something to save. */
static void write_title(viewer *which)
{
    char title[2 * VIEW_PATH_BYTES];
    if (which->is_marked != view_is_unsaved(&which->state)) {
        which->is_marked = !which->is_marked;
        (void)snprintf(title, sizeof title, "%s%s - svocl", which->is_marked ? "*" : "", which->state.input);
        window_set_title(which->window, title);
    }
}

static int run_frame(viewer *which)
{
    bool is_new = false;
    const double seconds = begin_frame(which);
    int exit_code = take_events(which);
    exit_code = exit_code == PROGRAM_DONE ? follow_scale(which) : exit_code;
    if (exit_code != PROGRAM_DONE || which->state.is_done) {
        return exit_code;
    }
    camera_move(&which->state, (float)seconds);
    play_advance(&which->state, seconds);
    write_title(which);
    lap(which, VIEW_STAGE_EVENTS);
    exit_code = update(which, &is_new);
    if (exit_code != PROGRAM_DONE || which->work.is_closed) {
        return exit_code;
    }
    exit_code = draw(which, seconds, is_new);
    if (exit_code == PROGRAM_DONE && which->has_script && which->step.kind == SCRIPT_SHOT) {
        exit_code = shots_take(which, which->step.path, which->state.width, which->state.height);
    }
    exit_code = exit_code == PROGRAM_DONE ? show_frame(which) : exit_code;
    end_frame(which, is_new);
    return exit_code;
}

/* ---- beginning and end ---- */

static view_picture picture_of_option(int view)
{
    static const view_picture by_light[] = {VIEW_AO, VIEW_DIRECT, VIEW_GI, VIEW_SPECULAR, VIEW_FULL};
    return view >= OPTION_VIEW_LIGHT ? by_light[view - OPTION_VIEW_LIGHT] : (view_picture)view;
}

/* What the command line says of the picture. */
static void take_picture_options(viewer *which)
{
    const options *given = &which->running->options;
    view_shown *shown = &which->state.shown;
    shown->gi = given->gi != 0;
    shown->photons = given->photons != 0;
    shown->form = (svo_light_form)given->light_form;
    shown->cones = given->cones > 0 ? (unsigned)given->cones : shown->cones;
    shown->falloff = (float)given->falloff;
    if (given->exposure > 0) {
        view_choose_exposure(&which->state, (float)given->exposure);
    }
    if (given->through != 0) {
        view_choose_through(&which->state, true);
    }
    view_choose_picture(&which->state, picture_of_option(given->view));
}

static int run_frames(viewer *which)
{
    int exit_code = window_use(which->window, &which->why) ? PROGRAM_DONE : viewer_fail(which);
    which->frame_begin_ms = now_ms(which);
    while (exit_code == PROGRAM_DONE && !which->state.is_done) {
        exit_code = run_frame(which);
    }
    return exit_code;
}

static int show(viewer *which)
{
    int exit_code = opening_input(which);
    if (exit_code == PROGRAM_DONE && !which->state.is_done) {
        take_picture_options(which);
        exit_code = run_frames(which);
    }
    window_hide(which->window);
    marks_end(&which->marks);
    opening_close(which);
    return exit_code;
}

/* The window comes before the tree: without a display nothing is built. */
static int open_window(viewer *which)
{
    view_state *state = &which->state;
    const window_place place = {.width = state->settings.width,
                                .height = state->settings.height,
                                .grows = which->first.window_width == 0 && which->first.window_height == 0,
                                .fullscreen = state->settings.fullscreen};
    char title[VIEW_PATH_BYTES];
    (void)snprintf(title, sizeof title, "%s - svocl", state->input);
    which->window = window_open(title, &place, &which->why);
    if (which->window == NULL) {
        return viewer_fail(which);
    }
    which->is_fullscreen = state->settings.fullscreen;
    window_size(which->window, &state->width, &state->height);
    state->renderer = window_renderer(which->window);
    state->scale = scale_of(which);
    which->canvas = canvas_create(window_gl(which->window), &which->why);
    return which->canvas != NULL ? make_overlay(which) : viewer_fail(which);
}

/* What the command line says of the window goes before the settings. */
static void take_options(viewer *which)
{
    const options *given = &which->running->options;
    view_settings *settings = &which->state.settings;
    settings->width = given->window_width > 0 ? (unsigned)given->window_width : settings->width;
    settings->height = given->window_height > 0 ? (unsigned)given->window_height : settings->height;
    settings->fullscreen = settings->fullscreen || given->fullscreen != 0;
    which->state.input = given->input;
    which->first = *given;
    which->state.files = &which->running->files;
}

static int run(viewer *which)
{
    int exit_code = open_window(which);
    exit_code = exit_code == PROGRAM_DONE ? work_begin(which) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? show(which) : exit_code;
    work_end(which);
    overlay_destroy(&which->overlay);
    canvas_destroy(&which->canvas);
    window_close(&which->window);
    if (exit_code == PROGRAM_DONE && !which->has_script && !settings_save(&which->settings, &which->state)) {
        warn(which);
    }
    return exit_code;
}

/* What the command line asks for and INPUT cannot have: light by cones is of trees. */
static int check_options(program *running)
{
    const options *given = &running->options;
    const bool is_scene = scene_file_is_input(running);
    const bool has_cones = given->view >= OPTION_VIEW_LIGHT || (given->given_groups & (unsigned)OPTION_LIGHT) != 0;
    if (given->frames != 0 && !is_scene) {
        return program_fail(running, PROGRAM_WRONG_USAGE, "--frames takes a scene with motions, a .json file, not %s",
                            given->input);
    }
    if (given->tree_form != 0 && !is_scene) {
        return program_fail(running, PROGRAM_WRONG_USAGE,
                            "--tree-form takes a scene, a .json file: %s is shown as a built tree, which light needs",
                            given->input);
    }
    return is_scene && has_cones
               ? program_fail(running, PROGRAM_WRONG_USAGE,
                              "options of lights and cones, and their views, do not apply to the scene %s",
                              given->input)
               : PROGRAM_DONE;
}

/* A script neither reads nor writes settings: it shows the same for everybody. */
static int begin(viewer *which)
{
    const char *path = which->running->options.script_path;
    which->has_script = path != NULL;
    if (path != NULL) {
        return script_open(which->running, path, &which->script);
    }
    settings_find(&which->settings);
    if (!settings_load(&which->settings, &which->state)) {
        warn(which);
    }
    return PROGRAM_DONE;
}

int view_run(program *running)
{
    viewer *which = calloc(1, sizeof *which);
    if (which == NULL) {
        return program_fail(running, PROGRAM_FAILED, "out of memory");
    }
    which->running = running;
    view_state_begin(&which->state);
    int exit_code = check_options(running);
    exit_code = exit_code == PROGRAM_DONE ? begin(which) : exit_code;
    if (exit_code == PROGRAM_DONE) {
        take_options(which);
        exit_code = run(which);
    }
    script_close(&which->script);
    view_state_end(&which->state);
    free(which->opened_path);
    free(which);
    return exit_code;
}
