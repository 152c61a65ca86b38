/* SPDX-License-Identifier: MIT */
/*
 * Brings the mesh that a plan is made from to the device. Arrays of the host are uploaded, or used in place by a CPU.
 * Arrays in a caller's buffers are used in place; those with gaps, at odd offsets or of 16-bit indices are packed.
 * Reads the arrays of plans that kernels made; builds by OpenCL need none of that.
 */
#include "plan/arrays.h"

#include <stddef.h>
#include <string.h>

/* ---- the mesh ---- */

/* One array of the mesh. */
typedef struct array {
    const char *name;
    const void *host;
    const svo_mesh_view *view; /* NULL: host */
    uint64_t count;
    uint32_t element_bytes;
} array;

static void words_of(uint64_t number, cl_uint words[2])
{
    words[0] = (cl_uint)(number & UINT32_MAX);
    words[1] = (cl_uint)(number >> 32);
}

svo_status svo_i_plan_copy_view(svo_i_device_work *work, const svo_mesh_view *view, uint64_t count,
                                uint32_t element_bytes, cl_mem to)
{
    svo_plan_view params = {.element_bytes = element_bytes};
    words_of(count, params.count);
    words_of(view->offset_bytes, params.offset);
    words_of(view->stride_bytes != 0 ? view->stride_bytes : element_bytes, params.stride);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(view->memory), SVO_I_ARGUMENT(to), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_plan_pack", SVO_I_ARGUMENTS(arguments), count);
}

/* Gets an array. *out stays NULL for one that is empty or absent. */
static svo_status get_array(svo_i_device_work *work, const array *from, cl_mem *out)
{
    if (from->count == 0 || (from->view != NULL ? from->view->memory == NULL : from->host == NULL)) {
        return SVO_OK;
    }
    if (from->view == NULL) {
        return svo_i_work_input(work, from->name, from->host, from->count * from->element_bytes, out);
    }
    const uint64_t stride_bytes = from->view->stride_bytes != 0 ? from->view->stride_bytes : from->element_bytes;
    if (from->view->offset_bytes != 0 || stride_bytes != from->element_bytes) {
        SVO_I_TRY(svo_i_work_result(work, from->name, from->count * from->element_bytes, out));
        return svo_i_plan_copy_view(work, from->view, from->count, from->element_bytes, *out);
    }
    const cl_int error = clRetainMemObject(from->view->memory);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(work->device, work->function, "clRetainMemObject", error);
    }
    *out = from->view->memory;
    return SVO_OK;
}

/* Replaces indices of 16 bits by indices of 32 bits. */
static svo_status widen(svo_i_device_work *work, cl_ulong count, cl_mem *indices)
{
    cl_mem wide = NULL;
    SVO_I_TRY(svo_i_work_result(work, "indices", count * 4, &wide));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(*indices), SVO_I_ARGUMENT(wide), SVO_I_ARGUMENT(count)};
    const svo_status status = svo_i_work_launch(work, "svo_k_plan_widen", SVO_I_ARGUMENTS(arguments), count);
    svo_i_buffer_release(status == SVO_OK ? indices : &wide);
    *indices = status == SVO_OK ? wide : *indices;
    return status;
}

svo_status svo_i_device_mesh_geometry(svo_i_device_work *work, const svo_i_plan_input *input, svo_i_device_mesh *out)
{
    const svo_mesh *mesh = &input->mesh;
    const svo_mesh_buffers *buffers = input->buffers;
    const bool is_double = mesh->positions_double != NULL;
    const bool is_narrow = buffers != NULL && buffers->index_bytes == 2;
    const array positions = {"positions", is_double ? (const void *)mesh->positions_double : mesh->positions,
                             buffers != NULL ? &buffers->positions : NULL, mesh->vertex_count, is_double ? 24 : 12};
    const array indices = {"indices", mesh->indices, buffers != NULL ? &buffers->indices : NULL,
                           (uint64_t)mesh->triangle_count * 3, is_narrow ? 2 : 4};
    SVO_I_TRY(get_array(work, &positions, &out->positions));
    SVO_I_TRY(get_array(work, &indices, &out->indices));
    return is_narrow && out->indices != NULL ? widen(work, indices.count, &out->indices) : SVO_OK;
}

svo_status svo_i_device_mesh_attributes(svo_i_device_work *work, const svo_i_plan_input *input, uint32_t need,
                                        svo_i_device_mesh *out)
{
    const svo_mesh *mesh = &input->mesh;
    const svo_mesh_buffers *b = input->buffers;
    const uint64_t vertices = mesh->vertex_count;
    const array normals = {"normals", mesh->normals, b != NULL ? &b->normals : NULL, vertices, 12};
    const array colors = {"colors", mesh->colors, b != NULL ? &b->colors : NULL, vertices, 4};
    const array uvs = {"uvs", mesh->uvs, b != NULL ? &b->uvs : NULL, vertices, 8};
    const array materials = {"triangle_materials", mesh->triangle_materials, b != NULL ? &b->triangle_materials : NULL,
                             mesh->triangle_count, 2};
    if ((need & SVO_NEED_NORMAL) != 0) {
        SVO_I_TRY(get_array(work, &normals, &out->normals));
    }
    if ((need & SVO_NEED_COLOR) != 0) {
        SVO_I_TRY(get_array(work, &colors, &out->colors));
        SVO_I_TRY(get_array(work, &uvs, &out->uvs));
    }
    return get_array(work, &materials, &out->triangle_materials);
}

void svo_i_device_mesh_free(svo_i_device_mesh *mesh)
{
    svo_i_buffer_release(&mesh->positions);
    svo_i_buffer_release(&mesh->indices);
    svo_i_buffer_release(&mesh->normals);
    svo_i_buffer_release(&mesh->colors);
    svo_i_buffer_release(&mesh->uvs);
    svo_i_buffer_release(&mesh->triangle_materials);
}

/* ---- the plan's arrays ---- */

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
    {PLACES(remainders), 8, 0},
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

static cl_mem memory_at(const svo_i_plan_memory *memory, size_t index)
{
    cl_mem buffer = NULL;
    memcpy(&buffer, (const char *)memory + arrays[index].memory_offset, sizeof buffer);
    return buffer;
}

bool svo_i_plan_owns(const svo_plan *plan, cl_mem buffer)
{
    size_t i = 0;
    while (i < ARRAY_COUNT && memory_at(&plan->memory, i) != buffer) {
        ++i;
    }
    return buffer != NULL && i < ARRAY_COUNT;
}

svo_status svo_i_plan_copy_to_host(svo_plan *plan)
{
    for (size_t i = 0; i < ARRAY_COUNT; ++i) {
        char *at = (char *)plan + arrays[i].host_offset;
        cl_mem memory = memory_at(&plan->memory, i);
        void *host = NULL;
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
        cl_mem buffer = memory_at(memory, i);
        svo_i_buffer_release(&buffer);
    }
    *memory = (svo_i_plan_memory){0};
}
