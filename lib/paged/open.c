/* SPDX-License-Identifier: MIT */
/*
 * Paged trees from the opening of the file to its closing: options, how many bytes go to what, reading, making; and
 * pictures of what is there, with the pages that they used and missed. Bands are counted from the leaves up, so the top
 * level is above the leaves by a multiple of the levels of a page.
 */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <string.h>
#include <sys/stat.h>

#include "core/struct_size.h"
#include "paged/paged.h"
#include "rays/picture.h"
#include "rays/rays.h"
#include "shared/page.h"
#include "svocl/paged.h"

/* ---- the layout: the top level and the room for pages ---- */

/* The share of the bytes that the top levels may take, unless there are no fewer of them. */
#define TOP_SHARE 4u

/* Of an inner node beside its payload: mask and link. */
#define INNER_BYTES 5u

static uint64_t node_bytes(const paged_layout *layout, uint64_t inner_count, uint64_t leaf_count)
{
    return inner_count * (INNER_BYTES + layout->payload_bytes) + leaf_count * layout->payload_bytes;
}

static uint64_t count_nodes(const svo_tree_info *info, uint32_t level)
{
    return info->level_begin[level + 1] - info->level_begin[level];
}

/* Sets what follows from the top level. */
static void set_top(const svo_tree_info *info, uint32_t top_level, paged_layout *layout)
{
    const bool is_whole = top_level == info->depth;
    layout->top_level = top_level;
    layout->band_count = 0;
    layout->page_count = 0;
    layout->top_inner_count = info->level_begin[is_whole ? info->depth : top_level + 1];
    layout->inner_count = info->level_begin[info->depth] - layout->top_inner_count;
    layout->leaf_count = is_whole ? 0 : info->leaf_count;
    for (uint32_t level = top_level; level < info->depth; level += layout->page_levels) {
        ++layout->band_count;
        layout->page_count += (uint32_t)count_nodes(info, level);
    }
}

/* Bytes of what is always there: top levels, the table of pages, payload that all nodes share. */
static uint64_t fixed_bytes(const svo_tree_info *info, const paged_layout *layout)
{
    uint64_t bytes = (uint64_t)layout->page_count * SVO_PAGE_WORDS * sizeof(uint32_t) +
                     node_bytes(layout, layout->top_inner_count, info->leaf_count - layout->leaf_count);
    for (int i = 0; i < PAGED_ARRAYS; ++i) {
        bytes += svo_i_tree_is_constant(info, svo_i_paged_buffer((paged_array)i))
                     ? svo_i_paged_element_bytes((paged_array)i)
                     : 0;
    }
    return bytes;
}

/* No page has more bytes than one with every child. */
static uint64_t full_page_bytes(const paged_layout *layout)
{
    uint64_t count = 0;
    for (uint32_t level = 1; level <= layout->page_levels; ++level) {
        count = 8 * count + 8;
    }
    return node_bytes(layout, count, 0);
}

static void choose_top(svo_paged *paged, uint32_t page_levels, uint64_t budget_bytes)
{
    const svo_tree_info *info = &paged->file.info;
    paged_layout *layout = &paged->layout;
    layout->page_levels = page_levels;
    layout->payload_bytes = 0;
    for (int i = 0; i < PAGED_ARRAYS; ++i) {
        const svo_tree_buffer buffer = svo_i_paged_buffer((paged_array)i);
        layout->by_node[i] = svo_i_tree_holds(info, buffer) && !svo_i_tree_is_constant(info, buffer);
        layout->payload_bytes +=
            layout->by_node[i] && i != PAGED_MASKS ? (uint32_t)svo_i_paged_element_bytes((paged_array)i) : 0;
    }
    for (uint32_t level = info->depth;; level -= page_levels) {
        set_top(info, level, layout);
        const uint64_t fixed = fixed_bytes(info, layout);
        const bool fits = fixed <= budget_bytes / TOP_SHARE && full_page_bytes(layout) <= budget_bytes - fixed;
        if (level <= page_levels || (level == info->depth && fixed <= budget_bytes / TOP_SHARE) || fits) {
            break;
        }
    }
}

/* count * part / whole, rounded down or one less, without overflow. part is at most whole. */
static uint64_t take_share(uint64_t count, uint64_t part, uint64_t whole)
{
    if (part == whole) {
        return count;
    }
    while (whole >= (uint64_t)1 << 31) {
        whole = (whole >> 1) + 1;
        part >>= 1;
    }
    return count * part / whole;
}

/* Elements for inner nodes and leaves beyond those of the largest page, within a number of bytes. Bands are read from
   the top down, so inner nodes of all but the last come first, with half of the bytes at most; what is left is shared
   as the last band's nodes are. */
static void share_room(const svo_paged *paged, uint64_t bytes, uint64_t *inner, uint64_t *leaves)
{
    const paged_layout *layout = &paged->layout;
    const svo_tree_info *info = &paged->file.info;
    const uint64_t more_inner = layout->inner_count - paged->largest_inner;
    const uint64_t more_leaves = layout->leaf_count - paged->largest_leaves;
    const uint32_t last_root_level = info->depth - layout->page_levels;
    const uint64_t above = info->level_begin[last_root_level + 1] - layout->top_inner_count;
    const uint64_t afforded = bytes / 2 / node_bytes(layout, 1, 0);
    uint64_t first = above < afforded ? above : afforded;
    first = first < more_inner ? first : more_inner;
    const uint64_t rest = node_bytes(layout, more_inner - first, more_leaves);
    const uint64_t left = bytes - node_bytes(layout, first, 0);
    const uint64_t part = left < rest ? left : rest;
    *inner = first + take_share(more_inner - first, part, rest);
    *leaves = take_share(more_leaves, part, rest);
}

static svo_status fit(svo_paged *paged, uint64_t budget_bytes)
{
    const svo_tree_info *info = &paged->file.info;
    paged_layout *layout = &paged->layout;
    const uint64_t fixed = fixed_bytes(info, layout);
    const uint64_t top_leaves = info->leaf_count - layout->leaf_count;
    uint64_t inner = 0, leaves = 0;
    layout->least_bytes = fixed + node_bytes(layout, paged->largest_inner, paged->largest_leaves);
    layout->whole_bytes = fixed + node_bytes(layout, layout->inner_count, layout->leaf_count);
    if (budget_bytes < layout->least_bytes) {
        return svo_i_device_fail(paged->device, SVO_CAPACITY_EXCEEDED,
                                 "svo_paged_open: budget_bytes %" PRIu64 " is below %" PRIu64 ", the least for %s",
                                 budget_bytes, layout->least_bytes, paged->path);
    }
    if (layout->page_count > 0) {
        share_room(paged, budget_bytes - layout->least_bytes, &inner, &leaves);
    }
    inner += layout->top_inner_count + paged->largest_inner;
    leaves += top_leaves + paged->largest_leaves;
    if (inner + leaves >= SVO_PAGE_ROOT) {
        return svo_i_device_fail(paged->device, SVO_UNSUPPORTED,
                                 "svo_paged_open: budget_bytes %" PRIu64 " is room for %" PRIu64
                                 " nodes, and there may be %u",
                                 budget_bytes, inner + leaves, SVO_PAGE_ROOT - 1);
    }
    layout->inner_capacity = (uint32_t)inner;
    layout->leaf_capacity = (uint32_t)leaves;
    layout->device_bytes = fixed + node_bytes(layout, inner - layout->top_inner_count, leaves - top_leaves);
    return SVO_OK;
}

/* ---- opening ---- */

static svo_status read_options(svo_device *device, const svo_paged_options *given, svo_paged_options *asked,
                               svo_i_memory *memory)
{
    static const char function[] = "svo_paged_open";
    svo_message *message = svo_i_device_message(device);
    SVO_I_TRY(
        svo_i_struct_read(message, function, "options", given, asked, SVO_I_STRUCT_SIZES(svo_paged_options, region)));
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
                           .scale = info->scale,
                           .edge = info->edge};
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
    choose_top(paged, asked->page_levels, budget_bytes);
    SVO_I_TRY_CLEANUP(svo_i_paged_scan(paged, &top));
    SVO_I_TRY_CLEANUP(fit(paged, budget_bytes));
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
    paged->load = (svo_i_file_load){.source = {.file = -1}, .host_memory = *memory};
    paged->file.load = &paged->load;
    return paged;
}

/* Whether a path is that of a folder of parts, or of its plan. */
static bool is_folder(const char *path)
{
    struct stat found;
    const char *slash = strrchr(path, '/');
    return stat(path, &found) == 0 && (S_ISDIR(found.st_mode) || strcmp(slash != NULL ? slash + 1 : path, "plan") == 0);
}

/* Opens a region of a folder of parts in place of a file. */
static svo_status open_parts(svo_paged *paged, const svo_parts_region *given)
{
    static const char function[] = "svo_paged_open";
    svo_message *message = svo_i_device_message(paged->device);
    svo_parts_region region = SVO_PARTS_REGION_INIT;
    SVO_I_TRY(svo_i_parts_tree_open(function, paged->path, &paged->parts, message));
    SVO_I_TRY(svo_i_struct_read(message, function, "options.region", given, &region,
                                SVO_I_STRUCT_SIZES(svo_parts_region, voxels_max)));
    if (region.level == 0 && region.last_level == 0) {
        region.last_level = svo_i_parts_tree_last_level(paged->parts);
    }
    paged->view = svo_i_alloc(&paged->memory, sizeof *paged->view);
    if (paged->view == NULL) {
        return svo_i_device_fail(paged->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %s", function, paged->path);
    }
    SVO_I_TRY(svo_i_parts_view_open(function, paged->parts, &region, paged->view));
    paged->load.source = svo_i_parts_view_source(paged->view);
    return SVO_OK;
}

static svo_status open_source(svo_paged *paged, const svo_paged_options *asked)
{
    static const char function[] = "svo_paged_open";
    if (is_folder(paged->path)) {
        return open_parts(paged, asked->region);
    }
    return asked->region == NULL ? svo_i_source_open(function, svo_from_path(paged->path),
                                                     svo_i_device_message(paged->device), &paged->load.source)
                                 : svo_i_device_fail(paged->device, SVO_INVALID_ARGUMENT,
                                                     "%s: options.region is not NULL, and %s is no folder of parts",
                                                     function, paged->path);
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
    SVO_I_TRY_CLEANUP(open_source(paged, &asked));
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
    svo_i_source_close(&closed->load.source);
    svo_i_free(closed->view);
    svo_parts_tree_close(&closed->parts);
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
                                 .file_bytes = paged->load.source.byte_count,
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

/* ---- pictures ---- */

/* Those of SVO_TREE_PARAMETERS: the nodes' three and the grid. */
#define VIEW_ARGUMENTS 4u

static svo_status check_target(void *of, const char *function)
{
    (void)of;
    (void)function;
    return SVO_OK;
}

static svo_status set_target(void *of, const char *function, cl_kernel kernel, cl_uint first_index)
{
    const svo_paged *paged = of;
    const svo_i_argument arguments[VIEW_ARGUMENTS] = {SVO_I_ARGUMENT(paged->arrays[PAGED_MASKS]),
                                                      SVO_I_ARGUMENT(paged->links), SVO_I_ARGUMENT(paged->device_table),
                                                      SVO_I_ARGUMENT(paged->params)};
    return svo_i_kernel_set_from(paged->device, function, kernel, first_index, arguments, VIEW_ARGUMENTS);
}

static svo_i_picture_source describe(svo_paged *paged, const char *function)
{
    const svo_tree_info *info = &paged->file.info;
    return (svo_i_picture_source){.device = paged->device,
                                  .function = function,
                                  .grid = {.depth = info->depth,
                                           .snap_bits = info->snap_bits,
                                           .origin = {info->origin[0], info->origin[1], info->origin[2]},
                                           .scale = info->scale},
                                  .form_defines = " -DSVO_READ_PAGED",
                                  .nodes = {paged->arrays[PAGED_MASKS], paged->links, paged->device_table},
                                  .node_arguments = 3,
                                  .tree = {paged, VIEW_ARGUMENTS, check_target, set_target},
                                  .colors = paged->arrays[PAGED_COLORS],
                                  .normals = paged->arrays[PAGED_NORMALS],
                                  .one_color = !paged->layout.by_node[PAGED_COLORS],
                                  .one_normal = !paged->layout.by_node[PAGED_NORMALS]};
}

/* Before a picture no page is marked. */
static void clear_marks(svo_paged *paged)
{
    for (uint32_t page = 0; page < paged->layout.page_count; ++page) {
        paged->table[SVO_PAGE_WORDS * (size_t)page + SVO_PAGE_MARK] = 0;
    }
    paged->counts.used_pages = paged->counts.missed_pages = 0;
}

/* After it, the marks of pages that are there say when they were used, and are taken away; the others were missed. */
static void count_marks(svo_paged *paged)
{
    svo_paged_counts *counts = &paged->counts;
    ++counts->pictures;
    for (uint32_t page = 0; page < paged->layout.page_count; ++page) {
        uint32_t *words = &paged->table[SVO_PAGE_WORDS * (size_t)page];
        if (words[SVO_PAGE_MARK] == 0) {
            continue;
        }
        if (words[SVO_PAGE_BEGIN] == SVO_PAGE_ABSENT) {
            ++counts->missed_pages;
        } else {
            ++counts->used_pages;
            paged->pages[page].used = (uint32_t)counts->pictures;
            words[SVO_PAGE_MARK] = 0;
        }
    }
    counts->all_missed_pages += counts->missed_pages;
}

svo_status svo_paged_render(svo_paged *paged, const svo_render_options *options, uint8_t *rgba)
{
    static const char function[] = "svo_paged_render";
    static const svo_i_picture_kind kind = {
        .name = "paged tree", .views = SVO_I_VOXEL_VIEWS, .view_names = SVO_I_VOXEL_VIEW_NAMES};
    const svo_array pixels = svo_in_host(rgba);
    svo_render_options asked;
    if (paged == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (rgba == NULL) {
        return svo_i_device_fail(paged->device, SVO_INVALID_ARGUMENT, "%s: rgba is NULL", function);
    }
    SVO_I_TRY(svo_i_picture_options(paged->device, function, &kind, options, &asked));
    const svo_i_picture_source source = describe(paged, function);
    clear_marks(paged);
    SVO_I_TRY(svo_i_paged_write_table(paged));
    SVO_I_TRY(svo_i_picture_draw(&source, &asked, &pixels, NULL));
    const svo_status status = svo_i_paged_read_table(paged);
    if (status != SVO_OK) {
        clear_marks(paged); /* a read that fails may have brought some */
        return status;
    }
    count_marks(paged);
    return SVO_OK;
}
