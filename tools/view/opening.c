/* SPDX-License-Identifier: MIT */
/* INPUT of the command line, and files that take its place. */
#define _XOPEN_SOURCE 700 /* realpath */
#include "view/opening.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/cleanup.h"
#include "view/history.h"
#include "view/work.h"

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
    view_choose_probe_choice(&which->state, (svo_probe_choice)given->probe_choice);
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
