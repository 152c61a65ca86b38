/* SPDX-License-Identifier: MIT */
/* The list of figures, and how rows of a table become panels, curves and points. */
#include "report/charts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report/chart_script.h"
#include "report/text.h"

static const chart_figure figures[] = {
    {.table_id = "e1-voxelization",
     .name = "e1",
     .caption = "Wrong voxels against time, one point per grid, each twice as fine as the one before. Down and left is "
                "better. Rings mark the Pareto front of each grid; 0 stands on the floor.",
     .panels = {"scene"},
     .curves = "method",
     .x = "time",
     .ys = {"error"},
     .x_label = "time, ms",
     .y_label = "missed and surplus voxels, %",
     .front = FRONT_ALL,
     .size = "grid edge"},
    {.table_id = "e2-rays",
     .name = "e2",
     .caption = "Wrong rays against time per ray, one point per mesh. Rings mark the Pareto front of each mesh. Voxels "
                "alone name no triangle: they are in the next figure.",
     .without = "voxels alone",
     .panels = {"rays aimed"},
     .curves = "method",
     .x = "time",
     .ys = {"error"},
     .x_label = "time, ns per ray",
     .y_label = "missed and wrong rays, %",
     .front = FRONT_ALL,
     .size = "triangles"},
    {.table_id = "e2-rays",
     .name = "e2t",
     .caption = "How far t is off where the hit is right, relative to t.",
     .panels = {"rays aimed"},
     .curves = "method",
     .x = "time",
     .ys = {"error of t, mean"},
     .x_label = "time, ns per ray",
     .y_label = "|t − exact| / exact, mean",
     .front = FRONT_ALL,
     .size = "triangles"},
    {.table_id = "e3-attributes",
     .name = "e3",
     .caption =
         "Mean error of a voxel's attribute against time, one point per depth. Rings mark the Pareto front of each "
         "depth.",
     .panels = {"attribute"},
     .curves = "method",
     .x = "time",
     .ys = {"error, mean"},
     .x_label = "time, ms",
     .y_label = "error, mean",
     .front = FRONT_ALL,
     .size = "depth"},
    {.table_id = "e3-attributes",
     .name = "e3o",
     .caption = "The largest difference between two orders of the same samples.",
     .panels = {"attribute"},
     .curves = "method",
     .x = "time",
     .ys = {"order, largest"},
     .x_label = "time, ms",
     .y_label = "largest difference",
     .front = FRONT_ALL,
     .size = "depth"},
    {.table_id = "e4-detail",
     .name = "e4",
     .caption = "What each depth loses against the time to build it, one point per depth. Rings mark each measure's "
                "own Pareto front.",
     .panels = {"scene"},
     .x = "time",
     .ys = {"distance of centers", "area by faces, error", "volume, error", "area by fill, error"},
     .x_label = "time, ms",
     .y_label = "error, %",
     .front = FRONT_EACH},
    {.table_id = "e5-conditioning",
     .name = "e5v",
     .caption = "Voxelization as triangles get stiffer: where a curve leaves its level, the way breaks.",
     .only = {"of what", "voxelization"},
     .panels = {"conditioning"},
     .curves = "method",
     .x = "value",
     .ys = {"error"},
     .x_label = "conditioning",
     .y_label = "missed and surplus voxels, %"},
    {.table_id = "e5-conditioning",
     .name = "e5r",
     .caption = "Rays as meshes get stiffer.",
     .only = {"of what", "rays"},
     .panels = {"conditioning"},
     .curves = "method",
     .x = "value",
     .ys = {"error"},
     .x_label = "conditioning",
     .y_label = "missed and wrong rays, %"},
    {.table_id = "e5-conditioning",
     .name = "e5vt",
     .caption = "The same voxels against time. Rings mark the Pareto front of each mesh.",
     .only = {"of what", "voxelization"},
     .panels = {"conditioning"},
     .curves = "method",
     .x = "time",
     .ys = {"error"},
     .x_label = "time, ms",
     .y_label = "missed and surplus voxels, %",
     .front = FRONT_ALL,
     .size = "value"},
    {.table_id = "e5-conditioning",
     .name = "e5rt",
     .caption = "The same rays against time.",
     .only = {"of what", "rays"},
     .panels = {"conditioning"},
     .curves = "method",
     .x = "time",
     .ys = {"error"},
     .x_label = "time, ms",
     .y_label = "missed and wrong rays, %",
     .front = FRONT_ALL,
     .size = "value"},
    {.table_id = "builders",
     .name = "builders",
     .caption =
         "Stage by stage: nodes level by level, sorted leaf lists, payload from the leaves to the root, and all of it "
         "from the fragment list to the finished tree.",
     .panels = {"scene"},
     .curves = "builder",
     .x = "depth",
     .ys = {"subdivide", "pack", "filter", "list to tree"},
     .x_label = "depth",
     .y_label = "ms",
     .apart = true},
    {.table_id = "e6-leaving-out",
     .name = "e6",
     .caption = "By what is asked for: time from the mesh to the finished tree, the largest sum of bytes allocated at "
                "one time, and the bytes of the tree that stays.",
     .panels = {"scene"},
     .curves = "need",
     .ys = {"build", "peak", "tree"},
     .apart = true},
    {.table_id = "memory",
     .name = "memory",
     .caption = "Bytes by depth: what a build holds, beside ways that keep all.",
     .x = "depth",
     .ys = {"full octree", "list of 36 bytes", "fragment list", "peak", "tree"},
     .x_label = "depth",
     .y_label = "bytes"},
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
    const char *const single[] = {figure->panels[0], figure->panels[1], figure->curves,
                                  figure->x,         figure->size,      figure->only[0]};
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

static bool is_shown(const chart_figure *figure, const result_table *table, size_t row)
{
    return figure->only[0] == NULL ||
           strcmp(text_at(table, row, result_find_column(table, figure->only[0])), figure->only[1]) == 0;
}

static void add_row(const chart_figure *figure, const result_table *table, size_t row, chart_points *points)
{
    if (!is_shown(figure, table, row)) {
        return;
    }
    const double x = figure->x != NULL ? number_at(table, row, result_find_column(table, figure->x)) : 0.0;
    const double size = figure->size != NULL ? number_at(table, row, result_find_column(table, figure->size)) : 0.0;
    for (size_t i = 0; i < CHART_YS_MAX && figure->ys[i] != NULL; ++i) {
        const char *curve =
            figure->curves != NULL ? text_at(table, row, result_find_column(table, figure->curves)) : figure->ys[i];
        if (figure->without != NULL && strncmp(curve, figure->without, strlen(figure->without)) == 0) {
            continue;
        }
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
        if (strcmp(wanted, own) == 0) { /* rows that are not shown add nothing */
            add_row(figure, table, row, &points);
        }
    }
    snprintf(name, sizeof name, "%s_%u", figure->name, panel);
    fputs("<div class=\"panel\">", page);
    if (wanted[0] != '\0') {
        fputs("<h4>", page);
        text_escape(wanted, page);
        if (figure->apart) {
            fprintf(page, ": %s", figure->ys[0]);
        }
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
        if (is_shown(figure, table, before) && strcmp(own, other) == 0) {
            return true;
        }
    }
    return false;
}

/* Every panel of the figure, on the same axes. */
static int draw_panels(program *state, const chart_figure *figure, const result_table *table, FILE *page)
{
    int exit_code = PROGRAM_DONE;
    unsigned panel = 0;
    chart_points all = {0};
    for (size_t row = 0; row < result_row_count(table); ++row) {
        add_row(figure, table, row, &all);
    }
    for (size_t row = 0; row < result_row_count(table) && exit_code == PROGRAM_DONE; ++row) {
        if (is_shown(figure, table, row) && !is_drawn(figure, table, row)) {
            exit_code = draw_panel(state, figure, table, &all, row, ++panel, page);
        }
    }
    chart_points_free(&all);
    return exit_code;
}

/* The panels of one y after the other. */
static int draw_apart(program *state, const chart_figure *figure, const result_table *table, FILE *page)
{
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; i < CHART_YS_MAX && figure->ys[i] != NULL && exit_code == PROGRAM_DONE; ++i) {
        char name[64];
        char label[128];
        const char *unit = table->columns[result_find_column(table, figure->ys[i])].unit;
        chart_figure one = *figure;
        snprintf(name, sizeof name, "%s_%zu", figure->name, i + 1);
        snprintf(label, sizeof label, "%s, %s", figure->ys[i], unit);
        one.name = name;
        one.ys[0] = figure->ys[i];
        one.ys[1] = NULL;
        one.y_label = label;
        one.x_label = figure->x != NULL ? figure->x_label : label;
        exit_code = draw_panels(state, &one, table, page);
    }
    return exit_code;
}

static void write_legend(const chart_figure *figure, const result_table *table, FILE *page)
{
    chart_points all = {0};
    for (size_t row = 0; row < result_row_count(table); ++row) {
        add_row(figure, table, row, &all);
    }
    chart_points_legend(&all, page);
    chart_points_free(&all);
}

int charts_draw(program *state, const chart_figure *figure, const result_table *table, FILE *page)
{
    if (!has_columns(figure, table) || result_row_count(table) == 0) {
        return PROGRAM_DONE;
    }
    fputs("<figure>\n", page);
    if (figure->x != NULL) {
        write_legend(figure, table, page);
    }
    fputs("<div class=\"panels\">\n", page);
    const int exit_code =
        figure->apart ? draw_apart(state, figure, table, page) : draw_panels(state, figure, table, page);
    fputs("</div>\n<figcaption>", page);
    text_escape(figure->caption, page);
    fputs("</figcaption>\n</figure>\n", page);
    return exit_code;
}
