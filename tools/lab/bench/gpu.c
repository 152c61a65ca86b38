/* SPDX-License-Identifier: MIT */
/*
 * What is measured where a GPU is there once: everything by one command, in less than ten minutes, into one file. A
 * driver may crash or hang, so each step is a process of its own.
 */
#include "bench/gpu.h"

#include "bench/gpu_steps.h"
#include "measure/host.h"
#include "support/input.h"

#define REPEATS       "11"
#define SLOW_REPEATS  "5"
#define QUICK_REPEATS "2"

static const gpu_method methods[] = {
    {"cl", {"--frontend", "cl"}, false, false},
    {"cl, sorted", {"--frontend", "cl", "--builder", "sorted"}, false, false},
    {"gl-expand, interop", {"--frontend", "gl-expand", "--share", "interop"}, true, false},
    {"gl-expand, host", {"--frontend", "gl-expand", "--share", "host"}, true, false},
    {"gl-expand, copy", {"--frontend", "gl-expand", "--share", "copy"}, true, false},
    {"gl-hw", {"--frontend", "gl-hw"}, true, false},
    {"gl-compute", {"--builder", "gl-compute"}, true, true},
};
#define METHOD_COUNT (sizeof methods / sizeof methods[0])

/* What is compared with the exact reference, by the first method of each front end. */
static const gpu_method *const verified_methods[] = {&methods[0], &methods[4], &methods[5], NULL};

typedef struct gpu_work {
    gpu_input verified[4], built[4], traced[4];
    const char *stress_count, *repeats, *slow_repeats;
} gpu_work;

/* Hashes are the same on every device, front end, builder and path; these are of PoCL on a CPU. With weights by area
   gl-compute takes eight seconds a build of the statue on llvmpipe, which clips triangles in 64-bit integers slowly. */
static const gpu_work full_work = {
    .verified = {{.scene = "scene:knot:20000", .depth = "9"},
                 {.scene = "scene:needles:2000", .depth = "8"},
                 {.scene = "scene:dust:20000", .depth = "7"}},
    .built = {{"scene:cube", "8", "area", "91379db20923711cd023e72f17a1221f"},
              {"scene:statue", "9", "area", "58d21deb2ee726acae301fd7b09f2208"},
              {"scene:atrium", "10", "area", "4b180471a013d21348ed8e086f660a4b"}},
    .traced = {{.scene = "scene:statue", .depth = "8"}, {.scene = "scene:atrium", .depth = "8"}},
    .stress_count = "32",
    .repeats = REPEATS,
    .slow_repeats = SLOW_REPEATS,
};
static const gpu_work quick_work = {
    .verified = {{.scene = "scene:knot:2000", .depth = "6"}},
    .built = {{"scene:cube", "5", "uniform", "42c42f9426a397a7191277559135ac97"},
              {"scene:knot:8000", "7", "uniform", "ed94caadd565d534b230bff73c0da38a"}},
    .traced = {{.scene = "scene:knot:8000", .depth = "6"}},
    .stress_count = "0",
    .repeats = QUICK_REPEATS,
    .slow_repeats = QUICK_REPEATS,
};

static unsigned count_inputs(const gpu_input *inputs)
{
    unsigned count = 0;
    while (inputs[count].scene != NULL) {
        ++count;
    }
    return count;
}

static unsigned count_steps(const gpu_work *work)
{
    const unsigned verified_count = sizeof verified_methods / sizeof verified_methods[0] - 1;
    return 2 + count_inputs(work->verified) * verified_count + count_inputs(work->built) * (unsigned)METHOD_COUNT +
           count_inputs(work->traced);
}

static void run_checks(gpu_run *run, const gpu_work *work)
{
    progress_step(run->state->progress, "devices");
    gpu_step_devices(run);
    for (const gpu_input *source = work->verified; source->scene != NULL; ++source) {
        for (size_t i = 0; verified_methods[i] != NULL; ++i) {
            progress_step(run->state->progress, "verify");
            gpu_step_verify(run, source, verified_methods[i]);
        }
    }
    progress_step(run->state->progress, "stress");
    gpu_step_stress(run, work->stress_count);
}

static void run_times(gpu_run *run, const gpu_work *work)
{
    for (const gpu_input *source = work->built; source->scene != NULL; ++source) {
        for (size_t i = 0; i < METHOD_COUNT; ++i) {
            progress_step(run->state->progress, "build");
            gpu_step_build(run, source, &methods[i], methods[i].is_slow ? work->slow_repeats : work->repeats);
        }
    }
    for (const gpu_input *source = work->traced; source->scene != NULL; ++source) {
        progress_step(run->state->progress, "rays");
        gpu_step_rays(run, source);
    }
}

int bench_gpu(program *state, result_set *results, size_t *wrong_count)
{
    const gpu_work *work = state->options.quick ? &quick_work : &full_work;
    gpu_run run = {.state = state, .results = results, .start_ms = input_now_ms()};
    host_describe(&state->options, &results->machine);
    program_begin_progress(state, count_steps(work));
    gpu_add_tables(&run);
    run_checks(&run, work);
    run_times(&run, work);
    progress_destroy(&state->progress);
    *wrong_count = run.wrong_count;
    return result_is_whole(results) ? PROGRAM_DONE
                                    : program_fail(state, PROGRAM_FAILED, "out of memory for the tables");
}
