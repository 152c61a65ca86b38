/* SPDX-License-Identifier: MIT */
/* This program run again as a child, timed from its start to its end, with compiler caches in a folder of its own. */
#ifndef SVOCL_TOOLS_BENCH_CHILD_H
#define SVOCL_TOOLS_BENCH_CHILD_H

#include <cjson/cJSON.h>
#include <stdbool.h>

/* An empty folder for what drivers keep of compiled kernels and shaders. False when it cannot be made. */
typedef struct child_cache {
    char path[256];
} child_cache;
bool child_cache_create(child_cache *made);
void child_cache_remove(const child_cache *made);

/* arguments: ends with NULL; without the program's name. Standard error is thrown away. document: receives the JSON it
   printed, NULL when there is none; cJSON_Delete releases it.
   Returns the milliseconds from start to end, below 0 when it could not be run or ended with an error. */
double child_run(const char *const arguments[], const child_cache *cache, cJSON **document);

#endif
