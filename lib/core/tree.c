/* SPDX-License-Identifier: MIT */
/* The tree: its arrays on the device and on the host, and its hash. */
#include "core/tree.h"

#include <stdio.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/device.h"
#include "core/message.h"
#include "core/staging.h"
#include "core/struct_size.h"
#include "svocl/nodes.h"
#include "svocl/plan.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "svocl hashes and stores arrays in memory order and needs a little-endian host"
#endif

svo_tree *svo_i_tree_new(const svo_i_memory *memory)
{
    svo_tree *tree = svo_i_alloc_zeroed(memory, 1, sizeof *tree);
    if (tree != NULL && memory != NULL) {
        tree->memory = *memory;
    }
    return tree;
}

void svo_tree_destroy(svo_tree **tree)
{
    if (tree == NULL || *tree == NULL) {
        return;
    }
    svo_i_attachments_clear(&(*tree)->attachments);
    svo_i_tree_forget(*tree);
    svo_i_attachments_clear(&(*tree)->derived);
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if ((*tree)->buffers[i] != NULL) {
            clReleaseMemObject((*tree)->buffers[i]);
        }
    }
    if ((*tree)->build_state != NULL) {
        clReleaseMemObject((*tree)->build_state);
    }
    svo_i_free((*tree)->part.runs);
    svo_i_free(*tree);
    *tree = NULL;
}

void svo_i_tree_forget(svo_tree *tree)
{
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        svo_i_free(tree->host[i]);
        tree->host[i] = NULL;
    }
    tree->downloaded = false;
    svo_i_attachments_outdate(&tree->derived);
}

const char *svo_i_tree_undefined(const svo_tree *tree)
{
    switch (tree->content) {
    case SVO_I_TREE_EMPTY:
        return "nothing was built into the tree; call svo_build_enqueue and svo_tree_finish first";
    case SVO_I_TREE_IN_FLIGHT:
        return "the tree's build is in flight; call svo_tree_finish first";
    case SVO_I_TREE_FAILED:
        return "the tree's last build failed, which leaves it undefined";
    case SVO_I_TREE_ABANDONED:
        return "the tree's workspace was destroyed before its build was finished";
    default:
        return NULL;
    }
}

svo_status svo_i_tree_check(const svo_tree *tree, const char *function)
{
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const char *undefined = svo_i_tree_undefined(tree);
    return undefined == NULL ? SVO_OK
                             : svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: %s", function, undefined);
}

svo_status svo_tree_get_info(const svo_tree *tree, svo_tree_info *info)
{
    SVO_I_TRY(svo_i_tree_check(tree, "svo_tree_get_info"));
    svo_tree_info found = tree->info;
    found.ray_bytes = tree->ray_bytes;
    return svo_i_struct_write(svo_i_device_message(tree->device), "svo_tree_get_info", "info", &found, info,
                              SVO_I_STRUCT_SIZES(svo_tree_info, level_begin));
}

cl_mem *svo_i_tree_slot(svo_tree *tree, const char *name)
{
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if (strcmp(svo_name(SVO_NAME_TREE_BUFFER, i), name) == 0) {
            return &tree->buffers[i];
        }
    }
    return &tree->build_state;
}

bool svo_i_tree_holds(const svo_tree_info *info, svo_tree_buffer buffer)
{
    switch (buffer) {
    case SVO_TREE_CHILD_MASK:
    case SVO_TREE_FIRST_CHILD:
        return true;
    case SVO_TREE_COLORS:
        return (info->need & SVO_NEED_COLOR) != 0;
    case SVO_TREE_NORMALS:
        return (info->need & SVO_NEED_NORMAL) != 0;
    case SVO_TREE_MATERIALS:
        return (info->need & SVO_NEED_MATERIAL) != 0;
    case SVO_TREE_FILLS:
        return (info->need & SVO_NEED_FILL) != 0;
    case SVO_TREE_AREAS:
        return (info->need & SVO_NEED_PROJECTED_AREA) != 0;
    case SVO_TREE_POSITIONS:
        return info->positions == SVO_POSITIONS_FLOAT;
    case SVO_TREE_POSITIONS_DOUBLE:
        return info->positions == SVO_POSITIONS_DOUBLE;
    default:
        return (info->need & SVO_NEED_RAYS) != 0;
    }
}

bool svo_i_tree_is_constant(const svo_tree_info *info, svo_tree_buffer buffer)
{
    switch (buffer) {
    case SVO_TREE_COLORS:
        return (info->constant & SVO_NEED_COLOR) != 0;
    case SVO_TREE_NORMALS:
        return (info->constant & SVO_NEED_NORMAL) != 0;
    case SVO_TREE_MATERIALS:
        return (info->constant & SVO_NEED_MATERIAL) != 0;
    default:
        return false;
    }
}

uint64_t svo_i_tree_payload_count(const svo_tree_info *info)
{
    return info->node_count - info->level_begin[info->payload_level];
}

uint64_t svo_i_tree_element_count(const svo_tree_info *info, svo_tree_buffer buffer)
{
    switch (buffer) {
    case SVO_TREE_CHILD_MASK:
    case SVO_TREE_FIRST_CHILD:
        return info->inner_count;
    case SVO_TREE_COLORS:
    case SVO_TREE_NORMALS:
    case SVO_TREE_MATERIALS:
    case SVO_TREE_FILLS:
        return svo_i_tree_is_constant(info, buffer) ? 1 : svo_i_tree_payload_count(info);
    case SVO_TREE_AREAS:
        return info->leaf_count;
    case SVO_TREE_LIST_BEGIN:
        return info->leaf_count + 1;
    case SVO_TREE_LIST:
        return info->list_count;
    case SVO_TREE_VERTICES:
    case SVO_TREE_POSITIONS:
    case SVO_TREE_POSITIONS_DOUBLE:
        return info->vertex_count;
    default:
        return info->list_triangle_count;
    }
}

size_t svo_i_tree_element_bytes(svo_tree_buffer buffer)
{
    switch (buffer) {
    case SVO_TREE_CHILD_MASK:
        return 1;
    case SVO_TREE_MATERIALS:
    case SVO_TREE_FILLS:
        return 2;
    case SVO_TREE_NORMALS:
        return 6;
    case SVO_TREE_VERTICES:
    case SVO_TREE_INDICES:
    case SVO_TREE_AREAS:
    case SVO_TREE_POSITIONS:
        return 12;
    case SVO_TREE_POSITIONS_DOUBLE:
        return 24;
    default:
        return 4;
    }
}

cl_mem svo_tree_get_buffer(const svo_tree *tree, svo_tree_buffer buffer)
{
    if (buffer == SVO_TREE_BUILD_STATE) {
        return tree->build_state;
    }
    return buffer < SVO_TREE_BUFFER_COUNT ? tree->buffers[buffer] : NULL;
}

svo_status svo_tree_get_arrays(const svo_tree *tree, svo_tree_arrays *arrays)
{
    SVO_I_TRY(svo_i_tree_check(tree, "svo_tree_get_arrays"));
    const svo_tree_arrays held = {.child_mask = tree->host[SVO_TREE_CHILD_MASK],
                                  .first_child = tree->host[SVO_TREE_FIRST_CHILD],
                                  .colors = tree->host[SVO_TREE_COLORS],
                                  .normals = tree->host[SVO_TREE_NORMALS],
                                  .list_begin = tree->host[SVO_TREE_LIST_BEGIN],
                                  .list = tree->host[SVO_TREE_LIST],
                                  .vertices = tree->host[SVO_TREE_VERTICES],
                                  .indices = tree->host[SVO_TREE_INDICES],
                                  .triangle_ids = tree->host[SVO_TREE_TRIANGLE_IDS],
                                  .materials = tree->host[SVO_TREE_MATERIALS],
                                  .fills = tree->host[SVO_TREE_FILLS],
                                  .areas = tree->host[SVO_TREE_AREAS],
                                  .positions = tree->host[SVO_TREE_POSITIONS],
                                  .positions_double = tree->host[SVO_TREE_POSITIONS_DOUBLE]};
    return svo_i_struct_write(svo_i_device_message(tree->device), "svo_tree_get_arrays", "arrays", &held, arrays,
                              SVO_I_STRUCT_SIZES(svo_tree_arrays, first_child));
}

/* Bytes of an array on the device; 0 if the tree does not hold it or the size overflows. */
static size_t array_bytes(const svo_tree *tree, svo_tree_buffer buffer)
{
    size_t bytes = 0;
    if (!svo_i_tree_holds(&tree->info, buffer) || !svo_i_mul_size((size_t)svo_i_tree_element_count(&tree->info, buffer),
                                                                  svo_i_tree_element_bytes(buffer), &bytes)) {
        return 0;
    }
    return bytes;
}

/* Bytes of an array on the host, where payload has an element for every node. */
static size_t host_bytes(const svo_tree *tree, svo_tree_buffer buffer)
{
    const size_t bytes = array_bytes(tree, buffer);
    size_t repeated = 0;
    return svo_i_tree_is_constant(&tree->info, buffer) &&
                   svo_i_mul_size(bytes, (size_t)svo_i_tree_payload_count(&tree->info), &repeated)
               ? repeated
               : bytes;
}

bool svo_i_tree_repeat(const svo_tree *tree, svo_tree_buffer buffer, void **array)
{
    const size_t bytes = host_bytes(tree, buffer);
    const size_t element_bytes = svo_i_tree_element_bytes(buffer);
    if (!svo_i_tree_is_constant(&tree->info, buffer) || bytes <= element_bytes) {
        return true;
    }
    unsigned char *repeated = svo_i_grow(&tree->memory, *array, bytes);
    if (repeated == NULL) {
        return false;
    }
    for (size_t at = element_bytes; at < bytes; at += element_bytes) {
        memcpy(repeated + at, repeated, element_bytes);
    }
    *array = repeated;
    return true;
}

svo_decide_params svo_i_grid_params(const svo_part_header *part, uint32_t level, uint64_t code, uint32_t depth,
                                    const double origin[3], double edge)
{
    const bool is_part = part->depth != 0;
    svo_decide_params params = {.depth = is_part ? part->depth : depth};
    memcpy(params.origin, is_part ? part->origin : origin, sizeof params.origin);
    memcpy(params.edge, is_part ? &part->edge : &edge, sizeof params.edge);
    if (is_part) {
        svo_code_to_cell(code, params.corner);
        for (unsigned axis = 0; axis < 3; ++axis) {
            params.corner[axis] <<= part->depth - level;
        }
    }
    return params;
}

/* Reads an array into new memory. *out stays NULL for an array that the tree does not hold. */
static svo_status download_array(const svo_tree *tree, cl_command_queue queue, svo_tree_buffer buffer, void **out)
{
    static const char function[] = "svo_tree_download";
    const size_t bytes = array_bytes(tree, buffer);
    if (bytes == 0 || tree->buffers[buffer] == NULL) {
        return SVO_OK;
    }
    *out = svo_i_alloc(&tree->memory, bytes);
    if (*out == NULL) {
        return svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: %s needs %zu bytes", function,
                                 svo_name(SVO_NAME_TREE_BUFFER, buffer), bytes);
    }
    const cl_int error = clEnqueueReadBuffer(queue, tree->buffers[buffer], CL_TRUE, 0, bytes, *out, 0, NULL, NULL);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(tree->device, function, "clEnqueueReadBuffer", error);
    }
    return svo_i_tree_repeat(tree, buffer, out)
               ? SVO_OK
               : svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: %s needs %zu bytes", function,
                                   svo_name(SVO_NAME_TREE_BUFFER, buffer), host_bytes(tree, buffer));
}

svo_status svo_tree_download(svo_tree *tree, cl_command_queue queue)
{
    void *host[SVO_TREE_BUFFER_COUNT] = {NULL};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_tree_check(tree, "svo_tree_download"));
    if (tree->downloaded) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_device_queue(tree->device, "svo_tree_download", queue, &queue));
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        SVO_I_TRY_CLEANUP(download_array(tree, queue, i, &host[i]));
    }
    memcpy(tree->host, host, sizeof host);
    memset(host, 0, sizeof host);
    tree->downloaded = true;

cleanup:
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        svo_i_free(host[i]);
    }
    return status;
}

/* Makes a buffer for an array. *out stays NULL for an array that the tree does not hold. */
static svo_status upload_array(const svo_tree *tree, svo_device *device, cl_command_queue queue, svo_tree_buffer buffer,
                               cl_mem *out)
{
    static const char function[] = "svo_tree_upload";
    const size_t bytes = array_bytes(tree, buffer);
    if (!svo_i_tree_holds(&tree->info, buffer)) {
        return SVO_OK;
    }
    SVO_I_TRY(
        svo_i_device_buffer(device, function, svo_name(SVO_NAME_TREE_BUFFER, buffer), CL_MEM_READ_ONLY, bytes, out));
    return svo_i_device_write(device, function, queue, *out, 0, tree->host[buffer], bytes);
}

svo_status svo_tree_upload(svo_tree *tree, svo_device *device, cl_command_queue queue)
{
    cl_mem buffers[SVO_TREE_BUFFER_COUNT] = {NULL};
    svo_status status = SVO_OK;
    if (tree == NULL || device == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_tree_upload: %s is NULL",
                                 tree == NULL ? "tree" : "device");
    }
    SVO_I_TRY(svo_i_tree_check(tree, "svo_tree_upload"));
    if (tree->device != NULL && tree->device != device) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_tree_upload: the tree is on %s already",
                                 tree->device->name);
    }
    if (tree->device != NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_device_queue(device, "svo_tree_upload", queue, &queue));
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        SVO_I_TRY_CLEANUP(upload_array(tree, device, queue, i, &buffers[i]));
    }
    memcpy(tree->buffers, buffers, sizeof buffers);
    memset(buffers, 0, sizeof buffers);
    tree->device = device;

cleanup:
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if (buffers[i] != NULL) {
            clReleaseMemObject(buffers[i]);
        }
    }
    return status;
}

/* Hashes the array's length and then its bytes, so that different trees never hash the same sequence of bytes. */
static void hash_array(XXH3_state_t *state, const svo_tree *tree, svo_tree_buffer buffer)
{
    const uint64_t bytes = host_bytes(tree, buffer);
    XXH3_128bits_update(state, &bytes, sizeof bytes);
    if (bytes > 0) {
        XXH3_128bits_update(state, tree->host[buffer], (size_t)bytes);
    }
}

svo_status svo_tree_hash(const svo_tree *tree, svo_hash_scope scope, char text[SVO_HASH_TEXT_BYTES])
{
    SVO_I_TRY(svo_i_tree_check(tree, "svo_tree_hash"));
    if (text == NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "svo_tree_hash: text is NULL");
    }
    if (!tree->downloaded) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "svo_tree_hash: the tree has no host arrays; call svo_tree_download first");
    }
    XXH3_state_t stack; /* a tree from a file has no message that a lack of memory could be told in */
    XXH3_state_t *state = &stack;
    XXH3_INITSTATE(state);
    XXH3_128bits_reset(state);
    const svo_tree_info *info = &tree->info;
    const uint32_t words[3] = {info->depth, info->coverage, info->is_exact != 0 ? 0 : info->snap_bits};
    XXH3_128bits_update(state, words, sizeof words);
    XXH3_128bits_update(state, info->origin, sizeof info->origin);
    XXH3_128bits_update(state, &info->edge, sizeof info->edge);
    XXH3_128bits_update(state, info->level_begin, (info->depth + 2) * sizeof info->level_begin[0]);
    hash_array(state, tree, SVO_TREE_CHILD_MASK);
    hash_array(state, tree, SVO_TREE_FIRST_CHILD);
    if (scope == SVO_HASH_ALL) {
        hash_array(state, tree, SVO_TREE_LIST_BEGIN);
        hash_array(state, tree, SVO_TREE_LIST);
        hash_array(state, tree, SVO_TREE_COLORS);
        hash_array(state, tree, SVO_TREE_NORMALS);
        hash_array(state, tree, SVO_TREE_MATERIALS);
        hash_array(state, tree, SVO_TREE_FILLS);
    }
    if (scope == SVO_HASH_ALL && svo_i_tree_holds(info, SVO_TREE_AREAS)) {
        hash_array(state, tree, SVO_TREE_AREAS);
    }
    const XXH128_hash_t hash = XXH3_128bits_digest(state);
    (void)snprintf(text, SVO_HASH_TEXT_BYTES, "%016llx%016llx", (unsigned long long)hash.high64,
                   (unsigned long long)hash.low64);
    return SVO_OK;
}
