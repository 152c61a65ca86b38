/* SPDX-License-Identifier: MIT */
/* Opens what is looked at, and files in its place. */
#ifndef SVOCL_TOOLS_VIEW_OPENING_H
#define SVOCL_TOOLS_VIEW_OPENING_H

#include "view/viewer.h"

/* Opens INPUT of the command line. Where that is canceled, the state says that the program is done. Returns the exit
   code. */
int opening_input(viewer *which);
/* Opens the file that the state asks for, if it does, in place of what is shown. Where that fails or is canceled,
   everything stays, and a box says why. Returns the exit code. */
int opening_take(viewer *which);
/* Closes what is shown. */
void opening_close(viewer *which);

#endif
