/* SPDX-License-Identifier: MIT */
/* One chart: gnuplot in a child process draws it, and what it drew is made fit to stand in a page. */
#ifndef SVOCL_TOOLS_REPORT_PLOT_H
#define SVOCL_TOOLS_REPORT_PLOT_H

#include <stdio.h>

#include "support/program.h"

/* Whether gnuplot is there: before long work. Returns the exit code. */
int plot_check(program *state);

/*
 * Writes the script's picture as an <svg class="chart"> to page: colors of the palette as variables of the style sheet,
 * black as the color of the text around it, nothing that is looked for outside, and names that begin with name.
 *
 * script: gnuplot commands behind "set terminal". label: what a reader is told who does not see it. Returns the exit
 * code.
 */
int plot_draw(program *state, const char *script, const char *name, const char *label, unsigned width, unsigned height,
              FILE *page);

#endif
