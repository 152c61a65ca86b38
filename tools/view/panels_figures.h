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
    float ms; /* 0: no frame yet */
    float stage_ms[VIEW_STAGES];
    double rays_a_second; /* 0: nothing was drawn */
} panels_means;

panels_means panels_mean(const view_state *state);

/* The longest begin of a text that is at most so wide. */
void panels_fit(const ui *toolkit, const char *text, float width, char *out, size_t out_bytes);

#endif
