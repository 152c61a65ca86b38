/* SPDX-License-Identifier: MIT */
/*
 * Files of the viewer's loop: pictures that it saves; the worker's jobs, and the window meanwhile, its events and a box
 * that says what is made; and of those jobs INPUT of the command line, and files that take its place.
 */
#define _XOPEN_SOURCE 700 /* realpath */
#include "view/work.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/cleanup.h"
#include "support/input.h"
#include "support/picture.h"
#include "view/dialogs.h"
#include "view/history.h"

/* ---- pictures that are saved ---- */

/* Pictures that are saved have numbers up to this. */
#define SHOTS_MAX 9999u

int shots_take(viewer *which, const char *path, unsigned width, unsigned height)
{
    uint8_t *rgba = malloc((size_t)width * height * 4);
    if (rgba == NULL) {
        return program_fail(which->running, PROGRAM_FAILED, "out of memory for %ux%u pixels", width, height);
    }
    const int exit_code = canvas_read(which->canvas, width, height, rgba, &which->why)
                              ? picture_write_as(which->running, path, width, height, rgba)
                              : viewer_fail(which);
    free(rgba);
    return exit_code;
}

/* What pictures of INPUT are called: "a/statue.svo" gives "statue", "scene:knot:2000" gives "knot". */
static void name_shots(const char *path, char name[VIEW_NAME_BYTES])
{
    const char *slash = strrchr(path, '/');
    const char *begin = strncmp(path, "scene:", 6) == 0 ? path + 6 : slash != NULL ? slash + 1 : path;
    (void)snprintf(name, VIEW_NAME_BYTES, "%.*s", (int)strcspn(begin, ".:"), begin);
    if (name[0] == '\0' || name[0] == '-') {
        (void)snprintf(name, VIEW_NAME_BYTES, "svocl");
    }
}

/* Takes a name that no file has, in a folder, by making the file. False with errno where none can be made. */
static bool take_fresh_name(const char *folder, const char *name, char path[VIEW_PATH_BYTES])
{
    for (unsigned i = 1; i <= SHOTS_MAX; ++i) {
        const int length = snprintf(path, VIEW_PATH_BYTES, "%s/%s-%03u.png", folder, name, i);
        if (length < 0 || length >= VIEW_PATH_BYTES) {
            errno = ENAMETOOLONG;
            return false;
        }
        const int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file >= 0) {
            (void)close(file);
            return true;
        }
        if (errno != EEXIST) {
            return false;
        }
    }
    return false;
}

/* Saves the frame as it is, in the folder where the program runs, or at home where that cannot be written. */
static void save(viewer *which)
{
    view_state *state = &which->state;
    const char *home = getenv("HOME");
    char folder[VIEW_PATH_BYTES];
    char path[VIEW_PATH_BYTES];
    char name[VIEW_NAME_BYTES];
    svo_message reason = {""};
    name_shots(state->input, name);
    const bool is_here = getcwd(folder, sizeof folder) != NULL && take_fresh_name(folder, name, path);
    if (!is_here && (home == NULL || !take_fresh_name(home, name, path))) {
        view_log(state, "no picture was saved: %s", strerror(errno));
        return;
    }
    which->running->failure = &reason;
    const int exit_code = shots_take(which, path, state->width, state->height);
    which->running->failure = NULL;
    if (exit_code == PROGRAM_DONE) {
        view_log(state, "saved %s", path);
    } else {
        (void)unlink(path);
        view_notice(state, reason.text);
    }
}

void shots_save(viewer *which, view_shot shot)
{
    view_state *state = &which->state;
    if (state->wants_shot == shot && shot != VIEW_SHOT_NONE && state->is_refined) {
        state->wants_shot = VIEW_SHOT_NONE;
        save(which);
    }
}

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

/* ---- what is opened ---- */

/* A subject that is opened into a state of its own, beside the one that is shown. */
typedef struct opening {
    viewer *which;
    view_state *state;
    subject *subject;
} opening;

static int open_job(void *user)
{
    const opening *work = user;
    cleanup_take();
    return subject_open(work->which->running, work->state, work->subject);
}

static int close_job(void *user)
{
    subject *gone = user;
    cleanup_take();
    subject_close(gone);
    return PROGRAM_DONE;
}

/* Contexts of OpenGL that a build made stay with the worker's thread. */
void opening_close(viewer *which)
{
    drawing_end(&which->drawing);
    ground_end(&which->ground);
    history_end(&which->state);
    if (which->subject != NULL) {
        (void)work_run(which, "", false, close_job, which->subject);
        free(which->subject);
        which->subject = NULL;
    }
}

/* Of the command line what does not depend on INPUT: the first one's camera, lights and frames are not the next one's.
   Options that do not apply to a finished tree are no mistake here. */
static options options_of(const viewer *which, const char *path)
{
    options given = which->first;
    given.input = path;
    given.given_groups = 0;
    given.lights_path = NULL;
    given.eye.is_given = given.look_at.is_given = given.up.is_given = false;
    given.fov = 0;
    given.frames = 0;
    given.last_level = 0;
    return given;
}

/* What the command line says of probes. */
static void take_probe_options(viewer *which)
{
    const options *given = &which->running->options;
    view_probe_grid *grid = &which->state.probes.asked;
    if (given->probe_counts[0] > 0) {
        memcpy(grid->counts, given->probe_counts, sizeof grid->counts);
    }
    grid->resolution = given->probe_resolution > 0 ? (uint32_t)given->probe_resolution : grid->resolution;
    grid->field_size = given->probe_field > 0 ? (uint32_t)given->probe_field : grid->field_size;
    view_make_probes(&which->state);
}

/* The file as the window has it from now on. */
static void begin_showing(viewer *which)
{
    view_state *state = &which->state;
    char title[VIEW_PATH_BYTES + 16];
    char path[PATH_MAX];
    (void)snprintf(title, sizeof title, "%s - svocl", state->input);
    window_set_title(which->window, title);
    which->is_marked = false;
    which->drawing.pixels = (pixel_buffer){.running = which->running, .context = window_context(which->window)};
    which->listed = 0;
    take_probe_options(which);
    history_begin(state);
    if (!which->has_script && which->running->piped.name == NULL && realpath(state->input, path) != NULL) {
        view_remember_file(state, path);
    }
}

/* Why a file is not shown: in a box, and on the terminal. */
static void refuse_file(viewer *which, const char *path)
{
    char text[VIEW_NOTICE_BYTES];
    if (which->work.is_canceled) {
        view_log(&which->state, "canceled: %s", path);
        return;
    }
    const bool names_file = strstr(which->failure.text, path) != NULL;
    (void)snprintf(text, sizeof text, "%s%s%s", names_file ? "" : path, names_file ? "" : ": ", which->failure.text);
    view_notice(&which->state, text);
    (void)program_fail(which->running, PROGRAM_FAILED, "%s", text);
}

/* Puts what was opened in place of what is shown. */
static void take_opened(viewer *which, opening *work, char *path)
{
    opening_close(which);
    view_state_end(&which->state);
    which->state = *work->state;
    which->subject = work->subject;
    free(work->state);
    free(which->opened_path);
    which->opened_path = path;
    begin_showing(which);
    view_log(&which->state, "opened %s", path);
}

/* Opens a file in place of what is shown. Where that fails or is canceled, everything stays. */
static int open_file(viewer *which, const char *asked)
{
    const options before = which->running->options;
    char *path = strdup(asked);
    opening work = {which, calloc(1, sizeof *work.state), calloc(1, sizeof *work.subject)};
    if (path == NULL || work.state == NULL || work.subject == NULL) {
        free(path);
        free(work.state);
        free(work.subject);
        view_notice(&which->state, "out of memory for another file");
        return PROGRAM_DONE;
    }
    view_state_renew(&which->state, work.state);
    work.state->input = path;
    which->running->options = options_of(which, path);
    const int exit_code = work_run(which, path, true, open_job, &work);
    const bool is_canceled = which->work.is_canceled;
    if (exit_code == PROGRAM_DONE && !is_canceled) {
        if (which->failure.text[0] != '\0') {
            view_log(work.state, "%s", which->failure.text);
        }
        take_opened(which, &work, path);
        return which->work.exit_code;
    }
    which->running->options = before;
    if (!which->work.is_closed) {
        refuse_file(which, path);
    }
    if (exit_code == PROGRAM_DONE) { /* what does not ask whether it is canceled */
        (void)work_run(which, "", false, close_job, work.subject);
    }
    view_state_end(work.state);
    free(work.state);
    free(work.subject);
    free(path);
    return which->work.exit_code;
}

/* Opens the file that the state asks for. */
int opening_take(viewer *which)
{
    view_state *state = &which->state;
    char path[VIEW_PATH_BYTES];
    if (!state->wants_load && !state->wants_open) {
        return PROGRAM_DONE;
    }
    memcpy(path, state->wants_load ? state->scene_path : state->open_path, sizeof path);
    state->wants_load = state->wants_open = false;
    return open_file(which, path);
}

/* ---- voxels that are saved ---- */

static int save_job(void *user)
{
    viewer *which = user;
    cleanup_take();
    return subject_save_voxels(which->subject, &which->state, which->state.question.path);
}

int saving_take(viewer *which)
{
    char failure[sizeof which->failure.text];
    if (!which->state.wants_voxels) {
        return PROGRAM_DONE;
    }
    const int exit_code = work_run(which, which->state.question.path, false, save_job, which);
    memcpy(failure, which->failure.text, sizeof failure);
    question_wrote_voxels(&which->state, exit_code == PROGRAM_DONE ? NULL : failure);
    return which->work.exit_code;
}

/* INPUT of the command line. Whoever cancels it has nothing else to look at: that ends the program as closing does. */
int opening_input(viewer *which)
{
    opening work = {which, &which->state, calloc(1, sizeof *work.subject)};
    if (work.subject == NULL) {
        return program_fail(which->running, PROGRAM_FAILED, "out of memory");
    }
    const int exit_code = work_run(which, which->state.input, true, open_job, &work);
    if (exit_code == PROGRAM_DONE && which->work.exit_code == PROGRAM_DONE) {
        which->subject = work.subject;
        begin_showing(which);
        return PROGRAM_DONE;
    }
    if (exit_code == PROGRAM_DONE) {
        (void)work_run(which, "", false, close_job, work.subject);
    }
    free(work.subject);
    which->state.is_done = true;
    return which->work.is_canceled && which->work.exit_code == PROGRAM_DONE ? PROGRAM_DONE
                                                                            : work_fail(which, exit_code);
}
