/* SPDX-License-Identifier: MIT */
/* The window: SDL's, with a context of OpenGL 4.3 core. */
#ifndef SVOCL_TOOLS_VIEW_WINDOW_H
#define SVOCL_TOOLS_VIEW_WINDOW_H

#include "svocl/gl.h"
#include "view/gl.h"
#include "view/ui.h"

typedef struct window window;

/* How a window begins. */
typedef struct window_place {
    unsigned width, height;
    bool grows; /* these are pixels of a plain display */
    bool fullscreen;
} window_place;

/* Opens a window and makes its context current. NULL with a reason on failure. */
window *window_open(const char *title, const window_place *place, svo_message *why);
void window_close(window **which);

/* Makes the context current again, after others used the thread. */
bool window_use(window *which, svo_message *why);

const view_gl *window_gl(const window *which);
/* The same context for the library; lives as long as the window. */
svo_gl_context *window_context(const window *which);
/* The address of a function of OpenGL; NULL where there is none. */
void *window_find_function(const char *name);
/* Name of OpenGL's renderer; lives as long as the window. */
const char *window_renderer(const window *which);
void window_set_title(window *which, const char *title);
/* Pixels for each pixel of a plain display, in quarters, 1 .. 4: as the desktop says, where it does. */
float window_scale(const window *which);
/* Pixels of the window as it is now. */
void window_size(const window *which, unsigned *width, unsigned *height);

/* Takes the next event; false where there is none. */
bool window_poll(window *which, view_event *event);
/* Puts an event behind those that wait, as if a hand had made it. False where the queue is full. */
bool window_push(window *which, const view_event *event);

/* Takes the window off the screen. */
void window_hide(window *which);
void window_set_fullscreen(window *which, bool fullscreen);
/* Waits until all is drawn. */
void window_finish(window *which);
/* Shows what was drawn and waits for it. False with a reason on failure: the context is lost. */
bool window_show(window *which, svo_message *why);

/* Whether somebody closes the window. Takes no event. */
bool window_is_closing(window *which);

/* The text that was copied, until the next call; a text for other programs. user: the window. */
const char *window_read_clipboard(void *user);
void window_write_clipboard(void *user, const char *text);

/* Waits for an event, but no longer than so many milliseconds. */
void window_wait(window *which, unsigned milliseconds);

#endif
