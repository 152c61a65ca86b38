/* SPDX-License-Identifier: MIT */
/* Small helpers over cJSON. Its functions accept NULL, so an allocation failure shows when the document is printed. */
#include "support/json.h"

#include <stdio.h>
#include <string.h>

#include "support/output.h"
#include "svocl/plan.h"

void json_add_count(cJSON *object, const char *name, uint64_t count)
{
    cJSON_AddNumberToObject(object, name, (double)count);
}

void json_add_vector(cJSON *object, const char *name, const double vector[3])
{
    cJSON_AddItemToObject(object, name, cJSON_CreateDoubleArray(vector, 3));
}

void json_add_file(cJSON *array, const char *path, long byte_count)
{
    cJSON *object = cJSON_CreateObject();
    json_add_text(object, "file", path);
    cJSON_AddNumberToObject(object, "bytes", (double)byte_count);
    cJSON_AddItemToArray(array, object);
}

int json_save(program *state, const char *path, const cJSON *document)
{
    char *text = cJSON_Print(document);
    if (text == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the JSON text");
    }
    output_file file;
    int exit_code = output_open(state, path, &file);
    if (exit_code == PROGRAM_DONE) {
        output_write(&file, text, strlen(text));
        output_write(&file, "\n", 1);
        exit_code = output_commit(state, &file);
    }
    cJSON_free(text);
    return exit_code;
}

void json_add_needs(cJSON *object, const char *name, uint32_t bits)
{
    cJSON *array = cJSON_AddArrayToObject(object, name);
    for (uint32_t bit = 1; bit <= (uint32_t)SVO_NEED_ALL; bit <<= 1) {
        if ((bits & bit) != 0) {
            cJSON_AddItemToArray(array, cJSON_CreateString(svo_name(SVO_NAME_NEED, (svo_need)bit)));
        }
    }
}

/* Warnings so far, as texts; those beyond PROGRAM_WARNINGS_KEPT as a number of their own. */
static void add_warnings(cJSON *document, const program *state)
{
    cJSON *array = cJSON_AddArrayToObject(document, "warnings");
    for (unsigned i = 0; i < state->warning_count && i < PROGRAM_WARNINGS_KEPT; ++i) {
        if (state->warnings[i] != NULL) {
            cJSON_AddItemToArray(array, json_text(state->warnings[i]));
        }
    }
    json_add_count(document, "warning_count", state->warning_count);
}

int json_print(program *state, cJSON *document)
{
    if (state->reads_mesh) {
        add_warnings(document, state);
    }
    char *text = cJSON_Print(document);
    cJSON_Delete(document);
    if (text == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the JSON text");
    }
    progress_hide(state->progress);
    puts(text);
    cJSON_free(text);
    return PROGRAM_DONE;
}
