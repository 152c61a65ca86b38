/* SPDX-License-Identifier: MIT */
/* The loop: events, the tree and its light, the picture, panels, the window. */
#include "view/view.h"

#include <stdlib.h>

#include "support/input.h"
#include "view/canvas.h"
#include "view/drawing.h"
#include "view/overlay.h"
#include "view/window.h"

typedef struct viewer {
    program *running;
    view_state state;
    window *window;
    canvas *canvas;
    overlay *overlay;
    subject subject;
    drawing drawing;
    svo_message why;
} viewer;

static int fail(viewer *which)
{
    return program_fail(which->running, PROGRAM_FAILED, "%s", which->why.text);
}

static double now_ms(void *clock)
{
    (void)clock;
    return input_now_ms();
}

static int run_frame(viewer *which)
{
    view_event event;
    view_state *state = &which->state;
    bool is_new = false;
    while (window_poll(which->window, &event)) {
        (void)overlay_take(which->overlay, &event);
        state->is_done = state->is_done || event.kind == VIEW_EVENT_QUIT;
    }
    window_size(which->window, &state->width, &state->height);
    int exit_code = subject_update(&which->subject, state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = drawing_next(&which->drawing, &which->subject, state, now_ms, NULL, &is_new);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if ((is_new && !canvas_take_picture(which->canvas, which->drawing.rgba, which->drawing.width, which->drawing.height,
                                        &which->why)) ||
        !canvas_draw(which->canvas, state->width, state->height, NULL, 0, &which->why) ||
        !overlay_draw(which->overlay, state, 1.0F / 60, &which->why)) {
        return fail(which);
    }
    window_show(which->window);
    return PROGRAM_DONE;
}

static int show(viewer *which)
{
    int exit_code = subject_open(which->running, &which->state, &which->subject);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    progress_destroy(&which->running->progress);
    if (!window_use(which->window, &which->why)) {
        exit_code = fail(which);
    }
    while (exit_code == PROGRAM_DONE && !which->state.is_done) {
        exit_code = run_frame(which);
    }
    drawing_end(&which->drawing);
    subject_close(&which->subject);
    return exit_code;
}

static int open_window(viewer *which)
{
    view_state *state = &which->state;
    which->window = window_open("svocl view", state->settings.width, state->settings.height, state->settings.fullscreen,
                                &which->why);
    if (which->window == NULL) {
        return fail(which);
    }
    window_size(which->window, &state->width, &state->height);
    state->renderer = window_renderer(which->window);
    which->canvas = canvas_create(window_gl(which->window), &which->why);
    which->overlay = which->canvas != NULL ? overlay_create(window_gl(which->window), &which->why) : NULL;
    return which->overlay != NULL ? PROGRAM_DONE : fail(which);
}

int view_run(program *running)
{
    viewer *which = calloc(1, sizeof *which);
    if (which == NULL) {
        return program_fail(running, PROGRAM_FAILED, "out of memory");
    }
    which->running = running;
    view_state_begin(&which->state);
    which->state.input = running->options.input;
    int exit_code = open_window(which);
    if (exit_code == PROGRAM_DONE) {
        exit_code = show(which);
    }
    overlay_destroy(&which->overlay);
    canvas_destroy(&which->canvas);
    window_close(&which->window);
    view_state_end(&which->state);
    free(which);
    return exit_code;
}
