/* SPDX-License-Identifier: MIT */
/*
 * Counts what svocl asks of OpenCL: memory, by handle, and programs with their kernels; and lets launches fail. The
 * linker puts it between a test and the OpenCL loader: in CMake, svocl_count_calls(test_name) wraps the calls named
 * there (ld --wrap), in the test and in the libraries linked into it; so svocl must be static. Drivers' own calls are
 * not seen.
 *
 *     counting_begin();
 *     ... svo_build(plan, frontend, queue, &tree, NULL) ...
 *     counted figures = counting_read();
 *     assert_int_equal(figures.peak_bytes, svo_plan_peak_bytes(plan));
 *     assert_int_equal(figures.live_bytes, svo_plan_tree_bytes(plan));
 *
 * Works inside a running cmocka test, from one thread at a time.
 */
#ifndef SVOCL_TESTS_COUNTING_H
#define SVOCL_TESTS_COUNTING_H

#include <stddef.h>
#include <stdint.h>

/* Since counting_begin. Of a buffer that was made before, nothing is counted, its release neither. */
typedef struct counted {
    /* A buffer lives until clReleaseMemObject was called once more than clRetainMemObject, and as long as a sub-buffer
       of it does. Sub-buffers have no bytes of their own. */
    uint64_t live_bytes, peak_bytes;
    uint64_t total_bytes; /* of all buffers that were made */
    uint64_t live_buffers, buffers; /* those that live; calls of clCreateBuffer that succeeded */
    uint64_t sub_buffers; /* calls of clCreateSubBuffer that succeeded */
    uint64_t programs; /* calls of clCreateProgramWithSource that succeeded */
    uint64_t builds, built_kernels; /* programs that clBuildProgram compiled, and the kernels in them */
    uint64_t kernels; /* calls of clCreateKernel that succeeded */
    uint64_t failed_launches; /* as counting_fail_launch asked for */
} counted;

void counting_begin(void);
counted counting_read(void);

/* From now on the index-th launch of a kernel, counted from 0, fails with CL_INVALID_KERNEL_ARGS, once. */
void counting_fail_launch(size_t index);

/* Of the index-th program built since counting_begin: its options, and its kernels as "one;another". index is below
   counting_read().builds. Both live until the next counting_begin. */
const char *counting_options(size_t index);
const char *counting_kernels(size_t index);

#endif
