/* SPDX-License-Identifier: MIT */
/*
 * The panels: two columns of sections beside the picture's center, and a line below. Left is what the viewer tells,
 * right what can be changed. Everything comes from the state and goes to the functions that change it.
 */
#ifndef SVOCL_TOOLS_VIEW_PANELS_H
#define SVOCL_TOOLS_VIEW_PANELS_H

#include "support/progress.h"
#include "view/state.h"
#include "view/ui.h"

/* Describes the panels of a frame, between ui_begin and ui_end. */
void panels_describe(ui *toolkit, view_state *state);

/* What is being loaded or made, and how far that is. */
typedef struct panels_work {
    const char *name; /* of what is loaded */
    progress_view progress;
    double seconds; /* since it began */
    bool is_first; /* there is nothing to go back to: Esc ends the program */
    bool can_stop; /* Esc ends it before its end */
    bool is_stopped; /* as soon as it can */
} panels_work;

/* Describes the box of work in a window of this size. It covers what it stands on, so it can be drawn over itself. */
void panels_describe_work(ui *toolkit, const panels_work *work, float width, float height);

/* Whether text is large, by the settings and the window. */
bool panels_text_is_large(const view_state *state);

/* What the last frame that drew took to make, "idle" before it while nothing is drawn. */
typedef struct panels_text {
    char text[64];
} panels_text;

panels_text panels_time(const view_state *state);

#endif
