/* SPDX-License-Identifier: MIT */
/* The worker's jobs, and the window meanwhile: its events, and a box that says what is made. */
#include "view/work.h"

#include <stdlib.h>
#include <string.h>

#include "support/cleanup.h"
#include "support/input.h"
#include "view/shots.h"

/* While something is made, the window is looked after this often. */
#define LOOK_MS 20
/* What is made within this time of what is already shown needs no box. */
#define QUIET_MS 400.0
/* After the window was closed, what is being made has this time to end. */
#define CLOSE_MS 500.0

/* ---- the window ---- */

static void stop(viewer *which)
{
    which->work.is_canceled = true;
    worker_cancel(which->worker);
}

/* Draws the box over what the window shows, and saves that where shot names a file. */
static int draw(viewer *which, const char *shot)
{
    const progress_view now = worker_progress(which->worker);
    const panels_work work = {.name = which->work.name,
                              .progress = now,
                              .seconds = which->has_script ? 0 : (input_now_ms() - which->work.begun_ms) / 1e3,
                              .is_first = which->subject == NULL,
                              .can_stop = which->work.is_opening || now.stage != NULL,
                              .is_stopped = which->work.is_canceled};
    unsigned width = 0;
    unsigned height = 0;
    window_size(which->window, &width, &height);
    const bool is_begun = which->work.is_opening
                              ? canvas_draw(which->canvas, width, height, NULL, 0, &which->why) /* without panels */
                              : canvas_continue(which->canvas, width, height, &which->why);
    if (!is_begun || !overlay_draw_work(which->overlay, &work, width, height, &which->why)) {
        return viewer_fail(which);
    }
    const int exit_code = shot != NULL ? shots_take(which, shot, width, height) : PROGRAM_DONE;
    if (exit_code == PROGRAM_DONE &&
        !(canvas_show(which->canvas, &which->why) && window_show(which->window, &which->why))) {
        return viewer_fail(which);
    }
    return exit_code;
}

/* What a hand does to the picture meanwhile is lost. Without anything to go back to, Escape closes the window. */
static void take_event(viewer *which, const view_event *event)
{
    view_work *work = &which->work;
    const bool escapes = event->kind == VIEW_EVENT_KEY && event->is_down && event->key == VIEW_KEY_ESCAPE;
    const bool closes = event->kind == VIEW_EVENT_QUIT || (escapes && which->subject == NULL);
    if (closes && work->asks) {
        work->leaves = true;
        stop(which);
    } else if (closes) {
        work->is_closed = true;
        work->closed_ms = input_now_ms();
        window_hide(which->window);
        stop(which);
    } else if (escapes) {
        stop(which);
    }
}

/* Shows what there is to show, and says to the work if it is in vain. */
static void take_turn(viewer *which, const char *shot)
{
    view_work *work = &which->work;
    view_event event;
    while (!work->is_closed && window_poll(which->window, &event)) {
        take_event(which, &event);
    }
    if (!work->is_closed && work->exit_code == PROGRAM_DONE) {
        work->exit_code = draw(which, shot);
    }
    if (work->exit_code != PROGRAM_DONE && !work->is_canceled) {
        stop(which);
    }
}

/* Ends the program: the window is closed, and the work does not end, as a compiler of kernels does not. */
static void abandon(viewer *which)
{
    view_state *copy = which->has_script ? NULL : calloc(1, sizeof *copy); /* the state is the work's */
    if (copy != NULL) {
        copy->settings = which->state.settings;
        (void)settings_save(&which->settings, copy);
    }
    cleanup_end(PROGRAM_DONE);
}

static void look_after(viewer *which)
{
    view_work *work = &which->work;
    const double now = input_now_ms();
    work->is_shown = work->is_shown || window_is_closing(which->window) || now - work->begun_ms > QUIET_MS;
    if (work->is_shown) {
        take_turn(which, NULL);
    }
    if (work->is_closed && now - work->closed_ms > CLOSE_MS) {
        abandon(which);
    }
}

/* ---- the work ---- */

/* A line of a script for the box, while the work waits. */
static void play(void *user)
{
    viewer *which = user;
    view_work *work = &which->work;
    script_step step;
    work->is_shown = true;
    do {
        step = script_next_loading(&which->script);
        if (step.kind == SCRIPT_EVENT && !window_push(which->window, &step.event)) {
            work->exit_code = program_fail(which->running, PROGRAM_FAILED, "an event of the script was refused");
        }
        take_turn(which, step.kind == SCRIPT_SHOT ? step.path : NULL);
    } while (script_has_loading(&which->script, step.line));
}

/* Functions of a progress_watch. A script's steps come at those of the work, so that they are always the same. */
static void see_progress(void *user, const progress_view *now)
{
    viewer *which = user;
    worker_see(which->worker, now);
    if (which->has_script && now->stage == NULL && script_has_loading(&which->script, 0)) {
        worker_ask(which->worker, play, which);
    }
}

static bool stops(void *user)
{
    const viewer *which = user;
    return worker_stops(which->worker);
}

/* What failed and did not end the work, such as motions that cannot be shown. */
static void report(viewer *which)
{
    if (which->failure.text[0] != '\0') {
        view_log(&which->state, "%s", which->failure.text);
        (void)program_fail(which->running, PROGRAM_FAILED, "%s", which->failure.text);
    }
}

int work_run(viewer *which, const char *name, bool is_opening, int (*made)(void *user), void *user)
{
    view_work *work = &which->work;
    worker_state now = WORKER_BUSY;
    *work = (view_work){.name = name,
                        .begun_ms = input_now_ms(),
                        .is_opening = is_opening,
                        .asks = view_is_unsaved(&which->state),
                        .is_shown = is_opening && !which->has_script};
    which->failure.text[0] = '\0';
    which->running->failure = &which->failure;
    worker_begin(which->worker, made, user);
    if (work->is_shown) {
        take_turn(which, NULL);
    }
    while (now != WORKER_DONE) {
        now = worker_wait(which->worker, which->has_script ? WORKER_FOREVER : LOOK_MS);
        if (now == WORKER_ASKS) {
            worker_answer(which->worker);
        } else if (now == WORKER_BUSY) {
            look_after(which);
        }
    }
    cleanup_take();
    which->running->failure = NULL;
    progress_destroy(&which->running->progress);
    if (work->is_shown) { /* what went up meanwhile was not seen */
        overlay_release(which->overlay);
        input_release(&which->mouse, &which->state);
        memset(which->held, 0, sizeof which->held);
        which->lively_frames = LIVELY_FRAMES;
    }
    if (work->leaves) {
        view_leave(&which->state, &which->state.is_done);
    }
    which->state.is_done = which->state.is_done || work->is_closed;
    if (worker_exit_code(which->worker) == PROGRAM_DONE && !work->is_canceled) {
        report(which);
    }
    return worker_exit_code(which->worker);
}

int work_fail(viewer *which, int exit_code)
{
    return which->work.exit_code != PROGRAM_DONE ? which->work.exit_code
                                                 : program_fail(which->running, exit_code, "%s", which->failure.text);
}

/* ---- devices ---- */

/* A device that the worker asks for: the window's context is current on this thread. */
typedef struct device_request {
    const viewer *which;
    const svo_device_options *asked;
    svo_device **out;
    svo_message *message;
    svo_status status;
} device_request;

static void answer_device(void *user)
{
    device_request *request = user;
    request->status = svo_gl_device_create(window_context(request->which->window), NULL, request->asked, request->out,
                                           request->message);
}

/* A program_devices.create: OpenCL contexts are made for the window's context where the two can share. */
static svo_status create_device(void *user, const svo_device_options *asked, svo_device **out, svo_message *message)
{
    const viewer *which = user;
    device_request request = {.which = which, .asked = asked, .out = out, .message = message};
    worker_ask(which->worker, answer_device, &request);
    return request.status;
}

/* ---- the thread ---- */

int work_begin(viewer *which)
{
    which->worker = worker_create();
    which->watch = (progress_watch){see_progress, stops, which};
    which->running->watch = &which->watch;
    which->running->devices = (program_devices){create_device, which};
    return which->worker != NULL ? PROGRAM_DONE
                                 : program_fail(which->running, PROGRAM_FAILED, "no memory for another thread");
}

void work_end(viewer *which)
{
    which->running->devices = (program_devices){NULL, NULL};
    which->running->watch = NULL;
    worker_destroy(&which->worker);
}
