/* SPDX-License-Identifier: MIT */
/* What keys and the mouse do outside panels. */
#ifndef SVOCL_TOOLS_VIEW_INPUT_H
#define SVOCL_TOOLS_VIEW_INPUT_H

#include "view/state.h"
#include "view/ui.h"

/* The mouse, from one event to the next. */
typedef struct input_mouse {
    int x, y;
    int press_x, press_y; /* where the left button went down */
    bool held[3];
    bool dragged; /* since then */
} input_mouse;

/* What an event asks for besides changes of the state. */
typedef enum input_wish { INPUT_NOTHING = 0, INPUT_PICK, INPUT_FULLSCREEN } input_wish;

/* Forgets what is held: its end was not seen. */
void input_release(input_mouse *mouse, view_state *state);

/* Applies an event. INPUT_PICK: a click at mouse->x, y. */
input_wish input_take(input_mouse *mouse, const view_event *event, view_state *state);

/* A key of the viewer and what it does; NULL keys: there are no more. */
typedef struct input_binding {
    const char *keys, *words;
} input_binding;
input_binding input_describe(size_t index);

#endif
