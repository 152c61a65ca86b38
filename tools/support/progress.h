/* SPDX-License-Identifier: MIT */
/*
 * A progress bar on standard error: a step counter with a running clock, drawn only when standard error is a terminal
 * and the work has taken longer than half a second. A thread of its own keeps the clock going during long calls.
 *
 * Every function allows NULL and then does nothing, which is what there is without a terminal.
 */
#ifndef SVOCL_TOOLS_SUPPORT_PROGRESS_H
#define SVOCL_TOOLS_SUPPORT_PROGRESS_H

#include <stdbool.h>

typedef struct progress progress;

/* title: a static string. step_count: how often progress_step will be called. NULL without a terminal. */
progress *progress_create(const char *title, unsigned step_count);

/* The next step begins. what: a static string, "reading the mesh". */
void progress_step(progress *bar, const char *what);

/* While held, steps that begin are part of the present one. */
void progress_hold(progress *bar, bool held);

/* Takes the bar away for now, so that a line can be printed; it comes back by itself. */
void progress_hide(progress *bar);

/* Takes the bar away and sets *bar to NULL. */
void progress_destroy(progress **bar);

#endif
