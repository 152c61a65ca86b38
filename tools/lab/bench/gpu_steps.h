/* SPDX-License-Identifier: MIT */
/* The steps of svocl bench gpu, each a process of its own that becomes a row. */
#ifndef SVOCL_TOOLS_BENCH_GPU_STEPS_H
#define SVOCL_TOOLS_BENCH_GPU_STEPS_H

#include "bench/child.h"
#include "measure/result.h"
#include "support/program.h"

/* How the steps went, all zero at first. What a machine does not offer is neither wrong nor failed. */
typedef struct bench_gpu_verdicts {
    size_t wrong_count, failed_count;
    svo_message first; /* the first of both, and why */
} bench_gpu_verdicts;

typedef struct gpu_run {
    program *state;
    result_set *results;
    /* The devices; what works on which device and renderer; all steps; the kernels that builds and products compiled */
    result_table *drivers, *pairs, *steps, *kernels;
    double start_ms; /* input_now_ms */
    cJSON *devices; /* what `svocl devices` says; NULL: nothing */
    bench_gpu_verdicts *verdicts;
} gpu_run;

/* A generated scene at a depth. */
typedef struct gpu_input {
    const char *scene; /* "scene:cube"; NULL: no more */
    const char *depth;
    const char *weights; /* of payload, for gpu_step_build */
    const char *hash; /* of the tree with colors, normals and leaf lists, or of the product; NULL: not known */
} gpu_input;

/* How a tree is built. */
typedef struct gpu_method {
    const char *name;
    const char *options[5]; /* ends with NULL */
    bool in_gl;
    bool is_slow; /* where OpenGL is llvmpipe: built less often */
} gpu_method;

/* What is made on a tree and has a known hash: light in each form, probes. */
typedef struct gpu_product {
    const char *step, *kind;
    gpu_input source;
    const char *options[12]; /* of svocl hash; ends with NULL */
} gpu_product;

/* All tables, with their columns. */
void gpu_add_tables(gpu_run *run);
/* Devices and renderers, and what works on each pair; fills the machine. */
void gpu_step_devices(gpu_run *run);
/* The ill-conditioned inputs of svocl stress. count: how many, in its unit. */
void gpu_step_stress(gpu_run *run, const char *count);
/* A tree against the exact reference. */
void gpu_step_verify(gpu_run *run, const gpu_input *source, const gpu_method *method);
/* The compact forms of a tree, each expanded again. */
void gpu_step_forms(gpu_run *run, const gpu_input *source);
/* A tree's hash, its times and its calls. repeats: builds. */
void gpu_step_build(gpu_run *run, const gpu_input *source, const gpu_method *method, const char *repeats);
void gpu_step_product(gpu_run *run, const gpu_product *product);
/* A subject of svocl bench, smaller than its own, as a whole. */
void gpu_step_subject(gpu_run *run, const char *name);
/* Rays, a row for each kind. */
void gpu_step_rays(gpu_run *run, const gpu_input *source);

#endif
