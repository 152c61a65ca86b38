/* SPDX-License-Identifier: MIT */
/* Reads the arrays of plans that kernels made. Builds by OpenCL need none of it. */
#include "plan/host_copy.h"

bool svo_i_plan_has(const void *host, cl_mem memory)
{
    return host != NULL || memory != NULL;
}

svo_status svo_i_plan_read(const svo_plan *plan, cl_mem memory, uint64_t bytes, void **out)
{
    cl_command_queue queue = NULL;
    SVO_I_TRY(svo_i_device_queue(plan->device, "svo_plan", NULL, &queue));
    void *host = svo_i_alloc(&plan->device->memory, (size_t)bytes + 1);
    if (host == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan: no %llu bytes to read the plan",
                                 (unsigned long long)bytes);
    }
    const cl_int error =
        bytes > 0 ? clEnqueueReadBuffer(queue, memory, CL_TRUE, 0, (size_t)bytes, host, 0, NULL, NULL) : CL_SUCCESS;
    if (error != CL_SUCCESS) {
        svo_i_free(host);
        return svo_i_device_fail_cl(plan->device, "svo_plan", "clEnqueueReadBuffer", error);
    }
    *out = host;
    return SVO_OK;
}

/* Reads an array that is on the device alone. */
static svo_status bring(const svo_plan *plan, cl_mem memory, uint64_t bytes, void **host)
{
    return *host == NULL && memory != NULL ? svo_i_plan_read(plan, memory, bytes, host) : SVO_OK;
}

svo_status svo_i_plan_copy_to_host(svo_plan *plan)
{
    const svo_i_plan_memory *memory = &plan->memory;
    const uint64_t vertices = plan->vertex_count;
    const uint64_t triangles = plan->triangle_count;
    void *host = NULL;
    host = plan->vertices;
    SVO_I_TRY(bring(plan, memory->vertices, vertices * 12, &host));
    plan->vertices = host;
    host = plan->indices;
    SVO_I_TRY(bring(plan, memory->indices, triangles * 12, &host));
    plan->indices = host;
    host = plan->triangle_ids;
    SVO_I_TRY(bring(plan, memory->triangle_ids, triangles * 4, &host));
    plan->triangle_ids = host;
    host = plan->positions;
    SVO_I_TRY(bring(plan, memory->positions, vertices * 12, &host));
    plan->positions = host;
    host = plan->positions_double;
    SVO_I_TRY(bring(plan, memory->positions_double, vertices * 24, &host));
    plan->positions_double = host;
    host = plan->items;
    SVO_I_TRY(bring(plan, memory->items, triangles * sizeof(svo_draw_item), &host));
    plan->items = host;
    host = plan->item_fragments;
    SVO_I_TRY(bring(plan, memory->item_fragments, triangles * 4, &host));
    plan->item_fragments = host;
    host = plan->records;
    SVO_I_TRY(bring(plan, memory->records, triangles * sizeof(svo_triangle_record), &host));
    plan->records = host;
    host = plan->colors;
    SVO_I_TRY(bring(plan, memory->colors, vertices * 4, &host));
    plan->colors = host;
    host = plan->normals;
    SVO_I_TRY(bring(plan, memory->normals, vertices * 8, &host));
    plan->normals = host;
    host = plan->uvs;
    SVO_I_TRY(bring(plan, memory->uvs, vertices * 8, &host));
    plan->uvs = host;
    return SVO_OK;
}

void svo_i_plan_memory_free(svo_i_plan_memory *memory)
{
    const cl_mem buffers[] = {memory->vertices,  memory->indices,         memory->triangle_ids,
                              memory->items,     memory->item_fragments,  memory->records,
                              memory->colors,    memory->normals,         memory->uvs,
                              memory->positions, memory->positions_double};
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        if (buffers[i] != NULL) {
            clReleaseMemObject(buffers[i]);
        }
    }
    *memory = (svo_i_plan_memory){0};
}
