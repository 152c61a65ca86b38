/* SPDX-License-Identifier: MIT */
/* Columns are looked at first: what is a number, how many decimals there are, which are quartiles of the one before. */
#include "report/table_html.h"

#include <string.h>

#include "report/text.h"

#define COLUMNS_MAX   48u
#define FOLDED_ROWS   24u
#define FIGURE_SPACE  "\u2007" /* as wide as a digit */
#define POINT_SPACE   "\u2008" /* as wide as a point */
#define MISSING_FIELD "–"

typedef struct column_look {
    bool number;
    bool quartiles; /* the two columns behind it are its quartiles */
    bool hidden; /* is one of those */
    const char *unit;
    double divisor;
    size_t decimals;
} column_look;

/* ---- looking ---- */

static const result_cell *cell_at(const result_table *table, size_t row, size_t column)
{
    return result_cell_at(table, row, column);
}

double table_html_unit(const result_table *table, size_t column, const char **unit)
{
    double most = 0.0;
    *unit = table->columns[column].unit;
    if (strcmp(*unit, "B") != 0) {
        return 1.0;
    }
    for (size_t row = 0; row < result_row_count(table); ++row) {
        const result_cell *cell = cell_at(table, row, column);
        most = cell->kind == RESULT_NUMBER && cell->number > most ? cell->number : most;
    }
    *unit = most >= 0x1p20 ? "MiB" : most >= 0x1p13 ? "KiB" : "bytes";
    return most >= 0x1p20 ? 0x1p20 : most >= 0x1p13 ? 0x1p10 : 1.0;
}

static bool is_quartile(const result_table *table, size_t column, size_t of, const char *which)
{
    const char *name = table->columns[of].name;
    const size_t length = strlen(name);
    return column < table->column_count && strncmp(table->columns[column].name, name, length) == 0 &&
           strcmp(table->columns[column].name + length, which) == 0;
}

static size_t count_decimals(const char *number)
{
    const char *point = strchr(number, '.');
    return point == NULL || strstr(number, "×") != NULL ? 0 : strlen(point + 1);
}

static void look_at(const result_table *table, column_look *looks)
{
    for (size_t column = 0; column < table->column_count && column < COLUMNS_MAX; ++column) {
        column_look *look = &looks[column];
        look->divisor = table_html_unit(table, column, &look->unit);
        look->quartiles =
            is_quartile(table, column + 1, column, " q1") && is_quartile(table, column + 2, column, " q3");
        look->hidden = (column > 0 && looks[column - 1].quartiles) || (column > 1 && looks[column - 2].quartiles);
        for (size_t row = 0; row < result_row_count(table); ++row) {
            const result_cell *cell = cell_at(table, row, column);
            if (cell->kind == RESULT_NUMBER) {
                const size_t decimals = count_decimals(text_format_number(cell->number / look->divisor).text);
                look->number = true;
                look->decimals = decimals > look->decimals ? decimals : look->decimals;
            }
        }
    }
}

/* ---- writing ---- */

static void write_head(const result_table *table, const column_look *looks, FILE *page)
{
    fputs("<thead><tr>", page);
    for (size_t column = 0; column < table->column_count && column < COLUMNS_MAX; ++column) {
        const column_look *look = &looks[column];
        if (look->hidden) {
            continue;
        }
        fprintf(page, "<th%s%s>", look->number ? " class=\"n\"" : "", look->quartiles ? " colspan=\"2\"" : "");
        text_escape(table->columns[column].name, page);
        if (look->unit[0] != '\0') {
            fputs(" <span class=\"unit\">", page);
            text_escape(look->unit, page);
            fputs("</span>", page);
        }
        fputs("</th>", page);
    }
    fputs("</tr></thead>\n", page);
}

/* The number, and blanks as wide as the decimals that others of its column have. */
static void write_number(double number, size_t decimals, FILE *page)
{
    const text_number text = text_format_number(number);
    fputs(text.text, page);
    if (strstr(text.text, "×") != NULL) {
        return;
    }
    const size_t own = count_decimals(text.text);
    if (decimals > 0 && own == 0) {
        fputs(POINT_SPACE, page);
    }
    for (size_t i = own; i < decimals; ++i) {
        fputs(FIGURE_SPACE, page);
    }
}

static void write_quartiles(const result_table *table, const column_look *look, size_t row, size_t column, FILE *page)
{
    const result_cell *low = cell_at(table, row, column + 1);
    const result_cell *high = cell_at(table, row, column + 2);
    fputs("<td class=\"q\">", page);
    if (low->kind == RESULT_NUMBER && high->kind == RESULT_NUMBER) {
        fprintf(page, "%s–%s", text_format_number(low->number / look->divisor).text,
                text_format_number(high->number / look->divisor).text);
    }
    fputs("</td>", page);
}

static bool is_same(const result_cell *a, const result_cell *b)
{
    return a->kind == b->kind && (a->kind == RESULT_TEXT ? strcmp(a->text, b->text) == 0 : a->number == b->number);
}

static void write_cell(const result_cell *cell, const column_look *look, bool same, FILE *page)
{
    fprintf(page, "<td%s>",
            look->number && same ? " class=\"n same\""
            : look->number       ? " class=\"n\""
            : same               ? " class=\"same\""
                                 : "");
    if (cell->kind == RESULT_NUMBER) {
        write_number(cell->number / look->divisor, look->decimals, page);
    } else {
        text_escape(cell->kind == RESULT_TEXT ? cell->text : MISSING_FIELD, page);
    }
    fputs("</td>", page);
}

/* Leading cells that say the same as those above are written faintly; the first that differs begins a group. */
static void write_row(const result_table *table, const column_look *looks, size_t row, FILE *page)
{
    const bool begins = row > 0 && !is_same(cell_at(table, row, 0), cell_at(table, row - 1, 0));
    bool same = row > 0;
    fputs(begins ? "<tr class=\"group\">" : "<tr>", page);
    for (size_t column = 0; column < table->column_count && column < COLUMNS_MAX; ++column) {
        const result_cell *cell = cell_at(table, row, column);
        same = same && is_same(cell, cell_at(table, row - 1, column));
        if (looks[column].hidden) {
            continue;
        }
        write_cell(cell, &looks[column], same, page);
        if (looks[column].quartiles) {
            write_quartiles(table, &looks[column], row, column, page);
        }
    }
    fputs("</tr>\n", page);
}

void table_html_write(const result_table *table, FILE *page)
{
    column_look looks[COLUMNS_MAX] = {0};
    const size_t row_count = result_row_count(table);
    const bool folded = row_count > FOLDED_ROWS;
    look_at(table, looks);
    if (folded) {
        fprintf(page, "<details><summary>The figures: %zu rows</summary>\n", row_count);
    }
    fprintf(page, "<div class=\"scroll\"><table id=\"table-%s\">\n", text_make_name(table->id).text);
    write_head(table, looks, page);
    fputs("<tbody>\n", page);
    for (size_t row = 0; row < row_count; ++row) {
        write_row(table, looks, row, page);
    }
    fprintf(page, "</tbody></table></div>\n%s", folded ? "</details>\n" : "");
}
