/* SPDX-License-Identifier: MIT */
/*
 * Finds the tiles of columns that the projection of a large triangle can meet, so that many work-items share one
 * triangle. The kernel (kernels/stages/voxelize.cl) computes the same bounds for every triangle and skips those that
 * have more columns than a tile. Tiles are sorted by columns within blocks, as items are (grid.c).
 */
#include "plan/tiles.h"

#include <math.h>

/* A triangle's projection along its axis. */
typedef struct projection {
    double u[3], v[3]; /* corners, in voxels */
    int32_t first_u, first_v, end_u, end_v; /* its columns inside the draw */
} projection;

/* First and last voxel on an axis, as in the kernel. */
static void voxel_bounds(const svo_plan *plan, const int32_t *corners, unsigned axis, int32_t *first, int32_t *last)
{
    const int32_t limit = (int32_t)(1u << plan->info.depth) - 1;
    int32_t low = corners[axis];
    int32_t high = low;
    for (unsigned corner = 1; corner < 3; ++corner) {
        const int32_t q = corners[corner * 3 + axis];
        low = q < low ? q : low;
        high = q > high ? q : high;
    }
    low = (low - (plan->info.coverage == SVO_COVERAGE_CLOSED ? 1 : 0)) >> plan->voxel_log2;
    high >>= plan->voxel_log2;
    *first = low < 0 ? 0 : low > limit ? limit : low;
    *last = high < 0 ? 0 : high > limit ? limit : high;
}

static projection project(const svo_plan *plan, const svo_i_draw *draw, const svo_large_item *large)
{
    const unsigned axis_u = (large->axis + 1) % 3;
    const unsigned axis_v = (large->axis + 2) % 3;
    const double voxel = (double)(1u << plan->voxel_log2);
    projection p;
    for (unsigned corner = 0; corner < 3; ++corner) {
        p.u[corner] = large->corners[corner * 3 + axis_u] / voxel;
        p.v[corner] = large->corners[corner * 3 + axis_v] / voxel;
    }
    int32_t last_u;
    int32_t last_v;
    voxel_bounds(plan, large->corners, axis_u, &p.first_u, &last_u);
    voxel_bounds(plan, large->corners, axis_v, &p.first_v, &last_v);
    const int32_t left = (int32_t)draw->tile_x;
    const int32_t bottom = (int32_t)draw->tile_y;
    const int32_t right = left + (int32_t)draw->tile_width;
    const int32_t top = bottom + (int32_t)draw->tile_height;
    p.first_u = p.first_u > left ? p.first_u : left;
    p.first_v = p.first_v > bottom ? p.first_v : bottom;
    p.end_u = last_u + 1 < right ? last_u + 1 : right;
    p.end_v = last_v + 1 < top ? last_v + 1 : top;
    return p;
}

static bool is_large(const projection *p)
{
    const int64_t width = p->end_u - p->first_u;
    const int64_t height = p->end_v - p->first_v;
    const int32_t most = SVO_TILE_COLUMNS;
    return width > 0 && height > 0 && width * height > most;
}

/* The range of u of the projection between two values of v; low is above high if the projection is not there. */
static void band_reach(const projection *p, double from, double to, double *low, double *high)
{
    *low = INFINITY;
    *high = -INFINITY;
    for (unsigned corner = 0; corner < 3; ++corner) {
        const unsigned next = (corner + 1) % 3;
        const double rise = p->v[next] - p->v[corner];
        if (rise == 0.0 && (p->v[corner] < from || p->v[corner] > to)) {
            continue;
        }
        /* Where the edge enters and leaves the band, as fractions of its length. */
        const double at_from = rise != 0.0 ? (from - p->v[corner]) / rise : 0.0;
        const double at_to = rise != 0.0 ? (to - p->v[corner]) / rise : 1.0;
        double enter = fmin(at_from, at_to);
        double leave = fmax(at_from, at_to);
        enter = enter > 0.0 ? enter : 0.0;
        leave = leave < 1.0 ? leave : 1.0;
        if (enter <= leave) {
            const double at_enter = p->u[corner] + enter * (p->u[next] - p->u[corner]);
            const double at_leave = p->u[corner] + leave * (p->u[next] - p->u[corner]);
            *low = fmin(*low, fmin(at_enter, at_leave));
            *high = fmax(*high, fmax(at_enter, at_leave));
        }
    }
}

/* The tiles that are not sorted yet, and the columns of each. */
typedef struct block {
    svo_i_tiles *tiles; /* that get them */
    svo_tile_item items[SVO_SCAN_TILE];
    uint8_t columns[SVO_SCAN_TILE];
    uint32_t count;
} block;

static bool reserve(svo_i_tiles *tiles, size_t count)
{
    const size_t capacity = tiles->count + count;
    if (capacity > tiles->capacity) {
        const size_t room = capacity + tiles->capacity;
        svo_tile_item *grown = svo_i_grow(tiles->memory, tiles->items, room * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        tiles->items = grown;
        tiles->capacity = room;
    }
    return true;
}

/* Adds the tiles of a block by their columns, with a stable counting sort, and empties it. */
static bool sort_block(block *from)
{
    svo_i_tiles *tiles = from->tiles;
    uint32_t slots[SVO_TILE_COLUMNS + 2] = {0};
    if (!reserve(tiles, from->count)) {
        return false;
    }
    for (uint32_t i = 0; i < from->count; ++i) {
        ++slots[from->columns[i] + 1];
    }
    for (unsigned size = 0; size <= SVO_TILE_COLUMNS; ++size) {
        slots[size + 1] += slots[size];
    }
    for (uint32_t i = 0; i < from->count; ++i) {
        tiles->items[tiles->count + slots[from->columns[i]]++] = from->items[i];
    }
    tiles->count += from->count;
    from->count = 0;
    return true;
}

/* Adds the tile of the projection at (u, v). */
static bool add_tile(block *to, const projection *p, uint32_t item, int32_t u, int32_t v)
{
    const int32_t width = p->end_u - u < SVO_TILE_EDGE ? p->end_u - u : SVO_TILE_EDGE;
    const int32_t height = p->end_v - v < SVO_TILE_EDGE ? p->end_v - v : SVO_TILE_EDGE;
    to->columns[to->count] = (uint8_t)(width * height);
    to->items[to->count++] = (svo_tile_item){item, (uint32_t)u | (uint32_t)v << 16};
    return to->count < SVO_SCAN_TILE || sort_block(to);
}

/* Adds the tiles of one row that the projection can meet. A margin of one voxel on every side covers the rounding of
   doubles and closed voxels' far faces. */
static bool add_row(block *to, const projection *p, uint32_t item, int32_t v)
{
    double low;
    double high;
    band_reach(p, v - 1.0, v + SVO_TILE_EDGE + 1.0, &low, &high);
    if (low > high) {
        return true;
    }
    const int32_t last_tile = (p->end_u - 1 - p->first_u) / SVO_TILE_EDGE;
    const double first = fmax(floor((low - 1.0 - p->first_u) / SVO_TILE_EDGE), 0.0);
    const double last = fmin(floor((high + 1.0 - p->first_u) / SVO_TILE_EDGE), last_tile);
    for (int32_t k = (int32_t)first; k <= (int32_t)last && last >= 0.0; ++k) {
        if (!add_tile(to, p, item, p->first_u + k * SVO_TILE_EDGE, v)) {
            return false;
        }
    }
    return true;
}

/* The index of the first large triangle from an item on. */
static uint32_t first_large(const svo_plan *plan, uint32_t item)
{
    uint32_t first = 0;
    uint32_t end = plan->large_count;
    while (first < end) {
        const uint32_t middle = first + (end - first) / 2;
        if (plan->large[middle].item < item) {
            first = middle + 1;
        } else {
            end = middle;
        }
    }
    return first;
}

bool svo_i_tiles_of_draw(const svo_plan *plan, const svo_i_draw *draw, svo_i_tiles *tiles)
{
    const uint32_t end = first_large(plan, draw->first_item + draw->item_count);
    block unsorted;
    unsorted.tiles = tiles;
    unsorted.count = 0;
    tiles->memory = &plan->device->memory;
    for (uint32_t i = first_large(plan, draw->first_item); i < end; ++i) {
        const projection p = project(plan, draw, &plan->large[i]);
        for (int32_t v = p.first_v; v < p.end_v && is_large(&p); v += SVO_TILE_EDGE) {
            if (!add_row(&unsorted, &p, plan->large[i].item, v)) {
                return false;
            }
        }
    }
    return sort_block(&unsorted);
}

double svo_i_tiles_expected(const svo_plan *plan, const svo_i_draw *draw)
{
    const uint32_t end = first_large(plan, draw->first_item + draw->item_count);
    double tiles = 0.0;
    for (uint32_t i = first_large(plan, draw->first_item); i < end; ++i) {
        const double fragments = (double)plan->large[i].fragments;
        tiles += fragments > SVO_TILE_COLUMNS ? fragments * 4.0 / SVO_TILE_COLUMNS : 0.0;
    }
    return tiles;
}

void svo_i_tiles_free(svo_i_tiles *tiles)
{
    svo_i_free(tiles->items);
    *tiles = (svo_i_tiles){0};
}
