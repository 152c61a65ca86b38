/* SPDX-License-Identifier: MIT */
/* The camera of svocl view against closed forms, its keys and mouse, and its file of settings. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/suite.h"
#include "support/work_folder.h"
#include "view/camera.h"
#include "view/dialogs.h"
#include "view/edit.h"
#include "view/files.h"
#include "view/input.h"
#include "view/panels.h"
#include "view/worker.h"

#define PI 3.14159265358979323846

/* Looks along -z at a target 10 away, 640 x 400 pixels. */
static view_state *make_state(void)
{
    view_state *state = malloc(sizeof *state);
    assert_non_null(state);
    view_state_begin(state);
    state->width = 640;
    state->height = 400;
    state->level_min = 1;
    state->level_max = 8;
    state->shown.level = 8;
    state->has_triangles = true;
    state->camera.speed = 2;
    state->camera.at = (svo_camera){{1, 2, 13}, {1, 2, 3}, {0, 1, 0}, 0.8F};
    state->camera.home = state->camera.at;
    return state;
}

static void free_state(view_state *state)
{
    view_state_end(state);
    free(state);
}

static double distance(const float a[3], const float b[3])
{
    return sqrt(pow((double)a[0] - (double)b[0], 2) + pow((double)a[1] - (double)b[1], 2) +
                pow((double)a[2] - (double)b[2], 2));
}

static void expect_point(const float point[3], double x, double y, double z)
{
    const float wanted[3] = {(float)x, (float)y, (float)z};
    if (!(distance(point, wanted) < 1e-4)) {
        fail_msg("%g %g %g instead of %g %g %g", (double)point[0], (double)point[1], (double)point[2], x, y, z);
    }
}

/* ---- camera ---- */

/* A drag to the right by a quarter turn brings the scene's left side to the front: the eye is at -x of the target. */
static void orbit_turns_the_eye_around_the_target(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    const svo_camera first = state->camera.at;
    const float quarter = (float)(PI / 2 * 640 / (double)state->settings.turn_speed);
    camera_turn(state, quarter, 0);
    expect_point(state->camera.at.eye, -9, 2, 3);
    expect_point(state->camera.at.target, 1, 2, 3);
    for (int i = 0; i < 3; ++i) {
        camera_turn(state, quarter, 0);
    }
    expect_point(state->camera.at.eye, (double)first.eye[0], (double)first.eye[1], (double)first.eye[2]);
    camera_turn(state, 0, quarter / 2);
    expect_point(state->camera.at.eye, 1, 2 + 10 * sqrt(0.5), 3 + 10 * sqrt(0.5));
    free_state(state);
}

static void flying_turns_the_line_of_sight(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    state->camera.mode = VIEW_FLY;
    camera_turn(state, (float)(PI / 2 * 640 / (double)state->settings.turn_speed), 0);
    expect_point(state->camera.at.eye, 1, 2, 13);
    expect_point(state->camera.at.target, 11, 2, 13);
    free_state(state);
}

/* However far a drag goes, the line of sight stays off the vertical, and the distance of the target is kept. */
static void no_drag_passes_the_poles(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    for (int mode = 0; mode < 2; ++mode) {
        state->camera.mode = (view_camera_mode)mode;
        for (int i = 0; i < 2000; ++i) {
            camera_turn(state, (float)(i % 37) - 11, (float)(i % 1000 < 500 ? 97 : -89));
            const svo_camera *at = &state->camera.at;
            const double flat =
                hypot((double)at->eye[0] - (double)at->target[0], (double)at->eye[2] - (double)at->target[2]);
            const double away = distance(at->eye, at->target);
            if (!(flat > 0.019 * away) || !(fabs(away - 10) < 0.01)) {
                fail_msg("drag %d of mode %d: %g away, %g of it flat", i, mode, away, flat);
                return;
            }
        }
    }
    free_state(state);
}

static void speed_does_not_depend_on_the_frames(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    state->camera.held[VIEW_FORWARD] = true;
    state->camera.held[VIEW_UP] = true;
    camera_move(state, 1);
    expect_point(state->camera.at.eye, 1, 4, 11);
    camera_go_home(state);
    for (int i = 0; i < 240; ++i) {
        camera_move(state, 1.0F / 240);
    }
    expect_point(state->camera.at.eye, 1, 4, 11);
    expect_point(state->camera.at.target, 1, 4, 1);
    free_state(state);
}

/* The target stays below the mouse, and so does every point of its plane. */
static void panning_keeps_the_target_below_the_mouse(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    const float target[3] = {1, 2, 3};
    float pixel[2];
    camera_turn(state, 50, 30);
    camera_pan(state, 33, -21);
    assert_true(camera_project(state, target, pixel));
    assert_true(fabsf(pixel[0] - 353) < 0.01F);
    assert_true(fabsf(pixel[1] - 179) < 0.01F);
    free_state(state);
}

/* A point along the ray of a pixel is at that pixel; one behind the eye is nowhere. */
static void rays_and_pixels_agree(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    camera_turn(state, -70, 40);
    for (int i = 0; i < 400; ++i) {
        const float x = (float)(i * 37 % 640) + 0.5F;
        const float y = (float)(i * 53 % 400) + 0.5F;
        float direction[3];
        float ahead[3];
        float behind[3];
        float pixel[2];
        camera_ray(state, x, y, direction);
        for (int axis = 0; axis < 3; ++axis) {
            ahead[axis] = state->camera.at.eye[axis] + 7 * direction[axis];
            behind[axis] = state->camera.at.eye[axis] - 7 * direction[axis];
        }
        assert_true(camera_project(state, ahead, pixel));
        if (!(fabsf(pixel[0] - x) < 0.01F && fabsf(pixel[1] - y) < 0.01F)) {
            fail_msg("%g %g instead of %g %g", (double)pixel[0], (double)pixel[1], (double)x, (double)y);
            return;
        }
        assert_false(camera_project(state, behind, pixel));
    }
    free_state(state);
}

/* ---- keys and the mouse ---- */

static input_wish press(view_state *state, int key, bool shift)
{
    static input_mouse mouse;
    const view_event event = {.kind = VIEW_EVENT_KEY, .key = key, .is_down = true, .shift = shift};
    return input_take(&mouse, &event, state);
}

static void keys_choose_what_is_shown(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    for (int i = 0; i < 10; ++i) {
        press(state, i == 9 ? '0' : '1' + i, false);
        assert_int_equal(state->shown.picture, i);
    }
    press(state, 'l', false);
    assert_int_equal(state->shown.level, 7);
    press(state, 'l', true);
    press(state, 'l', true);
    assert_int_equal(state->shown.level, 8);
    state->level_min = 8; /* a finished tree */
    press(state, 'l', false);
    assert_int_equal(state->shown.level, 8);
    press(state, 'g', false);
    press(state, 'p', false);
    press(state, 'b', false);
    assert_false(state->shown.gi);
    assert_false(state->shown.photons);
    assert_int_equal(state->shown.form, SVO_LIGHT_BRICKS);
    state->has_triangles = false;
    const size_t lines = state->log_count;
    press(state, '6', false);
    assert_int_equal(state->shown.picture, VIEW_FULL);
    assert_int_equal(state->log_count, lines + 1);
    assert_int_equal(press(state, VIEW_KEY_F1 + 10, false), INPUT_FULLSCREEN);
    free_state(state);
}

static void send(input_mouse *mouse, view_state *state, view_event event)
{
    assert_int_equal(input_take(mouse, &event, state), INPUT_NOTHING);
}

/* Drags draw, but for those with Shift and those from beside the tree, and more places than a frame has are the last
   one. */
static void drags_are_strokes(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    input_mouse mouse = {.x = 0};
    const view_event down = {.kind = VIEW_EVENT_BUTTON, .is_down = true, .x = 10, .y = 20};
    const view_event up = {.kind = VIEW_EVENT_BUTTON, .x = 10, .y = 20};
    press(state, 'u', false);
    assert_true(state->brush.is_on);
    press(state, 'q', false);
    press(state, 'q', true);
    press(state, ']', false);
    assert_int_equal(state->brush.tool, VIEW_BRUSH_CLEAR);
    assert_int_equal(state->brush.shape, VIEW_BRUSH_BOX);
    assert_float_equal(state->brush.radius, 4.5, 0);
    view_choose_brush_radius(state, NAN);
    assert_float_equal(state->brush.radius, 0, 0);
    const svo_camera before = state->camera.at;
    send(&mouse, state, down);
    assert_true(state->brush.is_down && state->brush.begins);
    for (int i = 0; i < 2 * VIEW_BRUSH_PLACES; ++i) {
        send(&mouse, state, (view_event){.kind = VIEW_EVENT_MOVE, .x = 20 + i, .y = 30});
    }
    assert_memory_equal(&before, &state->camera.at, sizeof before);
    assert_int_equal(state->brush.place_count, VIEW_BRUSH_PLACES);
    assert_float_equal(state->brush.places[0][0], 10.5, 0);
    assert_float_equal(state->brush.places[VIEW_BRUSH_PLACES - 1][0], 19.5 + 2 * VIEW_BRUSH_PLACES, 0);
    state->brush.is_beside = true;
    send(&mouse, state, (view_event){.kind = VIEW_EVENT_MOVE, .x = 90, .y = 30});
    assert_memory_not_equal(&before, &state->camera.at, sizeof before);
    send(&mouse, state, up);
    assert_false(state->brush.is_down || state->brush.takes);
    view_event shifted = down;
    shifted.shift = true;
    send(&mouse, state, shifted);
    assert_false(state->brush.is_down);
    shifted = up;
    shifted.shift = true;
    send(&mouse, state, shifted);
    assert_true(state->brush.takes);
    press(state, 'u', false);
    state->is_scene = true;
    press(state, 'u', false);
    assert_false(state->brush.is_on);
    free_state(state);
}

static void press_control(view_state *state, int key)
{
    input_mouse mouse = {.x = 0};
    const view_event event = {.kind = VIEW_EVENT_KEY, .key = key, .is_down = true, .control = true};
    assert_int_equal(input_take(&mouse, &event, state), INPUT_NOTHING);
}

/* Probes have four views, and no light of a scene. */
static void keys_look_through_probes(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    press(state, '0', false);
    press(state, 't', false);
    assert_true(state->shown.through);
    assert_int_equal(state->shown.picture, VIEW_SHADED);
    press(state, '3', false);
    press(state, '9', false); /* refused */
    assert_int_equal(state->shown.picture, VIEW_DEPTH);
    press(state, 't', false);
    press(state, '9', false);
    assert_int_equal(state->shown.picture, VIEW_GI);
    assert_false(view_shows_probes(state));
    press(state, 'o', false);
    press(state, 'm', false);
    assert_true(view_shows_probes(state));
    state->probes.made.probe_count = 3;
    press(state, '.', false);
    press(state, '.', false);
    press(state, '.', false);
    assert_int_equal(state->probes.chosen, 2);
    press(state, ',', false);
    assert_int_equal(state->probes.chosen, 1);
    state->is_scene = true;
    press(state, 't', false);
    press(state, '1', false); /* refused */
    assert_int_equal(state->shown.picture, VIEW_NORMAL);
    view_hide_probes(state);
    assert_int_equal(state->shown.picture, VIEW_SHADED);
    assert_false(view_shows_probes(state));
    press(state, VIEW_KEY_F12, false);
    assert_true(state->settings.open[VIEW_PANEL_PROBES]);
    free_state(state);
}

/* A sphere is found where its center is seen; of two that cover each other, the nearer one. */
static void clicks_find_spheres(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    svo_probe places[3] = {{.state = SVO_PROBE_IN_PLACE}, {.state = SVO_PROBE_IN_PLACE}, {.state = SVO_PROBE_OFF}};
    const svo_camera *at = &state->camera.at;
    uint32_t index = 9;
    float pixel[2];
    for (int axis = 0; axis < 3; ++axis) {
        places[0].position[axis] = at->target[axis];
        places[1].position[axis] = 0.5F * (at->eye[axis] + at->target[axis]);
        places[2].position[axis] = at->target[axis] + (axis == 1 ? 1.0F : 0.0F);
    }
    state->probes.places = places;
    state->probes.made.probe_count = 3;
    for (int axis = 0; axis < 3; ++axis) {
        state->probes.made.step[axis] = 2;
    }
    assert_true(camera_project(state, places[2].position, pixel));
    assert_false(probe_sphere_at(state, pixel[0], pixel[1], &index));
    state->probes.has_spheres = true;
    assert_true(probe_sphere_at(state, pixel[0], pixel[1], &index));
    assert_int_equal(index, 2);
    assert_true(probe_sphere_at(state, (float)state->width / 2, (float)state->height / 2, &index));
    assert_int_equal(index, 1);
    assert_false(probe_sphere_at(state, 1, 1, &index));
    free_state(state);
}

static input_wish button(input_mouse *mouse, view_state *state, bool is_down, int x, int y)
{
    const view_event event = {
        .kind = VIEW_EVENT_BUTTON, .button = VIEW_BUTTON_LEFT, .is_down = is_down, .x = x, .y = y};
    return input_take(mouse, &event, state);
}

/* A click picks, even if the hand trembles; a drag turns and does not pick. */
static void clicks_pick_and_drags_turn(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    input_mouse mouse = {.x = 0};
    const view_event tremble = {.kind = VIEW_EVENT_MOVE, .x = 102, .y = 99};
    const view_event drag = {.kind = VIEW_EVENT_MOVE, .x = 140, .y = 90};
    assert_int_equal(button(&mouse, state, true, 100, 100), INPUT_NOTHING);
    assert_int_equal(input_take(&mouse, &tremble, state), INPUT_NOTHING);
    assert_int_equal(button(&mouse, state, false, 102, 99), INPUT_PICK);
    expect_point(state->camera.at.eye, 1, 2, 13);
    assert_int_equal(button(&mouse, state, true, 100, 100), INPUT_NOTHING);
    assert_int_equal(input_take(&mouse, &drag, state), INPUT_NOTHING);
    assert_int_equal(button(&mouse, state, false, 140, 90), INPUT_NOTHING);
    assert_true(distance(state->camera.at.eye, state->camera.home.eye) > 0.1);
    assert_int_equal(button(&mouse, state, false, 140, 90), INPUT_NOTHING);
    free_state(state);
}

/* ---- work ---- */

/* A job that asks, says how far it is, and goes on until it is to end. */
typedef struct long_job {
    worker *thread;
    unsigned answers;
    bool is_seen;
} long_job;

static void answer(void *user)
{
    long_job *of = user;
    ++of->answers;
}

static int work_until_canceled(void *user)
{
    long_job *of = user;
    const progress_view now = {.what = "working", .stage = "half", .step = 1, .step_count = 2, .part = 0.5};
    worker_ask(of->thread, answer, of);
    worker_see(of->thread, &now);
    worker_ask(of->thread, answer, of);
    while (!worker_stops(of->thread)) {
        (void)sched_yield();
    }
    return 7;
}

static int end_at_once(void *user)
{
    long_job *of = user;
    return worker_stops(of->thread) ? 1 : 0;
}

static void jobs_ask_and_are_canceled(void **unused)
{
    (void)unused;
    long_job of = {.thread = worker_create()};
    assert_non_null(of.thread);
    assert_int_equal(worker_wait(of.thread, 0), WORKER_DONE);
    worker_begin(of.thread, work_until_canceled, &of);
    for (unsigned i = 1; i <= 2; ++i) {
        assert_int_equal(worker_wait(of.thread, WORKER_FOREVER), WORKER_ASKS);
        assert_int_equal(of.answers, i - 1);
        worker_answer(of.thread);
    }
    assert_int_equal(of.answers, 2);
    const progress_view now = worker_progress(of.thread);
    assert_string_equal(now.stage, "half");
    assert_int_equal(now.step, 1);
    assert_int_equal(worker_wait(of.thread, 1), WORKER_BUSY);
    worker_cancel(of.thread);
    assert_int_equal(worker_wait(of.thread, WORKER_FOREVER), WORKER_DONE);
    assert_int_equal(worker_exit_code(of.thread), 7);
    worker_begin(of.thread, end_at_once, &of); /* the next one is not canceled */
    assert_int_equal(worker_wait(of.thread, WORKER_FOREVER), WORKER_DONE);
    assert_int_equal(worker_exit_code(of.thread), 0);
    worker_destroy(&of.thread);
}

/* ---- files ---- */

static void make_file(const char *name)
{
    FILE *file = fopen(path_of(name), "wb");
    assert_non_null(file);
    assert_int_equal(fclose(file), 0);
    work_folder_remember(name);
}

static void type(view_state *state, const char *begin)
{
    (void)snprintf(state->open.path, sizeof state->open.path, "%s", path_of(begin));
}

static void paths_are_completed(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    make_file("model-a.obj");
    make_file("model-b.obj");
    make_file("Other.ply");
    make_file(".hidden.obj");
    state->input = path_of("model-a.obj");
    press_control(state, 'o');
    assert_true(state->open.is_shown);
    assert_int_equal(state->open.name_count, 3);
    type(state, "m");
    open_dialog_complete(state);
    assert_string_equal(state->open.path, path_of("model-"));
    assert_int_equal(state->open.name_count, 2);
    open_dialog_choose(state, 1); /* from none to the first one */
    open_dialog_choose(state, 1);
    open_dialog_choose(state, -1);
    open_dialog_accept(state);
    assert_true(state->wants_open);
    assert_false(state->open.is_shown);
    assert_string_equal(state->open_path, path_of("model-a.obj"));
    open_dialog_show(state);
    type(state, "oth"); /* whatever the case */
    open_dialog_complete(state);
    assert_string_equal(state->open.path, path_of("Other.ply"));
    type(state, "nothing");
    open_dialog_complete(state);
    assert_string_equal(state->open.path, path_of("nothing"));
    type(state, ".h");
    open_dialog_complete(state);
    assert_string_equal(state->open.path, path_of(".hidden.obj"));
    press(state, VIEW_KEY_ESCAPE, false);
    assert_false(state->open.is_shown);
    free_state(state);
}

/* What belongs to one model ends with it; the window, its settings and its log stay. */
static void another_model_begins_anew(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    view_state *fresh = make_state();
    view_state_end(fresh);
    press(state, 'c', false);
    press(state, '3', false);
    assert_int_equal(state->camera.mode, VIEW_FLY);
    state->selection.is_hit = true;
    state->film.is_playing = true;
    state->camera.held[VIEW_FORWARD] = true;
    state->settings.turn_speed = 7;
    state->scale = 2;
    const size_t lines = state->log_count;
    view_state_renew(state, fresh);
    assert_int_equal(fresh->camera.mode, VIEW_ORBIT);
    assert_int_equal(fresh->shown.picture, VIEW_SHADED);
    assert_false(fresh->selection.is_hit);
    assert_false(fresh->film.is_playing);
    assert_false(fresh->camera.held[VIEW_FORWARD]);
    assert_true(fresh->settings.turn_speed > 6.9F);
    assert_true(fresh->scale > 1.9F);
    assert_int_equal(fresh->log_count, lines);
    assert_int_equal(fresh->width, 640);
    free_state(state);
    free_state(fresh);
}

/* At rest a frame has waited; its work is that of the last one that drew. */
static void times_are_of_work(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    state->frames[state->frame_count++] = (view_frame){.ms = 40, .work_ms = 12.5F, .rays = 100};
    assert_string_equal(panels_time(state).text, "12.5 ms");
    state->frames[state->frame_count++] = (view_frame){.ms = 137, .work_ms = 0.5F};
    state->is_idle = true;
    assert_string_equal(panels_time(state).text, "idle, 12.5 ms");
    free_state(state);
}

/* ---- settings ---- */

static settings_file file_in_folder(const char *name)
{
    settings_file file;
    (void)snprintf(file.path, sizeof file.path, "%s", path_of(name));
    return file;
}

static void settings_come_back(void **unused)
{
    (void)unused;
    view_state *written = make_state();
    view_state *read = make_state();
    const settings_file file = file_in_folder("view.json");
    assert_true(settings_load(&file, written)); /* it is missing */
    written->settings.width = 321;
    written->settings.coarse = 4;
    written->settings.move_speed = 0.7F;
    view_remember_file(written, "/a/first.obj");
    view_remember_file(written, "/a/second.obj");
    view_remember_file(written, "/a/first.obj");
    written->settings.panels = false;
    written->settings.open[VIEW_PANEL_LOG] = true;
    written->settings.open[VIEW_PANEL_CAMERA] = false;
    work_folder_remember("view.json");
    assert_true(settings_save(&file, written));
    assert_true(settings_load(&file, read));
    assert_int_equal(read->settings.width, 321);
    assert_int_equal(read->settings.coarse, 4);
    assert_true(fabsf(read->settings.move_speed - 0.7F) < 1e-6F);
    assert_string_equal(read->settings.recent[0], "/a/first.obj");
    assert_string_equal(read->settings.recent[1], "/a/second.obj");
    assert_string_equal(read->settings.recent[2], "");
    assert_false(read->settings.panels);
    assert_memory_equal(read->settings.open, written->settings.open, sizeof read->settings.open);
    assert_int_equal(read->log_count, 0);
    free_state(written);
    free_state(read);
}

static void damaged_settings_mean_defaults_and_a_line(void **unused)
{
    (void)unused;
    static const char *const texts[] = {"",
                                        "{\"width\": 300",
                                        "[]",
                                        "{\"height\": 300, \"width\": 3}",
                                        "{\"height\": 300, \"width\": \"640\"}",
                                        "{\"height\": 300, \"goal_ms\": 1e99}",
                                        "{\"height\": 300, \"panels\": 1}",
                                        "{\"height\": 300, \"recent\": [7]}",
                                        "{\"height\": 300, \"open\": {}}"};
    const settings_file file = file_in_folder("damaged.json");
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        view_state *state = make_state();
        const view_settings defaults = state->settings;
        write_text("damaged.json", texts[i]);
        if (settings_load(&file, state) || state->log_count != 1 ||
            strstr(state->log[0], "damaged; defaults are taken") == NULL) {
            fail_msg("'%s' is taken: %s", texts[i], state->log[0]);
            return;
        }
        assert_memory_equal(&state->settings, &defaults, sizeof defaults);
        free_state(state);
    }
}

/* A folder in place of the file, and a file in place of the folder. */
static void settings_that_cannot_be_kept_are_a_line(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    const settings_file below = file_in_folder("plain/view.json");
    write_text("plain", "a file");
    assert_false(settings_save(&below, state));
    assert_int_equal(state->log_count, 1);
    assert_non_null(strstr(state->log[0], "the settings are not kept"));
    const settings_file folder = file_in_folder("");
    assert_false(settings_save(&folder, state));
    assert_int_equal(state->log_count, 2);
    free_state(state);
}

static void settings_have_the_place_of_the_standard(void **unused)
{
    (void)unused;
    settings_file file;
    assert_int_equal(setenv("HOME", "/home/somebody", 1), 0);
    assert_int_equal(setenv("XDG_CONFIG_HOME", "/config", 1), 0);
    settings_find(&file);
    assert_string_equal(file.path, "/config/svocl/view.json");
    assert_int_equal(setenv("XDG_CONFIG_HOME", "relative", 1), 0);
    settings_find(&file);
    assert_string_equal(file.path, "/home/somebody/.config/svocl/view.json");
    assert_int_equal(unsetenv("XDG_CONFIG_HOME"), 0);
    assert_int_equal(unsetenv("HOME"), 0);
    settings_find(&file);
    assert_string_equal(file.path, "");
}

/* ---- motions ---- */

/* One instance moves for 2 s in 21 frames. */
static view_state *make_film(void)
{
    static scene_key keys[2] = {{.time = 1}, {.time = 3}};
    static const scene_motion motion = {0, keys, 2};
    view_state *state = make_state();
    assert_true(view_add_instance(state, &(svo_instance){.tree = 0}));
    assert_true(view_add_mover(state, &(view_mover){.motion = &motion}));
    state->film.frame_count = 21;
    state->film.first_time = 1;
    state->film.last_time = 3;
    return state;
}

static void motions_play_by_seconds(void **unused)
{
    (void)unused;
    view_state *state = make_film();
    play_advance(state, 1);
    assert_int_equal(state->film.frame, 0);
    (void)press(state, VIEW_KEY_SPACE, false);
    play_advance(state, 0.99);
    assert_int_equal(state->film.frame, 9);
    play_advance(state, 0.02);
    assert_int_equal(state->film.frame, 10);
    (void)press(state, VIEW_KEY_UP, false);
    play_advance(state, 0.5);
    assert_int_equal(state->film.frame, 20);
    play_advance(state, 0.1);
    assert_int_equal(state->film.frame, 1); /* from the beginning again */
    (void)press(state, VIEW_KEY_DOWN, false);
    (void)press(state, VIEW_KEY_DOWN, false);
    state->film.loops = false;
    play_advance(state, 100);
    assert_int_equal(state->film.frame, 20);
    assert_false(state->film.is_playing);
    (void)press(state, VIEW_KEY_SPACE, false);
    assert_int_equal(state->film.frame, 0);
    assert_true(state->film.is_playing);
    for (int i = 0; i < 20; ++i) {
        (void)press(state, VIEW_KEY_DOWN, false);
    }
    assert_int_equal(state->film.speed_log2, -VIEW_SPEED_MAX);
    free_state(state);
}

static void steps_pause_and_end(void **unused)
{
    (void)unused;
    view_state *state = make_film();
    (void)press(state, VIEW_KEY_SPACE, false);
    (void)press(state, VIEW_KEY_LEFT, false);
    assert_false(state->film.is_playing);
    assert_int_equal(state->film.frame, 20);
    (void)press(state, VIEW_KEY_RIGHT, false);
    assert_int_equal(state->film.frame, 0);
    (void)press(state, VIEW_KEY_RIGHT, false);
    assert_int_equal(state->film.frame, 1);
    state->film.loops = false;
    play_seek(state, 99);
    (void)press(state, VIEW_KEY_RIGHT, false);
    assert_int_equal(state->film.frame, 20);
    play_seek(state, 0);
    (void)press(state, VIEW_KEY_LEFT, false);
    assert_int_equal(state->film.frame, 0);
    free_state(state);
}

/* Without motions nothing plays, and what moves is not lit by cones and has no probes: a line of the log each. */
static void motions_say_what_is_not_possible(void **unused)
{
    (void)unused;
    view_state *none = make_state();
    (void)press(none, VIEW_KEY_SPACE, false);
    (void)press(none, VIEW_KEY_RIGHT, false);
    assert_int_equal(none->log_count, 2);
    assert_false(none->film.is_playing);
    free_state(none);
    view_state *state = make_film();
    view_choose_picture(state, VIEW_FULL);
    assert_int_equal(state->shown.picture, VIEW_SHADED);
    view_choose_through(state, true);
    assert_false(state->shown.through);
    assert_int_equal(state->log_count, 2);
    view_choose_picture(state, VIEW_DEPTH);
    assert_int_equal(state->shown.picture, VIEW_DEPTH);
    free_state(state);
}

/* ---- what is up ---- */

static void tap(view_state *state, int key)
{
    input_mouse mouse = {.x = 0};
    const view_event event = {.kind = VIEW_EVENT_KEY, .key = key, .is_down = true};
    (void)input_take(&mouse, &event, state);
}

/* Key Z: the camera sees the model's sides as before, and goes around z. */
static void the_worlds_up_may_be_z(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    const float quarter = (float)(PI / 2 * 640 / (double)state->settings.turn_speed);
    tap(state, 'z');
    expect_point(state->camera.at.eye, 1, 2 - 10, 3);
    expect_point(state->camera.at.up, 0, 0, 1);
    camera_turn(state, quarter, 0);
    expect_point(state->camera.at.eye, 1 - 10, 2, 3);
    expect_point(state->camera.at.up, 0, 0, 1);
    tap(state, VIEW_KEY_HOME);
    expect_point(state->camera.at.eye, 1, 2 - 10, 3);
    tap(state, 'z');
    expect_point(state->camera.at.eye, 1, 2, 13);
    expect_point(state->camera.at.up, 0, 1, 0);
    free_state(state);
}

/* Looking from above and turning goes around up again; R flies up. */
static void views_along_axes_keep_up(void **unused)
{
    (void)unused;
    for (int up = 1; up < 3; ++up) {
        view_state *state = make_state();
        const float wanted[3] = {0, up == 1, up == 2};
        camera_choose_up(state, wanted);
        for (int axis = 0; axis < 3; ++axis) {
            camera_look_along(state, axis);
            expect_point(state->camera.at.eye, 1 + 10 * (axis == 0), 2 + 10 * (axis == 1), 3 + 10 * (axis == 2));
            camera_turn(state, 30, 0);
            expect_point(state->camera.at.up, 0, up == 1, up == 2);
            assert_true(fabs(distance(state->camera.at.eye, state->camera.at.target) - 10) < 1e-4);
        }
        free_state(state);
    }
}

/* ---- clipping ---- */

/* Key V cuts away the side of the camera; picking begins at the plane. */
static void clicks_respect_the_clip_plane(void **unused)
{
    (void)unused;
    view_state *state = make_state();
    svo_ray ray;
    float plane[4];
    for (int axis = 0; axis < 3; ++axis) {
        state->low[axis] = -5;
        state->high[axis] = 7;
    }
    tap(state, 'v');
    view_clip_plane(state, plane);
    assert_memory_equal(plane, ((const float[4]){0, 0, -1, 1}), sizeof plane); /* below z = 1 */
    for (int x = 0; x < 640; x += 64) {
        camera_pick_ray(state, (float)x, 100, &ray);
        assert_float_equal(ray.origin[2] + ray.t_min * ray.direction[2], 1, 1e-5F);
        assert_true(ray.t_max > 1e30F);
    }
    state->camera.at.target[2] = 30; /* away from what is left */
    camera_pick_ray(state, 320, 200, &ray);
    assert_true(ray.t_min > ray.t_max);
    state->camera.at.eye[2] = -20; /* from the side that is left, rays end at the plane */
    camera_pick_ray(state, 320, 200, &ray);
    assert_float_equal(ray.t_min, 0, 0);
    assert_float_equal(ray.origin[2] + ray.t_max * ray.direction[2], 1, 1e-5F);
    tap(state, 'v');
    view_clip_plane(state, plane);
    assert_memory_equal(plane, ((const float[4]){0}), sizeof plane);
    /* Not through probes. */
    state->shown.through = true;
    tap(state, 'v');
    assert_false(state->shown.clip.is_on);
    free_state(state);
}

TEST_GROUP(view_state)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(orbit_turns_the_eye_around_the_target),
                                       cmocka_unit_test(flying_turns_the_line_of_sight),
                                       cmocka_unit_test(no_drag_passes_the_poles),
                                       cmocka_unit_test(speed_does_not_depend_on_the_frames),
                                       cmocka_unit_test(panning_keeps_the_target_below_the_mouse),
                                       cmocka_unit_test(rays_and_pixels_agree),
                                       cmocka_unit_test(the_worlds_up_may_be_z),
                                       cmocka_unit_test(views_along_axes_keep_up),
                                       cmocka_unit_test(clicks_respect_the_clip_plane),
                                       cmocka_unit_test(keys_choose_what_is_shown),
                                       cmocka_unit_test(drags_are_strokes),
                                       cmocka_unit_test(keys_look_through_probes),
                                       cmocka_unit_test(clicks_find_spheres),
                                       cmocka_unit_test(clicks_pick_and_drags_turn),
                                       cmocka_unit_test(jobs_ask_and_are_canceled),
                                       cmocka_unit_test(paths_are_completed),
                                       cmocka_unit_test(another_model_begins_anew),
                                       cmocka_unit_test(times_are_of_work),
                                       cmocka_unit_test(settings_come_back),
                                       cmocka_unit_test(damaged_settings_mean_defaults_and_a_line),
                                       cmocka_unit_test(settings_that_cannot_be_kept_are_a_line),
                                       cmocka_unit_test(motions_play_by_seconds),
                                       cmocka_unit_test(steps_pause_and_end),
                                       cmocka_unit_test(motions_say_what_is_not_possible),
                                       cmocka_unit_test(settings_have_the_place_of_the_standard)};
    return cmocka_run_group_tests_name("view_state", tests, work_folder_make, work_folder_remove);
}
