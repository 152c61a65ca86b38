/* SPDX-License-Identifier: MIT */
/*
 * Assigns triangles to chunks of the fragment list, and tiles of triangles that are too large for a chunk. A chunk is
 * no larger than a storage block and an allocation may be. Cuts large triangles into tiles of columns for the front end
 * "cl". Finds the triangles that the front end "gl-hybrid" rasterizes. No result depends on either cut.
 */
#include "plan/chunking.h"

#include <math.h>
#include <string.h>

#include "plan/arrays.h"
#include "plan/estimate.h"

/* ---- chunks ---- */

/* Tiles are halved down to one pixel. A column has at most four fragments per triangle, so such a tile always fits. */
#define TILE_PIXELS_MIN 1u
/* Most tiles along an axis that a triangle is cut into at first. Tiles that are too large are split later. */
#define TILES_MAX 1024u

static svo_status no_memory(const svo_plan *plan)
{
    return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory to cut the fragment list");
}

uint64_t svo_i_chunk_bytes_max(const svo_plan *plan, uint64_t frontend_bytes)
{
    const uint64_t allocation = plan->device->max_allocation_bytes;
    const uint64_t most = frontend_bytes < allocation ? frontend_bytes : allocation;
    const uint64_t requested = plan->options.chunk_bytes;
    return requested != 0 && requested < most ? requested : most;
}

/* The fragments of a chunk of that size, as far as kernels can count them. */
static uint64_t fragments_within(const svo_plan *plan, uint64_t chunk_bytes)
{
    const uint64_t fragments = chunk_bytes / svo_i_plan_fragment_bytes(plan);
    return fragments < SVO_I_FRAGMENTS_MAX ? fragments : SVO_I_FRAGMENTS_MAX;
}

void svo_i_chunking_destroy(svo_i_chunking *chunking)
{
    svo_i_free(chunking->draws);
    svo_i_free(chunking->chunks);
    memset(chunking, 0, sizeof *chunking);
}

static bool add_draw(svo_i_chunking *chunking, svo_i_draw draw)
{
    if (chunking->draw_count == chunking->draw_capacity) {
        const uint32_t capacity = chunking->draw_capacity * 2 + 16;
        svo_i_draw *draws = capacity > chunking->draw_capacity
                                ? svo_i_grow(chunking->memory, chunking->draws, capacity * sizeof *draws)
                                : NULL;
        if (draws == NULL) {
            return false;
        }
        chunking->draws = draws;
        chunking->draw_capacity = capacity;
    }
    chunking->draws[chunking->draw_count++] = draw;
    return true;
}

/* Closes the chunk that began at first_draw. */
static bool add_chunk(svo_i_chunking *chunking, uint32_t first_draw, uint64_t capacity)
{
    if (chunking->chunk_count == chunking->chunk_capacity) {
        const uint32_t grown = chunking->chunk_capacity * 2 + 16;
        svo_i_chunk *chunks = grown > chunking->chunk_capacity
                                  ? svo_i_grow(chunking->memory, chunking->chunks, grown * sizeof *chunks)
                                  : NULL;
        if (chunks == NULL) {
            return false;
        }
        chunking->chunks = chunks;
        chunking->chunk_capacity = grown;
    }
    chunking->chunks[chunking->chunk_count++] = (svo_i_chunk){first_draw, chunking->draw_count - first_draw, capacity};
    return true;
}

/* Draws a run of items over the whole grid, viewport by viewport. */
static bool add_items(const svo_plan *plan, svo_i_chunking *chunking, svo_i_class class_id, uint32_t first_item,
                      uint32_t item_count)
{
    const uint32_t depth = plan->info.depth;
    const uint32_t views_log2 = depth > SVO_I_VIEW_LOG2 ? depth - SVO_I_VIEW_LOG2 : 0;
    const uint32_t edge = 1u << (depth - views_log2);
    for (uint32_t k = 0; k < 1u << (2 * views_log2); ++k) {
        const uint32_t x = (k & ((1u << views_log2) - 1u)) * edge;
        const uint32_t y = (k >> views_log2) * edge;
        if (!add_draw(chunking, (svo_i_draw){class_id, first_item, item_count, x, y, edge, edge})) {
            return false;
        }
    }
    return true;
}

/* State of the cut: the chunk that is being filled. */
typedef struct cutter {
    const svo_plan *plan;
    svo_i_chunking *chunking;
    double room; /* expected fragments a chunk should hold */
    const float *expected; /* fragments of each item; NULL where all items fit one chunk */
    double held; /* expected fragments of the current chunk */
    uint32_t first_draw;
    uint64_t limit; /* fragments a chunk can hold */
} cutter;

static bool close_chunk(cutter *c)
{
    if (c->chunking->draw_count == c->first_draw) {
        return true;
    }
    uint64_t capacity = svo_i_with_slack(c->held);
    capacity = capacity < c->limit ? capacity : c->limit;
    const bool added = add_chunk(c->chunking, c->first_draw, capacity);
    c->first_draw = c->chunking->draw_count;
    c->held = 0.0;
    return added;
}

/* Cuts a triangle that is too large for a chunk into tiles, each with a chunk of its own. */
static bool cut_triangle(cutter *c, svo_i_class class_id, uint32_t item)
{
    const uint32_t pixels = 1u << c->plan->info.depth;
    uint32_t tiles = c->plan->info.depth > SVO_I_VIEW_LOG2 ? pixels >> SVO_I_VIEW_LOG2 : 2;
    while (tiles < pixels && tiles < TILES_MAX && (double)c->expected[item] / ((double)tiles * tiles) * 4.0 > c->room) {
        tiles *= 2;
    }
    const uint32_t edge = pixels / tiles;
    for (uint32_t k = 0; k < tiles * tiles; ++k) {
        const svo_i_draw draw = {class_id, item, 1, k % tiles * edge, k / tiles * edge, edge, edge};
        /* The triangle may cover the whole tile: at most four fragments per pixel, usually two. */
        c->held = (double)edge * edge * 2.5;
        if (!add_draw(c->chunking, draw) || !close_chunk(c)) {
            return false;
        }
    }
    return true;
}

/* Puts the items of a class into the current chunk, in which the whole list fits. */
static bool add_class(cutter *c, svo_i_class class_id)
{
    const uint32_t first = c->plan->class_begin[class_id];
    const uint32_t end = c->plan->class_begin[class_id + 1];
    return first == end || add_items(c->plan, c->chunking, class_id, first, end - first);
}

static bool cut_class(cutter *c, svo_i_class class_id)
{
    const uint32_t end = c->plan->class_begin[class_id + 1];
    uint32_t first = c->plan->class_begin[class_id];
    for (uint32_t item = first; item < end; ++item) {
        const double expected = (double)c->expected[item];
        const bool huge = expected > c->room;
        if (huge || c->held + expected > c->room) {
            if ((item > first && !add_items(c->plan, c->chunking, class_id, first, item - first)) || !close_chunk(c)) {
                return false;
            }
            first = item;
        }
        if (huge) {
            if (!cut_triangle(c, class_id, item)) {
                return false;
            }
            first = item + 1;
            continue;
        }
        c->held += expected;
    }
    return first == end || add_items(c->plan, c->chunking, class_id, first, end - first);
}

/* Cuts the classes one after the other. */
static bool cut_list(cutter *c, bool fits)
{
    for (svo_i_class class_id = 0; class_id < SVO_I_CLASS_COUNT; ++class_id) {
        if (!(fits ? add_class(c, class_id) : cut_class(c, class_id))) {
            return false;
        }
    }
    return close_chunk(c);
}

svo_status svo_i_chunking_create(const svo_plan *plan, uint64_t chunk_bytes, svo_i_chunking *chunking)
{
    *chunking = (svo_i_chunking){.memory = &plan->device->memory};
    cutter c = {.plan = plan, .chunking = chunking, .limit = fragments_within(plan, chunk_bytes)};
    /* The capacity that svo_i_with_slack makes of it stays within the limit. */
    c.room = c.limit > 2048 ? ((double)c.limit - 1024.0) / 1.125 : (double)c.limit * 0.5;
    const double expected = svo_i_plan_expected(plan, plan->info.depth);
    const bool fits = expected <= c.room;
    const bool reads = !fits && plan->item_fragments == NULL; /* the plan's kernels have left them on the device */
    void *read = NULL;
    if (reads) {
        SVO_I_TRY(svo_i_plan_read(plan, plan->memory.item_fragments, (uint64_t)plan->class_begin[SVO_I_CLASS_COUNT] * 4,
                                  &read));
    }
    c.expected = reads ? read : plan->item_fragments;
    c.held = fits ? expected : 0.0;
    const bool cut = cut_list(&c, fits);
    svo_i_free(read);
    if (!cut) {
        svo_i_chunking_destroy(chunking);
        return no_memory(plan);
    }
    if (plan->options.fragment_capacity != 0 && chunking->chunk_count == 1) {
        const uint64_t asked = plan->options.fragment_capacity;
        chunking->chunks[0].capacity = asked < c.limit ? asked : c.limit;
    }
    return SVO_OK;
}

/* Splits a draw in two: its triangles, or for a single triangle its tile. Returns false if it cannot be split. */
static bool split_draw(const svo_i_draw *draw, svo_i_draw halves[2])
{
    halves[0] = *draw;
    halves[1] = *draw;
    if (draw->item_count > 1) {
        halves[0].item_count = draw->item_count / 2;
        halves[1].first_item += halves[0].item_count;
        halves[1].item_count -= halves[0].item_count;
        return true;
    }
    if (draw->tile_width <= TILE_PIXELS_MIN && draw->tile_height <= TILE_PIXELS_MIN) {
        return false;
    }
    if (draw->tile_width >= draw->tile_height) {
        halves[0].tile_width = draw->tile_width / 2;
        halves[1].tile_x += halves[0].tile_width;
        halves[1].tile_width -= halves[0].tile_width;
    } else {
        halves[0].tile_height = draw->tile_height / 2;
        halves[1].tile_y += halves[0].tile_height;
        halves[1].tile_height -= halves[0].tile_height;
    }
    return true;
}

/* Enlarges a chunk that was too small. Above the limit, each of its draws gets a chunk of its own, or two if it can be
   split. */
static bool regrow_chunk(const svo_i_chunking *old, uint32_t chunk_index, uint64_t needed, uint64_t limit,
                         svo_i_chunking *chunking)
{
    const svo_i_chunk *chunk = &old->chunks[chunk_index];
    const uint32_t first_draw = chunking->draw_count;
    const uint64_t capacity = needed < limit ? needed : limit;
    for (uint32_t i = 0; i < chunk->draw_count; ++i) {
        svo_i_draw parts[2] = {old->draws[chunk->first_draw + i]};
        const unsigned part_count = needed > limit && split_draw(&old->draws[chunk->first_draw + i], parts) ? 2 : 1;
        for (unsigned part = 0; part < part_count; ++part) {
            const uint32_t begin = chunking->draw_count;
            if (!add_draw(chunking, parts[part]) || (needed > limit && !add_chunk(chunking, begin, capacity))) {
                return false;
            }
        }
    }
    return needed > limit || add_chunk(chunking, first_draw, needed > chunk->capacity ? needed : chunk->capacity);
}

svo_status svo_i_chunking_grow(const svo_plan *plan, uint64_t chunk_bytes, const uint64_t *needed,
                               svo_i_chunking *chunking)
{
    const uint64_t limit = fragments_within(plan, chunk_bytes);
    svo_i_chunking grown = {.memory = &plan->device->memory};
    for (uint32_t i = 0; i < chunking->chunk_count; ++i) {
        if (!regrow_chunk(chunking, i, needed[i], limit, &grown)) {
            svo_i_chunking_destroy(&grown);
            return no_memory(plan);
        }
    }
    svo_i_chunking_destroy(chunking);
    *chunking = grown;
    return SVO_OK;
}

/* ---- tiles of columns ---- */

/*
 * Finds the tiles of columns that the projection of a large triangle can meet, so that many work-items share one
 * triangle. The kernel (kernels/stages/voxelize.cl) computes the same bounds for every triangle and skips those that
 * have more columns than a tile. Tiles are sorted by columns within blocks, as items are (grid.c).
 */

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

static int64_t columns_of(const projection *p)
{
    const int64_t width = p->end_u - p->first_u;
    const int64_t height = p->end_v - p->first_v;
    return width > 0 && height > 0 ? width * height : 0;
}

/* Whether the projection is cut into tiles. most_columns: as in a cut. */
static bool is_large(const projection *p, uint32_t most_columns)
{
    const int64_t columns = columns_of(p);
    return columns > (int64_t)SVO_TILE_COLUMNS && (most_columns == 0 || columns <= (int64_t)most_columns);
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

bool svo_i_tiles_of_draw(const svo_plan *plan, const svo_i_draw *draw, uint32_t most_columns, svo_i_tiles *tiles)
{
    const uint32_t end = first_large(plan, draw->first_item + draw->item_count);
    block unsorted;
    unsorted.tiles = tiles;
    unsorted.count = 0;
    tiles->memory = &plan->device->memory;
    for (uint32_t i = first_large(plan, draw->first_item); i < end; ++i) {
        const projection p = project(plan, draw, &plan->large[i]);
        for (int32_t v = p.first_v; v < p.end_v && is_large(&p, most_columns); v += SVO_TILE_EDGE) {
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

/* ---- the rest of a cut ---- */

/* Candidates are the plan's large triangles, or all items where smaller ones may have more columns. */
static bool are_large(uint32_t most_columns)
{
    return most_columns >= (uint32_t)SVO_TILE_COLUMNS;
}

/* The first candidate from an item on. */
static uint32_t first_candidate(const svo_plan *plan, uint32_t most_columns, uint32_t item)
{
    return are_large(most_columns) ? first_large(plan, item) : item;
}

static svo_large_item candidate_at(const svo_plan *plan, uint32_t most_columns, uint32_t index)
{
    if (are_large(most_columns)) {
        return plan->large[index];
    }
    const svo_draw_item item = plan->items[index];
    const uint32_t *corners = plan->indices + (size_t)item.triangle * 3;
    svo_large_item r = {.item = index, .axis = item.flags & SVO_DRAW_AXIS_MASK};
    for (unsigned corner = 0; corner < 3; ++corner) {
        memcpy(r.corners + (size_t)corner * 3, plan->vertices + (size_t)corners[corner] * 3, 3 * sizeof r.corners[0]);
    }
    return r;
}

/* Adds the draw's items of more columns, and a draw of them. */
static bool add_rest(const svo_plan *plan, const svo_i_draw *draw, uint32_t most_columns, svo_i_rest *to)
{
    svo_i_draw rest = *draw;
    rest.first_item = to->item_count;
    const uint32_t end = first_candidate(plan, most_columns, draw->first_item + draw->item_count);
    uint32_t i = draw->class_id == SVO_I_CLASS_POINT ? end : first_candidate(plan, most_columns, draw->first_item);
    for (; i < end; ++i) {
        const svo_large_item candidate = candidate_at(plan, most_columns, i);
        const projection p = project(plan, draw, &candidate);
        if (columns_of(&p) > (int64_t)most_columns) {
            to->items[to->item_count++] = plan->items[candidate.item];
        }
    }
    rest.item_count = to->item_count - rest.first_item;
    to->others += draw->item_count - rest.item_count;
    return add_draw(&to->chunking, rest);
}

bool svo_i_rest_may_exist(const svo_plan *plan, uint32_t most_columns)
{
    return !are_large(most_columns) || plan->large_count > 0;
}

svo_status svo_i_rest_find(const svo_plan *plan, const svo_i_chunking *cut, uint32_t most_columns, svo_i_rest *out)
{
    const svo_i_memory *memory = &plan->device->memory;
    uint64_t most = 0;
    for (uint32_t i = 0; i < cut->draw_count; ++i) {
        const svo_i_draw *draw = &cut->draws[i];
        most += first_candidate(plan, most_columns, draw->first_item + draw->item_count) -
                first_candidate(plan, most_columns, draw->first_item);
    }
    *out = (svo_i_rest){.items = svo_i_alloc(memory, (size_t)(most + 1) * sizeof *out->items),
                        .chunking = {.memory = memory}};
    bool added = out->items != NULL && most <= UINT32_MAX;
    for (uint32_t i = 0; i < cut->chunk_count && added; ++i) {
        const svo_i_chunk *chunk = &cut->chunks[i];
        const uint32_t first_draw = out->chunking.draw_count;
        for (uint32_t k = 0; k < chunk->draw_count && added; ++k) {
            added = add_rest(plan, &cut->draws[chunk->first_draw + k], most_columns, out);
        }
        added = added && add_chunk(&out->chunking, first_draw, chunk->capacity);
    }
    if (!added) {
        svo_i_rest_free(out);
        return no_memory(plan);
    }
    return SVO_OK;
}

void svo_i_rest_free(svo_i_rest *rest)
{
    svo_i_free(rest->items);
    rest->items = NULL;
    svo_i_chunking_destroy(&rest->chunking);
}
