/* SPDX-License-Identifier: MIT */
/*
 * The panels: two columns of sections beside the picture's center, and a line below. Left is what the viewer tells,
 * right what can be changed. Everything comes from the state and goes to the functions that change it.
 */
#ifndef SVOCL_TOOLS_VIEW_PANELS_H
#define SVOCL_TOOLS_VIEW_PANELS_H

#include "view/state.h"
#include "view/ui.h"

/* Describes the panels of a frame, between ui_begin and ui_end. */
void panels_describe(ui *toolkit, view_state *state);

/* Whether text is large, by the settings and the window. */
bool panels_text_is_large(const view_state *state);

#endif
