/* SPDX-License-Identifier: MIT */
/* Opens what the experiments share and runs them one after the other. */
#include "errors/errors.h"

#include <string.h>

#include "errors/bench_errors.h"
#include "measure/threads.h"

#define QUICK_ROUNDS 2u
#define FULL_ROUNDS  11u

static const struct {
    const char *name, *summary;
    int (*measure)(error_run *run);
    unsigned step_count; /* of the progress bar */
} experiments[] = {
    {"e1", "error beside time: voxels missed and too many, by every way to voxelize", errors_voxelization, 10},
    {"e2", "error beside time: rays missed and wrong, by every ray-triangle test", errors_rays, 12},
    {"e3", "error beside time: colors and normals of voxels, and what the order does to them", errors_attributes, 2},
    {"e4", "error beside time: what a level of detail loses", errors_detail, 2},
    {"e5", "error beside time: where each way breaks as meshes get stiffer", errors_conditioning, 6},
};

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

const char *bench_errors_describe(size_t index, const char **summary)
{
    *summary = index < EXPERIMENT_COUNT ? experiments[index].summary : NULL;
    return index < EXPERIMENT_COUNT ? experiments[index].name : NULL;
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

int bench_errors_fill(const bench_suite *all, const char *which)
{
    const unsigned threads = all->results->machine.cpu_threads;
    const bool asked = all->state->options.has_repeat;
    error_run run = {.state = all->state,
                     .opened = all->opened,
                     .quick = all->quick,
                     .threads = threads < THREADS_MAX ? threads : THREADS_MAX,
                     .rounds = asked        ? all->repeats
                               : all->quick ? QUICK_ROUNDS
                                            : FULL_ROUNDS,
                     .results = all->results};
    run.opened.frontend = run.opened.gl != NULL ? opengl_frontend(run.opened.gl) : run.opened.cl;
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; i < EXPERIMENT_COUNT && exit_code == PROGRAM_DONE; ++i) {
        if (is_wanted(which, i)) {
            exit_code = experiments[i].measure(&run);
        }
    }
    return exit_code;
}
