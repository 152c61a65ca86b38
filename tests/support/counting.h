/* SPDX-License-Identifier: MIT */
/*
 * Counts svocl's use of OpenCL: memory by handle, programs and their kernels. It can also make launches fail. The
 * linker puts it between a test and the OpenCL loader: in CMake, svocl_count_calls(test_name) wraps the calls listed
 * there (ld --wrap) in the test and in its static libraries, so svocl must be static. Calls inside drivers are not
 * counted.
 *
 *     counting_begin();
 *     ... svo_build(plan, frontend, queue, &tree, NULL) ...
 *     counted figures = counting_read();
 *     assert_int_equal(figures.peak_bytes, info_of_plan(plan).peak_bytes);
 *     assert_int_equal(figures.live_bytes, info_of_plan(plan).tree_bytes);
 *
 * Works inside a running cmocka test, from one thread at a time.
 */
#ifndef SVOCL_TESTS_COUNTING_H
#define SVOCL_TESTS_COUNTING_H

#include <stddef.h>
#include <stdint.h>

/* Counts since counting_begin. Buffers made earlier are not counted, and neither is their release. */
typedef struct counted {
    /* A buffer lives until clReleaseMemObject was called once more than clRetainMemObject, and as long as one of its
       sub-buffers lives. Sub-buffers have no bytes of their own. */
    uint64_t live_bytes, peak_bytes;
    uint64_t total_bytes; /* of all buffers ever made */
    uint64_t live_buffers, buffers; /* live ones; successful calls of clCreateBuffer */
    uint64_t sub_buffers; /* successful calls of clCreateSubBuffer */
    uint64_t programs; /* successful calls of clCreateProgramWithSource */
    uint64_t builds, built_kernels; /* programs compiled by clBuildProgram, and their kernels */
    uint64_t kernels; /* successful calls of clCreateKernel */
    uint64_t launches; /* of kernels */
    uint64_t launched_items; /* work-items of all launches of one dimension */
    uint64_t waits; /* calls of clWaitForEvents and clFinish, and blocking reads, maps and writes */
    uint64_t reads; /* blocking reads and maps */
    uint64_t read_bytes; /* that clEnqueueReadBuffer has brought to the host */
    uint64_t writes; /* calls of clEnqueueWriteBuffer */
    uint64_t written_bytes; /* that they have brought to the device */
    uint64_t fills, filled_bytes; /* calls of clEnqueueFillBuffer */
    uint64_t copies; /* calls of clEnqueueCopyBuffer */
    uint64_t failed_launches; /* as requested by counting_fail_launch */
} counted;

void counting_begin(void);
counted counting_read(void);

/* Makes one launch of a kernel fail with CL_INVALID_KERNEL_ARGS: the index-th from now on, counted from 0. */
void counting_fail_launch(size_t index);

/* The options and the kernels ("one;another") of the index-th program built since counting_begin. index is below
   counting_read().builds and below 32. Both strings live until the next counting_begin. */
const char *counting_options(size_t index);
const char *counting_kernels(size_t index);

#endif
