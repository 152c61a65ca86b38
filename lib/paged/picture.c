/* SPDX-License-Identifier: MIT */
/* Pictures of what is there, and which pages they used and missed. */
#include "rays/picture.h"
#include "paged/pool.h"
#include "shared/page.h"

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

static svo_status check_picture(const svo_paged *paged, const char *function, const svo_render_options *options,
                                const uint8_t *rgba, svo_render_options *asked)
{
    if (options == NULL || rgba == NULL) {
        return svo_i_device_fail(paged->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 options == NULL ? "options" : "rgba");
    }
    SVO_I_TRY(svo_i_picture_options(paged->device, function, options, asked));
    return asked->view != SVO_VIEW_TRIANGLES ? SVO_OK
                                             : svo_i_device_fail(paged->device, SVO_INVALID_ARGUMENT,
                                                                 "%s: a paged tree has no triangles to show", function);
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
    svo_render_options asked;
    if (paged == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(check_picture(paged, function, options, rgba, &asked));
    const svo_i_picture_source source = describe(paged, function);
    clear_marks(paged);
    SVO_I_TRY(svo_i_paged_write_table(paged));
    SVO_I_TRY(svo_i_picture_draw(&source, &asked, NULL, rgba));
    const svo_status status = svo_i_paged_read_table(paged);
    if (status != SVO_OK) {
        clear_marks(paged); /* a read that fails may have brought some */
        return status;
    }
    count_marks(paged);
    return SVO_OK;
}
