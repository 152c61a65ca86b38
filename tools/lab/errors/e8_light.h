/* SPDX-License-Identifier: MIT */
/* The part of E8 that is about light: rays through probes and prefiltered probes, beside cones and paths. */
#ifndef SVOCL_TOOLS_ERRORS_E8_LIGHT_H
#define SVOCL_TOOLS_ERRORS_E8_LIGHT_H

#include "errors/cones.h"

/* Adds the table with its columns. */
void e8_light_begin(const error_run *run);

/* Measures all methods on the trees of one depth, and adds their rows. False on failure. */
bool e8_light_measure(const error_run *run, cone_lights *lights, unsigned depth);

#endif
