/* SPDX-License-Identifier: MIT */
/*
 * A progress bar on standard error: steps, how far the current one is where it says so, and a running clock, in one
 * line, however narrow the terminal. It is drawn only on a terminal, and only after half a second of work. A separate
 * thread keeps the clock running during long calls.
 *
 * Every function accepts NULL, the bar of a program without a terminal, and then does nothing.
 */
#ifndef SVOCL_TOOLS_SUPPORT_PROGRESS_H
#define SVOCL_TOOLS_SUPPORT_PROGRESS_H

#include <stdbool.h>

typedef struct progress progress;

/* What a bar shows. */
typedef struct progress_view {
    const char *what; /* the current step: a static string; "" before the first one */
    const char *stage; /* of it: a static string, or NULL */
    unsigned step, step_count;
    double part; /* of the current step that is done, 0 .. 1 */
} progress_view;

/* Who else shows the bar, such as a window, and may stop the work. Both are called on the thread that works. */
typedef struct progress_watch {
    void (*see)(void *user, const progress_view *now); /* at each change */
    bool (*stops)(void *user); /* whether the work is to end */
    void *user;
} progress_watch;

/* title: a static string. step_count: the number of progress_step calls that follow. on_terminal: shown there, if
   there is one. watch: copied; NULL: nobody. NULL where neither shows it. */
progress *progress_create(const char *title, unsigned step_count, bool on_terminal, const progress_watch *watch);

/* The next step begins. what: a static string, "reading the mesh". */
void progress_step(progress *bar, const char *what);

/* How far the current step is, 0 .. 1, and what it is doing: a static string. */
void progress_part(progress *bar, const char *stage, double fraction);

/* Whether who watches wants the work to end. */
bool progress_stops(const progress *bar);

/* From now on the bar says how much time is left, if all steps take equally long. */
void progress_forecast(progress *bar);

/* While held, new steps are part of the current one. */
void progress_hold(progress *bar, bool held);

/* Removes the bar so that a line can be printed; it reappears by itself. */
void progress_hide(progress *bar);

/* Removes the bar and sets *bar to NULL. */
void progress_destroy(progress **bar);

#endif
