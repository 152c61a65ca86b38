/* SPDX-License-Identifier: MIT */
/* Sets of tables as JSON, in both directions. What is read comes from a file and is checked field by field. */
#include "measure/result_json.h"

#include <stdio.h>
#include <string.h>

#include "support/text.h"

/* ---- writing ---- */

static void add_known(cJSON *object, const char *name, const char *fact)
{
    if (fact[0] != '\0') {
        json_add_text(object, name, fact);
    }
}

static cJSON *machine_to_json(const result_machine *machine)
{
    cJSON *object = cJSON_CreateObject();
    json_add_text(object, "device", machine->device);
    json_add_text(object, "driver", machine->driver);
    json_add_text(object, "platform", machine->platform);
    json_add_text(object, "renderer", machine->renderer);
    cJSON_AddNumberToObject(object, "cpu_threads", machine->cpu_threads);
    json_add_text(object, "svocl", machine->svocl);
    add_known(object, "processor", machine->processor);
    add_known(object, "clock", machine->clock);
    add_known(object, "memory", machine->memory);
    add_known(object, "instruction_set", machine->instruction_set);
    add_known(object, "date", machine->date);
    return object;
}

static cJSON *cell_to_json(const result_cell *cell)
{
    return cell->kind == RESULT_TEXT     ? json_text(cell->text)
           : cell->kind == RESULT_NUMBER ? cJSON_CreateNumber(cell->number)
                                         : cJSON_CreateNull();
}

static cJSON *table_to_json(const result_table *table)
{
    cJSON *object = cJSON_CreateObject();
    json_add_text(object, "id", table->id);
    json_add_text(object, "title", table->title);
    json_add_text(object, "note", table->note);
    cJSON *columns = cJSON_AddArrayToObject(object, "columns");
    for (size_t i = 0; i < table->column_count; ++i) {
        cJSON *column = cJSON_CreateObject();
        json_add_text(column, "name", table->columns[i].name);
        json_add_text(column, "unit", table->columns[i].unit);
        cJSON_AddItemToArray(columns, column);
    }
    cJSON *rows = cJSON_AddArrayToObject(object, "rows");
    for (size_t row = 0; row < result_row_count(table); ++row) {
        cJSON *cells = cJSON_CreateArray();
        for (size_t column = 0; column < table->column_count; ++column) {
            cJSON_AddItemToArray(cells, cell_to_json(result_cell_at(table, row, column)));
        }
        cJSON_AddItemToArray(rows, cells);
    }
    return object;
}

cJSON *result_to_json(const result_set *set)
{
    if (!result_is_whole(set)) {
        return NULL;
    }
    cJSON *document = json_document();
    cJSON_AddItemToObject(document, "machine", machine_to_json(&set->machine));
    cJSON *tables = cJSON_AddArrayToObject(document, "tables");
    for (size_t i = 0; i < set->table_count; ++i) {
        cJSON_AddItemToArray(tables, table_to_json(set->tables[i]));
    }
    return document;
}

/* ---- reading ---- */

/* The text of that name, or NULL with the message. */
static const char *text_of(const cJSON *object, const char *name, svo_message *message)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, name));
    if (text == NULL) {
        snprintf(message->text, sizeof message->text, "\"%s\" is missing or no text", name);
    }
    return text;
}

static const cJSON *array_of(const cJSON *object, const char *name, svo_message *message)
{
    const cJSON *array = cJSON_GetObjectItemCaseSensitive(object, name);
    if (!cJSON_IsArray(array)) {
        snprintf(message->text, sizeof message->text, "\"%s\" is missing or no array", name);
        return NULL;
    }
    return array;
}

static bool read_fact(const cJSON *object, const char *name, char fact[RESULT_FACT_BYTES], svo_message *message)
{
    const char *text = text_of(object, name, message);
    snprintf(fact, RESULT_FACT_BYTES, "%s", text != NULL ? text : "");
    return text != NULL;
}

/* The same for a text of the set's. */
static bool read_text(const cJSON *object, const char *name, result_set *set, char **fact, svo_message *message)
{
    const char *text = text_of(object, name, message);
    if (text != NULL) {
        result_set_fact(set, fact, text);
    }
    return text != NULL;
}

/* True without such a fact, too. */
static bool read_optional(const cJSON *object, const char *name, char fact[RESULT_FACT_BYTES], svo_message *message)
{
    return cJSON_GetObjectItemCaseSensitive(object, name) == NULL || read_fact(object, name, fact, message);
}

static bool read_machine(const cJSON *document, result_set *set, svo_message *message)
{
    result_machine *machine = &set->machine;
    const cJSON *object = cJSON_GetObjectItemCaseSensitive(document, "machine");
    const cJSON *threads = cJSON_GetObjectItemCaseSensitive(object, "cpu_threads");
    if (!cJSON_IsNumber(threads) || threads->valuedouble < 0 || threads->valuedouble > 65536) {
        snprintf(message->text, sizeof message->text, "\"cpu_threads\" is missing or no number of threads");
        return false;
    }
    machine->cpu_threads = (unsigned)threads->valuedouble;
    if (!read_optional(object, "date", machine->date, message) ||
        !read_optional(object, "processor", machine->processor, message) ||
        !read_optional(object, "clock", machine->clock, message) ||
        !read_optional(object, "memory", machine->memory, message) ||
        !read_optional(object, "instruction_set", machine->instruction_set, message)) {
        return false;
    }
    return read_text(object, "device", set, &machine->device, message) &&
           read_text(object, "driver", set, &machine->driver, message) &&
           read_text(object, "platform", set, &machine->platform, message) &&
           read_text(object, "renderer", set, &machine->renderer, message) &&
           read_fact(object, "svocl", machine->svocl, message);
}

static bool read_row(const cJSON *row, result_table *table, svo_message *message)
{
    if (!cJSON_IsArray(row) || (size_t)cJSON_GetArraySize(row) != table->column_count) {
        snprintf(message->text, sizeof message->text, "table \"%.64s\": a row has not %zu cells", table->id,
                 table->column_count);
        return false;
    }
    const cJSON *cell = NULL;
    cJSON_ArrayForEach(cell, row)
    {
        if (cJSON_IsString(cell)) {
            result_add_text(table, "%s", cell->valuestring);
        } else if (cJSON_IsNumber(cell)) {
            result_add_number(table, cell->valuedouble);
        } else if (cJSON_IsNull(cell)) {
            result_add_absent(table);
        } else {
            snprintf(message->text, sizeof message->text, "table \"%.64s\": a cell is no text, number or null",
                     table->id);
            return false;
        }
    }
    return true;
}

static bool read_columns(const cJSON *columns, result_table *table, svo_message *message)
{
    const cJSON *column = NULL;
    cJSON_ArrayForEach(column, columns)
    {
        const char *name = text_of(column, "name", message);
        const char *unit = name != NULL ? text_of(column, "unit", message) : NULL;
        if (unit == NULL) {
            return false;
        }
        result_add_column(table, name, unit);
    }
    return true;
}

static bool read_table(const cJSON *object, result_set *set, svo_message *message)
{
    const char *id = text_of(object, "id", message);
    const char *title = id != NULL ? text_of(object, "title", message) : NULL;
    const char *note = title != NULL ? text_of(object, "note", message) : NULL;
    const cJSON *columns = note != NULL ? array_of(object, "columns", message) : NULL;
    const cJSON *rows = columns != NULL ? array_of(object, "rows", message) : NULL;
    if (rows == NULL) {
        return false;
    }
    if (cJSON_GetArraySize(columns) == 0) {
        snprintf(message->text, sizeof message->text, "table \"%.64s\" has no columns", id);
        return false;
    }
    result_table *table = result_add_table(set, id, title, note);
    bool read = table != NULL && read_columns(columns, table, message);
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, rows)
    {
        read = read && read_row(row, table, message);
    }
    return read;
}

static bool read_document(const cJSON *document, result_set *set, svo_message *message)
{
    const cJSON *tables = array_of(document, "tables", message);
    if (tables == NULL || !read_machine(document, set, message)) {
        return false;
    }
    const cJSON *table = NULL;
    cJSON_ArrayForEach(table, tables)
    {
        if (!read_table(table, set, message)) {
            return false;
        }
    }
    return result_is_whole(set);
}

result_set *result_parse(const char *text, svo_message *message)
{
    const char *end = text;
    cJSON *document = cJSON_ParseWithOpts(text, &end, 1);
    if (document == NULL) {
        const json_error error = json_error_at(text, end);
        snprintf(message->text, sizeof message->text, "line %u: %s", error.line, error.text);
        return NULL;
    }
    snprintf(message->text, sizeof message->text, "out of memory");
    result_set *set = result_create();
    if (set != NULL && !read_document(document, set, message)) {
        result_destroy(&set);
    }
    if (set != NULL) {
        message->text[0] = '\0';
    }
    cJSON_Delete(document);
    return set;
}
