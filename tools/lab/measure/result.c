/* SPDX-License-Identifier: MIT */
/* Sets of tables in memory, filled cell by cell. */
#include "measure/result.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "support/text.h"

void result_set_fact(result_set *set, char **fact, const char *text)
{
    char *copy = strdup(text);
    set->incomplete = set->incomplete || copy == NULL;
    if (copy != NULL) {
        free(*fact);
        *fact = copy;
    }
}

result_set *result_create(void)
{
    result_set *set = calloc(1, sizeof *set);
    if (set != NULL) {
        result_set_fact(set, &set->machine.device, "");
        result_set_fact(set, &set->machine.driver, "");
        result_set_fact(set, &set->machine.platform, "");
        result_set_fact(set, &set->machine.renderer, "");
        if (set->incomplete) {
            result_destroy(&set);
        }
    }
    return set;
}

static void release_table(result_table *table)
{
    for (size_t i = 0; i < table->cell_count; ++i) {
        free(table->cells[i].text);
    }
    for (size_t i = 0; i < table->column_count; ++i) {
        free(table->columns[i].name);
        free(table->columns[i].unit);
    }
    free(table->cells);
    free(table->columns);
    free(table->id);
    free(table->title);
    free(table->note);
    free(table);
}

void result_destroy(result_set **set)
{
    if (*set == NULL) {
        return;
    }
    for (size_t i = 0; i < (*set)->table_count; ++i) {
        release_table((*set)->tables[i]);
    }
    free((*set)->tables);
    free((*set)->machine.device);
    free((*set)->machine.driver);
    free((*set)->machine.platform);
    free((*set)->machine.renderer);
    free(*set);
    *set = NULL;
}

/* Room for one more table. */
static bool reserve_table(result_set *set)
{
    result_table **tables = realloc(set->tables, (set->table_count + 1) * sizeof *tables);
    if (tables == NULL) {
        set->incomplete = true;
        return false;
    }
    set->tables = tables;
    return true;
}

result_table *result_add_table(result_set *set, const char *id, const char *title, const char *note)
{
    if (set == NULL || !reserve_table(set)) {
        return NULL;
    }
    result_table *table = calloc(1, sizeof *table);
    if (table != NULL) {
        table->owner = set;
        table->id = strdup(id);
        table->title = strdup(title);
        table->note = strdup(note);
    }
    if (table == NULL || table->id == NULL || table->title == NULL || table->note == NULL) {
        set->incomplete = true;
        if (table != NULL) {
            release_table(table);
        }
        return NULL;
    }
    set->tables[set->table_count++] = table;
    return table;
}

/* Text by malloc; NULL, and the set remembers it, when out of memory. */
static char *make_text(result_set *owner, const char *format, va_list arguments)
{
    char *made = utf8_format(format, arguments);
    owner->incomplete = owner->incomplete || made == NULL;
    return made;
}

void result_set_note(result_table *table, const char *format, ...)
{
    if (table == NULL) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    char *note = make_text(table->owner, format, arguments);
    va_end(arguments);
    if (note != NULL) {
        free(table->note);
        table->note = note;
    }
}

void result_extend_note(result_table *table, const char *format, ...)
{
    if (table == NULL) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    char *sentence = make_text(table->owner, format, arguments);
    va_end(arguments);
    if (sentence != NULL && strstr(table->note, sentence) == NULL) {
        result_set_note(table, "%s %s", table->note, sentence);
    }
    free(sentence);
}

void result_add_column(result_table *table, const char *name, const char *unit)
{
    if (table == NULL) {
        return;
    }
    result_column *columns = realloc(table->columns, (table->column_count + 1) * sizeof *columns);
    if (columns == NULL) {
        table->owner->incomplete = true;
        return;
    }
    table->columns = columns;
    const result_column added = {.name = strdup(name), .unit = strdup(unit)};
    table->columns[table->column_count++] = added;
    table->owner->incomplete = table->owner->incomplete || added.name == NULL || added.unit == NULL;
}

static void add_cell(result_table *table, result_cell cell)
{
    if (table->cell_count == table->cell_capacity) {
        const size_t capacity = table->cell_capacity * 2 + 64;
        result_cell *cells = realloc(table->cells, capacity * sizeof *cells);
        if (cells == NULL) {
            free(cell.text);
            table->owner->incomplete = true;
            return;
        }
        table->cells = cells;
        table->cell_capacity = capacity;
    }
    table->cells[table->cell_count++] = cell;
}

void result_add_text(result_table *table, const char *format, ...)
{
    if (table == NULL) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    char *text = make_text(table->owner, format, arguments);
    va_end(arguments);
    if (text != NULL) {
        add_cell(table, (result_cell){.kind = RESULT_TEXT, .text = text});
    }
}

void result_add_number(result_table *table, double number)
{
    if (table == NULL) {
        return;
    }
    if (!isfinite(number)) {
        result_add_absent(table);
        return;
    }
    add_cell(table, (result_cell){.kind = RESULT_NUMBER, .number = number});
}

void result_add_absent(result_table *table)
{
    if (table != NULL) {
        add_cell(table, (result_cell){.kind = RESULT_ABSENT});
    }
}

void result_add_cell(result_table *table, const result_cell *cell)
{
    if (cell != NULL && cell->kind == RESULT_TEXT) {
        result_add_text(table, "%s", cell->text);
    } else if (cell != NULL && cell->kind == RESULT_NUMBER) {
        result_add_number(table, cell->number);
    } else {
        result_add_absent(table);
    }
}

void result_drop_partial_row(result_table *table)
{
    while (table != NULL && table->column_count > 0 && table->cell_count % table->column_count != 0) {
        free(table->cells[--table->cell_count].text);
    }
}

bool result_is_whole(const result_set *set)
{
    if (set == NULL || set->incomplete) {
        return false;
    }
    for (size_t i = 0; i < set->table_count; ++i) {
        const result_table *table = set->tables[i];
        if (table->column_count == 0 || table->cell_count % table->column_count != 0) {
            return false;
        }
    }
    return true;
}

static size_t find_index(const result_set *set, const char *id)
{
    size_t i = 0;
    while (i < set->table_count && strcmp(set->tables[i]->id, id) != 0) {
        ++i;
    }
    return i;
}

result_table *result_find(const result_set *set, const char *id)
{
    const size_t i = find_index(set, id);
    return i < set->table_count ? set->tables[i] : NULL;
}

size_t result_row_count(const result_table *table)
{
    return table->column_count > 0 ? table->cell_count / table->column_count : 0;
}

size_t result_find_column(const result_table *table, const char *name)
{
    size_t i = 0;
    while (i < table->column_count && strcmp(table->columns[i].name, name) != 0) {
        ++i;
    }
    return i;
}

static bool is_suffixed(const char *name, const char *stem, const char *suffix)
{
    const size_t length = strlen(stem);
    return strncmp(name, stem, length) == 0 && strcmp(name + length, suffix) == 0;
}

bool result_has_quartiles(const result_table *table, size_t column)
{
    const result_column *columns = table->columns + column;
    return column + 2 < table->column_count && ((is_suffixed(columns[1].name, columns[0].name, " q1") &&
                                                 is_suffixed(columns[2].name, columns[0].name, " q3")) ||
                                                (is_suffixed(columns[1].name, columns[0].name, " low") &&
                                                 is_suffixed(columns[2].name, columns[0].name, " high")));
}

const result_cell *result_cell_at(const result_table *table, size_t row, size_t column)
{
    const size_t i = row * table->column_count + column;
    return column < table->column_count && i < table->cell_count ? &table->cells[i] : NULL;
}

void result_take(result_set *into, result_set *from)
{
    for (size_t i = 0; i < from->table_count; ++i) {
        result_table *table = from->tables[i];
        const size_t known = find_index(into, table->id);
        if (known < into->table_count) {
            release_table(into->tables[known]);
        } else if (!reserve_table(into)) {
            release_table(table);
            continue;
        } else {
            ++into->table_count;
        }
        into->tables[known] = table;
        table->owner = into;
    }
    from->table_count = 0;
    into->incomplete = into->incomplete || from->incomplete;
}
