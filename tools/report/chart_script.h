/* SPDX-License-Identifier: MIT */
/* The points of one chart, and the gnuplot script that they become. */
#ifndef SVOCL_TOOLS_REPORT_CHART_SCRIPT_H
#define SVOCL_TOOLS_REPORT_CHART_SCRIPT_H

#include "report/charts.h"

#define CHART_CURVES_MAX 32u

typedef struct chart_point {
    size_t curve;
    double x, y;
    double size; /* of the work: points of the same size are compared */
} chart_point;

typedef struct chart_points {
    const char *curves[CHART_CURVES_MAX]; /* borrowed names, in order of appearance */
    size_t curve_count;
    chart_point *points;
    size_t count, capacity;
    bool failed; /* out of memory, or too many curves */
} chart_points;

/* A point that is not finite is left out; its curve is known all the same. */
void chart_points_add(chart_points *points, const char *curve, const chart_point *point);
void chart_points_free(chart_points *points);

/* The names of the curves with their lines and markers. */
void chart_points_legend(const chart_points *points, FILE *page);
/* all: of the whole figure, for its axes. name: of the picture; what: its title for readers who do not see it. Returns
   the exit code. */
int chart_points_draw(program *state, const chart_figure *figure, const chart_points *points, const chart_points *all,
                      const char *name, const char *what, FILE *page);

#endif
