/* SPDX-License-Identifier: MIT */
/* Trees of given opacity from lists of voxels, and a kernel that reads fields. */
#include "light_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "support/info_of.h"

void light_succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

svo_tree *light_tree_of(const fixture *opened, uint32_t depth, const uint8_t *alphas)
{
    const size_t width = (size_t)1 << depth;
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_voxels *list = NULL;
    svo_tree *tree = NULL;
    svo_voxel *voxels = malloc(width * width * width * sizeof *voxels);
    assert_non_null(voxels);
    for (size_t k = 0; k < width * width * width; ++k) {
        if (alphas[k] != 0 || k == 0) {
            voxels[source.voxel_count++] = (svo_voxel){.x = (int32_t)(k % width),
                                                       .y = (int32_t)(k / width % width),
                                                       .z = (int32_t)(k / width / width),
                                                       .rgba = {200, 100, 50, alphas[k]}};
        }
    }
    source.voxels = voxels;
    assert_int_equal(svo_voxels_create(&source, &list, NULL), SVO_OK);
    options.need = SVO_NEED_COLOR;
    options.builder = SVO_BUILDER_SORTED;
    light_succeed(opened, svo_voxels_build(opened->device, list, depth, &options, opened->queue, &tree, NULL));
    light_succeed(opened, svo_tree_download(tree, opened->queue));
    svo_voxels_destroy(&list);
    free(voxels);
    return tree;
}

svo_light *light_of(const fixture *opened, svo_tree *tree, svo_light_form form)
{
    svo_light_options options = SVO_LIGHT_OPTIONS_INIT;
    svo_light *light = NULL;
    options.form = form;
    light_succeed(opened, svo_light_create(tree, &options, opened->queue, &light));
    return light;
}

svo_light_info light_info_of(const svo_light *light)
{
    svo_light_info info = SVO_LIGHT_INFO_INIT;
    assert_int_equal(svo_light_get_info(light, &info), SVO_OK);
    return info;
}

void *light_read(const fixture *opened, const svo_light *light, svo_light_buffer buffer)
{
    const size_t bytes = (size_t)light_info_of(light).bytes[buffer];
    void *copy = malloc(bytes);
    assert_non_null(copy);
    assert_int_equal(
        clEnqueueReadBuffer(opened->queue, svo_light_get_buffer(light, buffer), CL_TRUE, 0, bytes, copy, 0, NULL, NULL),
        CL_SUCCESS);
    return copy;
}

/* ---- fields ---- */

static const char probe_kernel[] =
    "typedef struct light_probe {\n"
    "    float position[3];\n"
    "    uint level;\n"
    "    float direction[3];\n"
    "    uint with_light;\n"
    "    uint in_pair;\n"
    "} light_probe;\n"
    "__kernel void probe(SVO_LIGHT_PARAMETERS, __global const light_probe *probes, __global float *samples)\n"
    "{\n"
    "    SVO_LIGHT_MAKE(light);\n"
    "    const size_t i = get_global_id(0);\n"
    "    svo_field_sample found =\n"
    "        svo_field_at(&light, vload3(0, probes[i].position), probes[i].level, vload3(0, probes[i].direction),\n"
    "                     probes[i].with_light != 0u);\n"
    "    svo_field_sample finer, coarser;\n"
    "    if (probes[i].in_pair == 1u) {\n"
    "        svo_field_pair(&light, vload3(0, probes[i].position), probes[i].level, vload3(0, probes[i].direction),\n"
    "                       probes[i].with_light != 0u, &finer, &coarser);\n"
    "        found = finer;\n"
    "    } else if (probes[i].in_pair == 2u) {\n"
    "        svo_field_pair(&light, vload3(0, probes[i].position), probes[i].level + 1u,\n"
    "                       vload3(0, probes[i].direction), probes[i].with_light != 0u, &finer, &coarser);\n"
    "        found = coarser;\n"
    "    }\n"
    "    vstore4((float4)(found.extinction, found.cover, found.facing, found.opacity), 2 * i, samples);\n"
    "    vstore4((float4)(found.radiance, found.empty), 2 * i + 1, samples);\n"
    "}\n";

static cl_kernel make_kernel(const fixture *opened, svo_light *light)
{
    const char *sources[2] = {svo_kernel_source(svo_light_target(NULL)), probe_kernel};
    const cl_device_id device = info_of_device(opened->device).device;
    cl_program program = clCreateProgramWithSource(info_of_device(opened->device).context, 2, sources, NULL, NULL);
    if (clBuildProgram(program, 1, &device, svo_kernel_options(svo_light_target(light)), NULL, NULL) != CL_SUCCESS) {
        static char log[4096];
        clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, sizeof log, log, NULL);
        fail_msg("%s", log);
    }
    cl_kernel kernel = clCreateKernel(program, "probe", NULL);
    clReleaseProgram(program);
    assert_non_null(kernel);
    return kernel;
}

void light_probe_field(const fixture *opened, svo_light *light, const light_probe *probes, light_sample *samples,
                       size_t count)
{
    const cl_context context = info_of_device(opened->device).context;
    const size_t local = 1;
    cl_kernel kernel = make_kernel(opened, light);
    cl_mem input = clCreateBuffer(context, CL_MEM_READ_WRITE, count * sizeof *probes, NULL, NULL);
    cl_mem output = clCreateBuffer(context, CL_MEM_READ_WRITE, count * sizeof *samples, NULL, NULL);
    assert_non_null(input);
    assert_non_null(output);
    assert_int_equal(
        clEnqueueWriteBuffer(opened->queue, input, CL_TRUE, 0, count * sizeof *probes, probes, 0, NULL, NULL),
        CL_SUCCESS);
    light_succeed(opened, svo_kernel_set_arguments(svo_light_target(light), kernel, 0));
    assert_int_equal(clSetKernelArg(kernel, SVO_LIGHT_ARGUMENTS, sizeof input, &input), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, SVO_LIGHT_ARGUMENTS + 1, sizeof output, &output), CL_SUCCESS);
    assert_int_equal(clEnqueueNDRangeKernel(opened->queue, kernel, 1, NULL, &count, &local, 0, NULL, NULL), CL_SUCCESS);
    assert_int_equal(
        clEnqueueReadBuffer(opened->queue, output, CL_TRUE, 0, count * sizeof *samples, samples, 0, NULL, NULL),
        CL_SUCCESS);
    clReleaseMemObject(input);
    clReleaseMemObject(output);
    clReleaseKernel(kernel);
}
