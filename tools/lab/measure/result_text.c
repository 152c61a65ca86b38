/* SPDX-License-Identifier: MIT */
/* Sets of tables as text: aligned columns for people, CSV for spreadsheets and plotters. */
#include "measure/result_text.h"

#include <math.h>
#include <string.h>

#include "support/table.h"

/* ---- for people ---- */

void result_print_machine(const result_set *set)
{
    const result_machine *machine = &set->machine;
    table *rows = table_create("ll");
    table_cell(rows, "opencl");
    table_cell(rows, "%s, driver %s, %s", machine->device, machine->driver, machine->platform);
    table_cell(rows, "opengl");
    table_cell(rows, "%s", machine->renderer);
    table_cell(rows, "threads");
    table_cell(rows, "%u", machine->cpu_threads);
    table_cell(rows, "svocl");
    table_cell(rows, "%s%s%s", machine->svocl, machine->date[0] != '\0' ? ", " : "", machine->date);
    table_print(rows);
}

/* Counts whole with separators, other figures with a few significant digits and no exponent where they are moderate. */
static figure figure_of(double number)
{
    const double size = fabs(number);
    figure result;
    if (number >= 0.0 && size < 1e15 && number == floor(number)) {
        return figure_count((uint64_t)number);
    }
    if (size >= 1e-3 && size < 1e15) {
        const int decimals = size >= 1000.0 ? 0 : size >= 100.0 ? 1 : size >= 1.0 ? 2 : 4;
        snprintf(result.text, sizeof result.text, "%.*f", decimals, number);
    } else {
        snprintf(result.text, sizeof result.text, "%.3g", number);
    }
    return result;
}

/* Numbers to the right; a column counts as numbers when one of its cells is. */
static char alignment_of(const result_table *results, size_t column)
{
    for (size_t row = 0; row < result_row_count(results); ++row) {
        if (result_cell_at(results, row, column)->kind == RESULT_NUMBER) {
            return 'r';
        }
    }
    return 'l';
}

/* Quartiles stand in the cell of their median: the columns that follow it in the text. */
static size_t next_shown(const result_table *results, size_t column)
{
    return column + (result_has_quartiles(results, column) ? 3 : 1);
}

static void print_heading(table *rows, const result_table *results, size_t column)
{
    const result_column *head = &results->columns[column];
    table_cell(rows, "%s%s%s%s", head->name, head->unit[0] != '\0' ? ", " : "", head->unit,
               !result_has_quartiles(results, column)                      ? ""
               : strstr(results->columns[column + 1].name, " low") != NULL ? " (low-high)"
                                                                           : " (q1-q3)");
}

static void print_cell(table *rows, const result_table *results, size_t row, size_t column)
{
    const result_cell *cell = result_cell_at(results, row, column);
    const bool ranged =
        result_has_quartiles(results, column) && cell[1].kind == RESULT_NUMBER && cell[2].kind == RESULT_NUMBER;
    if (cell->kind == RESULT_NUMBER && ranged) {
        table_cell(rows, "%s (%s-%s)", figure_of(cell->number).text, figure_of(cell[1].number).text,
                   figure_of(cell[2].number).text);
    } else if (cell->kind == RESULT_NUMBER) {
        table_cell(rows, "%s", figure_of(cell->number).text);
    } else {
        table_cell(rows, "%s", cell->kind == RESULT_TEXT ? cell->text : "-");
    }
}

void result_print(const result_table *results)
{
    char alignment[TABLE_COLUMNS_MAX + 1] = "";
    size_t shown[TABLE_COLUMNS_MAX];
    size_t count = 0;
    for (size_t column = 0; column < results->column_count && count < TABLE_COLUMNS_MAX;
         column = next_shown(results, column)) {
        shown[count] = column;
        alignment[count++] = alignment_of(results, column);
    }
    table_heading("%s: %s", results->id, results->title);
    table *rows = table_create(alignment);
    for (size_t i = 0; i < count; ++i) {
        print_heading(rows, results, shown[i]);
    }
    for (size_t row = 0; row < result_row_count(results); ++row) {
        for (size_t i = 0; i < count; ++i) {
            print_cell(rows, results, row, shown[i]);
        }
    }
    table_print(rows);
    if (results->note[0] != '\0') {
        table_line("%s", results->note);
    }
}

/* ---- CSV ---- */

static void write_text(const char *text, FILE *file)
{
    if (strpbrk(text, ",\"\r\n") == NULL) {
        fputs(text, file);
        return;
    }
    fputc('"', file);
    for (const char *c = text; *c != '\0'; ++c) {
        fputs(*c == '"' ? "\"\"" : (const char[]){*c, '\0'}, file);
    }
    fputc('"', file);
}

static void write_heading(const result_column *column, FILE *file)
{
    char text[512];
    snprintf(text, sizeof text, column->unit[0] != '\0' ? "%s [%s]" : "%s%s", column->name, column->unit);
    write_text(text, file);
}

static void write_cell(const result_cell *cell, FILE *file)
{
    if (cell->kind == RESULT_TEXT) {
        write_text(cell->text, file);
    } else if (cell->kind == RESULT_NUMBER) {
        fprintf(file, "%.12g", cell->number);
    }
}

void result_write_csv(const result_table *results, FILE *file)
{
    for (size_t column = 0; column < results->column_count; ++column) {
        fputs(column > 0 ? "," : "", file);
        write_heading(&results->columns[column], file);
    }
    fputs("\r\n", file);
    for (size_t row = 0; row < result_row_count(results); ++row) {
        for (size_t column = 0; column < results->column_count; ++column) {
            fputs(column > 0 ? "," : "", file);
            write_cell(result_cell_at(results, row, column), file);
        }
        fputs("\r\n", file);
    }
}
