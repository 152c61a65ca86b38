/* SPDX-License-Identifier: MIT */
/*
 * What the machine that runs the tests has: an OpenCL device, off-screen OpenGL contexts. And a short way to run one
 * kernel or one compute shader over an array, for tests that ask the same question in several languages.
 *
 * What is not installed is skipped visibly; what is there and fails is a failure.
 */
#ifndef SVOCL_TESTS_MACHINE_H
#define SVOCL_TESTS_MACHINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "context/context.h"
#include "svocl/svocl.h"

/* The default device; skips the test when there is none. */
svo_device *machine_device_or_skip(void);

/* A context of the kind, or NULL with a printed reason when this machine cannot have one. */
svo_gl_context *machine_context_or_null(svo_gl_context_kind kind);
/* The first kind that this machine has; skips the test when there is none. */
svo_gl_context *machine_any_context_or_skip(void);

#define MACHINE_GROUP_ITEMS 64

/* item_count work-items read input and write output, which holds zeros at first. */
typedef struct machine_job {
    const void *input;
    size_t input_bytes;
    void *output;
    size_t output_bytes;
    uint32_t item_count;
} machine_job;

/* Runs kernel(global input, global output, uint item_count) in groups of MACHINE_GROUP_ITEMS. */
void machine_run_kernel(const svo_device *device, const char *source, const char *options, const char *kernel_name,
                        const machine_job *job);

/* Runs a compute shader: storage blocks 0 (input) and 1 (output), uniform uint item_count. prologue: what comes between
   the version line and the source. */
void machine_run_shader(svo_gl_context *context, const char *prologue, const char *source, const machine_job *job);

#endif
