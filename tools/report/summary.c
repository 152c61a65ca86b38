/* SPDX-License-Identifier: MIT */
/* A few rows and columns of the tables that matter most, as Markdown. */
#include "report/summary.h"

#include <math.h>
#include <string.h>

#include "report/text.h"

#define PICKS_MAX   2
#define COLUMNS_MAX 8

/* Rows whose column has that text, or, without a text, the column's largest number. */
typedef struct pick {
    const char *column, *text;
} pick;

typedef struct extract {
    const char *table_id, *title;
    pick picks[PICKS_MAX]; /* a column of NULL: none */
    const char *columns[COLUMNS_MAX]; /* ends with NULL */
} extract;

static const extract extracts[] = {
    {"e1-voxelization",
     "Voxels of the statue on the finest grid",
     {{"scene", "statue"}, {"grid edge", NULL}},
     {"method", "time", "false negatives", "false positives"}},
    {"e2-rays",
     "Rays aimed at edges",
     {{"rays", "at edges"}, {"triangles", NULL}},
     {"method", "time", "error", "error of t, mean"}},
    {"e3-attributes",
     "Colors of voxels, in 1/255",
     {{"attribute", "color, 1/255"}, {"depth", NULL}},
     {"method", "time", "error, mean", "error, largest", "order, largest"}},
    {"builders",
     "Builders",
     {{"depth", NULL}, {NULL, NULL}},
     {"scene", "builder", "subdivide", "pack", "filter", "list to tree", "ratio"}},
    {"e6-leaving-out",
     "Time and bytes of each need",
     {{"depth", NULL}, {NULL, NULL}},
     {"need", "build", "peak", "tree"}},
    {"thesis-2020",
     "Octree-building thesis (2020), depth 6",
     {{"depth", NULL}, {NULL, NULL}},
     {"scene", "voxelize", "structure", "total", "published structure, least", "published structure, most"}},
    {"thesis-2016",
     "Voxel cone tracing thesis (2016), 512³",
     {{"voxels per axis", NULL}, {NULL, NULL}},
     {"system", "fragment list", "full octree", "sparse octree", "voxelize", "first build", "second build"}},
    {"rays", "Rays, compared with Embree", {{NULL, NULL}, {NULL, NULL}}, {"scene", "rays", "svocl", "Embree", "ratio"}},
};

static bool fits(const result_table *table, size_t row, const pick *wanted)
{
    if (wanted->column == NULL) {
        return true;
    }
    const size_t column = result_find_column(table, wanted->column);
    const result_cell *cell = result_cell_at(table, row, column);
    if (cell == NULL || wanted->text != NULL) {
        return cell != NULL && cell->kind == RESULT_TEXT && strcmp(cell->text, wanted->text) == 0;
    }
    double most = -HUGE_VAL;
    for (size_t i = 0; i < result_row_count(table); ++i) {
        const result_cell *other = result_cell_at(table, i, column);
        most = other->kind == RESULT_NUMBER ? fmax(most, other->number) : most;
    }
    return cell->kind == RESULT_NUMBER && cell->number == most;
}

static void write_heads(const extract *wanted, const result_table *table, FILE *text)
{
    fputs("|", text);
    for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
        const char *unit = "";
        const size_t column = result_find_column(table, wanted->columns[i]);
        if (column < table->column_count) {
            text_choose_unit(table, column, &unit);
        }
        fprintf(text, " %s%s%s |", wanted->columns[i], unit[0] != '\0' ? ", " : "", unit);
    }
    fputs("\n|", text);
    for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
        const result_cell *cell = result_cell_at(table, 0, result_find_column(table, wanted->columns[i]));
        fputs(cell != NULL && cell->kind == RESULT_TEXT ? " --- |" : " ---: |", text);
    }
    fputs("\n", text);
}

static void write_row(const extract *wanted, const result_table *table, size_t row, FILE *text)
{
    fputs("|", text);
    for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
        const char *unit = "";
        const size_t column = result_find_column(table, wanted->columns[i]);
        const result_cell *cell = result_cell_at(table, row, column);
        if (cell != NULL && cell->kind == RESULT_NUMBER) {
            fprintf(text, " %s |", text_format_number(cell->number / text_choose_unit(table, column, &unit)).text);
        } else {
            fprintf(text, " %s |", cell != NULL && cell->kind == RESULT_TEXT ? cell->text : "");
        }
    }
    fputs("\n", text);
}

void summary_write(const result_set *results, FILE *text)
{
    const result_machine *machine = &results->machine;
    fprintf(text, "On %s, driver %s, OpenGL by %s, %u threads, svocl %s.\n", machine->device, machine->driver,
            machine->renderer, machine->cpu_threads, machine->svocl);
    for (size_t i = 0; i < sizeof extracts / sizeof extracts[0]; ++i) {
        const result_table *table = result_find(results, extracts[i].table_id);
        if (table == NULL) {
            continue;
        }
        fprintf(text, "\n**%s**\n\n", extracts[i].title);
        write_heads(&extracts[i], table, text);
        for (size_t row = 0; row < result_row_count(table); ++row) {
            if (fits(table, row, &extracts[i].picks[0]) && fits(table, row, &extracts[i].picks[1])) {
                write_row(&extracts[i], table, row, text);
            }
        }
    }
}
