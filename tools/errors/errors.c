/* SPDX-License-Identifier: MIT */
/* Opens what the experiments share and runs them one after the other. */
#include "errors.h"

#include <string.h>
#include <unistd.h>

#include "errors/bench_errors.h"
#include "errors/crew.h"

#define QUICK_ROUNDS 2u
#define FULL_ROUNDS  11u

static const struct {
    const char *name;
    int (*measure)(error_run *run);
    unsigned step_count; /* of the progress bar */
} experiments[] = {{"e1", errors_voxelization, 10},
                   {"e2", errors_rays, 12},
                   {"e3", errors_attributes, 2},
                   {"e4", errors_detail, 2},
                   {"e5", errors_stiffness, 6}};

#define EXPERIMENT_COUNT (sizeof experiments / sizeof experiments[0])

int errors_fail(error_run *run)
{
    const char *words = svo_device_message(run->opened.device);
    return words[0] != '\0' ? program_fail_library(run->state, words)
                            : program_fail(run->state, PROGRAM_FAILED, "out of memory");
}

scene *errors_scene(error_run *run, const char *spec)
{
    scene *made = NULL;
    svo_message message = {""};
    if (scene_create(spec, &made, &message) != SVO_OK) {
        program_fail_scene(run->state, SVO_OUT_OF_HOST_MEMORY, message.text);
        return NULL;
    }
    return made;
}

static bool is_wanted(const char *which, size_t experiment)
{
    return strcmp(which, "errors") == 0 || strcmp(which, experiments[experiment].name) == 0;
}

bool bench_errors_know(const char *which)
{
    for (size_t i = 0; i < EXPERIMENT_COUNT; ++i) {
        if (is_wanted(which, i)) {
            return true;
        }
    }
    return false;
}

unsigned bench_errors_step_count(const char *which)
{
    unsigned count = 0;
    for (size_t i = 0; i < EXPERIMENT_COUNT; ++i) {
        count += is_wanted(which, i) ? experiments[i].step_count : 0;
    }
    return count;
}

int bench_errors_fill(program *state, const char *which, bool quick, result_set *results)
{
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    error_run run = {.state = state,
                     .quick = quick,
                     .threads = state->options.threads != 0 ? (unsigned)state->options.threads
                                : online > 0                ? (unsigned)online
                                                            : 1,
                     .rounds = quick ? QUICK_ROUNDS : FULL_ROUNDS,
                     .results = results};
    run.threads = run.threads < CREW_MAX ? run.threads : CREW_MAX;
    int exit_code = session_open(state, &run.opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    session_choose_opengl(state, &run.opened);
    for (size_t i = 0; i < EXPERIMENT_COUNT && exit_code == PROGRAM_DONE; ++i) {
        if (is_wanted(which, i)) {
            exit_code = experiments[i].measure(&run);
        }
    }
    session_close(&run.opened);
    return exit_code;
}
