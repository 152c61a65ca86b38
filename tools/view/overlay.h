/* SPDX-License-Identifier: MIT */
/* Panels above the picture: events go in, and each frame they are described and drawn. */
#ifndef SVOCL_TOOLS_VIEW_OVERLAY_H
#define SVOCL_TOOLS_VIEW_OVERLAY_H

#include "svocl/status.h"
#include "view/gl.h"
#include "view/panels.h"
#include "view/state.h"
#include "view/ui.h"

typedef struct overlay overlay;

/* Makes what panels need in the current context, whose functions must outlive them. scale: pixels for each pixel of the
   panels. NULL with a reason on failure. */
overlay *overlay_create(const view_gl *gl, float scale, const ui_clipboard *clipboard, svo_message *why);
void overlay_destroy(overlay **which);

/* Tells the panels of an event. Returns whether it is theirs alone: the mouse over them, text for a field. What a
   button or key that went down on the picture does until it goes up is never theirs. */
bool overlay_take(overlay *which, const view_event *event);

/* Whether a field of text has the keys. */
bool overlay_types(const overlay *which);

/* Describes the panels, which may change the state, and draws them over what is there. False on failure. */
bool overlay_draw(overlay *which, view_state *state, float seconds, svo_message *why);

/* Draws the box of work alone over what is there, in a window of this size in pixels. False on failure. */
bool overlay_draw_work(overlay *which, const panels_work *work, unsigned width, unsigned height, svo_message *why);

/* Forgets what is held: its end was not seen. */
void overlay_release(overlay *which);

#endif
