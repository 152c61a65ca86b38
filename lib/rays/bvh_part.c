/* SPDX-License-Identifier: MIT */
/*
 * BVHs whose records lie in buffers with those of others, below common nodes: where they lie, and what those nodes need
 * to know of them. bvh_device.c makes them.
 */
#include "rays/bvh_part.h"

#include "core/work.h"
#include "stages/sort.h"

svo_status svo_i_bvh_place(svo_device *device, const char *function, svo_i_device_bvh *bvh, cl_mem nodes, cl_mem leaves,
                           uint32_t node_begin, uint32_t leaf_begin)
{
    cl_mem *const held[] = {&bvh->nodes, &bvh->leaves};
    const cl_mem given[] = {nodes, leaves};
    for (int i = 0; i < 2; ++i) {
        const cl_int error = clRetainMemObject(given[i]);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(device, function, "clRetainMemObject", error);
        }
        svo_i_buffer_release(held[i]);
        *held[i] = given[i];
    }
    bvh->node_begin = node_begin;
    bvh->leaf_begin = leaf_begin;
    return SVO_OK;
}

/* Launches and reads, without waiting. */
static svo_status read_extent(svo_i_device_work *work, const svo_i_device_bvh *bvh, svo_i_bvh_extent *extent)
{
    cl_event event = NULL;
    const cl_uint node_count = bvh->level_begin[bvh->level_count];
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(bvh->node_boxes),  SVO_I_ARGUMENT(bvh->leaf_boxes),
        SVO_I_ARGUMENT(bvh->item_counts), SVO_I_ARGUMENT(node_count),
        SVO_I_ARGUMENT(bvh->item_count),  SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_float))};
    SVO_I_TRY(svo_i_work_use(work, SVO_I_PROGRAM_BVH, svo_i_sort_defines(work->device)));
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_bvh_extent", SVO_I_ARGUMENTS(arguments), SVO_GROUP_ITEMS));
    const cl_int error =
        clEnqueueReadBuffer(work->queue, bvh->node_boxes, CL_FALSE, 0, sizeof *extent, extent, 1, &work->last, &event);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(work->device, work->function, "clEnqueueReadBuffer", error);
    }
    svo_i_work_follow(work, event);
    return SVO_OK;
}

svo_status svo_i_bvh_read_extent(svo_device *device, const char *function, cl_command_queue queue,
                                 const svo_i_device_bvh *bvh, cl_event wait, svo_i_bvh_extent *extent, cl_event *event)
{
    svo_i_device_work work;
    SVO_I_TRY(svo_i_work_begin_after(device, function, queue, 1, &wait, &work));
    const svo_status status = read_extent(&work, bvh, extent);
    if (status != SVO_OK) {
        svo_i_work_end(&work);
        return status;
    }
    svo_i_work_leave(&work, event);
    return SVO_OK;
}
