/* SPDX-License-Identifier: MIT */
/*
 * What is measured where a GPU is there once: everything by one command, in less than ten minutes, into one file. A
 * driver may crash or hang, so each step runs svocl in a process of its own, and becomes a row.
 */
#include "bench/gpu.h"

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
    {"gl-hybrid", {"--frontend", "gl-hybrid", "--hybrid-columns", "64"}, true, false},
    {"gl-compute", {"--builder", "gl-compute"}, true, true},
};
#define METHOD_COUNT (sizeof methods / sizeof methods[0])

/* What is compared with the exact reference, by the first method of each front end. */
static const gpu_method *const verified_methods[] = {&methods[0], &methods[4], &methods[5], NULL};

typedef struct gpu_work {
    gpu_input verified[4], built[4], traced[4], formed;
    const char *stress_count, *repeats, *slow_repeats;
    const char *subjects[4]; /* ends with NULL */
} gpu_work;

/* Hashes are the same on every device, front end, builder and path; these are of PoCL on a CPU. With weights by area
   gl-compute takes eight seconds a build of the statue on llvmpipe, which clips triangles in 64-bit integers slowly. */
static const gpu_work full_work = {
    .verified = {{.scene = "scene:knot:20000", .depth = "9"},
                 {.scene = "scene:needles:2000", .depth = "8"},
                 {.scene = "scene:dust:20000", .depth = "7"}},
    .built = {{"scene:cube", "8", "area", "5584746d1604d9ff300a9da5184513e2"},
              {"scene:statue", "9", "area", "a7b1d1838a58601db23225765f1da45f"},
              {"scene:atrium", "10", "area", "3295ef42d8af5ce9c9f3d5873673f309"}},
    .traced = {{.scene = "scene:statue", .depth = "8"}, {.scene = "scene:atrium", .depth = "8"}},
    .formed = {.scene = "scene:knot:20000", .depth = "8"},
    .subjects = {"moving", "scene", "solid"},
    .stress_count = "32",
    .repeats = REPEATS,
    .slow_repeats = SLOW_REPEATS,
};
static const gpu_work quick_work = {
    .verified = {{.scene = "scene:knot:8000", .depth = "6"}}, /* enough triangles for plans by kernels */
    .built = {{"scene:cube", "5", "uniform", "a7fe0dfc7847da89b4d733c3bf384e4f"},
              {"scene:knot:8000", "7", "uniform", "4ab1454d2f06554c7afc29e7be84de1b"}},
    .traced = {{.scene = "scene:knot:8000", .depth = "6"}},
    .formed = {.scene = "scene:knot:8000", .depth = "6"},
    .subjects = {"solid"},
    .stress_count = "0",
    .repeats = QUICK_REPEATS,
    .slow_repeats = QUICK_REPEATS,
};

#define LIT_NEEDS "color,normal,rays,fill,projected-area"
static const gpu_product products[] = {
    {"light",
     "faces",
     {"scene:knot:8000", "7", NULL, "28df34d015699bcbcb1ad99183110558"},
     {"--need", LIT_NEEDS, "--light", "faces"}},
    {"light",
     "bricks",
     {"scene:knot:8000", "7", NULL, "a2da6ca3ff26b5d67bb933229b610b88"},
     {"--need", LIT_NEEDS, "--light", "bricks"}},
    {"light",
     "voxels",
     {"scene:knot:8000", "7", NULL, "20d33daf0a6ba89a46779338cb05e832"},
     {"--need", LIT_NEEDS, "--light", "voxels"}},
    {"probes",
     "one place",
     {"scene:cornell:60", "5", NULL, "67fd5f2bb50722ff6d9c31c36fe4b716"},
     {"--need", "rays", "--probes", "1,1,1", "--probe-resolution", "64", "--probe-field", "16"}},
};
#define PRODUCT_COUNT (sizeof products / sizeof products[0])

static unsigned count_subjects(const gpu_work *work)
{
    unsigned count = 0;
    while (work->subjects[count] != NULL) {
        ++count;
    }
    return count;
}

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
    return 3 + (unsigned)PRODUCT_COUNT + count_subjects(work) + count_inputs(work->verified) * verified_count +
           count_inputs(work->built) * (unsigned)METHOD_COUNT + count_inputs(work->traced);
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
    progress_step(run->state->progress, "compact");
    gpu_step_forms(run, &work->formed);
    for (size_t i = 0; i < PRODUCT_COUNT; ++i) {
        progress_step(run->state->progress, products[i].step);
        gpu_step_product(run, &products[i]);
    }
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
    for (size_t i = 0; work->subjects[i] != NULL; ++i) {
        progress_step(run->state->progress, work->subjects[i]);
        gpu_step_subject(run, work->subjects[i]);
    }
}

int bench_gpu(program *state, result_set *results, bench_gpu_verdicts *verdicts)
{
    const gpu_work *work = state->options.quick ? &quick_work : &full_work;
    gpu_run run = {.state = state, .results = results, .start_ms = input_now_ms(), .verdicts = verdicts};
    host_describe(&state->options, &results->machine);
    program_begin_progress(state, count_steps(work));
    gpu_add_tables(&run);
    run_checks(&run, work);
    run_times(&run, work);
    progress_destroy(&state->progress);
    cJSON_Delete(run.devices);
    return result_is_whole(results) ? PROGRAM_DONE
                                    : program_fail(state, PROGRAM_FAILED, "out of memory for the tables");
}
