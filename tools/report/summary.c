/* SPDX-License-Identifier: MIT */
/* One list of extracts serves summary.md and the marked tables of docs/. */
#include "report/summary.h"

#include <math.h>
#include <string.h>

#include "report/table_html.h"
#include "report/text.h"

#define PICKS_MAX   3
#define COLUMNS_MAX 12

/* Rows whose column has that text. Without a text: those with the column's largest number among the rows that the picks
   before leave. */
typedef struct pick {
    const char *column, *text;
} pick;

struct summary_extract {
    const char *id; /* in the markers of docs/ */
    const char *table_id, *title;
    bool in_summary;
    pick picks[PICKS_MAX]; /* a column of NULL: no more */
    const char *columns[COLUMNS_MAX]; /* ends with NULL */
};

static const summary_extract extracts[] = {
    /* README.md */
    {"exactness",
     "e1-voxelization",
     "Voxels of the statue on the finest grid",
     false,
     {{"scene", "statue"}, {"grid edge", NULL}},
     {"method", "time", "missed", "surplus"}},
    /* docs/performance.md */
    {"stages",
     "builders",
     "A build, stage by stage",
     false,
     {{"builder", "cl"}, {"depth", NULL}},
     {"scene", "triangles", "fragments", "nodes", "voxelize", "transfer", "subdivide", "link", "pack", "filter",
      "total"}},
    {"frontends",
     "voxelize",
     "Front ends",
     false,
     {{"depth", NULL}},
     {"scene", "fragments", "frontend", "share", "voxelize", "transfer", "rate", "ratio"}},
    {"filter",
     "filter",
     "Payload by weights",
     false,
     {{"depth", NULL}},
     {"scene", "nodes", "payload", "weights", "filter", "list to tree", "ratio"}},
    {"startup", "startup", "Start-up", false, {{NULL}}, {"method", "cold", "cold compile", "warm", "warm compile"}},
    {"rays",
     "rays",
     "Rays beside Embree",
     true,
     {{NULL}},
     {"scene", "triangles", "rays", "svocl", "Embree", "ratio", "wrong", "Embree wrong"}},
    {"ray-structures",
     "peer-embree",
     "Building what rays need",
     false,
     {{NULL}},
     {"scene", "triangles", "depth", "svocl tree", "BVH", "svocl", "BVH time", "Embree", "ratio"}},
    {"builders",
     "builders",
     "Builders",
     true,
     {{"depth", NULL}},
     {"scene", "builder", "subdivide", "link", "pack", "filter", "list to tree", "ratio"}},
    {"share",
     "share",
     "Share paths",
     false,
     {{"depth", NULL}},
     {"scene", "list", "frontend", "share", "voxelize", "transfer", "ratio"}},
    {"leaving-out",
     "e6-leaving-out",
     "Leaving out",
     true,
     {{"depth", NULL}},
     {"need", "builder", "build", "peak", "tree", "tree per leaf", "ratio"}},
    {"sizes",
     "scene-sizes",
     "From no triangle to a million",
     false,
     {{NULL}},
     {"triangles", "need", "leaves", "peak", "tree", "build"}},
    {"memory",
     "memory",
     "Bytes of occupancy alone",
     false,
     {{NULL}},
     {"scene", "depth", "leaves", "tree", "tree per leaf", "fragment list", "full octree", "list of 36 bytes"}},
    {"thesis-2020",
     "thesis-2020",
     "Beside the thesis of 2020, depth 6",
     true,
     {{"depth", NULL}},
     {"scene", "voxelize", "structure", "total", "published structure, least", "published structure, most"}},
    {"thesis-2016",
     "thesis-2016",
     "Beside the thesis of 2016, 512³",
     true,
     {{"voxels per axis", NULL}},
     {"whose", "fragment list", "full octree", "sparse octree", "voxelize", "first build", "second build"}},
    /* docs/accuracy.md */
    {"e1",
     "e1-voxelization",
     "Voxels of the statue on the finest grid",
     true,
     {{"scene", "statue"}, {"grid edge", NULL}},
     {"method", "aims at", "time", "missed", "surplus", "false negatives", "false positives"}},
    {"e2-corners",
     "e2-rays",
     "Rays aimed at corners",
     false,
     {{"rays aimed", "at corners"}, {"triangles", NULL}},
     {"method", "time", "missed", "wrong", "error", "error of t, mean", "error of t, largest"}},
    {"e2-edges",
     "e2-rays",
     "Rays aimed at edges",
     true,
     {{"rays aimed", "at edges"}, {"triangles", NULL}},
     {"method", "time", "missed", "wrong", "error", "error of t, mean", "error of t, largest"}},
    {"e3-color",
     "e3-attributes",
     "Colors of voxels, in 1/255",
     true,
     {{"attribute", "color, 1/255"}, {"depth", NULL}},
     {"method", "time", "error, mean", "error, 99 % below", "error, largest", "order, largest"}},
    {"e3-normal",
     "e3-attributes",
     "Normals of voxels, in degrees",
     false,
     {{"attribute", "normal, degrees"}, {"depth", NULL}},
     {"method", "time", "error, mean", "error, 99 % below", "error, largest", "order, largest"}},
    {"e4",
     "e4-detail",
     "Levels of detail",
     false,
     {{NULL}},
     {"scene", "depth", "voxels", "size", "time", "distance of centers", "area by fill, error", "area by faces, error",
      "volume, error"}},
};

const summary_extract *summary_find(const char *id)
{
    for (size_t i = 0; i < sizeof extracts / sizeof extracts[0]; ++i) {
        if (strcmp(extracts[i].id, id) == 0) {
            return &extracts[i];
        }
    }
    return NULL;
}

/* ---- rows ---- */

static bool has_text(const result_cell *cell, const char *text)
{
    return cell != NULL && cell->kind == RESULT_TEXT && strcmp(cell->text, text) == 0;
}

/* Whether the first pick_count picks leave the row. */
static bool fits(const result_table *table, size_t row, const pick *picks, size_t pick_count)
{
    for (size_t i = 0; i < pick_count && picks[i].column != NULL; ++i) {
        const size_t column = result_find_column(table, picks[i].column);
        const result_cell *cell = result_cell_at(table, row, column);
        if (picks[i].text != NULL && !has_text(cell, picks[i].text)) {
            return false;
        }
        if (picks[i].text != NULL) {
            continue;
        }
        double most = -HUGE_VAL;
        for (size_t other = 0; other < result_row_count(table); ++other) {
            const result_cell *beside = result_cell_at(table, other, column);
            if (beside != NULL && beside->kind == RESULT_NUMBER && fits(table, other, picks, i)) {
                most = fmax(most, beside->number);
            }
        }
        if (cell == NULL || cell->kind != RESULT_NUMBER || cell->number < most) {
            return false;
        }
    }
    return true;
}

/* Whether the table has what the extract names. */
static bool is_there(const summary_extract *wanted, const result_table *table)
{
    if (table == NULL) {
        return false;
    }
    for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
        if (result_find_column(table, wanted->columns[i]) == table->column_count) {
            return false;
        }
    }
    for (size_t row = 0; row < result_row_count(table); ++row) {
        if (fits(table, row, wanted->picks, PICKS_MAX)) {
            return true;
        }
    }
    return false;
}

/* ---- Markdown ---- */

static void write_text(const char *cell, FILE *text)
{
    for (const char *c = cell; *c != '\0'; ++c) {
        fputs(*c == '|' ? "\\" : "", text);
        fputc(*c, text);
    }
}

static void write_heads(const summary_extract *wanted, const result_table *table, FILE *text)
{
    fputs("|", text);
    for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
        const char *unit = "";
        table_html_unit(table, result_find_column(table, wanted->columns[i]), &unit);
        fprintf(text, " %s%s%s |", wanted->columns[i], unit[0] != '\0' ? ", " : "", unit);
    }
    fputs("\n|", text);
    for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
        const result_cell *cell = result_cell_at(table, 0, result_find_column(table, wanted->columns[i]));
        fputs(cell->kind == RESULT_TEXT ? " --- |" : " ---: |", text);
    }
    fputs("\n", text);
}

static void write_row(const summary_extract *wanted, const result_table *table, size_t row, FILE *text)
{
    fputs("|", text);
    for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
        const char *unit = "";
        const size_t column = result_find_column(table, wanted->columns[i]);
        const result_cell *cell = result_cell_at(table, row, column);
        fputc(' ', text);
        if (cell->kind == RESULT_NUMBER) {
            fputs(text_format_number(cell->number / table_html_unit(table, column, &unit)).text, text);
        } else if (cell->kind == RESULT_TEXT) {
            write_text(cell->text, text);
        }
        fputs(" |", text);
    }
    fputs("\n", text);
}

bool summary_write_extract(const summary_extract *wanted, const result_set *results, FILE *text)
{
    const result_table *table = result_find(results, wanted->table_id);
    if (!is_there(wanted, table)) {
        return false;
    }
    write_heads(wanted, table, text);
    for (size_t row = 0; row < result_row_count(table); ++row) {
        if (fits(table, row, wanted->picks, PICKS_MAX)) {
            write_row(wanted, table, row, text);
        }
    }
    return true;
}

static void write_fact(const char *name, const char *fact, const char *more, FILE *text)
{
    if (fact[0] == '\0') {
        return;
    }
    fprintf(text, "| %s | ", name);
    write_text(fact, text);
    write_text(more, text);
    fputs(" |\n", text);
}

void summary_write_machine(const result_machine *machine, FILE *text)
{
    char driver[RESULT_FACT_BYTES + 16];
    char date[RESULT_FACT_BYTES + 16];
    char threads[16];
    snprintf(driver, sizeof driver, ", driver %s", machine->driver);
    snprintf(date, sizeof date, "%s%s", machine->date[0] != '\0' ? ", " : "", machine->date);
    snprintf(threads, sizeof threads, "%u", machine->cpu_threads);
    fputs("| measured on | |\n| --- | --- |\n", text);
    write_fact("OpenCL", machine->device, driver, text);
    write_fact("OpenGL", machine->renderer, "", text);
    write_fact("instruction set", machine->instruction_set, "", text);
    write_fact("threads", threads, "", text);
    write_fact("svocl", machine->svocl, date, text);
}

void summary_write(const result_set *results, FILE *text)
{
    summary_write_machine(&results->machine, text);
    for (size_t i = 0; i < sizeof extracts / sizeof extracts[0]; ++i) {
        if (extracts[i].in_summary && is_there(&extracts[i], result_find(results, extracts[i].table_id))) {
            fprintf(text, "\n**%s**\n\n", extracts[i].title);
            summary_write_extract(&extracts[i], results, text);
        }
    }
}
