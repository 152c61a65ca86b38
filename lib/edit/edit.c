/* SPDX-License-Identifier: MIT */
/* Edits: begun from a list, asked, turned into lists. */
#include <inttypes.h>
#include <string.h>

#include "core/limits.h"
#include "core/struct_size.h"
#include "edit/combine.h"
#include "edit/handle.h"
#include "edit/list.h"
#include "edit/steps.h"
#include "voxels/voxels.h"

#define COORDINATE_MAX (1 << 30)
#define UNDO_DEFAULT   64u
#define HALF_EXTENT    (SVO_EDIT_EXTENT / 2)

static const char create_name[] = "svo_edit_create";
static const char get_name[] = "svo_edit_get_voxels";

/* ---- create ---- */

static svo_status check_options(const svo_edit_options *options, svo_message *message)
{
    if (options->max_bytes != 0 && options->max_bytes < SVO_EDIT_BYTES_MIN) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: options.max_bytes %" PRIu64 " is below %d", create_name,
                          options->max_bytes, SVO_EDIT_BYTES_MIN);
    }
    if (options->undo_count > SVO_EDIT_UNDO_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: options.undo_count %u is above %d", create_name,
                          options->undo_count, SVO_EDIT_UNDO_MAX);
    }
    if (options->reserved != 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: options.reserved %u is not 0", create_name,
                          options->reserved);
    }
    return SVO_OK;
}

/* The list without its voxels. */
static svo_status make_frame(const svo_voxels *voxels, const svo_memory_callbacks *memory, svo_edit *made,
                             svo_message *message)
{
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.memory = memory;
    if (voxels != NULL) {
        source.properties = voxels->properties;
        source.property_count = (size_t)voxels->info.property_count;
        source.voxel_edge = voxels->info.voxel_edge;
        memcpy(source.origin, voxels->info.origin, sizeof source.origin);
    }
    const svo_status status = svo_voxels_create(&source, &made->frame, message);
    if (status != SVO_OK) {
        svo_i_message_rename(message, create_name);
        return status;
    }
    made->frame->axes = voxels != NULL ? voxels->axes : SVO_AXES_AUTO;
    return SVO_OK;
}

/* The cube, which has the list's least corner in its middle. */
static svo_status place_cube(const svo_voxels *voxels, svo_edit *made, svo_message *message)
{
    svo_edit_info *info = &made->info;
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t low = voxels != NULL ? voxels->info.low[axis] : 0;
        const int64_t high = voxels != NULL ? voxels->info.high[axis] : 0;
        if (high - low > HALF_EXTENT) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                              "%s: %c coordinates %" PRId64 " .. %" PRId64 " span more than %d voxels", create_name,
                              "xyz"[axis], low, high - 1, HALF_EXTENT);
        }
        const int64_t begin = low - HALF_EXTENT;
        const int64_t end = low + HALF_EXTENT;
        made->corner[axis] = begin;
        info->low[axis] = (int32_t)(begin < -COORDINATE_MAX ? -COORDINATE_MAX : begin);
        info->high[axis] = (int32_t)(end > COORDINATE_MAX + 1 ? COORDINATE_MAX + 1 : end);
    }
    memcpy(info->origin, made->frame->info.origin, sizeof info->origin);
    info->voxel_edge = made->frame->info.voxel_edge;
    return SVO_OK;
}

static svo_status read_voxels(const svo_voxels *voxels, svo_edit *made, svo_message *message)
{
    svo_i_edit_store *store = &made->store;
    const uint64_t count = voxels != NULL ? voxels->info.voxel_count : 0;
    made->version_count = 1;
    store->has_normals = voxels != NULL && voxels->normals != NULL;
    if (count > 0 &&
        !svo_i_edit_read_list(store, voxels->voxels, voxels->normals, count, made->corner, &made->versions[0])) {
        return store->failure == SVO_CAPACITY_EXCEEDED
                   ? svo_i_fail(message, SVO_CAPACITY_EXCEEDED, "%s: %" PRIu64 " voxels need more than max_bytes, %s",
                                create_name, count, svo_i_bytes(store->max_bytes).text)
                   : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the nodes of %" PRIu64 " voxels",
                                create_name, count);
    }
    made->info.kept_bytes = svo_i_edit_store_used(store);
    made->info.peak_bytes = svo_i_edit_store_held(store);
    return SVO_OK;
}

svo_status svo_edit_create(const svo_voxels *voxels, const svo_edit_options *options, svo_edit **out,
                           svo_message *message)
{
    svo_status status = SVO_OK;
    svo_edit_options given;
    svo_i_memory memory;
    svo_edit *made = NULL;
    if (out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: out is NULL", create_name);
    }
    SVO_I_TRY(svo_i_struct_read(message, create_name, "options", options, &given,
                                SVO_I_STRUCT_SIZES(svo_edit_options, memory)));
    SVO_I_TRY(svo_i_memory_read(message, create_name, "options.memory", given.memory, &memory));
    SVO_I_TRY(check_options(&given, message));
    const uint32_t room = (given.undo_count == 0 ? UNDO_DEFAULT : given.undo_count) + 1;
    made = svo_i_alloc_zeroed(&memory, 1, sizeof *made);
    svo_i_edit_ref *versions = svo_i_alloc_zeroed(&memory, room, sizeof *versions);
    if (made == NULL || versions == NULL) {
        svo_i_free(versions);
        status = svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the edit", create_name);
        goto cleanup;
    }
    made->versions = versions;
    made->version_room = room;
    made->info.struct_size = sizeof made->info;
    made->info.max_bytes = given.max_bytes == 0 ? svo_i_host_memory_bytes() / 2 : given.max_bytes;
    made->store = (svo_i_edit_store){.memory = memory, .max_bytes = made->info.max_bytes};
    made->progress = given.progress;
    made->progress_user = given.progress_user;
    SVO_I_TRY_CLEANUP(make_frame(voxels, given.memory, made, message));
    SVO_I_TRY_CLEANUP(place_cube(voxels, made, message));
    SVO_I_TRY_CLEANUP(read_voxels(voxels, made, message));
    *out = made;
    made = NULL;
cleanup:
    svo_edit_destroy(&made);
    return status;
}

void svo_edit_destroy(svo_edit **edit)
{
    if (edit == NULL || *edit == NULL) {
        return;
    }
    svo_i_edit_store_release(&(*edit)->store);
    svo_voxels_destroy(&(*edit)->frame);
    svo_i_free((*edit)->versions);
    svo_i_free(*edit);
    *edit = NULL;
}

/* ---- what it holds ---- */

static svo_i_edit_ref root_of(const svo_edit *edit)
{
    return edit->versions[edit->current];
}

svo_status svo_edit_get_info(const svo_edit *edit, svo_edit_info *info)
{
    if (edit == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    svo_edit_info made = edit->info;
    made.voxel_count = svo_i_edit_voxels_of(&edit->store, root_of(edit), SVO_I_EDIT_ROOT_LEVEL);
    made.undo_count = edit->current;
    made.redo_count = edit->version_count - 1 - edit->current;
    made.held_bytes = svo_i_edit_store_held(&edit->store);
    made.collect_bytes = svo_i_edit_collect_bytes(edit);
    return svo_i_struct_write(NULL, "svo_edit_get_info", "info", &made, info,
                              SVO_I_STRUCT_SIZES(svo_edit_info, voxel_edge));
}

int svo_edit_find(const svo_edit *edit, const int32_t place[3], svo_voxel *voxel)
{
    uint32_t cell[3];
    svo_i_edit_payload found;
    for (int axis = 0; axis < 3; ++axis) {
        if (place[axis] < edit->info.low[axis] || place[axis] >= edit->info.high[axis]) {
            return 0;
        }
        cell[axis] = (uint32_t)(place[axis] - edit->corner[axis]);
    }
    if (!svo_i_edit_find_cell(&edit->store, root_of(edit), cell, &found)) {
        return 0;
    }
    if (voxel != NULL) {
        *voxel = (svo_voxel){.x = place[0], .y = place[1], .z = place[2], .material = found.material};
        memcpy(voxel->rgba, &found.color, sizeof voxel->rgba);
    }
    return 1;
}

/* ---- lists ---- */

svo_status svo_edit_get_voxels(const svo_edit *edit, svo_voxels **out, svo_message *message)
{
    if (edit == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", get_name, edit == NULL ? "edit" : "out");
    }
    const svo_voxels *frame = edit->frame;
    const uint64_t count = svo_i_edit_voxels_of(&edit->store, root_of(edit), SVO_I_EDIT_ROOT_LEVEL);
    if (count > SVO_VOXELS_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the edit has %" PRIu64 " voxels, above %u", get_name,
                          count, SVO_VOXELS_MAX);
    }
    if (count * sizeof(svo_voxel) > svo_i_host_memory_bytes()) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY,
                          "%s: %" PRIu64 " voxels need %s, above the %s that are there", get_name, count,
                          svo_i_bytes(count * sizeof(svo_voxel)).text, svo_i_bytes(svo_i_host_memory_bytes()).text);
    }
    const bool has_normals = edit->store.has_normals;
    svo_voxel *voxels = svo_i_alloc(&frame->memory, (size_t)(count + 1) * sizeof *voxels);
    int16_t *normals = has_normals ? svo_i_alloc(&frame->memory, (size_t)(count + 1) * 3 * sizeof *normals) : NULL;
    if (voxels == NULL || (normals == NULL && has_normals)) {
        svo_i_free(voxels);
        svo_i_free(normals);
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %" PRIu64 " voxels", get_name, count);
    }
    svo_i_edit_write_list(&edit->store, root_of(edit), edit->corner, voxels, normals);
    svo_voxels_source source = {.struct_size = sizeof source,
                                .voxel_count = count,
                                .properties = frame->properties,
                                .property_count = (size_t)frame->info.property_count,
                                .voxel_edge = frame->info.voxel_edge};
    memcpy(source.origin, frame->info.origin, sizeof source.origin);
    const svo_status status = svo_i_voxels_take(&frame->memory, &source, voxels, normals, out, message);
    if (status != SVO_OK) {
        svo_i_message_rename(message, get_name);
        return status;
    }
    (*out)->axes = frame->axes;
    return SVO_OK;
}
