/* SPDX-License-Identifier: MIT */
/* What the files of the viewer's loop share: the window, what is looked at, and what is under way. */
#ifndef SVOCL_TOOLS_VIEW_VIEWER_H
#define SVOCL_TOOLS_VIEW_VIEWER_H

#include "support/program.h"
#include "view/canvas.h"
#include "view/drawing.h"
#include "view/files.h"
#include "view/input.h"
#include "view/marks.h"
#include "view/overlay.h"
#include "view/script.h"
#include "view/window.h"
#include "view/worker.h"

/* After an event, so many frames come at once. */
#define LIVELY_FRAMES 3u

/* What is being made, and what the window does meanwhile. */
typedef struct view_work {
    const char *name;
    double begun_ms, closed_ms;
    bool is_opening; /* a file, so that it can be canceled; else something of what is shown */
    bool is_shown; /* the box */
    bool is_canceled, is_closed;
    bool asks; /* there are edits that closing would lose */
    bool leaves; /* the window is to close, after the question about them */
    int exit_code; /* of the box */
} view_work;

typedef struct viewer {
    program *running;
    view_state state;
    settings_file settings;
    window *window;
    canvas *canvas;
    overlay *overlay;
    worker *worker;
    progress_watch watch;
    view_work work;
    subject *subject;
    char *opened_path; /* of the file that is shown, where it is not the command line's */
    options first; /* the command line's */
    drawing drawing;
    ground ground;
    marks marks;
    uint64_t listed; /* sum of changes whose memory is listed */
    bool is_fullscreen;
    unsigned lively_frames; /* to come without a wait: panels answer an event one frame later */
    input_mouse mouse;
    bool held[3]; /* buttons, whoever they are for */
    bool is_marked; /* the title has the mark of unsaved edits */
    script script;
    bool has_script;
    script_step step; /* of this frame */
    uint64_t frame_number;
    double frame_begin_ms, lap_ms;
    view_frame frame; /* what is known of this one */
    svo_message why, failure;
} viewer;

/* Prints why. Returns the exit code. */
static inline int viewer_fail(viewer *which)
{
    return program_fail(which->running, PROGRAM_FAILED, "%s", which->why.text);
}

#endif
