/* SPDX-License-Identifier: MIT */
/* Batches of rays and points against the triangles of a tree, kernels/rays/trace.cl and nearest.cl, and of rays against
   its voxels. */
#include "svocl/trace.h"
#include "rays/batch.h"
#include "rays/programs.h"
#include "rays/rays.h"
#include "shared/layout.h"

#define STREAM_ITEMS     4096u
#define STREAM_SHARE_MAX 256u

/* ---- rays ---- */

/* Rays of a work-item with streams, whose last rays have few others beside them: many, but enough work-items for the
   threads of a large machine. */
static size_t stream_share(size_t ray_count)
{
    const size_t share = ray_count / STREAM_ITEMS / SVO_GROUP_ITEMS * SVO_GROUP_ITEMS;
    return share < SVO_GROUP_ITEMS ? SVO_GROUP_ITEMS : share < STREAM_SHARE_MAX ? share : STREAM_SHARE_MAX;
}

/* any: 1 for SVO_TRACE_ANY, else 0; lives as long as the batch. */
static svo_status ray_batch(svo_tree *tree, const char *function, size_t ray_count, uint32_t flags, cl_uint *any,
                            svo_i_batch *out)
{
    const bool streams = flags != SVO_TRACE_COUNT && tree->device != NULL && tree->device->cpu_path;
    *any = flags == SVO_TRACE_ANY;
    *out = (svo_i_batch){.device = tree->device,
                         .function = function,
                         .target = svo_i_rays_target(tree),
                         .program = &svo_i_program_trace,
                         .kernel_name = "svo_k_trace",
                         .defines = flags == SVO_TRACE_COUNT ? " -DSVO_COUNT_HITS"
                                    : streams                ? " -DSVO_RAY_STREAMS"
                                                             : "",
                         .input_name = "rays",
                         .output_name = "hits",
                         .input_bytes = sizeof(svo_ray),
                         .output_bytes = sizeof(svo_hit),
                         .count = ray_count,
                         .per_item = streams ? stream_share(ray_count) : 1, /* see kernels/rays/trace.cl */
                         .last_argument = {sizeof *any, any, false}};
    return flags <= SVO_TRACE_COUNT
               ? SVO_OK
               : svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: flags %u is not in 0 .. %u", function,
                                   flags, (unsigned)SVO_TRACE_COUNT);
}

svo_status svo_tree_trace_enqueue(svo_tree *tree, cl_mem rays, cl_mem hits, size_t ray_count, uint32_t flags,
                                  cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    cl_uint any = 0;
    svo_i_batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(ray_batch(tree, "svo_tree_trace_enqueue", ray_count, flags, &any, &asked));
    return svo_i_batch_enqueue(&asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_tree_trace(svo_tree *tree, const svo_ray *rays, svo_hit *hits, size_t ray_count, uint32_t flags,
                          cl_command_queue queue)
{
    cl_uint any = 0;
    svo_i_batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(ray_batch(tree, "svo_tree_trace", ray_count, flags, &any, &asked));
    return svo_i_batch_run(&asked, rays, hits, queue);
}

/* ---- points ---- */

static svo_i_batch point_batch(svo_tree *tree, const char *function, size_t point_count)
{
    return (svo_i_batch){.device = tree->device,
                         .function = function,
                         .target = svo_i_rays_target(tree),
                         .program = &svo_i_program_trace,
                         .kernel_name = "svo_k_nearest",
                         .defines = "",
                         .input_name = "points",
                         .output_name = "results",
                         .input_bytes = sizeof(svo_query_point),
                         .output_bytes = sizeof(svo_nearest),
                         .count = point_count,
                         .per_item = 1};
}

svo_status svo_tree_nearest_enqueue(svo_tree *tree, cl_mem points, cl_mem results, size_t point_count,
                                    cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = point_batch(tree, "svo_tree_nearest_enqueue", point_count);
    return svo_i_batch_enqueue(&asked, points, results, queue, num_wait, wait, event);
}

svo_status svo_tree_nearest(svo_tree *tree, const svo_query_point *points, svo_nearest *results, size_t point_count,
                            cl_command_queue queue)
{
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = point_batch(tree, "svo_tree_nearest", point_count);
    return svo_i_batch_run(&asked, points, results, queue);
}

/* ---- voxels ---- */

/* footprint: lives as long as the batch. */
static svo_status voxel_batch(svo_tree *tree, const char *function, size_t ray_count, const cl_float *footprint,
                              svo_i_batch *out)
{
    *out = (svo_i_batch){.device = tree->device,
                         .function = function,
                         .target = svo_i_voxels_target(tree),
                         .program = &svo_i_program_trace_voxels,
                         .defines = ""};
    return svo_i_batch_of_voxels(out, ray_count, footprint);
}

svo_status svo_tree_trace_voxels_enqueue(svo_tree *tree, cl_mem rays, cl_mem hits, size_t ray_count, float footprint,
                                         cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                         cl_event *event)
{
    svo_i_batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(voxel_batch(tree, "svo_tree_trace_voxels_enqueue", ray_count, &footprint, &asked));
    return svo_i_batch_enqueue(&asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_tree_trace_voxels(svo_tree *tree, const svo_ray *rays, svo_voxel_hit *hits, size_t ray_count,
                                 float footprint, cl_command_queue queue)
{
    svo_i_batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(voxel_batch(tree, "svo_tree_trace_voxels", ray_count, &footprint, &asked));
    return svo_i_batch_run(&asked, rays, hits, queue);
}
