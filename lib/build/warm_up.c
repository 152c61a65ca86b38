/* SPDX-License-Identifier: MIT */
/*
 * Drivers compile a kernel when it is first launched. So that this time is counted as compilation, and no stage of the
 * first build looks slow, every kernel of a fresh program is launched once on nothing.
 */
#include <string.h>

#include "build/build.h"

/* What a kernel's launches are as large as. Drivers may compile small and large launches apart (PoCL: below and above
   65535 work-items), so the launches on nothing have the sizes of the build. */
typedef enum launch_size {
    LAUNCH_SCAN, /* always a few thousand items */
    LAUNCH_FRAGMENTS, /* one per fragment */
    LAUNCH_LEVELS /* one per node: small for the upper levels, large for the lower */
} launch_size;
#define LARGE_ITEMS 131072

/* Every kernel takes its buffers first, then its parameters, then local memory. */
typedef struct kernel_shape {
    const char *name;
    cl_uint buffers;
    size_t params_bytes;
    cl_uint locals;
    launch_size size;
    uint32_t need; /* svo_need bits, or one of those below, that make the build launch it; 0: always */
    svo_i_program_kind kind; /* the program it belongs to */
} kernel_shape;

/* What the builder of levels needs beside: nodes; where each leaf's entries begin; lists. The sorted builder has a
   program of its own for all that. */
#define LEVELS 0x10000000u
#define RANGES 0x08000000u
#define LISTS  0x04000000u
/* Where each leaf's entries begin, of the sorted builder. */
#define SORTED_RANGES ((uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_MATERIAL)

static const kernel_shape shapes[] = {
    {"svo_k_take_count", 2, sizeof(svo_subdivide_params), 0, LAUNCH_SCAN, LEVELS, SVO_I_PROGRAM_BUILD},
    {"svo_k_mark", 3, sizeof(svo_subdivide_params), 0, LAUNCH_FRAGMENTS, LEVELS, SVO_I_PROGRAM_BUILD},
    {"svo_k_descend", 5, sizeof(svo_subdivide_params), 0, LAUNCH_FRAGMENTS, LEVELS, SVO_I_PROGRAM_BUILD},
    {"svo_k_scan_masks_reduce", 3, sizeof(svo_subdivide_params), 1, LAUNCH_SCAN, LEVELS, SVO_I_PROGRAM_BUILD},
    {"svo_k_scan_masks_partials", 2, sizeof(svo_subdivide_params), 1, LAUNCH_SCAN, LEVELS, SVO_I_PROGRAM_BUILD},
    {"svo_k_scan_masks_add", 4, sizeof(svo_subdivide_params), 1, LAUNCH_SCAN, LEVELS, SVO_I_PROGRAM_BUILD},
    {"svo_k_count", 3, sizeof(svo_filter_params), 0, LAUNCH_FRAGMENTS, RANGES, SVO_I_PROGRAM_BUILD},
    {"svo_k_scan_lists_reduce", 3, sizeof(svo_filter_params), 1, LAUNCH_SCAN, RANGES, SVO_I_PROGRAM_BUILD},
    {"svo_k_scan_lists_partials", 3, sizeof(svo_filter_params), 1, LAUNCH_SCAN, RANGES, SVO_I_PROGRAM_BUILD},
    {"svo_k_scan_lists_add", 4, sizeof(svo_filter_params), 1, LAUNCH_SCAN, RANGES, SVO_I_PROGRAM_BUILD},
    {"svo_k_scatter", 6, sizeof(svo_filter_params), 0, LAUNCH_FRAGMENTS, LISTS, SVO_I_PROGRAM_BUILD},
    {"svo_k_sort_short", 4, sizeof(svo_filter_params), 0, LAUNCH_FRAGMENTS, LISTS, SVO_I_PROGRAM_BUILD},
    {"svo_k_sort_long", 5, sizeof(svo_filter_params), 2, LAUNCH_SCAN, LISTS, SVO_I_PROGRAM_BUILD},
    {"svo_k_material_scatter", 9, sizeof(svo_filter_params), 0, LAUNCH_FRAGMENTS, SVO_NEED_MATERIAL,
     SVO_I_PROGRAM_BUILD},
    {"svo_k_material_leaves", 6, sizeof(svo_filter_params), 0, LAUNCH_FRAGMENTS, SVO_NEED_MATERIAL,
     SVO_I_PROGRAM_BUILD},
    {"svo_k_material_merge", 10, sizeof(svo_filter_params), 0, LAUNCH_LEVELS, SVO_NEED_MATERIAL, SVO_I_PROGRAM_BUILD},
    {"svo_k_link", 3, sizeof(svo_filter_params), 0, LAUNCH_FRAGMENTS, SVO_I_NEED_FILTER, SVO_I_PROGRAM_BUILD},
    {"svo_k_gather_level", 20, sizeof(svo_filter_params), 0, LAUNCH_LEVELS, SVO_I_NEED_FILTER, SVO_I_PROGRAM_BUILD},
    {"svo_k_filter", 12, sizeof(svo_filter_params), 0, LAUNCH_LEVELS, SVO_I_NEED_FILTER, SVO_I_PROGRAM_BUILD},
    {"svo_k_sort_count", 2, sizeof(svo_sort_params), 1, LAUNCH_SCAN, 0, SVO_I_PROGRAM_SORT},
    {"svo_k_sort_scatter", 3, sizeof(svo_sort_params), 1, LAUNCH_SCAN, 0, SVO_I_PROGRAM_SORT},
    {"svo_k_scan_lists_reduce", 3, sizeof(svo_filter_params), 1, LAUNCH_SCAN, 0, SVO_I_PROGRAM_SORT},
    {"svo_k_scan_lists_partials", 3, sizeof(svo_filter_params), 1, LAUNCH_SCAN, 0, SVO_I_PROGRAM_SORT},
    {"svo_k_scan_lists_add", 4, sizeof(svo_filter_params), 1, LAUNCH_SCAN, 0, SVO_I_PROGRAM_SORT},
    {"svo_k_bottom_up_count", 2, sizeof(svo_bottom_up_params), 1, LAUNCH_FRAGMENTS, 0, SVO_I_PROGRAM_SORT},
    {"svo_k_bottom_up_flags", 2, sizeof(svo_bottom_up_params), 0, LAUNCH_LEVELS, 0, SVO_I_PROGRAM_SORT},
    {"svo_k_bottom_up_leaves", 4, sizeof(svo_bottom_up_params), 0, LAUNCH_FRAGMENTS, 0, SVO_I_PROGRAM_SORT},
    {"svo_k_bottom_up_nodes", 5, sizeof(svo_bottom_up_params), 0, LAUNCH_LEVELS, 0, SVO_I_PROGRAM_SORT},
    {"svo_k_bottom_up_lists", 4, sizeof(svo_bottom_up_params), 0, LAUNCH_FRAGMENTS, SORTED_RANGES, SVO_I_PROGRAM_SORT},
    {"svo_k_voxelize", 6, sizeof(svo_voxelize_params), 2, LAUNCH_FRAGMENTS, 0, SVO_I_PROGRAM_VOXELIZE},
};

#define BUFFERS_MAX   20
#define ARGUMENTS_MAX (BUFFERS_MAX + 3)
/* What every buffer holds: zeros, that is counts of nothing, and room for the sums of nothing: the sort's are the
   most. */
#define ZERO_BYTES  (sizeof(cl_uint) * SVO_SORT_DIGITS * SVO_SORT_BLOCKS)
#define LOCAL_BYTES (sizeof(cl_uint) * SVO_SORT_DIGITS * SVO_GROUP_ITEMS)

/* What decides whether a kernel is launched. */
static uint32_t launches_of(const svo_plan *plan)
{
    const svo_i_work *work = &plan->work;
    const uint32_t bits = work->made | (work->lists ? (uint32_t)SVO_NEED_RAYS : 0u);
    return work->sorted ? bits : bits | LEVELS | (work->ranges ? RANGES : 0u) | (work->lists ? LISTS : 0u);
}

static svo_status launch_on_nothing(svo_i_build *build, const kernel_shape *shape, const cl_mem *zeros, uint64_t items)
{
    static const unsigned char no_params[sizeof(svo_filter_params)] = {0};
    svo_i_argument arguments[ARGUMENTS_MAX];
    cl_uint count = 0;
    while (count < shape->buffers) {
        arguments[count] = SVO_I_ARGUMENT(zeros[count]);
        ++count;
    }
    arguments[count++] = (svo_i_argument){shape->params_bytes, no_params};
    for (cl_uint i = 0; i < shape->locals; ++i) {
        arguments[count++] = SVO_I_LOCAL(LOCAL_BYTES);
    }
    cl_kernel kernel = NULL;
    svo_status status = svo_i_build_kernel(build, shape->name, &kernel);
    if (status == SVO_OK) {
        status = svo_i_build_launch(build, kernel, arguments, count, items);
        clReleaseKernel(kernel);
    }
    return status;
}

/* The launch sizes a build of this plan has. */
static svo_status launch_sizes(svo_i_build *build, const kernel_shape *shape, const cl_mem *zeros)
{
    const bool large = build->plan->info.expected_fragments >= LARGE_ITEMS && shape->size != LAUNCH_SCAN;
    svo_status status = SVO_OK;
    if (!large || shape->size == LAUNCH_LEVELS) {
        status = launch_on_nothing(build, shape, zeros, SVO_GROUP_ITEMS);
    }
    return status == SVO_OK && large ? launch_on_nothing(build, shape, zeros, LARGE_ITEMS) : status;
}

static void free_zeros(cl_mem *zeros)
{
    for (cl_uint i = 0; i < BUFFERS_MAX; ++i) {
        if (zeros[i] != NULL) {
            clReleaseMemObject(zeros[i]);
        }
    }
}

/* Buffers of their own for all arguments: what one work-item reads by one of them, another may write by another. */
static svo_status make_zeros(svo_i_build *build, cl_mem *zeros)
{
    svo_status status = SVO_OK;
    for (cl_uint i = 0; i < BUFFERS_MAX && status == SVO_OK; ++i) {
        status = svo_i_device_buffer(build->device, SVO_I_BUILD, "zeros", CL_MEM_READ_WRITE, ZERO_BYTES, &zeros[i]);
        if (status == SVO_OK) {
            status = svo_i_build_fill_zero(build, zeros[i], ZERO_BYTES);
        }
    }
    return status;
}

svo_status svo_i_build_warm(svo_i_build *build, svo_i_program_kind kind)
{
    cl_mem zeros[BUFFERS_MAX] = {NULL};
    const double start_ms = svo_i_now_ms();
    const uint32_t need = launches_of(build->plan);
    svo_status status = make_zeros(build, zeros);
    for (size_t i = 0; i < sizeof shapes / sizeof shapes[0] && status == SVO_OK; ++i) {
        const bool needed = shapes[i].need == 0 || (shapes[i].need & need) != 0;
        if (shapes[i].kind == kind && needed) {
            status = launch_sizes(build, &shapes[i], zeros);
        }
    }
    if (build->last != NULL) {
        clWaitForEvents(1, &build->last);
    }
    build->device->compile_ms += svo_i_now_ms() - start_ms;
    free_zeros(zeros);
    return status;
}
