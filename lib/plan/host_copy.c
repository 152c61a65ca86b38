/* SPDX-License-Identifier: MIT */
/* Reads the arrays of plans that kernels made. Builds by OpenCL need none of it. */
#include "plan/host_copy.h"

#include <stddef.h>
#include <string.h>

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

/* The arrays of a plan, each by its pointer on the host, its buffer, and its bytes per vertex or per triangle. */
#define PLACES(name) offsetof(svo_plan, name), offsetof(svo_i_plan_memory, name)
static const struct {
    size_t host_offset, memory_offset;
    uint64_t vertex_bytes, triangle_bytes;
} arrays[] = {
    {PLACES(vertices), 12, 0},
    {PLACES(positions), 12, 0},
    {PLACES(positions_double), 24, 0},
    {PLACES(colors), 4, 0},
    {PLACES(normals), 8, 0},
    {PLACES(uvs), 8, 0},
    {PLACES(indices), 0, 12},
    {PLACES(triangle_ids), 0, 4},
    {PLACES(items), 0, sizeof(svo_draw_item)},
    {PLACES(item_fragments), 0, 4},
    {PLACES(records), 0, sizeof(svo_triangle_record)},
};
#define ARRAY_COUNT (sizeof arrays / sizeof arrays[0])

svo_status svo_i_plan_copy_to_host(svo_plan *plan)
{
    for (size_t i = 0; i < ARRAY_COUNT; ++i) {
        char *at = (char *)plan + arrays[i].host_offset;
        cl_mem memory = NULL;
        void *host = NULL;
        memcpy(&memory, (const char *)&plan->memory + arrays[i].memory_offset, sizeof memory);
        memcpy(&host, at, sizeof host);
        if (host == NULL && memory != NULL) {
            const uint64_t bytes =
                plan->vertex_count * arrays[i].vertex_bytes + plan->triangle_count * arrays[i].triangle_bytes;
            SVO_I_TRY(svo_i_plan_read(plan, memory, bytes, &host));
            memcpy(at, &host, sizeof host);
        }
    }
    return SVO_OK;
}

void svo_i_plan_memory_free(svo_i_plan_memory *memory)
{
    for (size_t i = 0; i < ARRAY_COUNT; ++i) {
        cl_mem buffer = NULL;
        memcpy(&buffer, (const char *)memory + arrays[i].memory_offset, sizeof buffer);
        svo_i_buffer_release(&buffer);
    }
    *memory = (svo_i_plan_memory){0};
}
