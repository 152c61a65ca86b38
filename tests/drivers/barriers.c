/* SPDX-License-Identifier: MIT */
/*
 * Faults of drivers' compilers at barriers. Each has a kernel in two forms: the one that svocl has, which must be
 * right, and the one that the fault was seen with. This program needs OpenCL alone. It fails where the first form is
 * wrong, and says what the other does, in a process of its own.
 *
 *   nested  Mesa's rusticl (seen in 25.0.7, on llvmpipe): a function with a loop that calls another one with a barrier
 *           crashes the compiler, unless one of the two is always_inline. So svocl's functions with barriers, and those
 *           that call them, are SVO_INLINED (kernels/shared/calls.clh), and tools/kernels.sh finds others.
 *           OCL_ICD_VENDORS=rusticl.icd RUSTICL_ENABLE=llvmpipe driver_barriers
 *   values  Intel's driver for CPUs (seen in 2026.2.0): its pass sycl-kernel-reduce-cross-barrier-values reads memory
 *           that it has freed where many values live across the barriers of nested loops. One compilation in fifty
 *           crashes or never ends, and all do once freed memory is overwritten, as here. So svo_k_material_long calls
 *           its sort at one place.
 */
#include <malloc.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CL/cl.h>

enum { ITEMS = 64, ENTRIES = 1000, DIGITS = 2, NOT_BUILT = 2, WRONG = 3 };

typedef struct opened {
    cl_context context;
    cl_command_queue queue;
    cl_kernel kernel; /* "k", of one work-group of ITEMS work-items */
} opened;

/* Compiles a kernel for the first device of the first platform. */
static bool open_kernel(const char *text, const char *options, opened *out)
{
    cl_platform_id platform = NULL;
    cl_device_id device = NULL;
    cl_int error = clGetPlatformIDs(1, &platform, NULL);
    error |= clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &device, NULL);
    if (error != CL_SUCCESS) {
        return false;
    }
    out->context = clCreateContext(NULL, 1, &device, NULL, NULL, &error);
    out->queue = clCreateCommandQueue(out->context, device, 0, &error);
    cl_program program = clCreateProgramWithSource(out->context, 1, &text, NULL, &error);
    error = clBuildProgram(program, 1, &device, options, NULL, NULL);
    out->kernel = error == CL_SUCCESS ? clCreateKernel(program, "k", &error) : NULL;
    return error == CL_SUCCESS;
}

static cl_int run_kernel(const opened *kernel, cl_mem from, size_t bytes, void *found)
{
    const size_t items = ITEMS;
    const cl_int error = clEnqueueNDRangeKernel(kernel->queue, kernel->kernel, 1, NULL, &items, &items, 0, NULL, NULL);
    return error | clEnqueueReadBuffer(kernel->queue, from, CL_TRUE, 0, bytes, found, 0, NULL, NULL);
}

/* --- nested ------------------------------------------------------------------------------------------------------ */

static const char nested_text[] =
    "static INLINED uint next_in_group(uint value, __local uint *scratch)\n"
    "{\n"
    "    const uint item = (uint)get_local_id(0);\n"
    "    scratch[item] = value;\n"
    "    barrier(CLK_LOCAL_MEM_FENCE);\n"
    "    return scratch[(item + 1u) % 64u];\n"
    "}\n"
    "static INLINED uint sum_of_next(__local uint *scratch)\n"
    "{\n"
    "    uint sum = 0u;\n"
    "    for (uint k = (uint)get_local_id(0); k < 128u; k += 64u) {\n"
    "        sum += k;\n"
    "    }\n"
    "    return next_in_group(sum, scratch);\n"
    "}\n"
    "__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void k(__global uint *out, __local uint *scratch)\n"
    "{\n"
    "    out[get_local_id(0)] = sum_of_next(scratch);\n"
    "}\n";

static bool is_right_nested(const opened *kernel)
{
    cl_uint found[ITEMS] = {0};
    cl_int error = CL_SUCCESS;
    cl_mem out = clCreateBuffer(kernel->context, CL_MEM_READ_WRITE, sizeof found, NULL, &error);
    error |= clSetKernelArg(kernel->kernel, 0, sizeof out, &out);
    error |= clSetKernelArg(kernel->kernel, 1, ITEMS * sizeof(cl_uint), NULL);
    error |= run_kernel(kernel, out, sizeof found, found);
    bool right = error == CL_SUCCESS;
    for (cl_uint item = 0; item < ITEMS; ++item) {
        right = right && found[item] == 2 * ((item + 1) % ITEMS) + ITEMS;
    }
    return right;
}

/* --- values ------------------------------------------------------------------------------------------------------ */

/* Sorts ranges of entries by their digits, and leaves each value once. */
static const char values_text[] =
    "static INLINED uint sum_before(uint value, __local uint *scratch, uint *total)\n"
    "{\n"
    "    const uint item = (uint)get_local_id(0);\n"
    "    uint sum = value;\n"
    "    scratch[item] = sum;\n"
    "    barrier(CLK_LOCAL_MEM_FENCE);\n"
    "    for (uint reach = 1u; reach < 64u; reach *= 2u) {\n"
    "        const uint before = item >= reach ? scratch[item - reach] : 0u;\n"
    "        barrier(CLK_LOCAL_MEM_FENCE);\n"
    "        sum += before;\n"
    "        scratch[item] = sum;\n"
    "        barrier(CLK_LOCAL_MEM_FENCE);\n"
    "    }\n"
    "    *total = scratch[63];\n"
    "    barrier(CLK_LOCAL_MEM_FENCE);\n"
    "    return sum - value;\n"
    "}\n"
    "static INLINED void scan_digits(__local uint *counts, __local uint *scratch)\n"
    "{\n"
    "    const uint item = (uint)get_local_id(0);\n"
    "    uint sum = 0u;\n"
    "    for (uint k = 0u; k < 16u; ++k) {\n"
    "        const uint count = counts[item * 16u + k];\n"
    "        counts[item * 16u + k] = sum;\n"
    "        sum += count;\n"
    "    }\n"
    "    scratch[item] = sum;\n"
    "    barrier(CLK_LOCAL_MEM_FENCE);\n"
    "    for (uint reach = 1u; reach < 64u; reach *= 2u) {\n"
    "        const uint before = item >= reach ? scratch[item - reach] : 0u;\n"
    "        barrier(CLK_LOCAL_MEM_FENCE);\n"
    "        scratch[item] += before;\n"
    "        barrier(CLK_LOCAL_MEM_FENCE);\n"
    "    }\n"
    "    const uint before = scratch[item] - sum;\n"
    "    for (uint k = 0u; k < 16u; ++k) {\n"
    "        counts[item * 16u + k] += before;\n"
    "    }\n"
    "    barrier(CLK_LOCAL_MEM_FENCE);\n"
    "}\n"
    "static uint2 strip_of(uint begin, uint end)\n"
    "{\n"
    "    const uint length = (end - begin + 63u) / 64u;\n"
    "    const uint first = min((uint)get_local_id(0) * length, end - begin);\n"
    "    return (uint2)(begin + first, begin + min(first + length, end - begin));\n"
    "}\n"
    "static INLINED void sort_digit(__global const uint *from, __global uint *to, uint2 range, uint digit,\n"
    "                               __local uint *counts, __local uint *scratch)\n"
    "{\n"
    "    const uint item = (uint)get_local_id(0);\n"
    "    const uint2 strip = strip_of(range.x, range.y);\n"
    "    for (uint k = 0u; k < 16u; ++k) {\n"
    "        counts[k * 64u + item] = 0u;\n"
    "    }\n"
    "    for (uint i = strip.x; i < strip.y; ++i) {\n"
    "        ++counts[(from[i] >> 4u * digit & 15u) * 64u + item];\n"
    "    }\n"
    "    barrier(CLK_LOCAL_MEM_FENCE);\n"
    "    scan_digits(counts, scratch);\n"
    "    for (uint i = strip.x; i < strip.y; ++i) {\n"
    "        const uint entry = from[i];\n"
    "        to[range.x + counts[(entry >> 4u * digit & 15u) * 64u + item]++] = entry;\n"
    "    }\n"
    "    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);\n"
    "}\n"
    "__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void\n"
    "k(__global uint *entries, __global uint *spare, __global const uint *begins, __global uint *lengths, uint count,\n"
    "  uint digits, __local uint *counts, __local uint *scratch)\n"
    "{\n"
    "    for (uint k = (uint)get_group_id(0); k < count; k += (uint)get_num_groups(0)) {\n"
    "        const uint2 range = (uint2)(begins[k], begins[k + 1u]);\n"
    "#ifdef TWO_CALLS\n"
    "        for (uint digit = 0u; digit < digits; digit += 2u) {\n"
    "            sort_digit(entries, spare, range, digit, counts, scratch);\n"
    "            sort_digit(spare, entries, range, digit + 1u, counts, scratch);\n"
    "        }\n"
    "#else\n"
    "        __global uint *from = entries;\n"
    "        __global uint *to = spare;\n"
    "        for (uint digit = 0u; digit < digits; ++digit) {\n"
    "            sort_digit(from, to, range, digit, counts, scratch);\n"
    "            __global uint *const sorted = to;\n"
    "            to = from;\n"
    "            from = sorted;\n"
    "        }\n"
    "#endif\n"
    "        const uint2 strip = strip_of(range.x, range.y);\n"
    "        uint ends = 0u;\n"
    "        for (uint i = strip.x; i < strip.y; ++i) {\n"
    "            ends += i + 1u == range.y || entries[i] != entries[i + 1u] ? 1u : 0u;\n"
    "        }\n"
    "        uint total;\n"
    "        uint place = range.x + sum_before(ends, scratch, &total);\n"
    "        barrier(CLK_GLOBAL_MEM_FENCE);\n"
    "        for (uint i = strip.x; i < strip.y; ++i) {\n"
    "            if (i + 1u == range.y || entries[i] != entries[i + 1u]) {\n"
    "                spare[place++] = entries[i];\n"
    "            }\n"
    "        }\n"
    "        barrier(CLK_GLOBAL_MEM_FENCE);\n"
    "        for (uint i = range.x + (uint)get_local_id(0); i < range.x + total; i += 64u) {\n"
    "            entries[i] = spare[i];\n"
    "        }\n"
    "        barrier(CLK_GLOBAL_MEM_FENCE);\n"
    "        if (get_local_id(0) == 0u) {\n"
    "            lengths[k] = total;\n"
    "        }\n"
    "    }\n"
    "}\n";

static cl_int set_buffer(const opened *kernel, cl_uint place, size_t bytes, const void *contents, cl_mem *out)
{
    cl_int error = CL_SUCCESS;
    *out = clCreateBuffer(kernel->context, CL_MEM_READ_WRITE, bytes, NULL, &error);
    error |= clEnqueueWriteBuffer(kernel->queue, *out, CL_TRUE, 0, bytes, contents, 0, NULL, NULL);
    return error | clSetKernelArg(kernel->kernel, place, sizeof *out, out);
}

/* One range of multiples of 3 below 256, of each several. */
static bool is_right_values(const opened *kernel)
{
    enum { VALUES = 86 };
    const cl_uint begins[2] = {0, ENTRIES}, count = 1, digits = DIGITS;
    cl_uint entries[ENTRIES], length = 0;
    for (cl_uint i = 0; i < ENTRIES; ++i) {
        entries[i] = i * 37 % VALUES * 3;
    }
    cl_mem of_entries, spare, of_begins, lengths;
    cl_int error = set_buffer(kernel, 0, sizeof entries, entries, &of_entries);
    error |= set_buffer(kernel, 1, sizeof entries, entries, &spare);
    error |= set_buffer(kernel, 2, sizeof begins, begins, &of_begins);
    error |= set_buffer(kernel, 3, sizeof length, &length, &lengths);
    error |= clSetKernelArg(kernel->kernel, 4, sizeof count, &count);
    error |= clSetKernelArg(kernel->kernel, 5, sizeof digits, &digits);
    error |= clSetKernelArg(kernel->kernel, 6, 16 * ITEMS * sizeof(cl_uint), NULL);
    error |= clSetKernelArg(kernel->kernel, 7, ITEMS * sizeof(cl_uint), NULL);
    error |= run_kernel(kernel, of_entries, sizeof entries, entries);
    error |= clEnqueueReadBuffer(kernel->queue, lengths, CL_TRUE, 0, sizeof length, &length, 0, NULL, NULL);
    bool right = error == CL_SUCCESS && length == VALUES;
    for (cl_uint i = 0; i < VALUES; ++i) {
        right = right && entries[i] == 3 * i;
    }
    return right;
}

/* ----------------------------------------------------------------------------------------------------------------- */

typedef struct kernel_form {
    const char *name, *text, *options;
    bool (*is_right)(const opened *kernel);
} kernel_form;

/* Returns an exit code. */
static int run(const kernel_form *form)
{
    opened kernel = {.kernel = NULL};
    (void)mallopt(M_PERTURB, 0xa5);
    return !open_kernel(form->text, form->options, &kernel) ? NOT_BUILT
           : form->is_right(&kernel)                        ? EXIT_SUCCESS
                                                            : WRONG;
}

/* Runs a form in a child, and says how that ended. Returns whether it was right. */
static bool try_form(const kernel_form *form)
{
    int status = 0;
    (void)fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        (void)alarm(60); /* since a compiler may never end */
        _exit(run(form));
    }
    if (child < 0 || waitpid(child, &status, 0) != child) {
        printf("%s: no process\n", form->name);
        return false;
    }
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (code < 0) {
        printf("%s: ends by signal %d, %s\n", form->name, WTERMSIG(status), strsignal(WTERMSIG(status)));
    } else {
        printf("%s: %s\n", form->name, code == EXIT_SUCCESS ? "right" : code == WRONG ? "wrong" : "does not build");
    }
    return code == EXIT_SUCCESS;
}

#define INLINED "-cl-std=CL1.2 -DINLINED=__attribute__((always_inline))"

int main(void)
{
    const kernel_form own[] = {{"nested, always_inline", nested_text, INLINED, is_right_nested},
                               {"values, one call", values_text, INLINED, is_right_values}};
    const kernel_form others[] = {{"nested, plain", nested_text, "-cl-std=CL1.2 -DINLINED=", is_right_nested},
                                  {"values, two calls", values_text, INLINED " -DTWO_CALLS", is_right_values}};
    bool works = true;
    for (size_t i = 0; i < sizeof own / sizeof *own; ++i) {
        works = try_form(&own[i]) && works;
        (void)try_form(&others[i]);
    }
    return works ? EXIT_SUCCESS : EXIT_FAILURE;
}
