/* SPDX-License-Identifier: MIT */
/* Asks Linux for the processor and the memory. What it does not say is left out. */
#define _XOPEN_SOURCE 700
#include "measure/host.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "svocl/version.h"

/* The value of "key : value", NULL if the line has another key. */
static char *value_of(char *line, const char *key)
{
    char *colon = strncmp(line, key, strlen(key)) == 0 ? strchr(line, ':') : NULL;
    if (colon == NULL) {
        return NULL;
    }
    colon[1 + strcspn(colon + 1, "\n")] = '\0';
    return colon + 1 + strspn(colon + 1, " \t");
}

/* Of the first processor. The clock is the one at this moment. */
static void describe_processor(result_machine *machine)
{
    char line[1024];
    FILE *file = fopen("/proc/cpuinfo", "r");
    while (file != NULL && fgets(line, sizeof line, file) != NULL && line[0] != '\n') {
        const char *model = value_of(line, "model name");
        const char *clock = value_of(line, "cpu MHz");
        if (model != NULL) {
            snprintf(machine->processor, sizeof machine->processor, "%.*s", RESULT_FACT_BYTES - 1, model);
        }
        if (clock != NULL) {
            snprintf(machine->clock, sizeof machine->clock, "%.0f MHz", strtod(clock, NULL));
        }
    }
    if (file != NULL) {
        fclose(file);
    }
}

void host_describe(const options *given, result_machine *machine)
{
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    const double bytes = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    describe_processor(machine);
    if (bytes > 0) {
        snprintf(machine->memory, sizeof machine->memory, "%.1f GiB", bytes / 0x1p30);
    }
    machine->cpu_threads = given->threads != 0 ? (unsigned)given->threads : online > 0 ? (unsigned)online : 1;
    snprintf(machine->instruction_set, sizeof machine->instruction_set, "%s", instruction_set_name(given->isa));
    snprintf(machine->svocl, sizeof machine->svocl, "%s", svo_version_string());
}

/* ---- the instruction set ---- */

#define SET_COUNT 3

/* The widest one first. */
static const struct {
    const char *asked, *name;
} sets[SET_COUNT] = {{"avx512", "AVX-512"}, {"avx2", "AVX2"}, {"sse2", "SSE2"}};

static bool processor_has(size_t index)
{
#if defined(__x86_64__)
    return index == 0   ? __builtin_cpu_supports("avx512f") != 0
           : index == 1 ? __builtin_cpu_supports("avx2") != 0
                        : __builtin_cpu_supports("sse2") != 0;
#else
    (void)index;
    return false;
#endif
}

const char *instruction_set_name(const char *asked)
{
    for (size_t i = 0; i < SET_COUNT; ++i) {
        if (asked != NULL ? strcmp(asked, sets[i].asked) == 0 : processor_has(i)) {
            return sets[i].name;
        }
    }
#if defined(__aarch64__)
    return "NEON";
#else
    return "";
#endif
}

bool instruction_set_is_there(const char *asked)
{
    for (size_t i = 0; i < SET_COUNT; ++i) {
        if (strcmp(asked, sets[i].asked) == 0) {
            return processor_has(i);
        }
    }
    return false;
}

/* PoCL's names are the same. */
bool instruction_set_choose(const char *asked, const char *cache_path)
{
    return setenv("POCL_KERNELLIB_NAME", asked, 1) == 0 && setenv("POCL_CACHE_DIR", cache_path, 1) == 0;
}
