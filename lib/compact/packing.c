/* SPDX-License-Identifier: MIT */
/*
 * Payload arrays to packed ones, in units of 256 elements. Of each unit the eighths, quarters and halves that make
 * blocks are found from the smallest ones up: two neighbors become one block where that costs no more. Each block has
 * the mode of the least cost among those that keep within the error. The cost is the bits and, where elements may
 * change, what they differ by, with a Lagrangian multiplier (Sullivan and Wiegand, "Rate-Distortion Optimization for
 * Video Compression", 1998). Integers alone decide, so the words are the same on every machine.
 */
#include "compact/packing.h"

#include <string.h>

#include "shared/packed.clh"

#define CHANNELS    4
#define HEADER_BITS 32u
/* Blocks of a unit of 8, 16, ... 256 elements. */
#define LEAST_BLOCKS (SVO_PACKED_UNIT >> SVO_PACKED_LEAST_LOG2)
#define BLOCKS       (2 * LEAST_BLOCKS - 1)
/* Words of a unit's blocks at most: one block of raw elements of 48 bits has fewer. */
#define UNIT_WORDS_MAX (LEAST_BLOCKS + (1u << SVO_PACKED_OFFSET_BITS) / 32u + 2u)
#define NO_FIT         UINT32_MAX
/* What a difference of one step costs, in bits. Levels of step s have a mean error near s / 4 and take log2(range / s)
   bits, so that there a difference of s is worth 4 / ln 2 = 5.8 bits. Somewhat more, with a larger step, takes fewer
   bits at the same mean error. */
#define STEP_BITS 8u

typedef uint16_t element[CHANNELS];

/* How a block is coded. */
typedef struct coding {
    uint32_t bits; /* of the data; NO_FIT: not yet coded */
    uint64_t cost; /* in units of cost_of_bit */
    uint32_t mode, what; /* of the header */
    uint32_t levels[CHANNELS]; /* of radix, green and delta */
    element first, second; /* least; of a line the ends */
    element palette[SVO_PACKED_COLORS_MAX];
    uint8_t index[SVO_PACKED_UNIT]; /* of palettes and lines: per element */
} coding;

typedef struct packer {
    const svo_i_packing *what;
    const svo_i_memory *memory;
    const char *function;
    svo_message *message;
    uint32_t head; /* word 0 */
    uint32_t channels, channel_bits, most; /* most: the greatest of a channel */
    uint32_t error[CHANNELS]; /* as coded */
    uint32_t alpha; /* of colors with three channels */
    uint32_t *words;
    size_t word_count, word_capacity;
    element unit[SVO_PACKED_UNIT]; /* as coded */
    uint32_t unit_count; /* of these; fewer at the end */
    coding blocks[BLOCKS]; /* those of 8 elements, then those of 16, ... */
    coding tried;
} packer;

/* ---- what is common to modes ---- */

/* Bits of a number below count. */
static uint32_t bits_below(uint64_t count)
{
    uint32_t bits = 0;
    while ((UINT64_C(1) << bits) < count) {
        ++bits;
    }
    return bits;
}

static uint32_t distance(uint32_t a, uint32_t b)
{
    return a > b ? a - b : b - a;
}

static bool is_lossy(const packer *p)
{
    return p->error[0] > 0;
}

static uint32_t step_of(const packer *p, uint32_t channel)
{
    return 2 * p->error[channel] + 1;
}

/* The levels of a range of values, and the value of the first: errors are centered. */
static uint32_t count_levels(const packer *p, uint32_t channel, uint32_t low, uint32_t high, uint16_t *first)
{
    const uint32_t step = step_of(p, channel);
    const uint32_t levels = (high - low + step) / step;
    const uint32_t slack = levels * step - (high - low + 1);
    *first = (uint16_t)(low + p->error[channel] - slack / 2);
    return levels;
}

/* ---- costs ---- */

static uint32_t cost_of_bit(const packer *p)
{
    return step_of(p, 0);
}

/* What a channel of an element becomes. */
static uint32_t decoded(const packer *p, const coding *made, const element *values, uint32_t i, uint32_t channel)
{
    const uint32_t step = step_of(p, channel);
    const uint32_t value = values[i][channel];
    switch (made->mode) {
    case SVO_PACKED_GREEN:
        return value;
    case SVO_PACKED_PALETTE:
        return made->palette[made->index[i]][channel];
    case SVO_PACKED_LINE:
        return svo_packed_mix(made->first[channel], made->second[channel], made->index[i], (1u << made->what) - 1);
    default:
        return made->first[channel] + (value + p->error[channel] - made->first[channel]) / step * step;
    }
}

static void keep_better(packer *p, const element *values, uint32_t count, coding *best)
{
    uint64_t differences = 0;
    for (uint32_t i = 0; i < count && is_lossy(p); ++i) {
        for (uint32_t c = 0; c < p->channels; ++c) {
            differences += distance(decoded(p, &p->tried, values, i, c), values[i][c]);
        }
    }
    p->tried.cost = (uint64_t)p->tried.bits * cost_of_bit(p) + STEP_BITS * differences;
    if (p->tried.cost < best->cost) {
        *best = p->tried;
    }
}

static void find_range(const packer *p, const element *values, uint32_t count, element low, element high)
{
    memcpy(low, values[0], sizeof(element));
    memcpy(high, values[0], sizeof(element));
    for (uint32_t i = 1; i < count; ++i) {
        for (uint32_t c = 0; c < p->channels; ++c) {
            low[c] = values[i][c] < low[c] ? values[i][c] : low[c];
            high[c] = values[i][c] > high[c] ? values[i][c] : high[c];
        }
    }
}

/* ---- least and levels: radix, green, delta ---- */

static void set_radix(packer *p, uint32_t mode, uint32_t count)
{
    coding *made = &p->tried;
    uint64_t product = 1;
    for (uint32_t c = 0; c < p->channels; ++c) {
        product *= made->levels[c];
    }
    made->mode = mode;
    made->what = bits_below(product);
    made->bits = 16 * p->channels + count * made->what;
}

static void fit_levels(packer *p, const element low, const element high, uint32_t count)
{
    coding *made = &p->tried;
    for (uint32_t c = 0; c < p->channels; ++c) {
        made->levels[c] = count_levels(p, c, low[c], high[c], &made->first[c]);
    }
    if (p->channel_bits == 8) {
        set_radix(p, SVO_PACKED_RADIX, count);
        return;
    }
    made->mode = SVO_PACKED_DELTA;
    made->what = 0;
    uint32_t width = 0;
    for (uint32_t c = 0; c < p->channels; ++c) {
        const uint32_t bits = bits_below(made->levels[c]);
        made->what |= bits << 5 * c;
        width += bits;
    }
    made->bits = 16 * p->channels + count * width;
}

/* Red and blue less green, alpha and green. */
static void to_green(const uint16_t *value, int32_t out[CHANNELS])
{
    out[0] = value[1];
    out[1] = (int32_t)value[0] - value[1];
    out[2] = (int32_t)value[2] - value[1];
    out[3] = value[3];
}

static bool fit_green(packer *p, const element *values, uint32_t count)
{
    coding *made = &p->tried;
    int32_t low[CHANNELS];
    int32_t high[CHANNELS];
    to_green(values[0], low);
    memcpy(high, low, sizeof high);
    for (uint32_t i = 1; i < count; ++i) {
        int32_t value[CHANNELS];
        to_green(values[i], value);
        for (uint32_t c = 0; c < p->channels; ++c) {
            low[c] = value[c] < low[c] ? value[c] : low[c];
            high[c] = value[c] > high[c] ? value[c] : high[c];
        }
    }
    for (uint32_t c = 0; c < p->channels; ++c) {
        made->levels[c] = (uint32_t)(high[c] - low[c]) + 1;
        made->first[c] = (uint16_t)(low[c] & 255);
        if (made->levels[c] > 256) {
            return false;
        }
    }
    set_radix(p, SVO_PACKED_GREEN, count);
    return true;
}

/* ---- palettes ---- */

/* Values that one color of a palette stands for. */
typedef struct box {
    element low, high;
} box;

/* Takes a value into a box unless that would get wider than so many errors; a color in its middle may stand for two. */
static bool widen(const packer *p, const uint16_t *value, uint32_t errors, box *of)
{
    box wider = *of;
    for (uint32_t c = 0; c < p->channels; ++c) {
        wider.low[c] = value[c] < wider.low[c] ? value[c] : wider.low[c];
        wider.high[c] = value[c] > wider.high[c] ? value[c] : wider.high[c];
        if ((uint32_t)(wider.high[c] - wider.low[c]) > errors * p->error[c]) {
            return false;
        }
    }
    *of = wider;
    return true;
}

/* Gives each value the nearest color; that of its box is near enough. */
static void choose_nearest(const packer *p, const element *values, uint32_t count, uint32_t colors, coding *made)
{
    for (uint32_t i = 0; i < count; ++i) {
        uint64_t least = UINT64_MAX;
        for (uint32_t k = 0; k < colors; ++k) {
            uint64_t off = 0;
            bool fits = true;
            for (uint32_t c = 0; fits && c < p->channels; ++c) {
                const uint32_t difference = distance(values[i][c], made->palette[k][c]);
                fits = difference <= p->error[c];
                off += (uint64_t)difference * difference;
            }
            if (fits && off < least) {
                least = off;
                made->index[i] = (uint8_t)k;
            }
        }
    }
}

/* Moves each color to the mean of its values, as far as all of them stay near enough. */
static void center_colors(const packer *p, const element *values, uint32_t count, uint32_t colors, coding *made)
{
    for (uint32_t k = 0; k < colors; ++k) {
        for (uint32_t c = 0; c < p->channels; ++c) {
            uint64_t sum = 0;
            uint32_t members = 0;
            uint32_t low = p->most;
            uint32_t high = 0;
            for (uint32_t i = 0; i < count; ++i) {
                if (made->index[i] == k) {
                    sum += values[i][c];
                    ++members;
                    low = values[i][c] < low ? values[i][c] : low;
                    high = values[i][c] > high ? values[i][c] : high;
                }
            }
            if (members == 0) {
                continue; /* others are nearer to all of its values */
            }
            const uint32_t first = high > p->error[c] ? high - p->error[c] : 0;
            const uint32_t mean = (uint32_t)((2 * sum + members) / ((uint64_t)2 * members));
            const uint32_t last = low + p->error[c];
            made->palette[k][c] = (uint16_t)(mean < first ? first : mean > last ? last : mean);
        }
    }
}

/* Each value goes to the first box that takes it. errors: the width of boxes. bits_max: so many are no better. */
static bool fit_palette(packer *p, const element *values, uint32_t count, uint32_t errors, uint32_t bits_max)
{
    coding *made = &p->tried;
    box boxes[SVO_PACKED_COLORS_MAX];
    const uint32_t color_bits = p->channels * p->channel_bits;
    uint32_t colors = 0;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t at = i > 0 && widen(p, values[i], errors, &boxes[made->index[i - 1]]) ? made->index[i - 1] : 0;
        while (at < colors && !widen(p, values[i], errors, &boxes[at])) {
            ++at;
        }
        if (at == colors) {
            if (colors == SVO_PACKED_COLORS_MAX || (colors + 1) * color_bits >= bits_max) {
                return false;
            }
            memcpy(boxes[colors].low, values[i], sizeof(element));
            memcpy(boxes[colors++].high, values[i], sizeof(element));
        }
        made->index[i] = (uint8_t)at;
    }
    for (uint32_t k = 0; k < colors; ++k) {
        for (uint32_t c = 0; c < p->channels; ++c) {
            made->palette[k][c] = (uint16_t)((boxes[k].low[c] + boxes[k].high[c]) / 2);
        }
    }
    if (is_lossy(p) && colors > 1) {
        choose_nearest(p, values, count, colors, made);
        center_colors(p, values, count, colors, made);
    }
    const uint32_t width = bits_below(colors);
    made->mode = SVO_PACKED_PALETTE;
    made->what = width | (colors - 1) << 3;
    made->bits = colors * color_bits + count * width;
    return true;
}

/* ---- lines ---- */

/* Ends of a line through the values: the channel of the largest range goes from least to greatest, the others follow it
   with the slope of least squares, and half of the largest differences on both sides. False: alpha differs. */
static bool fit_ends(packer *p, const element *values, uint32_t count, const element low, const element high,
                     uint32_t *main_channel)
{
    uint32_t main = 0;
    int64_t sum = 0;
    int64_t squares = 0;
    for (uint32_t c = 0; c < p->channels; ++c) {
        main = high[c] - low[c] > high[main] - low[main] ? c : main;
        if (p->error[c] == 0 && high[c] != low[c]) {
            return false;
        }
    }
    for (uint32_t i = 0; i < count; ++i) {
        const int64_t x = values[i][main] - low[main];
        sum += x;
        squares += x * x;
    }
    *main_channel = main;
    const int64_t variance = (int64_t)count * squares - sum * sum; /* times count^2; above 0 where the range is */
    const int64_t range = high[main] - low[main];
    for (uint32_t c = 0; c < p->channels; ++c) {
        int64_t product = 0;
        int64_t own = 0;
        for (uint32_t i = 0; i < count; ++i) {
            const int64_t y = values[i][c] - low[c];
            product += y * (values[i][main] - low[main]);
            own += y;
        }
        const int64_t covariance = (int64_t)count * product - sum * own;
        const int64_t rise = variance > 0 ? covariance * range / variance : 0; /* from one end to the other */
        int64_t least = INT64_MAX;
        int64_t most = INT64_MIN;
        for (uint32_t i = 0; i < count; ++i) {
            const int64_t along = range > 0 ? rise * (values[i][main] - low[main]) / range : 0;
            const int64_t off = values[i][c] - along;
            least = off < least ? off : least;
            most = off > most ? off : most;
        }
        const int64_t first = (least + most) / 2;
        const int64_t second = first + rise;
        p->tried.first[c] = (uint16_t)(first < 0 ? 0 : first > p->most ? p->most : first);
        p->tried.second[c] = (uint16_t)(second < 0 ? 0 : second > p->most ? p->most : second);
    }
    return true;
}

/* The weight of a value, or 255 where none is near enough. */
static uint32_t find_weight(const packer *p, const uint16_t *value, uint32_t main, uint32_t most)
{
    const int32_t first = p->tried.first[main];
    const int32_t range = p->tried.second[main] - first;
    const int32_t guess = range != 0 ? (2 * (value[main] - first) * (int32_t)most + range) / (2 * range) : 0;
    uint32_t best = 255;
    uint64_t best_error = UINT64_MAX;
    for (int32_t weight = guess - 1; weight <= guess + 1; ++weight) {
        uint64_t error = 0;
        bool fits = weight >= 0 && weight <= (int32_t)most;
        for (uint32_t c = 0; fits && c < p->channels; ++c) {
            const uint32_t mixed = svo_packed_mix(p->tried.first[c], p->tried.second[c], (uint32_t)weight, most);
            const uint32_t off = distance(mixed, value[c]);
            fits = off <= p->error[c];
            error += (uint64_t)off * off;
        }
        if (fits && error < best_error) {
            best = (uint32_t)weight;
            best_error = error;
        }
    }
    return best;
}

static bool fit_weights(packer *p, const element *values, uint32_t count, uint32_t main, uint32_t width)
{
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t weight = find_weight(p, values[i], main, (1u << width) - 1);
        if (weight == 255) {
            return false;
        }
        p->tried.index[i] = (uint8_t)weight;
    }
    p->tried.mode = SVO_PACKED_LINE;
    p->tried.what = width;
    p->tried.bits = 2 * p->channels * p->channel_bits + count * width;
    return true;
}

/* Moves the ends to those of least squares for the weights that there are, and finds the weights anew. False: the ends
   cannot move, or then a value is too far off. */
static bool refine_line(packer *p, const element *values, uint32_t count, uint32_t main, uint32_t width)
{
    coding *made = &p->tried;
    const int64_t most = (1 << width) - 1;
    int64_t squares[3] = {0, 0, 0}; /* of the share of the first end, of both, of the second */
    for (uint32_t i = 0; i < count; ++i) {
        const int64_t weight = made->index[i];
        squares[0] += (most - weight) * (most - weight);
        squares[1] += (most - weight) * weight;
        squares[2] += weight * weight;
    }
    const int64_t determinant = squares[0] * squares[2] - squares[1] * squares[1]; /* below 2^36 */
    for (uint32_t c = 0; c < p->channels && determinant > 0; ++c) {
        int64_t products[2] = {0, 0};
        for (uint32_t i = 0; i < count; ++i) {
            products[0] += (most - made->index[i]) * values[i][c];
            products[1] += (int64_t)made->index[i] * values[i][c];
        }
        const int64_t first = most * (products[0] * squares[2] - products[1] * squares[1]) + determinant / 2;
        const int64_t second = most * (products[1] * squares[0] - products[0] * squares[1]) + determinant / 2;
        const int64_t limit = (int64_t)p->most * determinant;
        made->first[c] = (uint16_t)((first < 0 ? 0 : first > limit ? limit : first) / determinant);
        made->second[c] = (uint16_t)((second < 0 ? 0 : second > limit ? limit : second) / determinant);
    }
    return determinant > 0 && fit_weights(p, values, count, main, width);
}

/* More bits a weight as long as they are worth it. p->tried has the ends. */
static void fit_line(packer *p, const element *values, uint32_t count, uint32_t main, coding *best)
{
    const coding ends = p->tried;
    uint64_t before = UINT64_MAX;
    for (uint32_t width = 1; width <= SVO_PACKED_WEIGHT_MAX; ++width) {
        p->tried = ends;
        if (!fit_weights(p, values, count, main, width)) {
            continue;
        }
        keep_better(p, values, count, best);
        uint64_t cost = p->tried.cost;
        if (refine_line(p, values, count, main, width)) {
            keep_better(p, values, count, best);
            cost = p->tried.cost < cost ? p->tried.cost : cost;
        }
        if (cost > before) {
            return;
        }
        before = cost;
    }
}

/* ---- blocks ---- */

/* The best coding of some values. */
static void fit_block(packer *p, const element *values, uint32_t count, coding *best)
{
    element low;
    element high;
    uint32_t main = 0;
    best->cost = UINT64_MAX;
    find_range(p, values, count, low, high);
    fit_levels(p, low, high, count);
    keep_better(p, values, count, best);
    if (p->channel_bits == 8 && p->what->buffer == SVO_COMPACT_COLORS && fit_green(p, values, count)) {
        keep_better(p, values, count, best);
    }
    for (uint32_t errors = is_lossy(p) ? 1 : 2; errors <= 2; ++errors) {
        if (fit_palette(p, values, count, errors, (uint32_t)(best->cost / cost_of_bit(p)) + 1)) {
            keep_better(p, values, count, best);
        }
    }
    if (is_lossy(p) && best->bits > 2 * p->channels * p->channel_bits + count &&
        fit_ends(p, values, count, low, high, &main)) {
        fit_line(p, values, count, main, best);
    }
}

/* The first of p->blocks with so many elements. */
static uint32_t row_of(uint32_t block_log2)
{
    uint32_t row = 0;
    for (uint32_t log2 = SVO_PACKED_LEAST_LOG2; log2 < block_log2; ++log2) {
        row += SVO_PACKED_UNIT >> log2;
    }
    return row;
}

/* Codes all blocks; what two smaller ones code at less cost is left to them. best: receives the cost of each, of it or
   of those inside. */
static void fit_unit(packer *p, uint64_t best[BLOCKS])
{
    for (uint32_t log2 = SVO_PACKED_LEAST_LOG2; log2 <= SVO_PACKED_UNIT_LOG2; ++log2) {
        const uint32_t row = row_of(log2);
        for (uint32_t i = 0; i < SVO_PACKED_UNIT >> log2; ++i) {
            const uint32_t begin = i << log2;
            const uint32_t left = begin < p->unit_count ? p->unit_count - begin : 0;
            coding *own = &p->blocks[row + i];
            best[row + i] = 0;
            own->bits = NO_FIT;
            if (left == 0) {
                continue;
            }
            fit_block(p, (const element *)p->unit + begin, left < 1u << log2 ? left : 1u << log2, own);
            best[row + i] = own->cost + (uint64_t)HEADER_BITS * cost_of_bit(p);
            if (log2 > SVO_PACKED_LEAST_LOG2) {
                const uint32_t below = row_of(log2 - 1) + 2 * i;
                const uint64_t halves = best[below] + best[below + 1];
                if (halves < best[row + i]) {
                    best[row + i] = halves;
                    own->bits = NO_FIT;
                }
            }
        }
    }
}

/* ---- words ---- */

static svo_status reserve_words(packer *p, size_t count)
{
    const size_t needed = p->word_count + count;
    if (needed > UINT32_MAX) {
        return svo_i_fail(p->message, SVO_UNSUPPORTED, "%s: %zu words of packed payload are above 2^32 - 1",
                          p->function, needed);
    }
    if (needed > p->word_capacity) {
        const size_t capacity = needed + p->word_capacity / 2;
        uint32_t *grown = svo_i_grow(p->memory, p->words, capacity * sizeof *grown);
        if (grown == NULL) {
            return svo_i_fail(p->message, SVO_OUT_OF_HOST_MEMORY, "%s: packed payload needs %zu bytes", p->function,
                              capacity * sizeof *grown);
        }
        memset(grown + p->word_capacity, 0, (capacity - p->word_capacity) * sizeof *grown);
        p->words = grown;
        p->word_capacity = capacity;
    }
    return SVO_OK;
}

static void put_bits(uint32_t *data, uint32_t *bit, uint32_t value, uint32_t count)
{
    if (count == 0) {
        return;
    }
    const uint32_t shift = *bit & 31;
    data[*bit >> 5] |= value << shift;
    if (shift + count > 32) {
        data[(*bit >> 5) + 1] |= value >> (32 - shift);
    }
    *bit += count;
}

static void put_color(const packer *p, uint32_t *data, uint32_t *bit, const uint16_t *color)
{
    for (uint32_t c = 0; c < p->channels; ++c) {
        put_bits(data, bit, color[c], p->channel_bits);
    }
}

/* The level of a channel of a value. */
static uint32_t level_of(const packer *p, const coding *made, const uint16_t *value, uint32_t channel)
{
    int32_t green[CHANNELS];
    if (made->mode == SVO_PACKED_GREEN) {
        to_green(value, green);
        return (uint32_t)(green[channel] - made->first[channel]) & 255;
    }
    return ((uint32_t)value[channel] + p->error[channel] - made->first[channel]) / step_of(p, channel);
}

static void put_levels(const packer *p, const coding *made, uint32_t *data, uint32_t *bit, const uint16_t *value)
{
    uint32_t code = 0;
    uint32_t scale = 1;
    for (uint32_t c = 0; c < p->channels; ++c) {
        const uint32_t level = level_of(p, made, value, c);
        if (made->mode == SVO_PACKED_DELTA) {
            put_bits(data, bit, level, made->what >> 5 * c & 31);
        } else {
            code += level * scale;
            scale *= made->levels[c];
        }
    }
    if (made->mode != SVO_PACKED_DELTA) {
        put_bits(data, bit, code, made->what);
    }
}

static void put_block(const packer *p, const coding *made, const element *values, uint32_t count, uint32_t *data,
                      uint32_t *bit)
{
    const bool by_levels = made->mode <= SVO_PACKED_DELTA;
    for (uint32_t c = 0; made->mode <= SVO_PACKED_GREEN && c < p->channels; ++c) {
        put_bits(data, bit, made->levels[c] - 1, 8);
    }
    if (made->mode != SVO_PACKED_PALETTE) {
        put_color(p, data, bit, made->first);
    }
    if (made->mode == SVO_PACKED_LINE) {
        put_color(p, data, bit, made->second);
    }
    for (uint32_t k = 0; made->mode == SVO_PACKED_PALETTE && k <= made->what >> 3; ++k) {
        put_color(p, data, bit, made->palette[k]);
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (by_levels) {
            put_levels(p, made, data, bit, values[i]);
        } else {
            put_bits(data, bit, made->index[i], made->what & 7);
        }
    }
}

/* The blocks of a unit, by first element; returns how many. */
static uint32_t list_blocks(const packer *p, uint32_t log2, uint32_t index, const coding **out, uint32_t *begins)
{
    const coding *own = &p->blocks[row_of(log2) + index];
    if (index << log2 >= p->unit_count) {
        return 0;
    }
    if (own->bits != NO_FIT) {
        out[0] = own;
        begins[0] = index << log2;
        return 1;
    }
    const uint32_t first = list_blocks(p, log2 - 1, 2 * index, out, begins);
    return first + list_blocks(p, log2 - 1, 2 * index + 1, out + first, begins + first);
}

static svo_status put_unit(packer *p, uint32_t unit_index)
{
    const coding *list[LEAST_BLOCKS];
    uint32_t begins[LEAST_BLOCKS + 1];
    uint64_t best[BLOCKS];
    uint32_t bit = 0;
    fit_unit(p, best);
    SVO_I_TRY(reserve_words(p, UNIT_WORDS_MAX));
    const uint32_t count = list_blocks(p, SVO_PACKED_UNIT_LOG2, 0, list, begins);
    uint32_t *entry = p->words + SVO_PACKED_HEAD_WORDS + 2 * (size_t)unit_index;
    uint32_t *headers = p->words + p->word_count;
    begins[count] = p->unit_count;
    entry[1] = (uint32_t)p->word_count;
    for (uint32_t k = 0; k < count; ++k) {
        entry[0] |= 1u << (begins[k] >> SVO_PACKED_LEAST_LOG2);
        headers[k] = bit | list[k]->mode << SVO_PACKED_OFFSET_BITS | list[k]->what << SVO_PACKED_WHAT_SHIFT;
        put_block(p, list[k], (const element *)p->unit + begins[k], begins[k + 1] - begins[k], headers + count, &bit);
    }
    p->word_count += count + (bit + 31) / 32;
    return SVO_OK;
}

/* ---- from elements to channels ---- */

/* Finds u, v and length of a normal, the nearest ones around those that are rounded. */
static void fold_normal(const packer *p, const int16_t *normal, uint16_t *out)
{
    const int32_t most = (int32_t)(p->head >> 24);
    int32_t part[3];
    int64_t sum = 0;
    uint32_t squares = 0;
    for (int axis = 0; axis < 3; ++axis) {
        part[axis] = normal[axis] < -32767 ? -32767 : normal[axis];
        sum += part[axis] < 0 ? -part[axis] : part[axis];
        squares += (uint32_t)(part[axis] * part[axis]);
    }
    const uint32_t rounded = (2 * 255 * svo_packed_root(squares) + 32767) / (2 * 32767);
    const uint32_t length = rounded < 255 ? rounded : 255;
    int32_t guess[2] = {0, 0};
    for (int axis = 0; axis < 2 && sum > 0; ++axis) {
        const int32_t other = part[1 - axis] < 0 ? -part[1 - axis] : part[1 - axis];
        const int64_t along = part[2] >= 0 ? part[axis] : part[axis] < 0 ? other - sum : sum - other;
        guess[axis] = (int32_t)((2 * along * most + (along < 0 ? -sum : sum)) / (2 * sum));
    }
    uint64_t least = UINT64_MAX;
    for (int32_t near = 0; near < 9; ++near) {
        const int32_t u = guess[0] + near % 3 - 1;
        const int32_t v = guess[1] + near / 3 - 1;
        if (u < -most || u > most || v < -most || v > most) {
            continue;
        }
        const uint32_t coded[3] = {(uint32_t)(u + most), (uint32_t)(v + most), length};
        uint32_t shown[3];
        uint64_t off = 0;
        svo_packed_unfold((uint32_t)most, coded, shown);
        for (int axis = 0; axis < 3; ++axis) {
            const int64_t difference = (int64_t)(int16_t)(uint16_t)shown[axis] - part[axis];
            off += (uint64_t)(difference * difference);
        }
        if (off < least) {
            least = off;
            out[0] = (uint16_t)coded[0];
            out[1] = (uint16_t)coded[1];
            out[2] = (uint16_t)coded[2];
        }
    }
}

static void load_normal(const packer *p, const int16_t *normal, const int16_t *previous, const uint16_t *known,
                        uint16_t *out)
{
    if (p->channel_bits == 16) {
        for (int axis = 0; axis < 3; ++axis) {
            out[axis] = (uint16_t)((uint16_t)normal[axis] ^ 0x8000u);
        }
    } else if (previous != NULL && memcmp(normal, previous, 3 * sizeof *normal) == 0) {
        memcpy(out, known, sizeof(element)); /* flat surfaces */
    } else {
        fold_normal(p, normal, out);
    }
}

static void load_element(packer *p, uint64_t index, uint32_t i)
{
    uint16_t *out = p->unit[i];
    const uint8_t *color = (const uint8_t *)p->what->elements + 4 * index;
    const int16_t *normal = (const int16_t *)p->what->elements + 3 * index;
    switch (p->what->buffer) {
    case SVO_COMPACT_COLORS:
        for (uint32_t c = 0; c < p->channels; ++c) {
            out[c] = color[c];
        }
        break;
    case SVO_COMPACT_NORMALS:
        load_normal(p, normal, i > 0 ? normal - 3 : NULL, i > 0 ? p->unit[i - 1] : NULL, out);
        break;
    default:
        out[0] = ((const uint16_t *)p->what->elements)[index];
        break;
    }
}

/* ---- the head ---- */

/* Whether all colors have one alpha. */
static bool find_alpha(const svo_i_packing *what, uint32_t *alpha)
{
    const uint8_t *colors = what->elements;
    *alpha = colors[3];
    for (uint64_t i = 1; i < what->count; ++i) {
        if (colors[4 * i + 3] != *alpha) {
            *alpha = 0;
            return false;
        }
    }
    return true;
}

static void describe(packer *p)
{
    const svo_i_packing *what = p->what;
    const bool octahedral = what->buffer == SVO_COMPACT_NORMALS && what->normal_bits > 0;
    p->channel_bits = what->buffer == SVO_COMPACT_COLORS || octahedral ? 8 : 16;
    p->channels = what->buffer == SVO_COMPACT_NORMALS ? 3 : 1;
    if (what->buffer == SVO_COMPACT_COLORS) {
        p->channels = find_alpha(what, &p->alpha) ? 3 : 4;
    }
    p->most = (1u << p->channel_bits) - 1;
    for (uint32_t c = 0; c < 3; ++c) {
        p->error[c] = what->error;
    }
    p->head = SVO_PACKED_VERSION | p->channels << 8 | p->channel_bits << 11 |
              (octahedral ? SVO_PACKED_OCTAHEDRAL << 16 | ((1u << (what->normal_bits - 1)) - 1) << 24 : 0);
}

/* ---- errors ---- */

static uint32_t component(const packer *p, uint64_t index, uint32_t which)
{
    const void *elements = p->what->elements;
    switch (p->what->buffer) {
    case SVO_COMPACT_COLORS:
        return ((const uint8_t *)elements)[4 * index + which];
    case SVO_COMPACT_NORMALS:
        return (uint16_t)((const uint16_t *)elements)[3 * index + which] ^ 0x8000u;
    default:
        return ((const uint16_t *)elements)[index];
    }
}

/* Reads all elements back and sets what the head says of their errors. */
static void measure(packer *p)
{
    const bool is_color = p->what->buffer == SVO_COMPACT_COLORS;
    const uint32_t components = is_color ? 4 : p->channels;
    uint64_t sum = 0;
    uint32_t largest = 0;
    for (uint64_t i = 0; i < p->what->count; ++i) {
        uint32_t shown[CHANNELS];
        if (is_color) {
            const uint32_t color = svo_packed_color(p->words, (uint32_t)i);
            for (uint32_t c = 0; c < components; ++c) {
                shown[c] = color >> 8 * c & 255;
            }
        } else if (p->what->buffer == SVO_COMPACT_NORMALS) {
            svo_packed_normal(p->words, (uint32_t)i, shown);
        } else {
            svo_packed_coded(p->words, (uint32_t)i, shown);
        }
        for (uint32_t c = 0; c < components; ++c) {
            const uint32_t flip = p->what->buffer == SVO_COMPACT_NORMALS ? 0x8000 : 0;
            const uint32_t off = distance(shown[c] ^ flip, component(p, i, c));
            largest = off > largest ? off : largest;
            sum += off;
        }
    }
    p->words[4] = largest;
    p->words[5] = (uint32_t)sum;
    p->words[6] = (uint32_t)(sum >> 32);
}

/* ---- all of it ---- */

static svo_status pack(packer *p)
{
    const uint64_t count = p->what->count;
    const uint64_t units = (count + SVO_PACKED_UNIT - 1) / SVO_PACKED_UNIT;
    describe(p);
    SVO_I_TRY(reserve_words(p, SVO_PACKED_HEAD_WORDS + 2 * (size_t)units));
    p->word_count = SVO_PACKED_HEAD_WORDS + 2 * (size_t)units;
    p->words[0] = p->head;
    p->words[1] = (uint32_t)count;
    p->words[2] = step_of(p, 0);
    p->words[3] = p->alpha;
    for (uint64_t unit = 0; unit < units; ++unit) {
        const uint64_t begin = unit * SVO_PACKED_UNIT;
        p->unit_count = (uint32_t)(count - begin < SVO_PACKED_UNIT ? count - begin : SVO_PACKED_UNIT);
        for (uint32_t i = 0; i < p->unit_count; ++i) {
            load_element(p, begin + i, i);
        }
        SVO_I_TRY(put_unit(p, (uint32_t)unit));
    }
    p->words[7] = (uint32_t)p->word_count;
    if (is_lossy(p) || p->what->normal_bits > 0) {
        measure(p);
    }
    return SVO_OK;
}

svo_status svo_i_pack_payload(const char *function, const svo_i_packing *what, const svo_i_memory *memory,
                              uint32_t **words, svo_message *message)
{
    packer *p = svo_i_alloc_zeroed(memory, 1, sizeof *p);
    *words = NULL;
    if (p == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: packing needs %zu bytes", function, sizeof *p);
    }
    p->what = what;
    p->memory = memory;
    p->function = function;
    p->message = message;
    const svo_status status = pack(p);
    *words = p->words;
    svo_i_free(p);
    return status;
}
