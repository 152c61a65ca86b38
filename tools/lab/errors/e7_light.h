/* SPDX-License-Identifier: MIT */
/* Table "e7-light": each kind of light at points, by cones and by rays, beside paths through the triangles. */
#ifndef SVOCL_TOOLS_ERRORS_E7_LIGHT_H
#define SVOCL_TOOLS_ERRORS_E7_LIGHT_H

#include "errors/cones.h"

/* Adds the table with its columns. */
void e7_light_begin(const error_run *run);

/* Adds the rows of a scene, at some of its truth's points. False on failure, with the reason in the device's message or
   for lack of memory. */
bool e7_light_measure(const error_run *run, cone_lights *lights, unsigned depth);

#endif
