/* SPDX-License-Identifier: MIT */
/*
 * Scripts: keys, moves, clicks, waits and shots in place of hands, one step a frame. docs/view.md describes the
 * commands. Steps for the window of a load come at its next steps of progress. While one plays, a frame lasts 1/60 s,
 * however long it takes: so the same script gives the same pictures.
 */
#ifndef SVOCL_TOOLS_VIEW_SCRIPT_H
#define SVOCL_TOOLS_VIEW_SCRIPT_H

#include "support/program.h"
#include "view/state.h"
#include "view/ui.h"

#define SCRIPT_FRAME_SECONDS (1.0 / 60.0)

/* What happens in one frame. */
typedef enum script_kind {
    SCRIPT_EVENT, /* an event; it is seen by this frame */
    SCRIPT_WAIT, /* nothing, for some frames */
    SCRIPT_REFINE, /* nothing until the picture is refined */
    SCRIPT_COARSE, /* sets how coarse pictures are while something moves */
    SCRIPT_BRUSH, /* begins to draw */
    SCRIPT_SHOT, /* what this frame shows, as a PNG */
    SCRIPT_END
} script_kind;

typedef struct script_brush {
    view_brush_tool tool;
    view_brush_shape shape;
    float radius;
    bool has_color; /* the fields below were given */
    int color[3], material;
} script_brush;

typedef struct script_step {
    script_kind kind;
    view_event event;
    script_brush brush; /* SCRIPT_BRUSH */
    unsigned count; /* SCRIPT_WAIT: frames; SCRIPT_COARSE: pixels */
    const char *path; /* SCRIPT_SHOT */
    bool is_loading; /* for the window that shows what is loaded */
    unsigned line; /* of the file */
} script_step;

typedef struct script {
    char *text; /* of the file; paths of steps lie in it */
    script_step *steps;
    size_t step_count, step_capacity;
    size_t next;
    unsigned waited; /* frames of the current step */
} script;

/* Reads and checks the file. Returns the exit code; on failure nothing stays open. */
int script_open(program *running, const char *path, script *out);
void script_close(script *which);

/* The step of the next frame. Waits come once for each of their frames. */
script_step script_next(script *which, const view_state *state);

/* Whether the next step is for the window of a load, which script_next_loading then takes. line: that it must be of; 0:
   any. */
bool script_has_loading(const script *which, unsigned line);
script_step script_next_loading(script *which);

#endif
