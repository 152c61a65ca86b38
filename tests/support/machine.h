/* SPDX-License-Identifier: MIT */
/*
 * The OpenCL device and the off-screen OpenGL contexts of the machine that runs the tests, and helpers that run one
 * kernel or one compute shader over an array, for tests of the same code in several languages.
 *
 * A missing device or context skips the test visibly. One that exists and fails is a failure.
 */
#ifndef SVOCL_TESTS_MACHINE_H
#define SVOCL_TESTS_MACHINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "context/context.h"
#include "svocl/svocl.h"

/* The default device. Skips the test when there is none. */
svo_device *machine_device_or_skip(void);

/* A context of the kind. If this machine has none, prints the reason and returns NULL. */
svo_gl_context *machine_context_or_null(svo_gl_context_kind kind);
/* A context of the first available kind. Skips the test when there is none. */
svo_gl_context *machine_any_context_or_skip(void);

#define MACHINE_GROUP_ITEMS 64

/* item_count work-items read input and write output, which starts at zero. */
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

/* Runs a compute shader: storage blocks 0 (input) and 1 (output), uniform uint item_count. prologue: text between the
   version line and the source. */
void machine_run_shader(svo_gl_context *context, const char *prologue, const char *source, const machine_job *job);

#endif
