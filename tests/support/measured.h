/* SPDX-License-Identifier: MIT */
/*
 * A build by OpenCL alone with its costs: planned and allocated memory, compiled programs and kernels, and the plan's
 * list of work left out. Every build is checked against its plan: it allocates exactly the plan's list of buffers and
 * compiles exactly the plan's kernels. Call inside a running cmocka test, linked with svocl_count_calls.
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
    fixture opened; /* has its own device handle, so that every program is compiled for this build */
    built result;
    uint64_t planned_peak_bytes, planned_tree_bytes; /* before the build */
    uint64_t peak_bytes, tree_bytes; /* requested from clCreateBuffer */
    uint64_t programs, built_kernels;
    char defines[MEASURED_DEFINES_BYTES]; /* the options of all programs, each with a space before and after it */
    char kernels[MEASURED_KERNELS_BYTES]; /* the names of all kernels, each with a semicolon before and after it */
    struct {
        const char *what; /* static string */
        svo_message reason;
    } left_out[MEASURED_LEFT_OUT_MAX];
    size_t left_out_count;
} measured;

/* options: NULL means all defaults; struct_size need not be set. */
void measured_build(const svo_mesh *mesh, unsigned depth, const svo_plan_options *options, measured *out);
void measured_destroy(measured *made);

/* The reason why the plan left it out, or NULL if it did not. */
const char *measured_left_out(const measured *made, const char *what);
/* Whether any program has this define, for example "SVO_COLOR". */
bool measured_has_define(const measured *made, const char *define);
/* Whether any program has this kernel. */
bool measured_has_kernel(const measured *made, const char *name);
/* The entry in the plan's list after the build, or NULL. */
const svo_buffer_info *measured_buffer(const measured *made, const char *name);
/* Size on the device of an array of the tree; 0 if the tree has none. */
size_t measured_array_bytes(const measured *made, svo_tree_buffer array);

/* The figures in which a build must be below another. */
typedef enum measured_gain {
    FEWER_PEAK_BYTES = 1,
    FEWER_TREE_BYTES = 2,
    FEWER_PROGRAMS = 4,
    FEWER_KERNELS = 8,
    OTHER_DEFINES = 16,
    SAME_PEAK_BYTES = 32 /* with FEWER_PEAK_BYTES: planned below, but both builds peak where they make the nodes */
} measured_gain;

/* less is below full in the figures that gains (measured_gain bits) names and above it in none, as planned and as
   allocated. */
void assert_takes_less(const measured *less, const measured *full, unsigned gains);
/* Compares nodes and every array that both trees have, byte for byte. Lists only where the triangles are the same. */
void assert_same_results(const measured *a, const measured *b);

#endif
