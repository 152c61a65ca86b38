/* SPDX-License-Identifier: MIT */
/*
 * Assigns triangles to chunks of the fragment list, and tiles of triangles that are too large for a chunk. A chunk is
 * no larger than a storage block and an allocation may be. No result depends on the cut.
 */
#include <string.h>

#include "plan/chunking.h"
#include "plan/estimate.h"
#include "plan/host_copy.h"

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
