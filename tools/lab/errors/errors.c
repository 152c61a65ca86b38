/* SPDX-License-Identifier: MIT */
/* What the experiments share: rounds, threads, scenes and failures. */
#include "errors/errors.h"

#include <stdio.h>

#include "path/threads.h"

#define QUICK_ROUNDS 2u
#define FULL_ROUNDS  11u

void errors_set_rounds(error_run *run, size_t rounds)
{
    run->rounds = rounds;
    if (rounds > 1) {
        (void)snprintf(run->rounds_note, sizeof run->rounds_note, "Medians of %zu rounds after a warm-up round",
                       rounds);
    } else {
        (void)snprintf(run->rounds_note, sizeof run->rounds_note, "Times of one round without a warm-up round");
    }
}

error_run errors_begin(const suite *all)
{
    const unsigned threads = all->results->machine.cpu_threads;
    const bool asked = all->state->options.has_repeat;
    error_run run = {.state = all->state,
                     .opened = all->opened,
                     .quick = all->quick,
                     .threads = threads < THREADS_MAX ? threads : THREADS_MAX,
                     .results = all->results,
                     .scenes = all->scenes};
    errors_set_rounds(&run, asked ? all->repeats : all->quick ? QUICK_ROUNDS : FULL_ROUNDS);
    run.opened.frontend = run.opened.gl != NULL ? opengl_frontend(run.opened.gl) : run.opened.cl;
    return run;
}

int errors_fail(error_run *run)
{
    const char *words = svo_device_message(run->opened.device);
    return words[0] != '\0' ? program_fail_library(run->state, words)
                            : program_fail(run->state, PROGRAM_FAILED, "out of memory");
}

error_scene errors_scene_at(const error_run *run, const error_scene *own, size_t index)
{
    const error_scene asked = {.spec = run->scenes[index]};
    return run->scenes[0] != NULL ? asked : own[index];
}

const char *errors_scene_name(const error_scene *given, const input *source)
{
    return given->name != NULL ? given->name : suite_scene_name(source);
}
