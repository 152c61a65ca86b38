/* SPDX-License-Identifier: MIT */
/*
 * A build by OpenCL alone with all that it took: memory as planned and as allocated, programs and kernels as compiled,
 * what the plan left out. Every build is checked against its plan: what was allocated is the plan's list of buffers and
 * nothing else, and what was compiled are the plan's kernels. Inside a running cmocka test; linked with
 * svocl_count_calls.
 */
#ifndef SVOCL_TESTS_MEASURED_H
#define SVOCL_TESTS_MEASURED_H

#include <stdbool.h>

#include "counting.h"
#include "fixture.h"

#define MEASURED_DEFINES_BYTES 2048
#define MEASURED_KERNELS_BYTES 4096
#define MEASURED_LEFT_OUT_MAX  32

typedef struct measured {
    fixture opened; /* a device handle of its own, so that every program was compiled for this build */
    built result;
    uint64_t planned_peak_bytes, planned_tree_bytes; /* before the build */
    uint64_t peak_bytes, tree_bytes; /* that clCreateBuffer was asked for */
    uint64_t programs, built_kernels;
    char defines
        [MEASURED_DEFINES_BYTES]; /* the options of all programs, one after the other, a space before and after each */
    char kernels[MEASURED_KERNELS_BYTES]; /* the names of all kernels, a semicolon before and after each */
    struct {
        const char *what; /* static string */
        svo_message reason;
    } left_out[MEASURED_LEFT_OUT_MAX];
    size_t left_out_count;
} measured;

/* options: NULL means all defaults; struct_size need not be set. */
void measured_build(const svo_mesh *mesh, unsigned depth, const svo_plan_options *options, measured *out);
void measured_destroy(measured *made);

/* The reason, or NULL where the plan did not leave it out. */
const char *measured_left_out(const measured *made, const char *what);
/* Whether any program has this key, "SVO_COLOR" for example. */
bool measured_has_define(const measured *made, const char *key);
/* Whether any program has this kernel. */
bool measured_has_kernel(const measured *made, const char *name);
/* The entry in the plan's list after the build, or NULL. */
const svo_buffer_info *measured_buffer(const measured *made, const char *name);
/* Bytes on the device of an array of the tree; 0 without it. */
size_t measured_array_bytes(const measured *made, svo_tree_buffer array);

/* In what a build must be below another. */
typedef enum measured_gain {
    FEWER_PEAK_BYTES = 1,
    FEWER_TREE_BYTES = 2,
    FEWER_PROGRAMS = 4,
    FEWER_KERNELS = 8,
    OTHER_DEFINES = 16
} measured_gain;

/* less is below full in what gains (measured_gain bits) say, and nowhere above; as planned and as allocated. */
void assert_takes_less(const measured *less, const measured *full, unsigned gains);
/* Nodes, and every array that both trees have, byte for byte. Lists only where the triangles are the same. */
void assert_same_results(const measured *a, const measured *b);

#endif
