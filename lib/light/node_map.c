/* SPDX-License-Identifier: MIT */
#include "light/node_map.h"

#include "light/light_view.h"

/* The deepest node that holds both. */
static svo_i_map_cell find_ancestor(svo_i_map_cell a, svo_i_map_cell b)
{
    if (a.level == SVO_I_MAP_EMPTY || b.level == SVO_I_MAP_EMPTY) {
        return a.level == SVO_I_MAP_EMPTY ? b : a;
    }
    for (; a.level > b.level; --a.level) {
        a.code >>= 3;
    }
    for (; b.level > a.level; --b.level) {
        b.code >>= 3;
    }
    for (; a.code != b.code; --a.level) {
        a.code >>= 3;
        b.code >>= 3;
    }
    return a;
}

/* Levels above the leaves that a cell's first item filters, and that of the cell above does not. */
static uint64_t own_levels(svo_i_map_cell cell, const svo_i_map_cell *above, uint32_t depth)
{
    if (cell.level == SVO_I_MAP_EMPTY) {
        return 0;
    }
    const uint32_t end = cell.level < depth ? cell.level + 1 : depth;
    const uint32_t begin = above != NULL ? above->level + 1 : 0;
    return end > begin ? end - begin : 0;
}

/* The cell above 2 x 2 cells; *items grows by those that end there. */
static svo_i_map_cell join(const svo_i_map_cell *cells, const uint32_t size[2], const uint32_t place[2], uint32_t depth,
                           uint64_t *items)
{
    svo_i_map_cell quad[4];
    svo_i_map_cell above = {.level = SVO_I_MAP_EMPTY};
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t x = 2 * place[0] + k % 2;
        const uint32_t y = 2 * place[1] + k / 2;
        quad[k] =
            x < size[0] && y < size[1] ? cells[(size_t)y * size[0] + x] : (svo_i_map_cell){.level = SVO_I_MAP_EMPTY};
        above = find_ancestor(above, quad[k]);
    }
    for (uint32_t k = 0; k < 4; ++k) {
        *items += own_levels(quad[k], &above, depth);
    }
    return above;
}

uint64_t svo_i_node_map_items(svo_i_map_cell *cells, uint32_t columns, uint32_t rows, uint32_t depth)
{
    uint32_t size[2] = {columns, rows};
    uint64_t items = 0;
    while (size[0] > 1 || size[1] > 1) {
        const uint32_t half[2] = {(size[0] + 1) / 2, (size[1] + 1) / 2};
        for (uint32_t i = 0; i < half[0] * half[1]; ++i) {
            /* In place: a cell lies before those that are still to be joined. */
            cells[i] = join(cells, size, (const uint32_t[]){i % half[0], i / half[0]}, depth, &items);
        }
        size[0] = half[0];
        size[1] = half[1];
    }
    return items + own_levels(cells[0], NULL, depth);
}

/* ---- views ---- */

/* Memory, with a message when there is none. */
static svo_status take_memory(const svo_i_device_work *work, size_t count, size_t element_bytes, void **out)
{
    *out = svo_i_alloc_zeroed(&work->device->memory, count, element_bytes);
    return *out != NULL ? SVO_OK
                        : svo_i_device_fail(work->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a node map",
                                            work->function);
}

svo_status svo_i_node_map_begin(svo_i_node_map *map, svo_i_device_work *work, const svo_light_view_params *view)
{
    void *cells = NULL;
    SVO_I_TRY(take_memory(work, (size_t)view->columns * view->rows, sizeof *map->cells, &cells));
    map->cells = cells;
    return SVO_OK;
}

/* Takes the leaves of a launch's photons. */
static void place_leaves(svo_i_node_map *map, const svo_light_view_params *view, const uint32_t *leaves)
{
    for (uint32_t i = 0; i < view->count; ++i) {
        uint32_t column = 0;
        uint32_t row = 0;
        if (svo_i_photon_pixel(view, view->first + i, &column, &row)) {
            const bool met = leaves[i] < SVO_PHOTON_LOST;
            map->cells[(size_t)row * view->columns + column] =
                met ? (svo_i_map_cell){.code = map->leaf_codes[leaves[i]], .level = map->depth}
                    : (svo_i_map_cell){.level = SVO_I_MAP_EMPTY};
        }
    }
}

svo_status svo_i_node_map_take(svo_i_node_map *map, svo_i_device_work *work, cl_mem leaves,
                               const svo_light_view_params *view)
{
    void *found = NULL;
    SVO_I_TRY(take_memory(work, view->count, sizeof(uint32_t), &found));
    const svo_status status = svo_i_work_read(work, leaves, 0, found, view->count * sizeof(uint32_t));
    if (status == SVO_OK) {
        place_leaves(map, view, found);
    }
    svo_i_free(found);
    return status;
}

void svo_i_node_map_end(svo_i_node_map *map, const svo_light_view_params *view)
{
    if (map->cells != NULL) {
        map->items += svo_i_node_map_items(map->cells, view->columns, view->rows, map->depth);
    }
    svo_i_free(map->cells);
    map->cells = NULL;
}
