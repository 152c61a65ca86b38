/* SPDX-License-Identifier: MIT */
/* Reads the text of a file of results. */
#include "measure/result_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "measure/result_json.h"

#define FILE_BYTES_MAX ((size_t)64 << 20) /* 64 MiB */

/* The rest of a file as a text, allocated by malloc; NULL after a failure, which is printed. */
static char *read_text(program *state, FILE *file, const char *name)
{
    char *text = NULL;
    const char *failure = "longer than 64 MiB";
    size_t used = 0;
    for (size_t capacity = 1 << 16; capacity <= FILE_BYTES_MAX; capacity *= 2) {
        char *grown = realloc(text, capacity + 1);
        if (grown == NULL) {
            failure = "out of memory";
            break;
        }
        text = grown;
        used += fread(text + used, 1, capacity - used, file);
        if (used < capacity) { /* the end, or an error */
            text[used] = '\0';
            failure = ferror(file) != 0 ? strerror(errno) : NULL;
            break;
        }
    }
    if (failure != NULL) {
        program_fail(state, PROGRAM_FAILED, "%s: %s", name, failure);
        free(text);
        text = NULL;
    }
    return text;
}

result_set *result_file_read(program *state, const char *path)
{
    svo_message message = {""};
    const bool standard = piped_is_standard_input(path);
    const char *name = standard ? "standard input" : path;
    FILE *file = standard ? stdin : fopen(path, "rb");
    if (file == NULL) {
        program_fail(state, PROGRAM_FAILED, "%s: %s", name, strerror(errno));
        return NULL;
    }
    char *text = read_text(state, file, name);
    if (!standard) {
        fclose(file);
    }
    result_set *results = text != NULL ? result_parse(text, &message) : NULL;
    if (text != NULL && results == NULL) {
        program_fail(state, PROGRAM_FAILED, "%s: %s", name, message.text);
    }
    free(text);
    return results;
}
