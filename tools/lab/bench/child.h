/* SPDX-License-Identifier: MIT */
/* Runs svocl as a child process with compiler caches in a folder of its own, and times it. */
#ifndef SVOCL_TOOLS_BENCH_CHILD_H
#define SVOCL_TOOLS_BENCH_CHILD_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "support/options.h"
#include "svocl/status.h"

/* An empty folder for the drivers' caches of compiled kernels and shaders. False when it cannot be created. */
typedef struct child_cache {
    char path[256];
} child_cache;
bool child_cache_create(child_cache *made);
void child_cache_remove(const child_cache *made);

#define CHILD_ARGUMENTS_MAX 48
#define CHILD_REASON_BYTES  (SVO_MESSAGE_BYTES + 64) /* a message of the library, after the command */

/* Arguments, without the program's name; ends with NULL. */
typedef struct child_arguments {
    const char *list[CHILD_ARGUMENTS_MAX + 1];
    size_t count;
} child_arguments;
/* Borrows the text. What is above CHILD_ARGUMENTS_MAX is left out. */
void child_add(child_arguments *arguments, const char *text);
/* The options of this process that say where to run; the context only for a child that draws by OpenGL. */
void child_add_device(child_arguments *arguments, const options *given, bool in_gl);

/* arguments: ends with NULL; without the program's name. Standard error is discarded. document: receives the JSON on
   standard output, NULL without it; cJSON_Delete releases it. Returns the milliseconds from start to exit, below 0 when
   the process cannot run or fails. */
double child_run(const char *const arguments[], const child_cache *cache, cJSON **document);

/* Starts a child whose output is discarded. Returns its ID, below 0 when none could be started. */
pid_t child_start(const child_arguments *arguments, const child_cache *cache);
/* Waits until one of the children that were started ends; *well: with exit code 0. Returns its ID, below 0 without. */
pid_t child_wait(bool *well);

/* The end of a child. */
typedef struct child_answer {
    cJSON *document; /* the JSON on standard output, also of a child that failed; NULL without; cJSON_Delete */
    double ms; /* from start to exit */
    bool well; /* exit code 0 */
    char reason[CHILD_REASON_BYTES]; /* "" if it ended well; else its last line on standard error, or what ended it */
} child_answer;
/* Runs a child and keeps what it said. cache: NULL: the caches of this process. seconds: it is ended after so many; 0:
   never. */
void child_ask(const child_arguments *arguments, const child_cache *cache, unsigned seconds, child_answer *out);

#endif
