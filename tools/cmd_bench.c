/* SPDX-License-Identifier: MIT */
/* svocl bench: measurements, each a file of its own in bench/. */
#include <string.h>

#include "bench/bench.h"
#include "commands.h"

static const struct {
    const char *name;
    int (*run)(program *state);
} subjects[] = {{"rays", bench_rays}};

int command_bench(program *state)
{
    const char *wanted = state->options.subject;
    if (wanted == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "what to measure is missing: rays");
    }
    for (size_t i = 0; i < sizeof subjects / sizeof subjects[0]; ++i) {
        if (strcmp(subjects[i].name, wanted) == 0) {
            return subjects[i].run(state);
        }
    }
    return program_fail(state, PROGRAM_WRONG_USAGE, "'%s' cannot be measured, only: rays", wanted);
}
