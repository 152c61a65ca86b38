/* SPDX-License-Identifier: MIT */
/* The window: SDL's, with a context of OpenGL 4.3 core. */
#ifndef SVOCL_TOOLS_VIEW_WINDOW_H
#define SVOCL_TOOLS_VIEW_WINDOW_H

#include "svocl/gl.h"
#include "view/events.h"
#include "view/gl.h"

typedef struct window window;

/* Opens a window and makes its context current. NULL with a reason on failure. */
window *window_open(const char *title, unsigned width, unsigned height, bool fullscreen, svo_message *why);
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
/* Pixels of the window as it is now. */
void window_size(const window *which, unsigned *width, unsigned *height);

/* Takes the next event; false where there is none. */
bool window_poll(window *which, view_event *event);
/* Puts an event behind those that wait, as if a hand had made it. False where the queue is full. */
bool window_push(window *which, const view_event *event);

void window_set_title(window *which, const char *title);
void window_set_fullscreen(window *which, bool fullscreen);
/* Shows what was drawn and waits for it. False with a reason on failure: the context is lost. */
bool window_show(window *which, svo_message *why);

/* Waits for an event, but no longer than so many milliseconds. */
void window_wait(window *which, unsigned milliseconds);

#endif
