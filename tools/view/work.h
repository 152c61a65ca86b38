/* SPDX-License-Identifier: MIT */
/* What takes long is done by a thread, while the window answers and says how far it is. */
#ifndef SVOCL_TOOLS_VIEW_WORK_H
#define SVOCL_TOOLS_VIEW_WORK_H

#include "view/viewer.h"

/* Begins the thread, and has devices made for the window's context. Returns the exit code. */
int work_begin(viewer *which);
void work_end(viewer *which);

/* Has a function called on the thread, where cleanup_take comes first. name: of what is made. is_opening: a file, which
   has its box at once. Returns the function's exit code, with which->failure as its reason; which->work says whether it
   was canceled or the window was closed. */
int work_run(viewer *which, const char *name, bool is_opening, int (*made)(void *user), void *user);
/* Prints why work failed, unless that is printed already. Returns the exit code. */
int work_fail(viewer *which, int exit_code);

#endif
