/* SPDX-License-Identifier: MIT */
/* The list of figures, and how rows of a table become panels, curves and points. */
#include "charts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "page/chart_script.h"
#include "page/text.h"

static const chart_figure figures[] = {
    {"e1-voxelization",
     "e1",
     "Wrong voxels against time, one point per grid, each twice as fine as the one before. Down and left is better. "
     "Rings mark "
     "the Pareto front of each grid; 0 stands on the floor.",
     {"scene", NULL},
     "way",
     "time",
     {"error"},
     "time, ms",
     "missed and surplus voxels, %",
     FRONT_ALL,
     "grid edge"},
    {"e2-rays",
     "e2",
     "Wrong rays against time per ray, one point per mesh. Rings mark the Pareto front of each mesh.",
     {"rays aimed", NULL},
     "way",
     "time",
     {"error"},
     "time, ns per ray",
     "missed and wrong rays, %",
     FRONT_ALL,
     "triangles"},
    {"e2-rays",
     "e2t",
     "How far t is off where the hit is right, relative to t.",
     {"rays aimed", NULL},
     "way",
     "time",
     {"error of t, mean"},
     "time, ns per ray",
     "|t − exact| / exact, mean",
     FRONT_ALL,
     "triangles"},
    {"e3-attributes",
     "e3",
     "Mean error of a voxel's attribute against time, one point per depth. Rings mark the Pareto front of each depth.",
     {"attribute", NULL},
     "way",
     "time",
     {"error, mean"},
     "time, ms",
     "error, mean",
     FRONT_ALL,
     "depth"},
    {"e3-attributes",
     "e3o",
     "The largest difference between two orders of the same samples.",
     {"attribute", NULL},
     "way",
     "time",
     {"order, largest"},
     "time, ms",
     "largest difference",
     FRONT_ALL,
     "depth"},
    {"e4-detail",
     "e4",
     "What each depth loses against the time to build it, one point per depth. Rings mark each measure's own Pareto "
     "front.",
     {"scene", NULL},
     NULL,
     "time",
     {"distance of centres", "area by faces, error", "volume, error", "area by fill, error"},
     "time, ms",
     "error, %",
     FRONT_EACH,
     NULL},
    {"e5-stiffness",
     "e5",
     "Error as meshes get stiffer: where a curve leaves its level, the way breaks.",
     {"of what", "stiffness"},
     "way",
     "value",
     {"error"},
     "stiffness",
     "error, %",
     FRONT_NONE,
     NULL},
    {"e5-stiffness",
     "e5t",
     "The same points against time. Rings mark the Pareto front of each mesh.",
     {"of what", "stiffness"},
     "way",
     "time",
     {"error"},
     "time, ms",
     "error, %",
     FRONT_ALL,
     "value"},
    {"builders",
     "b1",
     "Nodes and their links, level by level.",
     {"scene", NULL},
     "builder",
     "depth",
     {"subdivide"},
     "depth",
     "subdivide, ms",
     FRONT_NONE,
     NULL},
    {"builders",
     "b2",
     "Sorted leaf lists.",
     {"scene", NULL},
     "builder",
     "depth",
     {"pack"},
     "depth",
     "pack, ms",
     FRONT_NONE,
     NULL},
    {"builders",
     "b3",
     "Payload, from the leaves to the root.",
     {"scene", NULL},
     "builder",
     "depth",
     {"filter"},
     "depth",
     "filter, ms",
     FRONT_NONE,
     NULL},
    {"builders",
     "b4",
     "All of it, from the fragment list to the finished tree.",
     {"scene", NULL},
     "builder",
     "depth",
     {"list to tree"},
     "depth",
     "list to tree, ms",
     FRONT_NONE,
     NULL},
    {"e6-leaving-out",
     "e6t",
     "Time from the mesh to the finished tree, by what is asked for.",
     {"scene", NULL},
     "need",
     NULL,
     {"build"},
     "time, ms",
     "",
     FRONT_NONE,
     NULL},
    {"e6-leaving-out",
     "e6b",
     "The largest sum of bytes allocated at one time.",
     {"scene", NULL},
     "need",
     NULL,
     {"peak"},
     "bytes",
     "",
     FRONT_NONE,
     NULL},
    {"e6-leaving-out",
     "e6k",
     "Bytes of the tree that stays.",
     {"scene", NULL},
     "need",
     NULL,
     {"tree"},
     "bytes",
     "",
     FRONT_NONE,
     NULL},
    {"memory",
     "mem",
     "Bytes by depth: what a build holds, beside a full octree.",
     {NULL, NULL},
     NULL,
     "depth",
     {"full octree", "list of 36 bytes", "fragment list", "peak", "tree"},
     "depth",
     "bytes",
     FRONT_NONE,
     NULL},
};

const chart_figure *charts_of(const char *table_id, size_t index)
{
    for (size_t i = 0; i < sizeof figures / sizeof figures[0]; ++i) {
        if (strcmp(figures[i].table_id, table_id) == 0 && index-- == 0) {
            return &figures[i];
        }
    }
    return NULL;
}

/* ---- rows to points ---- */

static const char *text_at(const result_table *table, size_t row, size_t column)
{
    const result_cell *cell = result_cell_at(table, row, column);
    return cell != NULL && cell->kind == RESULT_TEXT ? cell->text : "";
}

static double number_at(const result_table *table, size_t row, size_t column)
{
    const result_cell *cell = result_cell_at(table, row, column);
    return cell != NULL && cell->kind == RESULT_NUMBER ? cell->number : NAN;
}

static bool has_columns(const chart_figure *figure, const result_table *table)
{
    const char *const single[] = {figure->panels[0], figure->panels[1], figure->curves, figure->x, figure->size};
    bool all = true;
    for (size_t i = 0; i < sizeof single / sizeof single[0]; ++i) {
        all = all && (single[i] == NULL || result_find_column(table, single[i]) < table->column_count);
    }
    for (size_t i = 0; i < CHART_YS_MAX && figure->ys[i] != NULL; ++i) {
        all = all && result_find_column(table, figure->ys[i]) < table->column_count;
    }
    return all;
}

/* What a row's chart is called: the texts of the panel columns. */
static void panel_name(const chart_figure *figure, const result_table *table, size_t row, char *name, size_t name_bytes)
{
    size_t used = 0;
    name[0] = '\0';
    for (size_t i = 0; i < 2 && figure->panels[i] != NULL && used < name_bytes; ++i) {
        used += (size_t)snprintf(name + used, name_bytes - used, "%s%s", i > 0 ? ": " : "",
                                 text_at(table, row, result_find_column(table, figure->panels[i])));
    }
}

static void add_row(const chart_figure *figure, const result_table *table, size_t row, chart_points *points)
{
    const double x = figure->x != NULL ? number_at(table, row, result_find_column(table, figure->x)) : 0.0;
    const double size = figure->size != NULL ? number_at(table, row, result_find_column(table, figure->size)) : 0.0;
    for (size_t i = 0; i < CHART_YS_MAX && figure->ys[i] != NULL; ++i) {
        const char *curve =
            figure->curves != NULL ? text_at(table, row, result_find_column(table, figure->curves)) : figure->ys[i];
        const double y = number_at(table, row, result_find_column(table, figure->ys[i]));
        chart_points_add(points, curve, &(chart_point){.x = x, .y = y, .size = size});
    }
}

/* ---- the figure ---- */

static int draw_panel(program *state, const chart_figure *figure, const result_table *table, const chart_points *all,
                      size_t first_row, unsigned panel, FILE *page)
{
    char wanted[256];
    char own[256];
    char name[64];
    chart_points points = {0};
    panel_name(figure, table, first_row, wanted, sizeof wanted);
    for (size_t row = first_row; row < result_row_count(table); ++row) {
        panel_name(figure, table, row, own, sizeof own);
        if (strcmp(wanted, own) == 0) {
            add_row(figure, table, row, &points);
        }
    }
    snprintf(name, sizeof name, "%s_%u", figure->name, panel);
    fputs("<div class=\"panel\">", page);
    if (wanted[0] != '\0') {
        fputs("<h4>", page);
        text_escape(wanted, page);
        fputs("</h4>\n", page);
    }
    const int exit_code = chart_points_draw(state, figure, &points, all, name, wanted, page);
    fputs("</div>\n", page);
    chart_points_free(&points);
    return exit_code;
}

/* Whether an earlier row has the same panel. */
static bool is_drawn(const chart_figure *figure, const result_table *table, size_t row)
{
    char own[256];
    char other[256];
    panel_name(figure, table, row, own, sizeof own);
    for (size_t before = 0; before < row; ++before) {
        panel_name(figure, table, before, other, sizeof other);
        if (strcmp(own, other) == 0) {
            return true;
        }
    }
    return false;
}

int charts_draw(program *state, const chart_figure *figure, const result_table *table, FILE *page)
{
    if (!has_columns(figure, table) || result_row_count(table) == 0) {
        return PROGRAM_DONE;
    }
    int exit_code = PROGRAM_DONE;
    unsigned panel = 0;
    chart_points all = {0};
    for (size_t row = 0; row < result_row_count(table); ++row) {
        add_row(figure, table, row, &all);
    }
    fputs("<figure>\n", page);
    if (figure->x != NULL) {
        chart_points_legend(&all, page);
    }
    fputs("<div class=\"panels\">\n", page);
    for (size_t row = 0; row < result_row_count(table) && exit_code == PROGRAM_DONE; ++row) {
        if (!is_drawn(figure, table, row)) {
            exit_code = draw_panel(state, figure, table, &all, row, ++panel, page);
        }
    }
    chart_points_free(&all);
    fputs("</div>\n<figcaption>", page);
    text_escape(figure->caption, page);
    fputs("</figcaption>\n</figure>\n", page);
    return exit_code;
}
