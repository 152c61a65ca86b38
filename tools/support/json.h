/* SPDX-License-Identifier: MIT */
/* Figures as JSON on standard output or in a file. */
#ifndef SVOCL_TOOLS_SUPPORT_JSON_H
#define SVOCL_TOOLS_SUPPORT_JSON_H

#include <cjson/cJSON.h>
#include <stdint.h>

#include "support/program.h"
#include "support/text.h"

void json_add_count(cJSON *object, const char *name, uint64_t count);
void json_add_vector(cJSON *object, const char *name, const double vector[3]);
/* bits: svo_need; an array of their names. */
void json_add_needs(cJSON *object, const char *name, uint32_t bits);

/* Adds {file, bytes} to an array of files that were written. */
void json_add_file(cJSON *array, const char *path, long byte_count);

/* Writes the document to a file, completely or not at all. Returns the exit code. */
int json_save(program *state, const char *path, const cJSON *document);

/* Prints and releases the document. Returns the exit code. */
int json_print(program *state, cJSON *document);

#endif
