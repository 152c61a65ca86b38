/* SPDX-License-Identifier: MIT */
/*
 * Points to cells. A block of points is sorted by radix, least significant digit first (Knuth, "The Art of Computer
 * Programming", volume 3, 5.2.5), and summed up to a run of cells. Runs are merged as those of a log-structured merge
 * tree are (O'Neil et al., 1996): each is at least twice as long as the next, so that all together have at most two
 * cells for each voxel, and a cell is merged as often as the logarithm of the number of blocks.
 */
#include "io/points_cells.h"

#include <string.h>

#define DIGIT_BITS 11u
#define DIGITS     (1u << DIGIT_BITS)

bool svo_i_point_cells_begin(cell_set *set)
{
    size_t bytes = 0;
    const bool fits = svo_i_mul_size(set->block_points, sizeof *set->block, &bytes);
    set->block = fits ? svo_i_alloc(set->memory, bytes) : NULL;
    set->spare = fits ? svo_i_alloc(set->memory, bytes) : NULL;
    return set->block != NULL && set->spare != NULL;
}

void svo_i_point_cells_end(cell_set *set)
{
    for (size_t i = 0; i < set->run_count; ++i) {
        svo_i_free(set->runs[i].cells);
    }
    svo_i_free(set->block);
    svo_i_free(set->spare);
    *set = (cell_set){.run_count = 0};
}

/* ---- blocks ---- */

/* Moves the points to the other array, in the order of a digit. Returns false, with nothing moved, where all have the
   same. */
static bool sort_digit(const placed_point *from, placed_point *to, size_t count, uint32_t shift)
{
    size_t slots[DIGITS] = {0};
    for (size_t i = 0; i < count; ++i) {
        ++slots[from[i].code >> shift & (DIGITS - 1)];
    }
    if (slots[from[0].code >> shift & (DIGITS - 1)] == count) {
        return false;
    }
    size_t sum = 0;
    for (size_t digit = 0; digit < DIGITS; ++digit) {
        const size_t here = slots[digit];
        slots[digit] = sum;
        sum += here;
    }
    for (size_t i = 0; i < count; ++i) {
        to[slots[from[i].code >> shift & (DIGITS - 1)]++] = from[i];
    }
    return true;
}

static void sort_block(cell_set *set)
{
    for (uint32_t shift = 0; shift < set->bits; shift += DIGIT_BITS) {
        if (sort_digit(set->block, set->spare, set->filled, shift)) {
            placed_point *sorted = set->spare;
            set->spare = set->block;
            set->block = sorted;
        }
    }
}

static size_t count_codes(const placed_point *points, size_t count)
{
    size_t codes = 1;
    for (size_t i = 1; i < count; ++i) {
        codes += points[i].code != points[i - 1].code ? 1 : 0;
    }
    return codes;
}

static void sum_up(const placed_point *points, size_t count, point_cell *cells)
{
    point_cell *cell = cells;
    for (size_t i = 0; i < count; ++i) {
        if (i == 0 || points[i].code != points[i - 1].code) {
            cell = i == 0 ? cells : cell + 1;
            *cell = (point_cell){.code = points[i].code};
        }
        for (size_t channel = 0; channel < 3; ++channel) {
            cell->sums[channel] += points[i].channels[channel];
        }
        ++cell->count;
    }
}

/* ---- runs ---- */

/* Merges two runs into an array that has room for both. Returns how many cells there are. */
static size_t merge_cells(const cell_run *a, const cell_run *b, point_cell *out)
{
    size_t i = 0, j = 0, made = 0;
    while (i < a->count || j < b->count) {
        const bool takes_a = j == b->count || (i < a->count && a->cells[i].code <= b->cells[j].code);
        const bool takes_b = i == a->count || (j < b->count && b->cells[j].code <= a->cells[i].code);
        point_cell *cell = &out[made++];
        *cell = takes_a ? a->cells[i++] : b->cells[j];
        if (takes_a && takes_b) {
            for (size_t channel = 0; channel < 3; ++channel) {
                cell->sums[channel] += b->cells[j].sums[channel];
            }
            cell->count += b->cells[j].count;
        }
        j += takes_b ? 1 : 0;
    }
    return made;
}

/* Makes one of the last two runs. */
static bool merge_last(cell_set *set)
{
    cell_run *a = &set->runs[set->run_count - 2];
    cell_run *b = &set->runs[set->run_count - 1];
    size_t bytes = 0;
    const bool fits = svo_i_mul_size(a->count + b->count, sizeof *a->cells, &bytes);
    point_cell *cells = fits ? svo_i_alloc(set->memory, bytes) : NULL;
    if (cells == NULL) {
        return false;
    }
    const size_t count = merge_cells(a, b, cells);
    svo_i_free(a->cells);
    svo_i_free(b->cells);
    --set->run_count;
    point_cell *smaller = svo_i_grow(set->memory, cells, count * sizeof *cells);
    *a = (cell_run){smaller != NULL ? smaller : cells, count};
    set->too_many = count > set->cells_max;
    return !set->too_many;
}

/* Makes a run of the block and merges the last ones until each is at least twice as long as the next. */
static bool flush(cell_set *set)
{
    if (set->filled == 0) {
        return true;
    }
    sort_block(set);
    const size_t count = count_codes(set->block, set->filled);
    point_cell *cells = svo_i_alloc(set->memory, count * sizeof *cells);
    if (cells == NULL) {
        return false;
    }
    sum_up(set->block, set->filled, cells);
    set->runs[set->run_count++] = (cell_run){cells, count};
    set->filled = 0;
    set->too_many = count > set->cells_max;
    bool done = !set->too_many;
    while (done && set->run_count > 1 &&
           set->runs[set->run_count - 2].count / 2 < set->runs[set->run_count - 1].count) {
        done = merge_last(set);
    }
    return done;
}

bool svo_i_point_cells_add(cell_set *set, const placed_point *point)
{
    set->block[set->filled++] = *point;
    return set->filled < set->block_points || flush(set);
}

bool svo_i_point_cells_finish(cell_set *set)
{
    bool done = flush(set);
    while (done && set->run_count > 1) {
        done = merge_last(set);
    }
    return done;
}
