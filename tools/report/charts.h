/* SPDX-License-Identifier: MIT */
/* Which charts a report draws from which table, and the drawing. */
#ifndef SVOCL_TOOLS_REPORT_CHARTS_H
#define SVOCL_TOOLS_REPORT_CHARTS_H

#include <stdio.h>

#include "measure/result.h"
#include "support/program.h"

#define CHART_YS_MAX 5

typedef enum chart_front {
    FRONT_NONE = 0,
    FRONT_ALL, /* the Pareto front of points of the same size of work: none of them is both faster and better */
    FRONT_EACH /* of each curve's own points */
} chart_front;

/* One figure: a chart for each value of the panel columns, on the same axes. */
typedef struct chart_figure {
    const char *table_id;
    const char *name; /* the charts' ids begin with it */
    const char *caption;
    const char *only[2]; /* rows whose column has that text; NULL: all */
    const char *without; /* curves whose names begin so are left out; NULL: none are */
    const char *panels[2]; /* columns of text; NULL: none */
    const char *curves; /* the column that names the curve; of bars: the bar. NULL: each of ys is one */
    const char *x; /* of curves; NULL: bars of ys[0] */
    const char *ys[CHART_YS_MAX]; /* columns; ends with NULL */
    const char *x_label, *y_label;
    chart_front front;
    bool apart; /* each of ys has charts of its own */
    const char *size; /* FRONT_ALL: the column of numbers that says what is the same size of work */
} chart_figure;

/* The figures of a table in their order; NULL past the last. */
const chart_figure *charts_of(const char *table_id, size_t index);

/* Writes the figure with its legend and caption; nothing where the table lacks a column of it. Returns the exit
   code. */
int charts_draw(program *state, const chart_figure *figure, const result_table *table, FILE *page);

#endif
