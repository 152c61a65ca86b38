/* SPDX-License-Identifier: MIT */
/*
 * A fault of Mesa's rusticl (seen in 25.0.7, on llvmpipe): a function with a loop that calls another one with a barrier
 * crashes the compiler, unless one of the two is always_inline. So svocl's functions with barriers, and those that call
 * them, are SVO_INLINED (kernels/shared/calls.clh), and tools/kernels.sh finds others.
 *
 * This program needs OpenCL alone. It fails where the form that svocl has gives wrong sums, and says what the other
 * form does, in a process of its own: `OCL_ICD_VENDORS=rusticl.icd RUSTICL_ENABLE=llvmpipe ./driver_nested_barrier`.
 */
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CL/cl.h>

enum { ITEMS = 64, NOT_BUILT = 2, WRONG = 3 };

static const char text[] =
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

static bool is_right(const cl_uint found[ITEMS])
{
    bool right = true;
    for (cl_uint item = 0; item < ITEMS; ++item) {
        right = right && found[item] == 2 * ((item + 1) % ITEMS) + ITEMS;
    }
    return right;
}

/* Runs the kernel on the first device of the first platform. Returns an exit code. */
static int run(const char *options)
{
    const char *source = text;
    const size_t items = ITEMS;
    cl_uint found[ITEMS] = {0};
    cl_platform_id platform = NULL;
    cl_device_id device = NULL;
    cl_int error = clGetPlatformIDs(1, &platform, NULL);
    error |= clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &device, NULL);
    if (error != CL_SUCCESS) {
        return NOT_BUILT;
    }
    cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, &error);
    cl_command_queue queue = clCreateCommandQueue(context, device, 0, &error);
    cl_program program = clCreateProgramWithSource(context, 1, &source, NULL, &error);
    if (clBuildProgram(program, 1, &device, options, NULL, NULL) != CL_SUCCESS) {
        return NOT_BUILT;
    }
    cl_kernel kernel = clCreateKernel(program, "k", &error);
    cl_mem out = clCreateBuffer(context, CL_MEM_READ_WRITE, sizeof found, NULL, &error);
    error |= clSetKernelArg(kernel, 0, sizeof out, &out);
    error |= clSetKernelArg(kernel, 1, ITEMS * sizeof(cl_uint), NULL);
    error |= clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &items, &items, 0, NULL, NULL);
    error |= clEnqueueReadBuffer(queue, out, CL_TRUE, 0, sizeof found, found, 0, NULL, NULL);
    return error == CL_SUCCESS && is_right(found) ? EXIT_SUCCESS : WRONG;
}

/* Runs it in a child, and says how that ended. Returns whether it was right. */
static bool try_form(const char *form, const char *options)
{
    int status = 0;
    (void)fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        _exit(run(options));
    }
    if (child < 0 || waitpid(child, &status, 0) != child) {
        printf("%s: no process\n", form);
        return false;
    }
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (code < 0) {
        printf("%s: ends by signal %d, %s\n", form, WTERMSIG(status), strsignal(WTERMSIG(status)));
    } else {
        printf("%s: %s\n", form, code == EXIT_SUCCESS ? "right" : code == WRONG ? "wrong" : "does not build");
    }
    return code == EXIT_SUCCESS;
}

int main(void)
{
    const bool works = try_form("always_inline", "-cl-std=CL1.2 -DINLINED=__attribute__((always_inline))");
    (void)try_form("plain", "-cl-std=CL1.2 -DINLINED=");
    return works ? EXIT_SUCCESS : EXIT_FAILURE;
}
