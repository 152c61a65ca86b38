/* SPDX-License-Identifier: MIT */
/* The compact tree: its arrays on the device and on the host, and its hash. lib/compact makes it. */
#include "core/compact.h"

#include <stdio.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/device.h"
#include "core/staging.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "svocl/plan.h"

svo_compact *svo_i_compact_new(const svo_i_memory *memory)
{
    svo_compact *compact = svo_i_alloc_zeroed(memory, 1, sizeof *compact);
    if (compact != NULL && memory != NULL) {
        compact->memory = *memory;
    }
    return compact;
}

void svo_compact_destroy(svo_compact **compact)
{
    if (compact == NULL || *compact == NULL) {
        return;
    }
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        svo_i_free((*compact)->host[i]);
        if ((*compact)->buffers[i] != NULL) {
            clReleaseMemObject((*compact)->buffers[i]);
        }
    }
    svo_i_free(*compact);
    *compact = NULL;
}

/* ---- properties of arrays ---- */

uint32_t svo_i_compact_need(svo_compact_buffer buffer)
{
    switch (buffer) {
    case SVO_COMPACT_COLORS:
        return SVO_NEED_COLOR;
    case SVO_COMPACT_NORMALS:
        return SVO_NEED_NORMAL;
    case SVO_COMPACT_MATERIALS:
        return SVO_NEED_MATERIAL;
    case SVO_COMPACT_FILLS:
        return SVO_NEED_FILL;
    default:
        return 0;
    }
}

svo_tree_buffer svo_i_compact_tree_buffer(svo_compact_buffer buffer)
{
    switch (buffer) {
    case SVO_COMPACT_COLORS:
        return SVO_TREE_COLORS;
    case SVO_COMPACT_NORMALS:
        return SVO_TREE_NORMALS;
    case SVO_COMPACT_MATERIALS:
        return SVO_TREE_MATERIALS;
    case SVO_COMPACT_FILLS:
        return SVO_TREE_FILLS;
    default:
        return SVO_TREE_BUFFER_COUNT;
    }
}

bool svo_i_compact_is_constant(const svo_compact_info *info, svo_compact_buffer buffer)
{
    return (info->constant & svo_i_compact_need(buffer)) != 0;
}

bool svo_i_compact_is_packed(const svo_compact_info *info, svo_compact_buffer buffer)
{
    return (info->packed & svo_i_compact_need(buffer)) != 0;
}

size_t svo_i_compact_element_bytes(const svo_compact_info *info, svo_compact_buffer buffer)
{
    switch (buffer) {
    case SVO_COMPACT_NODES:
        return info->form == SVO_FORM_IMPLIED ? 1 : 4;
    case SVO_COMPACT_LINKS:
    case SVO_COMPACT_BASES:
        return 4;
    default:
        return svo_i_tree_element_bytes(svo_i_compact_tree_buffer(buffer));
    }
}

bool svo_i_compact_has_places(const svo_compact_info *info)
{
    return (info->need & ~info->constant) != 0;
}

/* Elements of bases: in breadth-first order one, the first node that has payload. */
static uint64_t count_bases(const svo_compact_info *info)
{
    if (!svo_i_compact_has_places(info)) {
        return 0;
    }
    switch (info->form) {
    case SVO_FORM_IMPLIED:
        return 1;
    case SVO_FORM_SHARED:
    case SVO_FORM_MIRRORED:
        return 0; /* places follow from the records */
    default:
        return info->stored_count;
    }
}

static uint64_t count_links(const svo_compact_info *info)
{
    switch (info->form) {
    case SVO_FORM_IMPLIED:
        return ((info->stored_count - 1) >> info->directory_step_log2) + 1;
    case SVO_FORM_SHARED:
        return 2;
    case SVO_FORM_MIRRORED:
        return info->depth + 1; /* two numbers, and where levels begin */
    default:
        return 0;
    }
}

static uint64_t count_elements(const svo_compact_info *info, svo_compact_buffer buffer)
{
    switch (buffer) {
    case SVO_COMPACT_NODES:
        /* Masks are read eight at a time. */
        return info->form == SVO_FORM_IMPLIED ? (info->stored_count + 7) / 8 * 8 : info->stored_count;
    case SVO_COMPACT_LINKS:
        return count_links(info);
    case SVO_COMPACT_BASES:
        return count_bases(info);
    default:
        return (info->need & svo_i_compact_need(buffer)) == 0 ? 0
               : (svo_i_compact_is_constant(info, buffer))    ? 1
                                                              : info->payload_count;
    }
}

void svo_i_compact_count(svo_compact_info *info)
{
    info->inner_count = 0;
    info->leaf_count = 0;
    info->voxel_count = 0;
    info->payload_count = 0;
    for (uint32_t level = 0; level <= info->depth; ++level) {
        info->inner_count += info->level_inner[level];
        info->leaf_count += info->level_leaf[level];
        info->voxel_count += (uint64_t)info->level_leaf[level] << (3 * (info->depth - level));
        info->payload_count +=
            level >= info->payload_level ? (uint64_t)info->level_inner[level] + info->level_leaf[level] : 0;
    }
    info->total_bytes = 0;
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const svo_compact_buffer buffer = (svo_compact_buffer)i;
        if (!svo_i_compact_is_packed(info, buffer)) {
            info->bytes[i] = count_elements(info, buffer) * svo_i_compact_element_bytes(info, buffer);
        }
        info->total_bytes += info->bytes[i];
    }
}

/* ---- what callers ask ---- */

svo_status svo_compact_get_info(const svo_compact *compact, svo_compact_info *info)
{
    return compact == NULL ? SVO_INVALID_ARGUMENT
                           : svo_i_struct_write(svo_i_device_message(compact->device), "svo_compact_get_info", "info",
                                                &compact->info, info, SVO_I_STRUCT_SIZES(svo_compact_info, bounds));
}

cl_mem svo_compact_get_buffer(const svo_compact *compact, svo_compact_buffer buffer)
{
    return (unsigned)buffer < SVO_COMPACT_BUFFER_COUNT ? compact->buffers[buffer] : NULL;
}

svo_status svo_compact_get_arrays(const svo_compact *compact, svo_compact_arrays *arrays)
{
    if (compact == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    svo_compact_arrays held = {.nodes = compact->host[SVO_COMPACT_NODES],
                               .links = compact->host[SVO_COMPACT_LINKS],
                               .bases = compact->host[SVO_COMPACT_BASES]};
    const void *plain[SVO_I_PAYLOAD_COUNT];
    for (int k = 0; k < SVO_I_PAYLOAD_COUNT; ++k) {
        const svo_compact_buffer buffer = (svo_compact_buffer)(SVO_I_PAYLOAD_FIRST + k);
        const bool packed = svo_i_compact_is_packed(&compact->info, buffer);
        plain[k] = packed ? NULL : compact->host[buffer];
        held.packed[k] = packed ? compact->host[buffer] : NULL;
    }
    held.colors = plain[0];
    held.normals = plain[1];
    held.materials = plain[2];
    held.fills = plain[3];
    return svo_i_struct_write(svo_i_device_message(compact->device), "svo_compact_get_arrays", "arrays", &held, arrays,
                              SVO_I_STRUCT_SIZES(svo_compact_arrays, fills));
}

/* ---- copies ---- */

/* Reads an array into new memory. *out stays NULL for an array that is not held. */
static svo_status download_array(const svo_compact *compact, cl_command_queue queue, svo_compact_buffer buffer,
                                 void **out)
{
    static const char function[] = "svo_compact_download";
    const size_t bytes = (size_t)compact->info.bytes[buffer];
    if (bytes == 0) {
        return SVO_OK;
    }
    *out = svo_i_alloc(&compact->memory, bytes);
    if (*out == NULL) {
        return svo_i_device_fail(compact->device, SVO_OUT_OF_HOST_MEMORY, "%s: %s needs %zu bytes", function,
                                 svo_name(SVO_NAME_COMPACT_BUFFER, buffer), bytes);
    }
    const cl_int error = clEnqueueReadBuffer(queue, compact->buffers[buffer], CL_TRUE, 0, bytes, *out, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(compact->device, function, "clEnqueueReadBuffer", error);
}

svo_status svo_compact_download(svo_compact *compact, cl_command_queue queue)
{
    void *host[SVO_COMPACT_BUFFER_COUNT] = {NULL};
    svo_status status = SVO_OK;
    if (compact == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (compact->downloaded) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_device_queue(compact->device, "svo_compact_download", queue, &queue));
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        SVO_I_TRY_CLEANUP(download_array(compact, queue, (svo_compact_buffer)i, &host[i]));
    }
    memcpy(compact->host, host, sizeof host);
    memset(host, 0, sizeof host);
    compact->downloaded = true;

cleanup:
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        svo_i_free(host[i]);
    }
    return status;
}

/* Makes a buffer for an array. *out stays NULL for an array that is not held. */
static svo_status upload_array(const svo_compact *compact, svo_device *device, cl_command_queue queue,
                               svo_compact_buffer buffer, cl_mem *out)
{
    static const char function[] = "svo_compact_upload";
    const size_t bytes = (size_t)compact->info.bytes[buffer];
    if (bytes == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(
        svo_i_device_buffer(device, function, svo_name(SVO_NAME_COMPACT_BUFFER, buffer), CL_MEM_READ_ONLY, bytes, out));
    return svo_i_device_write(device, function, queue, *out, 0, compact->host[buffer], bytes);
}

svo_status svo_compact_upload(svo_compact *compact, svo_device *device, cl_command_queue queue)
{
    cl_mem buffers[SVO_COMPACT_BUFFER_COUNT] = {NULL};
    svo_status status = SVO_OK;
    if (compact == NULL || device == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_compact_upload: %s is NULL",
                                 compact == NULL ? "compact" : "device");
    }
    if (compact->device != NULL && compact->device != device) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_compact_upload: the compact tree is on %s already",
                                 compact->device->name);
    }
    if (compact->device != NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_device_queue(device, "svo_compact_upload", queue, &queue));
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        SVO_I_TRY_CLEANUP(upload_array(compact, device, queue, (svo_compact_buffer)i, &buffers[i]));
    }
    memcpy(compact->buffers, buffers, sizeof buffers);
    memset(buffers, 0, sizeof buffers);
    compact->device = device;

cleanup:
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        if (buffers[i] != NULL) {
            clReleaseMemObject(buffers[i]);
        }
    }
    return status;
}

/* ---- hash ---- */

svo_status svo_compact_hash(const svo_compact *compact, char text[SVO_HASH_TEXT_BYTES])
{
    static const char function[] = "svo_compact_hash";
    if (compact == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (text == NULL) {
        return svo_i_device_fail(compact->device, SVO_INVALID_ARGUMENT, "%s: text is NULL", function);
    }
    if (!compact->downloaded) {
        return svo_i_device_fail(compact->device, SVO_INVALID_ARGUMENT,
                                 "%s: there are no host arrays; call svo_compact_download first", function);
    }
    XXH3_state_t stack;
    XXH3_state_t *state = &stack;
    const svo_compact_info *info = &compact->info;
    const uint32_t rounded_to = info->is_exact != 0 ? 0 : info->snap_bits;
    const uint32_t words[5] = {info->form, info->directory_step_log2, info->depth, info->coverage, rounded_to};
    XXH3_INITSTATE(state);
    XXH3_128bits_reset(state);
    XXH3_128bits_update(state, words, sizeof words);
    XXH3_128bits_update(state, info->origin, sizeof info->origin);
    XXH3_128bits_update(state, &info->edge, sizeof info->edge);
    XXH3_128bits_update(state, &info->payload_level, sizeof info->payload_level);
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        XXH3_128bits_update(state, &info->bytes[i], sizeof info->bytes[i]);
        if (info->bytes[i] > 0) {
            XXH3_128bits_update(state, compact->host[i], (size_t)info->bytes[i]);
        }
    }
    const XXH128_hash_t hash = XXH3_128bits_digest(state);
    (void)snprintf(text, SVO_HASH_TEXT_BYTES, "%016llx%016llx", (unsigned long long)hash.high64,
                   (unsigned long long)hash.low64);
    return SVO_OK;
}
