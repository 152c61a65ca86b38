/* SPDX-License-Identifier: MIT */
/* What takes long is done by a thread, while the window answers and says how far it is: files that are opened among it.
   Pictures of the window as PNG files. */
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

/* ---- what is opened ---- */

/* Opens INPUT of the command line. Where that is canceled, the state says that the program is done. Returns the exit
   code. */
int opening_input(viewer *which);
/* Opens the file that the state asks for, if it does, in place of what is shown. Where that fails or is canceled,
   everything stays, and a box says why. Returns the exit code. */
int opening_take(viewer *which);
/* Writes the voxels that the state wants to be saved. Returns the exit code: where that fails, the question says so. */
int saving_take(viewer *which);
/* Closes what is shown. */
void opening_close(viewer *which);

/* ---- pictures ---- */

/* Writes what was drawn of the frame. Returns the exit code. */
int shots_take(viewer *which, const char *path, unsigned width, unsigned height);
/* The same under a name that no file has, if the state asks for this kind and the picture is there in full; a box says
   why it failed. */
void shots_save(viewer *which, view_shot shot);

#endif
