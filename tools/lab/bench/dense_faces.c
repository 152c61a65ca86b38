/* SPDX-License-Identifier: MIT */
/* Buffers and launches of dense_faces.cl. */
#include "bench/dense_faces.h"

#include <stdlib.h>

#include "reference/oracle.h"
#include "support/info_of.h"
#include "support/input.h"

#define GROUP_ITEMS 64u

extern const char dense_faces_source[];

struct dense_faces {
    const session *opened;
    unsigned depth;
    cl_program program;
    cl_kernel place, merge;
    cl_mem levels[SVO_DEPTH_MAX + 1]; /* level 0 has one voxel */
};

static uint64_t level_bytes(unsigned level, unsigned depth)
{
    return (UINT64_C(1) << 3 * level) * (level == depth ? 1 : 6) * sizeof(cl_uint);
}

uint64_t dense_faces_bytes(unsigned depth)
{
    uint64_t sum = 0;
    for (unsigned level = 0; level <= depth; ++level) {
        sum += level_bytes(level, depth);
    }
    return sum;
}

static bool compile(dense_faces *made)
{
    const char *source = dense_faces_source;
    const svo_device_info on = info_of_device(made->opened->device);
    made->program = clCreateProgramWithSource(on.context, 1, &source, NULL, NULL);
    if (made->program == NULL || clBuildProgram(made->program, 1, &on.device, NULL, NULL, NULL) != CL_SUCCESS) {
        return false;
    }
    made->place = clCreateKernel(made->program, "place_leaves", NULL);
    made->merge = clCreateKernel(made->program, "merge_level", NULL);
    return made->place != NULL && made->merge != NULL;
}

static bool allocate(dense_faces *made)
{
    cl_ulong most = 0;
    const cl_uint zero = 0;
    const svo_device_info on = info_of_device(made->opened->device);
    bool worked = clGetDeviceInfo(on.device, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof most, &most, NULL) == CL_SUCCESS;
    for (unsigned level = 0; level <= made->depth && worked; ++level) {
        const size_t bytes = (size_t)level_bytes(level, made->depth);
        worked = bytes <= most;
        if (worked) {
            made->levels[level] = clCreateBuffer(on.context, CL_MEM_READ_WRITE, bytes, NULL, NULL);
            worked =
                made->levels[level] != NULL && clEnqueueFillBuffer(made->opened->queue, made->levels[level], &zero,
                                                                   sizeof zero, 0, bytes, 0, NULL, NULL) == CL_SUCCESS;
        }
    }
    return worked;
}

static bool launch(const dense_faces *pyramid, cl_kernel kernel, uint64_t items)
{
    const size_t local = GROUP_ITEMS;
    const size_t global = (size_t)((items + GROUP_ITEMS - 1) / GROUP_ITEMS * GROUP_ITEMS);
    return clEnqueueNDRangeKernel(pyramid->opened->queue, kernel, 1, NULL, &global, &local, 0, NULL, NULL) ==
           CL_SUCCESS;
}

static bool place(const dense_faces *made, cl_mem codes, cl_mem colors, cl_uint count)
{
    const cl_uint depth = made->depth;
    return clSetKernelArg(made->place, 0, sizeof(cl_mem), (const void *)&codes) == CL_SUCCESS &&
           clSetKernelArg(made->place, 1, sizeof(cl_mem), (const void *)&colors) == CL_SUCCESS &&
           clSetKernelArg(made->place, 2, sizeof count, &count) == CL_SUCCESS &&
           clSetKernelArg(made->place, 3, sizeof depth, &depth) == CL_SUCCESS &&
           clSetKernelArg(made->place, 4, sizeof(cl_mem), (const void *)&made->levels[made->depth]) == CL_SUCCESS &&
           launch(made, made->place, count) && clFinish(made->opened->queue) == CL_SUCCESS;
}

/* codes: room for a code of each leaf. */
static bool place_leaves(const dense_faces *made, const svo_tree_info *info, const svo_tree_arrays *arrays,
                         uint64_t *codes)
{
    const cl_context context = info_of_device(made->opened->device).context;
    const cl_mem_flags copied = CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR;
    const size_t count = (size_t)info->leaf_count;
    if (!oracle_leaf_codes(arrays->child_mask, info->inner_count, info->depth, info->leaf_count, codes)) {
        return false;
    }
    cl_mem places = clCreateBuffer(context, copied, count * sizeof *codes, codes, NULL);
    cl_mem colors = clCreateBuffer(context, copied, count * sizeof(cl_uint),
                                   (void *)(arrays->colors + 4 * (size_t)info->inner_count), NULL);
    const bool worked = places != NULL && colors != NULL && place(made, places, colors, (cl_uint)count);
    if (places != NULL) {
        clReleaseMemObject(places);
    }
    if (colors != NULL) {
        clReleaseMemObject(colors);
    }
    return worked;
}

dense_faces *dense_faces_create(const session *opened, const svo_tree *tree)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    if (svo_tree_get_info(tree, &info) != SVO_OK || svo_tree_get_arrays(tree, &arrays) != SVO_OK ||
        arrays.colors == NULL || info.leaf_count == 0) {
        return NULL;
    }
    dense_faces *made = calloc(1, sizeof *made);
    uint64_t *codes = malloc((size_t)info.leaf_count * sizeof *codes);
    if (made != NULL) {
        made->opened = opened;
        made->depth = info.depth;
    }
    if (made != NULL &&
        (codes == NULL || !compile(made) || !allocate(made) || !place_leaves(made, &info, &arrays, codes))) {
        dense_faces_destroy(&made);
    }
    free(codes);
    return made;
}

void dense_faces_destroy(dense_faces **pyramid)
{
    dense_faces *old = *pyramid;
    if (old == NULL) {
        return;
    }
    for (unsigned level = 0; level <= old->depth; ++level) {
        if (old->levels[level] != NULL) {
            clReleaseMemObject(old->levels[level]);
        }
    }
    if (old->place != NULL) {
        clReleaseKernel(old->place);
    }
    if (old->merge != NULL) {
        clReleaseKernel(old->merge);
    }
    if (old->program != NULL) {
        clReleaseProgram(old->program);
    }
    free(old);
    *pyramid = NULL;
}

static bool merge_into(const dense_faces *pyramid, unsigned level)
{
    const cl_uint fine_n = 1u << (level + 1);
    const cl_ulong apart = level + 1 == pyramid->depth ? 0 : UINT64_C(1) << 3 * (level + 1);
    return clSetKernelArg(pyramid->merge, 0, sizeof(cl_mem), (const void *)&pyramid->levels[level + 1]) == CL_SUCCESS &&
           clSetKernelArg(pyramid->merge, 1, sizeof(cl_mem), (const void *)&pyramid->levels[level]) == CL_SUCCESS &&
           clSetKernelArg(pyramid->merge, 2, sizeof fine_n, &fine_n) == CL_SUCCESS &&
           clSetKernelArg(pyramid->merge, 3, sizeof apart, &apart) == CL_SUCCESS &&
           launch(pyramid, pyramid->merge, UINT64_C(1) << 3 * level);
}

double dense_faces_merge(const dense_faces *pyramid)
{
    const double started_ms = input_now_ms();
    bool worked = true;
    for (unsigned level = pyramid->depth; level > 0 && worked; --level) {
        worked = merge_into(pyramid, level - 1);
    }
    worked = clFinish(pyramid->opened->queue) == CL_SUCCESS && worked;
    return worked ? input_now_ms() - started_ms : -1.0;
}
