/* SPDX-License-Identifier: MIT */
#define _XOPEN_SOURCE 700
#include "measure/instruction_set.h"

#include <stdlib.h>
#include <string.h>

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
