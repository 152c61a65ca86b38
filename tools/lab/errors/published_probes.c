/* SPDX-License-Identifier: MIT */
/* The program is svocl's source for kernels of rays through probes, and published_probes.cl behind it. */
#include "errors/published_probes.h"

#define GROUP_ITEMS ((size_t)64)

extern const char published_probes_source[];

bool published_probes_make(svo_device *device, svo_probes *probes, cl_command_queue queue, published_probes *out)
{
    const char *texts[] = {svo_kernel_source(svo_probes_target(probes)), published_probes_source};
    svo_device_info on = SVO_DEVICE_INFO_INIT;
    *out = (published_probes){.queue = queue};
    if (svo_device_get_info(device, &on) != SVO_OK) {
        return false;
    }
    out->context = on.context;
    out->program = clCreateProgramWithSource(out->context, 2, texts, NULL, NULL);
    if (out->program == NULL ||
        clBuildProgram(out->program, 1, &on.device, svo_kernel_options(svo_probes_target(probes)), NULL, NULL) !=
            CL_SUCCESS) {
        return false;
    }
    out->kernel = clCreateKernel(out->program, "trace_as_published", NULL);
    return out->kernel != NULL && svo_kernel_set_arguments(svo_probes_target(probes), out->kernel, 0) == SVO_OK;
}

void published_probes_free(published_probes *made)
{
    if (made->kernel != NULL) {
        clReleaseKernel(made->kernel);
    }
    if (made->program != NULL) {
        clReleaseProgram(made->program);
    }
    *made = (published_probes){.kernel = NULL};
}

static bool launch(const published_probes *made, cl_mem rays, cl_mem hits, size_t count)
{
    const cl_uint ray_count = (cl_uint)count;
    const size_t local = GROUP_ITEMS;
    const size_t global = (count + local - 1) / local * local;
    return clSetKernelArg(made->kernel, SVO_PROBES_ARGUMENTS, sizeof(cl_mem), (const void *)&rays) == CL_SUCCESS &&
           clSetKernelArg(made->kernel, SVO_PROBES_ARGUMENTS + 1, sizeof(cl_mem), (const void *)&hits) == CL_SUCCESS &&
           clSetKernelArg(made->kernel, SVO_PROBES_ARGUMENTS + 2, sizeof ray_count, &ray_count) == CL_SUCCESS &&
           clEnqueueNDRangeKernel(made->queue, made->kernel, 1, NULL, &global, &local, 0, NULL, NULL) == CL_SUCCESS;
}

bool published_probes_trace(const published_probes *made, const svo_ray *rays, svo_probe_hit *hits, size_t count)
{
    cl_mem from = clCreateBuffer(made->context, CL_MEM_READ_ONLY, count * sizeof *rays, NULL, NULL);
    cl_mem to = clCreateBuffer(made->context, CL_MEM_WRITE_ONLY, count * sizeof *hits, NULL, NULL);
    const bool worked =
        from != NULL && to != NULL &&
        clEnqueueWriteBuffer(made->queue, from, CL_TRUE, 0, count * sizeof *rays, rays, 0, NULL, NULL) == CL_SUCCESS &&
        launch(made, from, to, count) &&
        clEnqueueReadBuffer(made->queue, to, CL_TRUE, 0, count * sizeof *hits, hits, 0, NULL, NULL) == CL_SUCCESS;
    if (from != NULL) {
        clReleaseMemObject(from);
    }
    if (to != NULL) {
        clReleaseMemObject(to);
    }
    return worked;
}
