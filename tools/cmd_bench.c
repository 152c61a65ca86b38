/* SPDX-License-Identifier: MIT */
/* svocl bench: measurements, each a file of its own in bench/. */
#include <string.h>

#include "bench/bench.h"
#include "commands.h"
#include "errors/bench_errors.h"
#include "json.h"

static const struct {
    const char *name;
    int (*run)(program *state);
} subjects[] = {{"rays", bench_rays}};

static int bench_errors(program *state)
{
    result_set *results = result_create();
    program_begin_progress(state, bench_errors_step_count(state->options.subject));
    int exit_code = bench_errors_fill(state, state->options.subject, state->options.quick != 0, results);
    progress_destroy(&state->progress);
    if (exit_code == PROGRAM_DONE && state->options.json) {
        exit_code = json_print(state, result_to_json(results));
    } else if (exit_code == PROGRAM_DONE) {
        for (size_t i = 0; i < results->table_count; ++i) {
            result_print(results->tables[i]);
        }
    }
    result_destroy(&results);
    return exit_code;
}

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
    if (bench_errors_know(wanted)) {
        return bench_errors(state);
    }
    return program_fail(state, PROGRAM_WRONG_USAGE, "'%s' cannot be measured, only: rays", wanted);
}
