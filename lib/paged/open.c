/* SPDX-License-Identifier: MIT */
/* Paged trees from the opening of the file to its closing. */
#include "svocl/paged.h"

#include <inttypes.h>

#include "core/struct_size.h"
#include "paged/layout.h"
#include "paged/pool.h"
#include "rays/rays.h"

static svo_status read_options(svo_device *device, const svo_paged_options *given, svo_paged_options *asked,
                               svo_i_memory *memory)
{
    static const char function[] = "svo_paged_open";
    svo_message *message = svo_i_device_message(device);
    SVO_I_TRY(
        svo_i_struct_read(message, function, "options", given, asked, SVO_I_STRUCT_SIZES(svo_paged_options, memory)));
    asked->page_levels = asked->page_levels == 0 ? PAGED_LEVELS_DEFAULT : asked->page_levels;
    if (asked->page_levels < PAGED_LEVELS_MIN || asked->page_levels > PAGED_LEVELS_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.page_levels %" PRIu32 " is not in %d .. %d",
                                 function, asked->page_levels, PAGED_LEVELS_MIN, PAGED_LEVELS_MAX);
    }
    return svo_i_memory_read(message, function, "options.memory", asked->memory, memory);
}

/* What can be paged, by the header. */
static svo_status check_file(const svo_paged *paged)
{
    const svo_tree_info *info = &paged->file.info;
    const uint32_t version = paged->load.head.header.version;
    const uint32_t shown = info->need & ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL) & ~info->constant;
    if (version < FILE_BY_LEVELS) {
        return svo_i_device_fail(paged->device, SVO_UNSUPPORTED,
                                 "%s: version %" PRIu32 " is not by levels; load and save it to get version %d",
                                 paged->path, version, FILE_VERSION);
    }
    return info->payload_level == 0 || shown == 0 ? SVO_OK
                                                  : svo_i_device_fail(paged->device, SVO_UNSUPPORTED,
                                                                      "%s: the tree has payload from level %" PRIu32
                                                                      " on only, and pictures need all levels",
                                                                      paged->path, info->payload_level);
}

static svo_status find_params(svo_paged *paged)
{
    const svo_tree_info *info = &paged->file.info;
    const svo_grid grid = {.depth = info->depth,
                           .snap_bits = info->snap_bits,
                           .origin = {info->origin[0], info->origin[1], info->origin[2]},
                           .scale = info->scale};
    return svo_i_rays_params(paged->device, "svo_paged_open", &grid, info->edge, &paged->params);
}

/* Reads the file, which is open, and makes everything. */
static svo_status fill(svo_paged *paged, const svo_paged_options *asked, uint64_t budget_bytes)
{
    paged_top top = {{NULL}};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_tree_file_read_head(&paged->file));
    SVO_I_TRY(check_file(paged));
    SVO_I_TRY(find_params(paged));
    svo_i_paged_choose(paged, asked->page_levels, budget_bytes);
    SVO_I_TRY_CLEANUP(svo_i_paged_scan(paged, &top));
    SVO_I_TRY_CLEANUP(svo_i_paged_fit(paged, budget_bytes));
    SVO_I_TRY_CLEANUP(svo_i_paged_make_pool(paged, &top));

cleanup:
    for (int i = 0; i < PAGED_ARRAYS; ++i) {
        svo_i_free(top.arrays[i]);
    }
    return status;
}

static svo_paged *make(svo_device *device, const char *path, const svo_i_memory *memory)
{
    svo_paged *paged = svo_i_alloc_zeroed(memory, 1, sizeof *paged);
    if (paged == NULL) {
        return NULL;
    }
    paged->device = device;
    paged->memory = *memory;
    paged->path = svo_i_copy_text(memory, path);
    if (paged->path == NULL) {
        svo_i_free(paged);
        return NULL;
    }
    paged->load = (svo_i_file_load){
        .name = paged->path, .message = svo_i_device_message(device), .host_memory = *memory, .file = -1};
    paged->file.load = &paged->load;
    return paged;
}

svo_status svo_paged_open(svo_device *device, const char *path, uint64_t budget_bytes, const svo_paged_options *options,
                          svo_paged **out)
{
    svo_paged_options asked;
    svo_i_memory memory = {NULL, NULL, NULL};
    svo_paged *paged = NULL;
    svo_status status = SVO_OK;
    if (device == NULL || path == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_paged_open: %s is NULL",
                                 device == NULL ? "device"
                                 : path == NULL ? "path"
                                                : "out");
    }
    SVO_I_TRY(read_options(device, options, &asked, &memory));
    paged = make(device, path, &memory);
    if (paged == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_paged_open: no memory for %s", path);
    }
    paged->update_bytes = asked.update_bytes;
    SVO_I_TRY_CLEANUP(svo_i_file_load_open(&paged->load));
    SVO_I_TRY_CLEANUP(fill(paged, &asked, budget_bytes));
    *out = paged;
    paged = NULL;

cleanup:
    svo_paged_close(&paged);
    return status;
}

void svo_paged_close(svo_paged **paged)
{
    if (paged == NULL || *paged == NULL) {
        return;
    }
    svo_paged *closed = *paged;
    svo_i_paged_release_pool(closed);
    for (uint32_t i = 0; i < closed->layout.band_count; ++i) {
        for (uint32_t k = 1; k <= closed->layout.page_levels; ++k) {
            svo_i_free(closed->bands[i].first[k]);
        }
    }
    svo_i_free(closed->pages);
    if (closed->load.file >= 0) {
        svo_i_file_load_close(&closed->load);
    }
    svo_i_free(closed->path);
    svo_i_free(closed);
    *paged = NULL;
}

svo_status svo_paged_get_info(const svo_paged *paged, svo_paged_info *info)
{
    if (paged == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const paged_layout *layout = &paged->layout;
    const uint32_t shown = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL;
    const svo_paged_info held = {.depth = paged->file.info.depth,
                                 .top_level = layout->top_level,
                                 .page_levels = layout->page_levels,
                                 .need = paged->file.info.need & shown,
                                 .page_count = layout->page_count,
                                 .file_bytes = paged->load.file_bytes,
                                 .device_bytes = layout->device_bytes,
                                 .least_bytes = layout->least_bytes,
                                 .whole_bytes = layout->whole_bytes,
                                 .open_read_bytes = paged->open_read_bytes};
    return svo_i_struct_write(svo_i_device_message(paged->device), "svo_paged_get_info", "info", &held, info,
                              SVO_I_STRUCT_SIZES(svo_paged_info, open_read_bytes));
}

svo_status svo_paged_get_counts(const svo_paged *paged, svo_paged_counts *counts)
{
    if (paged == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    return svo_i_struct_write(svo_i_device_message(paged->device), "svo_paged_get_counts", "counts", &paged->counts,
                              counts, SVO_I_STRUCT_SIZES(svo_paged_counts, all_evicted_pages));
}
