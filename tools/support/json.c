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

void json_add_text(cJSON *object, const char *name, const char *text)
{
    if (text != NULL) {
        cJSON_AddStringToObject(object, name, text);
    } else {
        cJSON_AddNullToObject(object, name);
    }
}

void json_add_vector(cJSON *object, const char *name, const double vector[3])
{
    cJSON_AddItemToObject(object, name, cJSON_CreateDoubleArray(vector, 3));
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
            cJSON_AddItemToArray(array, cJSON_CreateString(svo_need_name((svo_need)bit)));
        }
    }
}

int json_print(program *state, cJSON *document)
{
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
