/* SPDX-License-Identifier: MIT */
/*
 * Meshes whose arrays lie in buffers of a device. They are read back to the host, where the pipeline's first step
 * (plan/grid.c) snaps them. Interleaved arrays are packed.
 */
#include "core/mesh.h"

#include <math.h>
#include <string.h>

#include "core/device.h"
#include "core/memory.h"
#include "core/opencl.h"
#include "core/struct_size.h"

#define ARRAYS           6
#define MATERIALS_MAX    65535
#define TEXTURE_EDGE_MAX 16384

struct svo_mesh_copy {
    svo_mesh mesh;
    void *arrays[ARRAYS]; /* owned; some NULL */
};

/* ---- checks ---- */

static svo_status check_texture(svo_device *device, const char *function, size_t index, const svo_texture *texture)
{
    const bool fits = texture->width >= 1 && texture->width <= TEXTURE_EDGE_MAX && texture->height >= 1 &&
                      texture->height <= TEXTURE_EDGE_MAX;
    return texture->rgba != NULL && fits
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                   "%s: texture %zu is %u x %u texels, not 1 .. %d each, or has none", function, index,
                                   texture->width, texture->height, TEXTURE_EDGE_MAX);
}

svo_status svo_i_mesh_check_counts(svo_device *device, const char *function, const svo_mesh *mesh)
{
    if (mesh->vertex_count >= UINT32_MAX || mesh->triangle_count >= UINT32_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: mesh has %zu vertices and %zu triangles, not below 2^32 - 1", function,
                                 mesh->vertex_count, mesh->triangle_count);
    }
    if (mesh->material_count > MATERIALS_MAX || (mesh->material_count > 0 && mesh->materials == NULL) ||
        (mesh->texture_count > 0 && mesh->textures == NULL)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: mesh has %zu materials (at most %d) and %zu textures, or no array", function,
                                 mesh->material_count, MATERIALS_MAX, mesh->texture_count);
    }
    for (size_t i = 0; i < mesh->texture_count; ++i) {
        SVO_I_TRY(check_texture(device, function, i, &mesh->textures[i]));
    }
    for (size_t i = 0; mesh->normal_maps != NULL && i < mesh->material_count; ++i) {
        if (!isfinite(mesh->normal_maps[i].scale)) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: normal map %zu has a scale of %g, not finite",
                                     function, i, (double)mesh->normal_maps[i].scale);
        }
    }
    return SVO_OK;
}

svo_status svo_i_mesh_check_host(svo_device *device, const char *function, const svo_mesh *mesh)
{
    if (mesh->vertex_count > 0 && (mesh->positions == NULL) == (mesh->positions_double == NULL)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: mesh has %zu vertices but not exactly one array of positions", function,
                                 mesh->vertex_count);
    }
    return svo_i_mesh_check_counts(device, function, mesh);
}

/* ---- reading ---- */

/* One array of a mesh in the making. */
typedef struct array {
    const char *name;
    const svo_mesh_view *view;
    size_t count, element_bytes;
} array;

void svo_mesh_copy_destroy(svo_mesh_copy **copy)
{
    if (copy == NULL || *copy == NULL) {
        return;
    }
    for (size_t i = 0; i < sizeof(*copy)->arrays / sizeof(*copy)->arrays[0]; ++i) {
        svo_i_free((*copy)->arrays[i]);
    }
    svo_i_free(*copy);
    *copy = NULL;
}

const svo_mesh *svo_mesh_copy_get(const svo_mesh_copy *copy)
{
    return &copy->mesh;
}

/* *span_bytes: from the start of the first to the end of the last element. Fails if the span leaves the buffer. */
static svo_status span_of(const svo_i_mesh_reader *reader, const array *from, size_t stride_bytes, size_t *span_bytes,
                          svo_message *message)
{
    size_t end_bytes = 0, held_bytes = 0;
    if (stride_bytes < from->element_bytes) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s.stride_bytes %zu is below the %zu of an element",
                          reader->function, from->name, stride_bytes, from->element_bytes);
    }
    if (!svo_i_mul_size(from->count - 1, stride_bytes, span_bytes) ||
        !svo_i_add_size(*span_bytes, from->element_bytes, span_bytes) ||
        !svo_i_add_size(*span_bytes, from->view->offset_bytes, &end_bytes)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s does not fit the address space", reader->function,
                          from->name);
    }
    SVO_I_TRY(reader->size(reader->self, from->name, from->view, &held_bytes, message));
    if (end_bytes > held_bytes) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s ends at byte %zu of a buffer of %zu bytes",
                          reader->function, from->name, end_bytes, held_bytes);
    }
    return SVO_OK;
}

/* Removes the gaps between elements that lie stride_bytes apart, in place. */
static void pack(unsigned char *bytes, const array *from, size_t stride_bytes)
{
    for (size_t i = 1; i < from->count && stride_bytes > from->element_bytes; ++i) {
        memmove(bytes + i * from->element_bytes, bytes + i * stride_bytes, from->element_bytes);
    }
}

/* Reads and packs an array. *out stays NULL for one that is empty or absent. */
static svo_status read_array(const svo_i_mesh_reader *reader, const svo_i_memory *memory, const array *from, void **out,
                             svo_message *message)
{
    if (from->count == 0 || !reader->has(from->view)) {
        return SVO_OK;
    }
    const size_t stride_bytes = from->view->stride_bytes != 0 ? from->view->stride_bytes : from->element_bytes;
    size_t span_bytes = 0;
    SVO_I_TRY(span_of(reader, from, stride_bytes, &span_bytes, message));
    if (span_bytes == 0) {
        return SVO_OK;
    }
    unsigned char *bytes = svo_i_alloc(memory, span_bytes);
    if (bytes == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no %zu bytes for %s", reader->function, span_bytes,
                          from->name);
    }
    const svo_status status =
        reader->read(reader->self, from->view, from->view->offset_bytes, span_bytes, bytes, message);
    if (status != SVO_OK) {
        svo_i_free(bytes);
        return status;
    }
    pack(bytes, from, stride_bytes);
    *out = bytes;
    return SVO_OK;
}

/* Replaces indices of 16 bits by indices of 32 bits. */
static svo_status widen_indices(const svo_i_mesh_reader *reader, const svo_i_memory *memory, size_t count,
                                void **indices, svo_message *message)
{
    const uint16_t *narrow = *indices;
    uint32_t *wide = svo_i_alloc_zeroed(memory, count, sizeof *wide);
    if (wide == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu indices", reader->function, count);
    }
    for (size_t i = 0; i < count; ++i) {
        wide[i] = narrow[i];
    }
    svo_i_free(*indices);
    *indices = wide;
    return SVO_OK;
}

static svo_status check_buffers(const svo_mesh_buffers *buffers, const svo_i_mesh_reader *reader, svo_message *message)
{
    if (buffers->index_bytes != 0 && buffers->index_bytes != 2 && buffers->index_bytes != 4) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: buffers.index_bytes %u is none of 0, 2, 4",
                          reader->function, buffers->index_bytes);
    }
    if (buffers->vertex_count >= UINT32_MAX || buffers->triangle_count >= UINT32_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "%s: buffers hold %zu vertices and %zu triangles, not below 2^32 - 1", reader->function,
                          buffers->vertex_count, buffers->triangle_count);
    }
    if (buffers->vertex_count > 0 && !reader->has(&buffers->positions)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: buffers.positions names no buffer", reader->function);
    }
    return SVO_OK;
}

/* The arrays in the order of svo_mesh_copy. */
static void list_arrays(const svo_mesh_buffers *buffers, array arrays[ARRAYS])
{
    const size_t vertices = buffers->vertex_count, triangles = buffers->triangle_count;
    arrays[0] = (array){"positions", &buffers->positions, vertices, 12};
    arrays[1] = (array){"indices", &buffers->indices, triangles * 3, buffers->index_bytes == 2 ? 2 : 4};
    arrays[2] = (array){"normals", &buffers->normals, vertices, 12};
    arrays[3] = (array){"colors", &buffers->colors, vertices, 4};
    arrays[4] = (array){"uvs", &buffers->uvs, vertices, 8};
    arrays[5] = (array){"triangle_materials", &buffers->triangle_materials, triangles, 2};
}

static svo_status read_arrays(const svo_mesh_buffers *buffers, const svo_i_mesh_reader *reader,
                              const svo_i_memory *memory, svo_mesh_copy *copy, svo_message *message)
{
    array arrays[ARRAYS];
    list_arrays(buffers, arrays);
    for (size_t i = 0; i < ARRAYS; ++i) {
        SVO_I_TRY(read_array(reader, memory, &arrays[i], &copy->arrays[i], message));
    }
    return copy->arrays[1] != NULL && buffers->index_bytes == 2
               ? widen_indices(reader, memory, buffers->triangle_count * 3, &copy->arrays[1], message)
               : SVO_OK;
}

svo_status svo_i_mesh_read(const svo_mesh_buffers *given, const svo_i_mesh_reader *reader, svo_mesh_copy **out,
                           svo_message *message)
{
    svo_mesh_buffers read;
    const svo_mesh_buffers *buffers = &read;
    SVO_I_TRY(svo_i_struct_read(message, reader->function, "buffers", given, &read,
                                SVO_I_STRUCT_SIZES(svo_mesh_buffers, indices)));
    SVO_I_TRY(check_buffers(buffers, reader, message));
    svo_i_memory memory;
    SVO_I_TRY(svo_i_memory_read(message, reader->function, "buffers.memory", buffers->memory, &memory));
    svo_mesh_copy *copy = svo_i_alloc_zeroed(&memory, 1, sizeof *copy);
    if (copy == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the handle", reader->function);
    }
    const svo_status status = read_arrays(buffers, reader, &memory, copy, message);
    if (status != SVO_OK) {
        svo_mesh_copy_destroy(&copy);
        return status;
    }
    copy->mesh = (svo_mesh){.struct_size = sizeof copy->mesh,
                            .positions = copy->arrays[0],
                            .vertex_count = buffers->vertex_count,
                            .indices = copy->arrays[1],
                            .triangle_count = buffers->triangle_count,
                            .normals = copy->arrays[2],
                            .colors = copy->arrays[3],
                            .uvs = copy->arrays[4],
                            .triangle_materials = copy->arrays[5],
                            .materials = buffers->materials,
                            .material_count = buffers->material_count,
                            .textures = buffers->textures,
                            .texture_count = buffers->texture_count};
    *out = copy;
    return SVO_OK;
}

/* Reading through a queue. */
typedef struct queue_reader {
    const char *function; /* for messages */
    cl_command_queue queue;
    cl_context context; /* the queue's */
    cl_uint wait_count;
    const cl_event *wait;
} queue_reader;

static bool has_memory(const svo_mesh_view *view)
{
    return view->memory != NULL;
}

static svo_status fail_cl(svo_message *message, const char *function, const char *call, cl_int error)
{
    return svo_i_fail(message, SVO_CL_ERROR, "%s: %s failed with %s (%d)", function, call, svo_i_cl_error_name(error),
                      error);
}

static svo_status memory_size(void *self, const char *name, const svo_mesh_view *view, size_t *bytes,
                              svo_message *message)
{
    const queue_reader *reader = self;
    const char *wrong = svo_i_wrong_memory(reader->context, view->memory);
    if (wrong != NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s %s", reader->function, name, wrong);
    }
    const cl_int error = clGetMemObjectInfo(view->memory, CL_MEM_SIZE, sizeof *bytes, bytes, NULL);
    return error == CL_SUCCESS ? SVO_OK : fail_cl(message, reader->function, "clGetMemObjectInfo", error);
}

static svo_status read_memory(void *self, const svo_mesh_view *view, size_t offset_bytes, size_t bytes, void *to,
                              svo_message *message)
{
    const queue_reader *reader = self;
    const cl_int error = clEnqueueReadBuffer(reader->queue, view->memory, CL_TRUE, offset_bytes, bytes, to,
                                             reader->wait_count, reader->wait, NULL);
    return error == CL_SUCCESS ? SVO_OK : fail_cl(message, reader->function, "clEnqueueReadBuffer", error);
}

svo_status svo_i_mesh_check(const char *function, cl_context context, const svo_mesh_buffers *buffers,
                            svo_message *message)
{
    queue_reader self = {.function = function, .context = context};
    const svo_i_mesh_reader reader = {.function = function, .self = &self, .has = has_memory, .size = memory_size};
    array arrays[ARRAYS];
    SVO_I_TRY(check_buffers(buffers, &reader, message));
    list_arrays(buffers, arrays);
    for (size_t i = 0; i < ARRAYS; ++i) {
        const array *from = &arrays[i];
        size_t span_bytes = 0;
        if (from->count > 0 && has_memory(from->view)) {
            const size_t stride_bytes = from->view->stride_bytes;
            SVO_I_TRY(
                span_of(&reader, from, stride_bytes != 0 ? stride_bytes : from->element_bytes, &span_bytes, message));
        }
    }
    return SVO_OK;
}

svo_status svo_mesh_read(const svo_mesh_buffers *buffers, cl_command_queue queue, cl_uint num_wait,
                         const cl_event *wait, svo_mesh_copy **out, svo_message *message)
{
    if (buffers == NULL || queue == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_mesh_read: %s is NULL",
                          buffers == NULL ? "buffers"
                          : queue == NULL ? "queue"
                                          : "out");
    }
    queue_reader self = {.function = "svo_mesh_read", .queue = queue, .wait_count = num_wait, .wait = wait};
    const cl_int error = clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof(cl_context), &self.context, NULL);
    if (error != CL_SUCCESS) {
        return fail_cl(message, self.function, "clGetCommandQueueInfo", error);
    }
    const char *wrong = svo_i_wrong_wait(self.context, num_wait, wait);
    if (wrong != NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_mesh_read: %s", wrong);
    }
    const svo_i_mesh_reader reader = {
        .function = "svo_mesh_read", .self = &self, .has = has_memory, .size = memory_size, .read = read_memory};
    return svo_i_mesh_read(buffers, &reader, out, message);
}
