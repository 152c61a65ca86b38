/* SPDX-License-Identifier: MIT */
/* Sets of tables as text: aligned columns for people, CSV for spreadsheets and plotters. */
#include <math.h>
#include <string.h>

#include "result.h"
#include "table.h"

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

/* Counts whole with separators, other figures with four significant digits and no exponent where they are moderate. */
static void print_number(table *rows, double number)
{
    const double size = fabs(number);
    if (number >= 0.0 && size < 1e15 && number == floor(number)) {
        table_cell(rows, "%s", figure_count((uint64_t)number).text);
    } else if (size >= 1000.0 && size < 1e15) {
        table_cell(rows, "%.0f", number);
    } else if (size >= 1e-3 && size < 1000.0) {
        table_cell(rows, "%.*f", size >= 100.0 ? 1 : size >= 1.0 ? 2 : 4, number);
    } else {
        table_cell(rows, "%.3g", number);
    }
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

void result_print(const result_table *results)
{
    char alignment[TABLE_COLUMNS_MAX + 1] = "";
    const size_t shown = results->column_count < TABLE_COLUMNS_MAX ? results->column_count : TABLE_COLUMNS_MAX;
    for (size_t column = 0; column < shown; ++column) {
        alignment[column] = alignment_of(results, column);
    }
    table_heading("%s: %s", results->id, results->title);
    table *rows = table_create(alignment);
    for (size_t column = 0; column < shown; ++column) {
        const result_column *head = &results->columns[column];
        table_cell(rows, "%s%s%s", head->name, head->unit[0] != '\0' ? ", " : "", head->unit);
    }
    for (size_t row = 0; row < result_row_count(results); ++row) {
        for (size_t column = 0; column < shown; ++column) {
            const result_cell *cell = result_cell_at(results, row, column);
            if (cell->kind == RESULT_NUMBER) {
                print_number(rows, cell->number);
            } else {
                table_cell(rows, "%s", cell->kind == RESULT_TEXT ? cell->text : "-");
            }
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
