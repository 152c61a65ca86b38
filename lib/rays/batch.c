/* SPDX-License-Identifier: MIT */
/* Launches batches: of a tree, rays and points; see kernels/rays. */
#include "rays/batch.h"

#include <math.h>
#include <stdio.h>

#include "core/device.h"
#include "core/submit.h"
#include "rays/programs.h"
#include "rays/rays.h"
#include "shared/layout.h"
#include "svocl/trace.h"

/* ---- checks ---- */

static svo_status check_batch(const svo_i_batch *asked)
{
    if (asked->count > SVO_TRACE_RAYS_MAX) {
        return svo_i_device_fail(asked->device, SVO_INVALID_ARGUMENT, "%s: %zu %s are above %u", asked->function,
                                 asked->count, asked->input_name, SVO_TRACE_RAYS_MAX);
    }
    return asked->target.check(asked->target.of, asked->function);
}

/* ---- launches ---- */

static svo_status make_kernel(const svo_i_batch *asked, cl_mem input, cl_mem output, cl_kernel *out)
{
    const cl_uint count = (cl_uint)asked->count;
    const cl_uint first = asked->target.arguments;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(input), SVO_I_ARGUMENT(output), SVO_I_ARGUMENT(count),
                                        asked->last_argument};
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    cl_program program = NULL;
    (void)snprintf(defines, sizeof defines, "%s%s", asked->defines, asked->streams ? " -DSVO_RAY_STREAMS" : "");
    SVO_I_TRY(svo_i_program_get(asked->device, asked->function, asked->program, defines, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(asked->device, asked->function, program, asked->kernel_name, out));
    SVO_I_TRY(asked->target.set(asked->target.of, asked->function, *out, 0));
    return svo_i_kernel_set_from(asked->device, asked->function, *out, first, arguments,
                                 asked->last_argument.value != NULL ? 4 : 3);
}

#define STREAM_SHARE_MAX 512u

/* Records of a work-item with streams, whose last rays have few others beside them: many, but enough work-items for the
   device's threads. */
static size_t stream_share(const svo_device *device, size_t count)
{
    const size_t share = count / device->stream_items / SVO_GROUP_ITEMS * SVO_GROUP_ITEMS;
    return share < SVO_GROUP_ITEMS ? SVO_GROUP_ITEMS : share < STREAM_SHARE_MAX ? share : STREAM_SHARE_MAX;
}

static svo_status launch(const svo_i_batch *asked, cl_mem input, cl_mem output, const svo_i_call *call)
{
    const size_t per_item = asked->streams ? stream_share(asked->device, asked->count) : 1;
    const size_t items = (asked->count + per_item - 1) / per_item;
    const size_t local = asked->streams ? 1 : SVO_GROUP_ITEMS;
    svo_i_launch launched = {.groups = (items + local - 1) / local, .group_items = local};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(make_kernel(asked, input, output, &launched.kernel));
    SVO_I_TRY_CLEANUP(svo_i_call_launch(call, &launched));

cleanup:
    if (launched.kernel != NULL) {
        clReleaseKernel(launched.kernel);
    }
    return status;
}

svo_status svo_i_batch_run(const svo_i_batch *asked, const svo_array *input, const svo_array *output,
                           const svo_submit *submit)
{
    const size_t input_bytes = asked->count * asked->input_bytes;
    const size_t output_bytes = asked->count * asked->output_bytes;
    cl_mem from = NULL;
    cl_mem to = NULL;
    svo_i_call call;
    svo_status status = SVO_OK;
    SVO_I_TRY(check_batch(asked));
    SVO_I_TRY(svo_i_call_begin(asked->device, asked->function, submit, &call));
    SVO_I_TRY_CLEANUP(svo_i_call_input(&call, asked->input_name, input, input_bytes, &from));
    SVO_I_TRY_CLEANUP(svo_i_call_output(&call, asked->output_name, output, output_bytes, 0, output_bytes, &to));
    status = asked->count > 0 ? launch(asked, from, to, &call) : svo_i_call_none(&call);

cleanup:
    return svo_i_call_end(&call, status);
}

svo_status svo_i_batch_of_voxels(svo_i_batch *batch, size_t ray_count, const cl_float *footprint, uint32_t flags)
{
    batch->kernel_name = "svo_k_trace_voxels";
    batch->input_name = "rays";
    batch->output_name = "hits";
    batch->input_bytes = sizeof(svo_ray);
    batch->output_bytes = sizeof(svo_voxel_hit);
    batch->count = ray_count;
    batch->streams = batch->device != NULL && batch->device->cpu_path;
    batch->last_argument = (svo_i_argument){sizeof *footprint, footprint, false};
    if (flags != 0) {
        return svo_i_device_fail(batch->device, SVO_INVALID_ARGUMENT, "%s: flags %u is not 0, and not of a scene",
                                 batch->function, flags);
    }
    return *footprint >= 0.0F && isfinite(*footprint)
               ? SVO_OK
               : svo_i_device_fail(batch->device, SVO_INVALID_ARGUMENT, "%s: footprint %g is negative or not finite",
                                   batch->function, (double)*footprint);
}

/* ---- rays ---- */

/* any: 1 for SVO_TRACE_ANY, else 0; lives as long as the batch. */
static svo_status ray_batch(svo_tree *tree, const char *function, size_t ray_count, uint32_t flags, cl_uint *any,
                            svo_i_batch *out)
{
    const uint32_t mode = flags & ~SVO_TRACE_BY_FIELD;
    const bool by_field = mode != flags;
    *any = mode == SVO_TRACE_ANY;
    *out = (svo_i_batch){.device = tree->device,
                         .function = function,
                         .target = svo_i_rays_target(tree),
                         .program = &svo_i_program_trace,
                         .kernel_name = "svo_k_trace",
                         .defines = mode == SVO_TRACE_COUNT
                                        ? (by_field ? " -DSVO_COUNT_HITS -DSVO_RAY_FIELDS" : " -DSVO_COUNT_HITS")
                                        : (by_field ? " -DSVO_RAY_FIELDS" : ""),
                         .streams = mode != SVO_TRACE_COUNT && tree->device != NULL && tree->device->cpu_path,
                         .input_name = "rays",
                         .output_name = "hits",
                         .input_bytes = sizeof(svo_ray),
                         .output_bytes = sizeof(svo_hit),
                         .count = ray_count,
                         .last_argument = {sizeof *any, any, false}};
    return mode <= SVO_TRACE_COUNT ? SVO_OK
                                   : svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                                       "%s: flags %u, without SVO_TRACE_BY_FIELD, is not in 0 .. %u",
                                                       function, mode, (unsigned)SVO_TRACE_COUNT);
}

svo_status svo_i_tree_trace_triangles(void *tree, const svo_array *rays, const svo_array *hits, size_t ray_count,
                                      uint32_t flags, const svo_submit *submit)
{
    cl_uint any = 0;
    svo_i_batch asked;
    SVO_I_TRY(ray_batch(tree, "svo_trace_triangles", ray_count, flags, &any, &asked));
    return svo_i_batch_run(&asked, rays, hits, submit);
}

/* ---- points ---- */

svo_status svo_tree_nearest(svo_tree *tree, svo_array points, svo_array results, size_t point_count,
                            const svo_submit *submit)
{
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = {.device = tree->device,
                               .function = "svo_tree_nearest",
                               .target = svo_i_rays_target(tree),
                               .program = &svo_i_program_trace,
                               .kernel_name = "svo_k_nearest",
                               .defines = "",
                               .input_name = "points",
                               .output_name = "results",
                               .input_bytes = sizeof(svo_query_point),
                               .output_bytes = sizeof(svo_nearest),
                               .count = point_count};
    return svo_i_batch_run(&asked, &points, &results, submit);
}

/* ---- voxels ---- */

svo_status svo_i_tree_trace_voxels(void *tree, const svo_array *rays, const svo_array *hits, size_t ray_count,
                                   float footprint, uint32_t flags, const svo_submit *submit)
{
    svo_i_batch asked = {.device = ((const svo_tree *)tree)->device,
                         .function = "svo_trace_voxels",
                         .target = svo_i_voxels_target(tree),
                         .program = &svo_i_program_trace_voxels,
                         .defines = ""};
    SVO_I_TRY(svo_i_batch_of_voxels(&asked, ray_count, &footprint, flags));
    return svo_i_batch_run(&asked, rays, hits, submit);
}
