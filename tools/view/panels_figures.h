/* SPDX-License-Identifier: MIT */
/* Figures of the last frames, and texts that fit. */
#ifndef SVOCL_TOOLS_VIEW_PANELS_FIGURES_H
#define SVOCL_TOOLS_VIEW_PANELS_FIGURES_H

#include "view/state.h"
#include "view/ui.h"

/* The frame so many frames ago; 0: the last one. NULL: there was none, or it is forgotten. */
const view_frame *panels_frame(const view_state *state, size_t ago);

/* Means of the last frames, half a second of them at most. */
typedef struct panels_means {
    float ms; /* from frame to frame; 0: no frame yet */
    float stage_ms[VIEW_STAGES];
    double rays_a_second; /* 0: nothing was drawn */
} panels_means;

panels_means panels_mean(const view_state *state);

/* What the last frame that drew took to make, "idle" before it while nothing is drawn. */
typedef struct panels_text {
    char text[64];
} panels_text;

panels_text panels_time(const view_state *state);

/* Begins a panel above the others, at most so wide, in a window of this size. ui_panel_end ends it. */
void panels_begin_box(ui *toolkit, const char *name, float box_width, float width, float height);

#endif
