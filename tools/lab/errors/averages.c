/* SPDX-License-Identifier: MIT */
/* Buffers, launches, and conversion from 8-bit values. */
#include "errors/averages.h"

#include <math.h>
#include <stdlib.h>

#include "support/input.h"

#define GROUP_ITEMS 64u

extern const char averages_source[];

struct averages {
    const session *opened;
    cl_program program;
    cl_kernel kernels[AVERAGE_METHOD_COUNT];
    cl_mem cells, samples, results;
    size_t count, leaf_count;
    double scale, offset;
};

static const char *const kernel_names[AVERAGE_METHOD_COUNT] = {"average_rgba8", "add_float"};
static const size_t words_per_leaf[AVERAGE_METHOD_COUNT] = {1, 4};

static bool compile(averages *made)
{
    const char *source = averages_source;
    const cl_device_id device = svo_device_cl_device(made->opened->device);
    made->program = clCreateProgramWithSource(svo_device_cl_context(made->opened->device), 1, &source, NULL, NULL);
    bool worked = made->program != NULL && clBuildProgram(made->program, 1, &device, NULL, NULL, NULL) == CL_SUCCESS;
    for (int method = 0; method < AVERAGE_METHOD_COUNT && worked; ++method) {
        made->kernels[method] = clCreateKernel(made->program, kernel_names[method], NULL);
        worked = made->kernels[method] != NULL;
    }
    return worked;
}

static bool make_buffers(averages *made)
{
    cl_context context = svo_device_cl_context(made->opened->device);
    made->cells = clCreateBuffer(context, CL_MEM_READ_ONLY, made->count * sizeof(cl_uint), NULL, NULL);
    made->samples = clCreateBuffer(context, CL_MEM_READ_ONLY, made->count * sizeof(cl_float4), NULL, NULL);
    made->results = clCreateBuffer(context, CL_MEM_READ_WRITE, made->leaf_count * 4 * sizeof(cl_uint), NULL, NULL);
    return made->cells != NULL && made->samples != NULL && made->results != NULL;
}

static bool set_arguments(averages *made)
{
    const cl_uint count = (cl_uint)made->count;
    bool worked = true;
    for (int method = 0; method < AVERAGE_METHOD_COUNT && worked; ++method) {
        cl_kernel kernel = made->kernels[method];
        worked = clSetKernelArg(kernel, 0, sizeof(cl_mem), (const void *)&made->cells) == CL_SUCCESS &&
                 clSetKernelArg(kernel, 1, sizeof(cl_mem), (const void *)&made->samples) == CL_SUCCESS &&
                 clSetKernelArg(kernel, 2, sizeof(cl_mem), (const void *)&made->results) == CL_SUCCESS &&
                 clSetKernelArg(kernel, 3, sizeof count, &count) == CL_SUCCESS;
    }
    return worked;
}

averages *averages_create(const session *opened, const attribute_samples *samples)
{
    averages *made = calloc(1, sizeof *made);
    if (made == NULL) {
        return NULL;
    }
    made->opened = opened;
    made->count = samples->count;
    made->leaf_count = samples->leaf_count;
    if (!compile(made) || !make_buffers(made) || !set_arguments(made)) {
        averages_destroy(&made);
    }
    return made;
}

void averages_destroy(averages **made)
{
    averages *old = *made;
    if (old == NULL) {
        return;
    }
    cl_mem buffers[3] = {old->cells, old->samples, old->results};
    for (int i = 0; i < 3; ++i) {
        if (buffers[i] != NULL) {
            clReleaseMemObject(buffers[i]);
        }
    }
    for (int method = 0; method < AVERAGE_METHOD_COUNT; ++method) {
        if (old->kernels[method] != NULL) {
            clReleaseKernel(old->kernels[method]);
        }
    }
    if (old->program != NULL) {
        clReleaseProgram(old->program);
    }
    free(old);
    *made = NULL;
}

bool averages_upload(averages *made, const attribute_samples *samples, double scale, double offset)
{
    cl_command_queue queue = made->opened->queue;
    float(*scaled)[4] = calloc(made->count + 1, sizeof *scaled);
    made->scale = scale;
    made->offset = offset;
    for (size_t i = 0; i < made->count && scaled != NULL; ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            scaled[i][channel] = (float)((double)samples->values[i][channel] * scale + offset);
        }
    }
    const bool worked = scaled != NULL &&
                        clEnqueueWriteBuffer(queue, made->samples, CL_TRUE, 0, made->count * sizeof *scaled, scaled, 0,
                                             NULL, NULL) == CL_SUCCESS &&
                        clEnqueueWriteBuffer(queue, made->cells, CL_TRUE, 0, made->count * sizeof(cl_uint),
                                             samples->leaves, 0, NULL, NULL) == CL_SUCCESS;
    free(scaled);
    return worked;
}

double averages_run(averages *made, average_method method)
{
    cl_command_queue queue = made->opened->queue;
    const cl_uint zero = 0;
    const size_t group = GROUP_ITEMS;
    const size_t size = (made->count + group - 1) / group * group;
    if (clEnqueueFillBuffer(queue, made->results, &zero, sizeof zero, 0, made->leaf_count * 4 * sizeof zero, 0, NULL,
                            NULL) != CL_SUCCESS ||
        clFinish(queue) != CL_SUCCESS) {
        return -1.0;
    }
    const double started_ms = input_now_ms();
    const bool worked =
        clEnqueueNDRangeKernel(queue, made->kernels[method], 1, NULL, &size, &group, 0, NULL, NULL) == CL_SUCCESS &&
        clFinish(queue) == CL_SUCCESS;
    return worked ? input_now_ms() - started_ms : -1.0;
}

static void unpack(const averages *made, average_method method, const cl_uint *words, double mean[3])
{
    union {
        cl_uint bits;
        float number;
    } sums[4];
    for (size_t i = 0; i < 4 && method == AVERAGE_FLOAT; ++i) {
        sums[i].bits = words[i];
    }
    for (unsigned channel = 0; channel < 3; ++channel) {
        const double octets = method == AVERAGE_FLOAT ? (double)sums[channel].number / fmax((double)sums[3].number, 1.0)
                                                      : (double)(words[0] >> 8 * channel & 255u);
        mean[channel] = (octets - made->offset) / made->scale;
    }
}

bool averages_read(averages *made, average_method method, double (*means)[3])
{
    const size_t bytes = made->leaf_count * words_per_leaf[method] * sizeof(cl_uint);
    cl_uint *words = malloc(bytes + 1);
    const bool worked = words != NULL && clEnqueueReadBuffer(made->opened->queue, made->results, CL_TRUE, 0, bytes,
                                                             words, 0, NULL, NULL) == CL_SUCCESS;
    for (size_t leaf = 0; leaf < made->leaf_count && worked; ++leaf) {
        unpack(made, method, words + leaf * words_per_leaf[method], means[leaf]);
    }
    free(words);
    return worked;
}
