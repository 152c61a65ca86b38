/* SPDX-License-Identifier: MIT */
/*
 * Launches kernels/scene: codes, then the radix sort of kernels/stages/sort.cl, whose fragments are (code, instance)
 * here, then link and refit. Each command waits for the previous one by an event, since the queue may be out-of-order.
 */
#include "scene/hierarchy.h"

#include <math.h>
#include <stdio.h>

#include "scene/programs.h"
#include "stages/sort.h"

#define CODE_BITS (3 * SVO_SCENE_CODE_BITS)

/* ---- sizes ---- */

#define SORT_CELLS ((uint64_t)SVO_SORT_DIGITS * SVO_SORT_BLOCKS)

/* The most nodes of the wide hierarchy. Of its nodes, F have eight children and S have fewer, at least two, which are
   instances alone. There are count + F + S - 1 children in all, 8 F + 2 S or more: 7 F + S is below count, and 2 S is
   at most count. */
static uint64_t wide_count_max(uint64_t count)
{
    return (count - 1 + 6 * (count / 2)) / 7;
}

void svo_i_hierarchy_plan(const svo_device *device, uint32_t instance_count, uint64_t bytes[SVO_I_SCENE_BUFFERS])
{
    const uint64_t count = instance_count;
    bytes[SVO_I_SCENE_INSTANCES] = count * sizeof(svo_scene_instance);
    if (count < 2) {
        return; /* the instance is the root */
    }
    bytes[SVO_I_SCENE_HIERARCHY] = (count - 1) * sizeof(svo_scene_node);
    bytes[SVO_I_SCENE_PARENTS] = count * sizeof(cl_uint);
    bytes[SVO_I_SCENE_ARRIVALS] = (count - 1) * SVO_SCENE_BOUNDS * sizeof(cl_uint);
    bytes[SVO_I_SCENE_WIDE] = device->cpu_path ? wide_count_max(count) * sizeof(svo_scene_wide) : 0;
    bytes[SVO_I_SCENE_LIST] = count * SVO_FRAGMENT_WORDS_48 * sizeof(cl_uint);
    bytes[SVO_I_SCENE_SPARE] = bytes[SVO_I_SCENE_LIST];
    bytes[SVO_I_SCENE_COUNTS] = SORT_CELLS * sizeof(cl_uint);
    bytes[SVO_I_SCENE_BEFORE] = (SORT_CELLS + 1) * sizeof(cl_uint);
    bytes[SVO_I_SCENE_PARTIALS] = SVO_SCAN_GROUPS * sizeof(cl_uint);
}

/* ---- commands ---- */

/* Commands one after the other. */
typedef struct chain {
    svo_scene *scene;
    const char *function;
    cl_command_queue queue;
    cl_program program;
    cl_event last; /* NULL: none yet */
} chain;

/* local: items of a group. */
static svo_status enqueue(chain *c, cl_kernel kernel, const char *name, uint64_t items, size_t local)
{
    const size_t global = (size_t)((items + local - 1) / local * local);
    cl_event done = NULL;
    const cl_int error = clEnqueueNDRangeKernel(c->queue, kernel, 1, NULL, &global, &local, c->last != NULL ? 1 : 0,
                                                c->last != NULL ? &c->last : NULL, &done);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(c->scene->device, c->function, name, error);
    }
    if (c->last != NULL) {
        clReleaseEvent(c->last);
    }
    c->last = done;
    return SVO_OK;
}

/* items: 0 for a kernel of one work-item. */
static svo_status run(chain *c, const char *name, const svo_i_argument *arguments, cl_uint argument_count,
                      uint64_t items)
{
    cl_kernel kernel = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_kernel_create(c->scene->device, c->function, c->program, name, &kernel));
    SVO_I_TRY_CLEANUP(svo_i_kernel_set(c->scene->device, c->function, kernel, arguments, argument_count));
    SVO_I_TRY_CLEANUP(enqueue(c, kernel, name, items > 0 ? items : 1, items > 0 ? SVO_GROUP_ITEMS : 1));

cleanup:
    clReleaseKernel(kernel);
    return status;
}

static svo_status begin(svo_scene *scene, const char *function, cl_command_queue queue, chain *out)
{
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    *out = (chain){.scene = scene, .function = function, .queue = queue};
    /* Fragments of three words. */
    (void)snprintf(defines, sizeof defines, " -DSVO_CODE48%s", svo_i_sort_defines(scene->device));
    return svo_i_program_get(scene->device, function, &svo_i_program_scene_build, defines, &out->program, NULL);
}

/* Waits for all commands, also after a failure: buffers may be released next. */
static svo_status end(chain *c, svo_status status)
{
    if (c->last == NULL) {
        return status;
    }
    const cl_int error = clWaitForEvents(1, &c->last);
    if (error != CL_SUCCESS) {
        (void)svo_i_event_settle(c->last);
    }
    clReleaseEvent(c->last);
    SVO_I_TRY(status);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(c->scene->device, c->function, "clWaitForEvents", error);
}

/* ---- parameters ---- */

static float center(float low, float high)
{
    return 0.5F * low + 0.5F * high;
}

/* The cells of the codes cover the box of the boxes' centers. */
static void fill_codes(const svo_scene *scene, svo_scene_params *params)
{
    double widest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        float low = INFINITY;
        float high = -INFINITY;
        for (uint32_t i = 0; i < scene->info.instance_count; ++i) {
            const float at = center(scene->boxes[i].low[axis], scene->boxes[i].high[axis]);
            low = at < low ? at : low;
            high = at > high ? at : high;
        }
        params->code_low[axis] = low;
        widest = fmax(widest, (double)high - (double)low);
    }
    const double scale = (double)(1u << SVO_SCENE_CODE_BITS) / widest;
    params->code_scale = scale < 0x1p120 ? (float)scale : 0.0F; /* all in one place: their order decides */
}

/* The box of all boxes, and the largest coordinate. */
static void fill_reach(svo_scene *scene, svo_scene_params *params)
{
    svo_scene_info *info = &scene->info;
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis) {
        info->low[axis] = INFINITY;
        info->high[axis] = -INFINITY;
        for (uint32_t i = 0; i < info->instance_count; ++i) {
            info->low[axis] = fmin(info->low[axis], (double)scene->boxes[i].low[axis]);
            info->high[axis] = fmax(info->high[axis], (double)scene->boxes[i].high[axis]);
        }
        reach = fmax(reach, fmax(fabs(info->low[axis]), fabs(info->high[axis])));
    }
    params->reach = (float)reach;
}

/* ---- building ---- */

/* Exclusive sums of the digits' counts. */
static svo_status scan(chain *c)
{
    const cl_mem *buffers = c->scene->buffers;
    const cl_mem state = NULL;
    const svo_filter_params params = {.leaf_count = (cl_uint)SORT_CELLS};
    const cl_uint tiles = ((cl_uint)SORT_CELLS + SVO_SCAN_TILE - 1) / SVO_SCAN_TILE;
    const uint64_t items = (uint64_t)tiles * SVO_GROUP_ITEMS;
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    const svo_i_argument reduce[] = {SVO_I_ARGUMENT(buffers[SVO_I_SCENE_COUNTS]),
                                     SVO_I_ARGUMENT(buffers[SVO_I_SCENE_PARTIALS]), SVO_I_ARGUMENT(state),
                                     SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument add[] = {SVO_I_ARGUMENT(buffers[SVO_I_SCENE_COUNTS]),
                                  SVO_I_ARGUMENT(buffers[SVO_I_SCENE_PARTIALS]),
                                  SVO_I_ARGUMENT(buffers[SVO_I_SCENE_BEFORE]),
                                  SVO_I_ARGUMENT(state),
                                  SVO_I_ARGUMENT(params),
                                  scratch};
    SVO_I_TRY(run(c, "svo_k_scan_lists_reduce", SVO_I_ARGUMENTS(reduce), items));
    return run(c, "svo_k_scan_lists_add", SVO_I_ARGUMENTS(add), items);
}

/* One pass over a digit of the codes; it swaps the list and the spare buffer. */
static svo_status sort_pass(chain *c, uint32_t shift)
{
    cl_mem *buffers = c->scene->buffers;
    const svo_sort_params params = {
        .fragment_count = c->scene->info.instance_count, .shift = shift, .bits = SVO_SORT_BITS};
    const uint64_t items = (uint64_t)SVO_SORT_BLOCKS * SVO_GROUP_ITEMS;
    const svo_i_argument digits = SVO_I_LOCAL(svo_i_sort_local_bytes(c->scene->device));
    const svo_i_argument count[] = {SVO_I_ARGUMENT(buffers[SVO_I_SCENE_LIST]),
                                    SVO_I_ARGUMENT(buffers[SVO_I_SCENE_COUNTS]), SVO_I_ARGUMENT(params), digits};
    const svo_i_argument scatter[] = {SVO_I_ARGUMENT(buffers[SVO_I_SCENE_LIST]),
                                      SVO_I_ARGUMENT(buffers[SVO_I_SCENE_SPARE]),
                                      SVO_I_ARGUMENT(buffers[SVO_I_SCENE_BEFORE]), SVO_I_ARGUMENT(params), digits};
    SVO_I_TRY(run(c, "svo_k_sort_count", SVO_I_ARGUMENTS(count), items));
    SVO_I_TRY(scan(c));
    SVO_I_TRY(run(c, "svo_k_sort_scatter", SVO_I_ARGUMENTS(scatter), items));
    cl_mem sorted = buffers[SVO_I_SCENE_SPARE];
    buffers[SVO_I_SCENE_SPARE] = buffers[SVO_I_SCENE_LIST];
    buffers[SVO_I_SCENE_LIST] = sorted;
    return SVO_OK;
}

/* The wide hierarchy, where there is one, from the boxes of the other. */
static svo_status widen(chain *c)
{
    const cl_mem *buffers = c->scene->buffers;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(buffers[SVO_I_SCENE_HIERARCHY]),
                                        SVO_I_ARGUMENT(buffers[SVO_I_SCENE_WIDE])};
    return buffers[SVO_I_SCENE_WIDE] != NULL ? run(c, "svo_k_scene_widen", SVO_I_ARGUMENTS(arguments), 0) : SVO_OK;
}

static svo_status refit(chain *c)
{
    const svo_scene *scene = c->scene;
    const cl_mem *buffers = scene->buffers;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(buffers[SVO_I_SCENE_INSTANCES]),
                                        SVO_I_ARGUMENT(buffers[SVO_I_SCENE_PARENTS]),
                                        SVO_I_ARGUMENT(buffers[SVO_I_SCENE_HIERARCHY]),
                                        SVO_I_ARGUMENT(buffers[SVO_I_SCENE_ARRIVALS]), SVO_I_ARGUMENT(scene->params)};
    SVO_I_TRY(run(c, "svo_k_scene_refit", SVO_I_ARGUMENTS(arguments),
                  (uint64_t)scene->info.instance_count * SVO_SCENE_BOUNDS));
    return widen(c);
}

static svo_status build(chain *c)
{
    const svo_scene *scene = c->scene;
    const cl_mem *buffers = scene->buffers;
    const svo_i_argument codes[] = {SVO_I_ARGUMENT(buffers[SVO_I_SCENE_INSTANCES]),
                                    SVO_I_ARGUMENT(buffers[SVO_I_SCENE_LIST]), SVO_I_ARGUMENT(scene->params)};
    SVO_I_TRY(run(c, "svo_k_scene_codes", SVO_I_ARGUMENTS(codes), scene->info.instance_count));
    for (uint32_t shift = 0; shift < CODE_BITS; shift += SVO_SORT_BITS) {
        SVO_I_TRY(sort_pass(c, shift));
    }
    const svo_i_argument link[] = {SVO_I_ARGUMENT(buffers[SVO_I_SCENE_LIST]),
                                   SVO_I_ARGUMENT(buffers[SVO_I_SCENE_HIERARCHY]),
                                   SVO_I_ARGUMENT(buffers[SVO_I_SCENE_PARENTS]), SVO_I_ARGUMENT(scene->params)};
    SVO_I_TRY(run(c, "svo_k_scene_link", SVO_I_ARGUMENTS(link), scene->info.instance_count - 1));
    return refit(c);
}

svo_status svo_i_hierarchy_build(svo_scene *scene, const char *function, cl_command_queue queue)
{
    chain c;
    const uint32_t count = scene->info.instance_count;
    scene->params = (svo_scene_params){.instance_count = count, .root = count > 1 ? 0 : SVO_SCENE_LEAF};
    fill_reach(scene, &scene->params);
    if (count < 2) {
        return SVO_OK;
    }
    fill_codes(scene, &scene->params);
    SVO_I_TRY(begin(scene, function, queue, &c));
    return end(&c, build(&c));
}

svo_status svo_i_hierarchy_refit(svo_scene *scene, const char *function, cl_command_queue queue)
{
    chain c;
    fill_reach(scene, &scene->params);
    if (scene->info.instance_count < 2) {
        return SVO_OK;
    }
    SVO_I_TRY(begin(scene, function, queue, &c));
    return end(&c, refit(&c));
}
