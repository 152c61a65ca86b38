/* SPDX-License-Identifier: MIT */
/* Tables of numbers as text. */
#include "support/number_table.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_BYTES 1024
#define FIELDS_MAX 16

/* A number with optional white space around it; false if there is none. */
static bool read_number(const char **text, float *out)
{
    char *end = NULL;
    const double number = strtod(*text, &end);
    if (end == *text) {
        return false;
    }
    while (*end == ' ' || *end == '\t' || *end == '\r' || *end == '\n') {
        ++end;
    }
    *text = end;
    *out = (float)number;
    return true;
}

size_t number_table_parse(const char *text, float *numbers, size_t limit)
{
    size_t count = 0;
    while (count < limit && read_number(&text, &numbers[count])) {
        ++count;
        if (*text == '\0') {
            return count;
        }
        if (*text != ',') {
            return 0;
        }
        ++text;
    }
    return 0;
}

static bool is_blank(const char *text)
{
    while (isspace((unsigned char)*text)) {
        ++text;
    }
    return *text == '\0';
}

static bool append(number_table *table, size_t *capacity, const float *numbers, size_t fields)
{
    if (table->row_count == *capacity) {
        const size_t larger = *capacity * 2 + 1024;
        float *grown = realloc(table->numbers, larger * fields * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        table->numbers = grown;
        *capacity = larger;
    }
    memcpy(table->numbers + fields * table->row_count++, numbers, fields * sizeof *numbers);
    return true;
}

static int read_lines(program *state, const char *path, FILE *file, const number_form *form, number_table *out)
{
    char line[LINE_BYTES];
    size_t capacity = 0;
    for (size_t number = 1; fgets(line, sizeof line, file) != NULL; ++number) {
        float numbers[FIELDS_MAX];
        const char *first = line;
        if (is_blank(line) || (number == 1 && !read_number(&first, numbers))) {
            continue;
        }
        if (number_table_parse(line, numbers, form->fields) != form->fields) {
            return program_fail(state, PROGRAM_FAILED, "%s:%zu: not %s", path, number, form->line);
        }
        if (!append(out, &capacity, numbers, form->fields)) {
            return program_fail(state, PROGRAM_FAILED, "%s: out of memory for %zu %ss", path, out->row_count,
                                form->noun);
        }
    }
    return ferror(file) == 0 ? PROGRAM_DONE : program_fail(state, PROGRAM_FAILED, "%s: %s", path, strerror(errno));
}

int number_table_read(program *state, const char *path, const number_form *form, number_table *out)
{
    *out = (number_table){0};
    const bool standard = piped_is_standard_input(path);
    const char *name = standard ? "standard input" : path;
    FILE *file = standard ? stdin : fopen(path, "r");
    if (file == NULL) {
        return program_fail(state, PROGRAM_FAILED, "%s: %s", name, strerror(errno));
    }
    int exit_code = read_lines(state, name, file, form, out);
    if (!standard) {
        fclose(file);
    }
    if (exit_code == PROGRAM_DONE && out->row_count == 0) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%s: no %s; a line is %s", name, form->noun, form->line);
    }
    if (exit_code != PROGRAM_DONE) {
        number_table_free(out);
    }
    return exit_code;
}

void number_table_free(number_table *table)
{
    free(table->numbers);
    *table = (number_table){0};
}
