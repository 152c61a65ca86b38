/* SPDX-License-Identifier: MIT */
/* A JSON document that a user wrote, and the lines of its values, for messages. */
#ifndef SVOCL_TOOLS_SUPPORT_JSON_SOURCE_H
#define SVOCL_TOOLS_SUPPORT_JSON_SOURCE_H

#include <cjson/cJSON.h>
#include <stddef.h>

#include "support/program.h"

typedef struct json_source {
    program *state;
    const char *path;
    cJSON *root;
    const cJSON **values; /* in the order of the text */
    unsigned *lines; /* of each: where its key is, else where it begins; from 1 */
    size_t count;
} json_source;

/* Reads and parses the file. Two members of one name in an object are an error. Returns the exit code; on failure
   nothing stays open. */
int json_source_open(program *state, const char *path, json_source *out);
void json_source_close(json_source *source);

/* program_fail with the path and the value's line in front: "PATH:LINE: text". */
int json_source_fail(const json_source *source, const cJSON *value, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The value must be an object whose members are all among keys, which ends with NULL. what: names the object. */
int json_source_check_keys(const json_source *source, const cJSON *object, const char *what, const char *const *keys);

/* The value must be an array of count finite numbers; what: names it. Each must fit a float. */
int json_source_floats(const json_source *source, const cJSON *array, const char *what, size_t count, float *out);

/* The value must be a whole number in low .. high. */
int json_source_count(const json_source *source, const cJSON *number, const char *what, unsigned low, unsigned high,
                      unsigned *out);

#endif
