/* SPDX-License-Identifier: MIT */
/* Small helpers over cJSON, whose functions allow NULL: running out of memory shows when the document is printed. */
#include "json.h"

#include <stdio.h>

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
