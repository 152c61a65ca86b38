/* SPDX-License-Identifier: MIT */
/* Aligned tables and readable figures on standard output. */
#include "support/table.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "support/text.h"
#include "svocl/plan.h"

struct table {
    char alignment[TABLE_COLUMNS_MAX + 1];
    size_t column_count;
    char **cells;
    size_t cell_count;
    size_t cell_capacity;
    size_t line_width; /* in columns: where the last cell of a row wraps */
};

table *table_create(const char *alignment)
{
    table *rows = calloc(1, sizeof *rows);
    if (rows != NULL) {
        snprintf(rows->alignment, sizeof rows->alignment, "%s", alignment);
        rows->column_count = strlen(rows->alignment);
    }
    return rows;
}

void table_cell(table *rows, const char *format, ...)
{
    if (rows == NULL) {
        return;
    }
    if (rows->cell_count == rows->cell_capacity) {
        const size_t capacity = rows->cell_capacity * 2 + 32;
        char **cells = realloc(rows->cells, capacity * sizeof *cells);
        if (cells == NULL) {
            return;
        }
        rows->cells = cells;
        rows->cell_capacity = capacity;
    }
    va_list arguments;
    va_start(arguments, format);
    char *text = utf8_format(format, arguments);
    va_end(arguments);
    char *cell = text != NULL ? utf8_escape(text) : NULL;
    free(text);
    if (cell != NULL) {
        rows->cells[rows->cell_count++] = cell;
    }
}

/* Names of files and devices may hold more than ASCII: widths are in characters of UTF-8, not in bytes. */
static bool begins_character(char byte)
{
    return ((unsigned char)byte & 0xc0u) != 0x80u;
}

static size_t text_width(const char *text)
{
    size_t width = 0;
    for (; *text != '\0'; ++text) {
        width += begins_character(*text);
    }
    return width;
}

/* printf pads by bytes. */
static int padded_bytes(const char *text, size_t width)
{
    return (int)(width + strlen(text) - text_width(text));
}

static void measure(const table *rows, size_t widths[TABLE_COLUMNS_MAX])
{
    memset(widths, 0, TABLE_COLUMNS_MAX * sizeof widths[0]);
    for (size_t i = 0; i < rows->cell_count; ++i) {
        const size_t width = text_width(rows->cells[i]);
        const size_t column = i % rows->column_count;
        if (width > widths[column]) {
            widths[column] = width;
        }
    }
}

/* Columns of the terminal; no limit if standard output is not a terminal. */
static size_t terminal_width(void)
{
    struct winsize window = {0};
    if (!isatty(STDOUT_FILENO)) {
        return SIZE_MAX;
    }
    return ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0 ? window.ws_col : 80;
}

/* The bytes of text that fit into width, up to a space if there is one. */
static size_t fitting_length(const char *text, size_t width)
{
    size_t end = 0, last_space = 0, used = 0;
    for (; text[end] != '\0'; ++end) {
        if (!begins_character(text[end])) {
            continue;
        }
        last_space = text[end] == ' ' ? end : last_space;
        if (used == width) {
            return last_space > 0 ? last_space : end;
        }
        ++used;
    }
    return end;
}

/* The last cell of a row; continuation lines are indented to its start. */
static void print_wrapped(const char *text, size_t line_width, size_t indent)
{
    const size_t room = line_width > indent + 20 ? line_width - indent : 20;
    size_t length = fitting_length(text, room);
    printf("%.*s\n", (int)length, text);
    for (text += length; *text != '\0'; text += length) {
        text += strspn(text, " ");
        length = fitting_length(text, room);
        printf("%*s%.*s\n", (int)indent, "", (int)length, text);
    }
}

static void print_cell(const table *rows, size_t index, const size_t widths[TABLE_COLUMNS_MAX])
{
    const size_t column = index % rows->column_count;
    const bool last = column + 1 == rows->column_count || index + 1 == rows->cell_count;
    const char *text = rows->cells[index];
    if (rows->alignment[column] == 'r') {
        printf("  %*s%s", padded_bytes(text, widths[column]), text, last ? "\n" : "");
    } else if (!last) {
        printf("  %-*s", padded_bytes(text, widths[column]), text);
    } else {
        size_t indent = 2;
        for (size_t i = 0; i < column; ++i) {
            indent += widths[i] + 2;
        }
        fputs("  ", stdout);
        print_wrapped(text, rows->line_width, indent);
    }
}

void table_print(table *rows)
{
    table_print_wrapped(rows, SIZE_MAX);
}

void table_print_wrapped(table *rows, size_t line_width)
{
    if (rows == NULL) {
        return;
    }
    size_t widths[TABLE_COLUMNS_MAX];
    const size_t screen_width = terminal_width();
    rows->line_width = line_width < screen_width ? line_width : screen_width;
    measure(rows, widths);
    for (size_t i = 0; i < rows->cell_count; ++i) {
        print_cell(rows, i, widths);
    }
    for (size_t i = 0; i < rows->cell_count; ++i) {
        free(rows->cells[i]);
    }
    free(rows->cells);
    free(rows);
}

static bool wants_bold(void)
{
    const char *no_color = getenv("NO_COLOR");
    const char *term = getenv("TERM");
    return isatty(STDOUT_FILENO) && (no_color == NULL || no_color[0] == '\0') && term != NULL &&
           strcmp(term, "dumb") != 0;
}

void table_gap(void)
{
    putchar('\n');
}

static void print_text(const char *format, va_list arguments)
{
    char *text = utf8_format(format, arguments);
    char *escaped = text != NULL ? utf8_escape(text) : NULL;
    fputs(escaped != NULL ? escaped : "", stdout);
    free(escaped);
    free(text);
}

void table_heading(const char *format, ...)
{
    const bool bold = wants_bold();
    va_list arguments;
    va_start(arguments, format);
    fputs(bold ? "\033[1m" : "", stdout);
    print_text(format, arguments);
    fputs(bold ? "\033[0m\n" : "\n", stdout);
    va_end(arguments);
}

void table_line(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("  ", stdout);
    print_text(format, arguments);
    putchar('\n');
    va_end(arguments);
}

double figure_rounded(double value)
{
    char text[32];
    (void)snprintf(text, sizeof text, "%.3g", value);
    return strtod(text, NULL);
}

figure figure_count(uint64_t count)
{
    char digits[24];
    const int length = snprintf(digits, sizeof digits, "%" PRIu64, count);
    figure result;
    size_t used = 0;
    for (int i = 0; i < length; ++i) {
        if (i > 0 && (length - i) % 3 == 0) {
            result.text[used++] = ',';
        }
        result.text[used++] = digits[i];
    }
    result.text[used] = '\0';
    return result;
}

figure figure_bytes(uint64_t bytes)
{
    static const char *const units[] = {"bytes", "KiB", "MiB", "GiB", "TiB"};
    double value = (double)bytes;
    size_t unit = 0;
    while (value >= 1024.0 && unit + 1 < sizeof units / sizeof units[0]) {
        value /= 1024.0;
        ++unit;
    }
    figure result;
    snprintf(result.text, sizeof result.text, unit == 0 ? "%.0f %s" : "%.1f %s", value,
             bytes == 1 ? "byte" : units[unit]);
    return result;
}

figure figure_ms(double ms)
{
    figure result;
    snprintf(result.text, sizeof result.text, "%.2f ms", ms);
    return result;
}

figure figure_rate(double per_second)
{
    figure result;
    if (per_second >= 1e6) {
        snprintf(result.text, sizeof result.text, "%.2f M/s", per_second / 1e6);
    } else if (per_second >= 1e3) {
        snprintf(result.text, sizeof result.text, "%.2f k/s", per_second / 1e3);
    } else {
        snprintf(result.text, sizeof result.text, "%.2f /s", per_second);
    }
    return result;
}

figure figure_needs(uint32_t bits)
{
    figure result = {""};
    for (uint32_t bit = 1; bit <= (uint32_t)SVO_NEED_ALL; bit <<= 1) {
        const size_t used = strlen(result.text);
        if ((bits & bit) != 0) {
            snprintf(result.text + used, sizeof result.text - used, "%s%s", used > 0 ? ", " : "",
                     svo_name(SVO_NAME_NEED, (svo_need)bit));
        }
    }
    if (result.text[0] == '\0') {
        snprintf(result.text, sizeof result.text, "none");
    }
    return result;
}
