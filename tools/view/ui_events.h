/* SPDX-License-Identifier: MIT */
/* From the window's events to what panels are told of the user. */
#ifndef SVOCL_TOOLS_VIEW_UI_EVENTS_H
#define SVOCL_TOOLS_VIEW_UI_EVENTS_H

#include "view/events.h"
#include "view/ui.h"

/* What is held, and what was pressed since the last frame even if it is held no more. */
typedef struct ui_events {
    ui_input next; /* without size and time; its buttons and keys are those that went down */
    bool buttons[3]; /* held */
    bool keys[UI_KEY_COUNT];
} ui_events;

/* No mouse, nothing held. */
void ui_events_begin(ui_events *events);

void ui_events_take(ui_events *events, const view_event *event);

/* The input of the next frame; forgets what is over. */
ui_input ui_events_frame(ui_events *events, unsigned width, unsigned height, float seconds);

#endif
