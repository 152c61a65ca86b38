/* SPDX-License-Identifier: MIT */
/* One work-item per ray. */
#include "errors/voxel_cast.h"

#include <stdlib.h>

#include "support/info_of.h"
#include "support/input.h"

#define GROUP_ITEMS 64u

static const char kernel_source[] =
    "__kernel void cast_voxels(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global float *ts, uint ray_count)\n"
    "{\n"
    "    SVO_TREE_MAKE(tree);\n"
    "    const uint i = get_global_id(0);\n"
    "    if (i < ray_count) {\n"
    "        const svo_ray ray = rays[i];\n"
    "        svo_voxel_hit hit;\n"
    "        ts[i] = svo_trace_voxel(&tree, &ray, 0.0f, &hit) ? hit.t : INFINITY;\n"
    "    }\n"
    "}\n";

struct voxel_cast {
    const session *opened;
    svo_tree *tree;
    cl_program program;
    cl_kernel kernel;
    cl_mem rays, ts;
    size_t ray_count;
};

static bool build_tree(voxel_cast *made, const svo_mesh *mesh, unsigned depth, const svo_plan_options *grid)
{
    svo_plan_options occupancy = *grid;
    svo_plan *plan = NULL;
    occupancy.need = (uint32_t)SVO_NEED_NONE;
    const bool worked = svo_plan_create(made->opened->device, mesh, depth, &occupancy, &plan) == SVO_OK &&
                        svo_build(plan, made->opened->frontend, made->opened->queue, &made->tree, NULL) == SVO_OK;
    svo_plan_destroy(&plan);
    return worked;
}

static bool compile(voxel_cast *made)
{
    const char *sources[2] = {svo_kernel_source(svo_tree_target(NULL)), kernel_source};
    const svo_device_info on = info_of_device(made->opened->device);
    made->program = clCreateProgramWithSource(on.context, 2, sources, NULL, NULL);
    if (made->program == NULL || clBuildProgram(made->program, 1, &on.device, svo_kernel_options(svo_tree_target(NULL)),
                                                NULL, NULL) != CL_SUCCESS) {
        return false;
    }
    made->kernel = clCreateKernel(made->program, "cast_voxels", NULL);
    return made->kernel != NULL;
}

static bool set_arguments(voxel_cast *made, const svo_ray *rays)
{
    cl_context context = info_of_device(made->opened->device).context;
    const cl_uint count = (cl_uint)made->ray_count;
    made->rays = clCreateBuffer(context, CL_MEM_READ_ONLY, made->ray_count * sizeof *rays, NULL, NULL);
    made->ts = clCreateBuffer(context, CL_MEM_WRITE_ONLY, made->ray_count * sizeof(float), NULL, NULL);
    return made->rays != NULL && made->ts != NULL &&
           clEnqueueWriteBuffer(made->opened->queue, made->rays, CL_TRUE, 0, made->ray_count * sizeof *rays, rays, 0,
                                NULL, NULL) == CL_SUCCESS &&
           svo_kernel_set_arguments(svo_tree_target(made->tree), made->kernel, 0) == SVO_OK &&
           clSetKernelArg(made->kernel, SVO_TREE_ARGUMENTS, sizeof(cl_mem), (const void *)&made->rays) == CL_SUCCESS &&
           clSetKernelArg(made->kernel, SVO_TREE_ARGUMENTS + 1, sizeof(cl_mem), (const void *)&made->ts) ==
               CL_SUCCESS &&
           clSetKernelArg(made->kernel, SVO_TREE_ARGUMENTS + 2, sizeof count, &count) == CL_SUCCESS;
}

voxel_cast *voxel_cast_create(const session *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *grid,
                              const svo_ray *rays, size_t ray_count)
{
    voxel_cast *made = calloc(1, sizeof *made);
    if (made == NULL) {
        return NULL;
    }
    made->opened = opened;
    made->ray_count = ray_count;
    if (!build_tree(made, mesh, depth, grid) || !compile(made) || !set_arguments(made, rays)) {
        voxel_cast_destroy(&made);
    }
    return made;
}

void voxel_cast_destroy(voxel_cast **made)
{
    voxel_cast *old = *made;
    if (old == NULL) {
        return;
    }
    if (old->kernel != NULL) {
        clReleaseKernel(old->kernel);
    }
    if (old->program != NULL) {
        clReleaseProgram(old->program);
    }
    if (old->rays != NULL) {
        clReleaseMemObject(old->rays);
    }
    if (old->ts != NULL) {
        clReleaseMemObject(old->ts);
    }
    svo_tree_destroy(&old->tree);
    free(old);
    *made = NULL;
}

double voxel_cast_run(voxel_cast *made)
{
    const size_t group = GROUP_ITEMS;
    const size_t size = (made->ray_count + group - 1) / group * group;
    const double started_ms = input_now_ms();
    const bool worked = clEnqueueNDRangeKernel(made->opened->queue, made->kernel, 1, NULL, &size, &group, 0, NULL,
                                               NULL) == CL_SUCCESS &&
                        clFinish(made->opened->queue) == CL_SUCCESS;
    return worked ? input_now_ms() - started_ms : -1.0;
}

bool voxel_cast_read(voxel_cast *made, float *ts)
{
    return clEnqueueReadBuffer(made->opened->queue, made->ts, CL_TRUE, 0, made->ray_count * sizeof *ts, ts, 0, NULL,
                               NULL) == CL_SUCCESS;
}
