/* SPDX-License-Identifier: MIT */
/* The program is svocl's source for kernels of integrators, and published.cl behind it. */
#include "errors/published_march.h"

#include "support/info_of.h"

extern const char published_source[];

static bool compile(svo_device *device, published_march *made)
{
    const char *texts[] = {svo_kernel_source(svo_light_target(NULL)), published_source};
    const svo_device_info on = info_of_device(device);
    made->program = clCreateProgramWithSource(on.context, 2, texts, NULL, NULL);
    if (made->program == NULL ||
        clBuildProgram(made->program, 1, &on.device, svo_kernel_options(svo_light_target(made->light)), NULL, NULL) !=
            CL_SUCCESS) {
        return false;
    }
    made->kernel = clCreateKernel(made->program, "gather_as_published", NULL);
    return made->kernel != NULL;
}

bool published_march_make(svo_device *device, svo_light *light, size_t count, cl_command_queue queue,
                          published_march *out)
{
    cl_context context = info_of_device(device).context;
    const cl_uint point_count = (cl_uint)count;
    *out = (published_march){.light = light, .queue = queue, .count = count};
    out->points = clCreateBuffer(context, CL_MEM_READ_ONLY, count * sizeof(svo_gather_point), NULL, NULL);
    out->results = clCreateBuffer(context, CL_MEM_WRITE_ONLY, count * sizeof(svo_gather_result), NULL, NULL);
    return out->points != NULL && out->results != NULL && compile(device, out) &&
           svo_kernel_set_arguments(svo_light_target(light), out->kernel, 0) == SVO_OK &&
           clSetKernelArg(out->kernel, SVO_LIGHT_ARGUMENTS, sizeof(cl_mem), (const void *)&out->points) == CL_SUCCESS &&
           clSetKernelArg(out->kernel, SVO_LIGHT_ARGUMENTS + 1, sizeof(cl_mem), (const void *)&out->results) ==
               CL_SUCCESS &&
           clSetKernelArg(out->kernel, SVO_LIGHT_ARGUMENTS + 2, sizeof point_count, &point_count) == CL_SUCCESS;
}

void published_march_free(published_march *made)
{
    if (made->kernel != NULL) {
        clReleaseKernel(made->kernel);
    }
    if (made->program != NULL) {
        clReleaseProgram(made->program);
    }
    if (made->points != NULL) {
        clReleaseMemObject(made->points);
    }
    if (made->results != NULL) {
        clReleaseMemObject(made->results);
    }
    *made = (published_march){.light = NULL};
}

bool published_march_gather(published_march *made, const svo_gather_point *points, svo_gather_result *results,
                            float range, bool with_light)
{
    const cl_float reach = range;
    const cl_uint lit = with_light;
    return clSetKernelArg(made->kernel, SVO_LIGHT_ARGUMENTS + 3, sizeof reach, &reach) == CL_SUCCESS &&
           clSetKernelArg(made->kernel, SVO_LIGHT_ARGUMENTS + 4, sizeof lit, &lit) == CL_SUCCESS &&
           clEnqueueWriteBuffer(made->queue, made->points, CL_FALSE, 0, made->count * sizeof *points, points, 0, NULL,
                                NULL) == CL_SUCCESS &&
           clEnqueueNDRangeKernel(made->queue, made->kernel, 1, NULL, &made->count, NULL, 0, NULL, NULL) ==
               CL_SUCCESS &&
           clEnqueueReadBuffer(made->queue, made->results, CL_TRUE, 0, made->count * sizeof *results, results, 0, NULL,
                               NULL) == CL_SUCCESS;
}
