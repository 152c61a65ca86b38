/* SPDX-License-Identifier: MIT */
/* Runs this program as a child process with compiler caches in a folder of its own, and times it. */
#ifndef SVOCL_TOOLS_BENCH_CHILD_H
#define SVOCL_TOOLS_BENCH_CHILD_H

#include <cjson/cJSON.h>
#include <stdbool.h>

/* An empty folder for the drivers' caches of compiled kernels and shaders. False when it cannot be created. */
typedef struct child_cache {
    char path[256];
} child_cache;
bool child_cache_create(child_cache *made);
void child_cache_remove(const child_cache *made);

/* arguments: ends with NULL; without the program's name. Standard error is discarded. document: receives the JSON on
   standard output, NULL without it; cJSON_Delete releases it. Returns the milliseconds from start to exit, below 0 when
   the process cannot run or fails. */
double child_run(const char *const arguments[], const child_cache *cache, cJSON **document);

#endif
