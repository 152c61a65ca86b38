/* SPDX-License-Identifier: MIT */
/*
 * Checks chunkings of the fragment list: every triangle is drawn over every pixel exactly once, in a chunk within its
 * limit, however often chunks were too small.
 */
#include "mesh_layout.h"

#include "fuzz.h"
#include "plan/chunking.h"
#include "plan/estimate.h"

/* Expected fragments, in capacities of a chunk: bounds the number of tiles and thus the time of one input. */
#define EXPECTED_CHUNKS_MAX 16.0
#define GROWTHS             2

/* splitmix64 (Steele, Lea, Flood, 2014) of one number. */
static uint64_t scramble(uint64_t x)
{
    uint64_t z = x + UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

/*
 * The sum over a rectangle of one random number per pixel: a difference of one random function in x times a difference
 * of another in y. If the sums of rectangles add up to the sum of the screen, they cover each pixel once, except with
 * probability 2^-64.
 */
static uint64_t rectangle_sum(uint32_t x, uint32_t y, uint32_t width, uint32_t height)
{
    const uint64_t other = UINT64_C(1) << 40;
    return (scramble(x + width) - scramble(x)) * (scramble(other + y + height) - scramble(other + y));
}

static void check_draw(const svo_plan *plan, const svo_i_draw *draw, uint64_t *covered)
{
    const uint32_t pixels = 1u << plan->info.depth;
    const uint32_t view = 1u << SVO_I_VIEW_LOG2;
    REQUIRE(draw->class_id < SVO_I_CLASS_COUNT && draw->item_count > 0);
    REQUIRE(draw->first_item >= plan->class_begin[draw->class_id]);
    REQUIRE(draw->item_count <= plan->class_begin[draw->class_id + 1] - draw->first_item);
    REQUIRE(draw->tile_width > 0 && draw->tile_width <= view && draw->tile_x <= pixels - draw->tile_width);
    REQUIRE(draw->tile_height > 0 && draw->tile_height <= view && draw->tile_y <= pixels - draw->tile_height);
    const uint64_t sum = rectangle_sum(draw->tile_x, draw->tile_y, draw->tile_width, draw->tile_height);
    for (uint32_t i = 0; i < draw->item_count; ++i) {
        covered[draw->first_item + i] += sum;
    }
}

static void check_layout(const svo_plan *plan, const svo_i_chunking *layout, uint64_t limit)
{
    const uint32_t pixels = 1u << plan->info.depth;
    uint64_t *covered = calloc((size_t)plan->triangle_count + 1, sizeof *covered);
    REQUIRE(covered != NULL);
    uint32_t next_draw = 0;
    for (uint32_t i = 0; i < layout->chunk_count; ++i) {
        const svo_i_chunk *chunk = &layout->chunks[i];
        REQUIRE(chunk->first_draw == next_draw && chunk->draw_count > 0);
        REQUIRE(chunk->capacity > 0 && chunk->capacity <= limit);
        next_draw += chunk->draw_count;
    }
    REQUIRE(next_draw == layout->draw_count);
    for (uint32_t i = 0; i < layout->draw_count; ++i) {
        check_draw(plan, &layout->draws[i], covered);
    }
    for (uint32_t i = 0; i < plan->triangle_count; ++i) {
        REQUIRE(covered[i] == rectangle_sum(0, 0, pixels, pixels));
    }
    free(covered);
}

/* One triangle in one column always fits into a chunk. Chunking relies on this. */
static bool can_overflow(const svo_i_chunking *layout, const svo_i_chunk *chunk)
{
    const svo_i_draw *draw = &layout->draws[chunk->first_draw];
    return chunk->draw_count > 1 || draw->item_count > 1 || draw->tile_width > 1 || draw->tile_height > 1;
}

/* Nothing, exactly the capacity, more, or more than any chunk may hold. */
static uint64_t choose_need(const svo_i_chunking *layout, const svo_i_chunk *chunk, uint64_t limit, uint64_t random)
{
    switch (random % 4) {
    case 0:
        return 0;
    case 1:
        return chunk->capacity;
    case 2:
        return chunk->capacity + (random >> 2) % (limit - chunk->capacity + 1);
    default:
        return can_overflow(layout, chunk) ? limit + 1 + (random >> 2) % limit : 1;
    }
}

static void grow_and_check(const svo_plan *plan, svo_i_chunking *layout, uint64_t chunk_bytes, uint64_t seed)
{
    const uint64_t limit = chunk_bytes / svo_i_plan_fragment_bytes(plan);
    REQUIRE(limit > 0);
    uint64_t *needed = malloc(((size_t)layout->chunk_count + 1) * sizeof *needed);
    REQUIRE(needed != NULL);
    uint64_t largest_fitting = 0;
    for (uint32_t i = 0; i < layout->chunk_count; ++i) {
        needed[i] = choose_need(layout, &layout->chunks[i], limit, scramble(seed + i));
        largest_fitting = needed[i] <= limit && needed[i] > largest_fitting ? needed[i] : largest_fitting;
    }
    REQUIRE(svo_i_chunking_grow(plan, chunk_bytes, needed, layout) == SVO_OK);
    uint64_t largest_capacity = 0;
    for (uint32_t i = 0; i < layout->chunk_count; ++i) {
        const uint64_t capacity = layout->chunks[i].capacity;
        largest_capacity = capacity > largest_capacity ? capacity : largest_capacity;
    }
    REQUIRE(largest_capacity >= largest_fitting);
    free(needed);
}

void check_layouts(const svo_plan *plan, uint64_t chunk_bytes, uint64_t seed)
{
    const uint64_t fragment_bytes = svo_i_plan_fragment_bytes(plan);
    const double least_bytes = plan->info.expected_fragments * (double)fragment_bytes / EXPECTED_CHUNKS_MAX;
    chunk_bytes = (double)chunk_bytes < least_bytes ? (uint64_t)least_bytes : chunk_bytes;
    svo_i_chunking layout;
    REQUIRE(svo_i_chunking_create(plan, chunk_bytes, &layout) == SVO_OK);
    check_layout(plan, &layout, chunk_bytes / fragment_bytes);
    for (unsigned growth = 0; growth < GROWTHS; ++growth) {
        grow_and_check(plan, &layout, chunk_bytes, seed + growth);
        check_layout(plan, &layout, chunk_bytes / fragment_bytes);
    }
    svo_i_chunking_destroy(&layout);
}
