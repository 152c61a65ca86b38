/* SPDX-License-Identifier: MIT */
/* Events of the window, whether a hand or a script made them. */
#ifndef SVOCL_TOOLS_VIEW_EVENTS_H
#define SVOCL_TOOLS_VIEW_EVENTS_H

#include <stdbool.h>

typedef enum view_event_kind {
    VIEW_EVENT_KEY, /* key went down or up */
    VIEW_EVENT_TEXT, /* text was typed */
    VIEW_EVENT_MOVE, /* the mouse is at x, y */
    VIEW_EVENT_BUTTON, /* of the mouse, at x, y */
    VIEW_EVENT_WHEEL, /* by steps, at x, y */
    VIEW_EVENT_RESIZE, /* the window has x times y pixels */
    VIEW_EVENT_DROP, /* a file was dropped on the window: path */
    VIEW_EVENT_QUIT
} view_event_kind;

enum { VIEW_BUTTON_LEFT = 0, VIEW_BUTTON_RIGHT, VIEW_BUTTON_MIDDLE };

/* Keys are their lowercase letter or digit, or one of these. */
enum {
    VIEW_KEY_NONE = 0,
    VIEW_KEY_BACKSPACE = 8,
    VIEW_KEY_TAB = 9,
    VIEW_KEY_ENTER = 13,
    VIEW_KEY_ESCAPE = 27,
    VIEW_KEY_SPACE = 32,
    VIEW_KEY_DELETE = 127,
    VIEW_KEY_LEFT = 256,
    VIEW_KEY_RIGHT,
    VIEW_KEY_UP,
    VIEW_KEY_DOWN,
    VIEW_KEY_HOME,
    VIEW_KEY_END,
    VIEW_KEY_F1, /* F2 to F12 follow */
    VIEW_KEY_F12 = VIEW_KEY_F1 + 11,
    VIEW_KEYS
};

typedef struct view_event {
    view_event_kind kind;
    int key;
    int button;
    bool is_down;
    bool shift, control; /* held */
    int x, y; /* pixels from the window's left upper corner */
    float steps; /* of the wheel, away from the user is positive */
    char text[32]; /* UTF-8 */
    char path[1024]; /* "": it was longer */
} view_event;

#endif
