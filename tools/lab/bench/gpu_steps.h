/* SPDX-License-Identifier: MIT */
/* The steps of bench gpu: each runs this program once and becomes a row. */
#ifndef SVOCL_TOOLS_BENCH_GPU_STEPS_H
#define SVOCL_TOOLS_BENCH_GPU_STEPS_H

#include "bench/child.h"
#include "measure/result.h"
#include "support/program.h"

typedef struct gpu_run {
    program *state;
    result_set *results;
    result_table *pairs, *steps; /* what works on which device and renderer; all steps */
    double start_ms; /* input_now_ms */
    size_t wrong_count;
} gpu_run;

/* A generated scene at a depth. */
typedef struct gpu_input {
    const char *scene; /* "scene:cube"; NULL: no more */
    const char *depth;
    /* For gpu_step_build: the weights of payload, and the hash of the tree with colors, normals and leaf lists. */
    const char *weights, *hash;
} gpu_input;

/* How a tree is built. */
typedef struct gpu_method {
    const char *name;
    const char *options[5]; /* ends with NULL */
    bool in_gl;
    bool is_slow; /* where OpenGL is llvmpipe: built less often */
} gpu_method;

/* Both tables, with their columns. */
void gpu_add_tables(gpu_run *run);

/* Devices and renderers, and what works on each pair; fills the machine. */
void gpu_step_devices(gpu_run *run);
/* The ill-conditioned inputs of svocl stress. count: how many, in its unit. */
void gpu_step_stress(gpu_run *run, const char *count);
/* A tree against the exact reference. */
void gpu_step_verify(gpu_run *run, const gpu_input *source, const gpu_method *method);
/* A tree's hash, its times and its calls. repeats: builds. */
void gpu_step_build(gpu_run *run, const gpu_input *source, const gpu_method *method, const char *repeats);
/* Rays, a row for each kind. */
void gpu_step_rays(gpu_run *run, const gpu_input *source);

#endif
