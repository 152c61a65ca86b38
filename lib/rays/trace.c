/* SPDX-License-Identifier: MIT */
/* Batches of rays and points against the triangles of a tree: launches kernels/rays/trace.cl and nearest.cl. */
#include "svocl/trace.h"
#include "rays/batch.h"
#include "rays/rays.h"

/* What a batch of a tree's rays or points launches. */
typedef struct tree_batch {
    svo_tree *tree;
    const char *kernel_name, *defines; /* of the program */
    const cl_uint *last_argument; /* after the count; NULL: none */
} tree_batch;

static svo_status make_kernel(const svo_i_batch *asked, cl_mem input, cl_mem output, cl_kernel *out)
{
    const tree_batch *of = asked->user;
    const cl_uint count = (cl_uint)asked->count;
    cl_program program = NULL;
    SVO_I_TRY(svo_i_program_get(asked->device, asked->function, SVO_I_PROGRAM_TRACE, of->defines, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(asked->device, asked->function, program, of->kernel_name, out));
    SVO_I_TRY(svo_i_rays_set_tree(of->tree, asked->function, *out, 0));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(input), SVO_I_ARGUMENT(output), SVO_I_ARGUMENT(count),
                                        (svo_i_argument){sizeof(cl_uint), of->last_argument, false}};
    return svo_i_rays_set(of->tree, asked->function, *out, SVO_TREE_ARGUMENTS, arguments,
                          of->last_argument != NULL ? 4 : 3);
}

static svo_status check(const svo_i_batch *asked, const void *input, const void *output)
{
    const tree_batch *of = asked->user;
    SVO_I_TRY(svo_i_batch_check(asked, input, output));
    return svo_i_rays_check(of->tree, asked->function);
}

/* ---- rays ---- */

/* any: 1 for SVO_TRACE_ANY, else 0; lives as long as the batch, like *of. */
static svo_status ray_batch(svo_tree *tree, const char *function, size_t ray_count, uint32_t flags, cl_uint *any,
                            tree_batch *of, svo_i_batch *out)
{
    const bool streams = flags != SVO_TRACE_COUNT && tree->device != NULL && tree->device->is_cpu;
    *any = flags == SVO_TRACE_ANY;
    *of = (tree_batch){.tree = tree,
                       .kernel_name = "svo_k_trace",
                       .defines = flags == SVO_TRACE_COUNT ? " -DSVO_COUNT_HITS"
                                  : streams                ? " -DSVO_RAY_STREAMS"
                                                           : "",
                       .last_argument = any};
    *out = (svo_i_batch){.function = function,
                         .device = tree->device,
                         .input_name = "rays",
                         .output_name = "hits",
                         .input_bytes = sizeof(svo_ray),
                         .output_bytes = sizeof(svo_hit),
                         .count = ray_count,
                         .per_item = streams ? SVO_GROUP_ITEMS : 1, /* see kernels/rays/trace.cl */
                         .make_kernel = make_kernel,
                         .user = of};
    return flags <= SVO_TRACE_COUNT
               ? SVO_OK
               : svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: flags %u is not in 0 .. %u", function,
                                   flags, (unsigned)SVO_TRACE_COUNT);
}

svo_status svo_tree_trace_enqueue(svo_tree *tree, cl_mem rays, cl_mem hits, size_t ray_count, uint32_t flags,
                                  cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    cl_uint any = 0;
    tree_batch of;
    svo_i_batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(ray_batch(tree, "svo_tree_trace_enqueue", ray_count, flags, &any, &of, &asked));
    SVO_I_TRY(check(&asked, rays, hits));
    return svo_i_batch_enqueue(&asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_tree_trace(svo_tree *tree, const svo_ray *rays, svo_hit *hits, size_t ray_count, uint32_t flags,
                          cl_command_queue queue)
{
    cl_uint any = 0;
    tree_batch of;
    svo_i_batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(ray_batch(tree, "svo_tree_trace", ray_count, flags, &any, &of, &asked));
    SVO_I_TRY(check(&asked, rays, hits));
    return svo_i_batch_run(&asked, rays, hits, queue);
}

/* ---- points ---- */

static svo_i_batch point_batch(svo_tree *tree, const char *function, size_t point_count, tree_batch *of)
{
    *of = (tree_batch){.tree = tree, .kernel_name = "svo_k_nearest", .defines = ""};
    return (svo_i_batch){.function = function,
                         .device = tree->device,
                         .input_name = "points",
                         .output_name = "results",
                         .input_bytes = sizeof(svo_query_point),
                         .output_bytes = sizeof(svo_nearest),
                         .count = point_count,
                         .per_item = 1,
                         .make_kernel = make_kernel,
                         .user = of};
}

svo_status svo_tree_nearest_enqueue(svo_tree *tree, cl_mem points, cl_mem results, size_t point_count,
                                    cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    tree_batch of;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = point_batch(tree, "svo_tree_nearest_enqueue", point_count, &of);
    SVO_I_TRY(check(&asked, points, results));
    return svo_i_batch_enqueue(&asked, points, results, queue, num_wait, wait, event);
}

svo_status svo_tree_nearest(svo_tree *tree, const svo_query_point *points, svo_nearest *results, size_t point_count,
                            cl_command_queue queue)
{
    tree_batch of;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = point_batch(tree, "svo_tree_nearest", point_count, &of);
    SVO_I_TRY(check(&asked, points, results));
    return svo_i_batch_run(&asked, points, results, queue);
}
