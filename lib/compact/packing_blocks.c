/* SPDX-License-Identifier: MIT */
/* The modes of blocks, and how each is fitted. */
#include "compact/packing_blocks.h"

#include <string.h>

/* What a difference of one step costs, in bits. Levels of step s have a mean error near s / 4 and take log2(range / s)
   bits, so that there a difference of s is worth 4 / ln 2 = 5.8 bits. Somewhat more, with a larger step, takes fewer
   bits at the same mean error. */
#define STEP_BITS 8u

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

static bool is_lossy(const svo_i_coder *p)
{
    return p->error[0] > 0;
}

/* The levels of a range of values, and the value of the first: errors are centered. */
static uint32_t count_levels(const svo_i_coder *p, uint32_t channel, uint32_t low, uint32_t high, uint16_t *first)
{
    const uint32_t step = svo_i_coding_step(p, channel);
    const uint32_t levels = (high - low + step) / step;
    const uint32_t slack = levels * step - (high - low + 1);
    *first = (uint16_t)(low + p->error[channel] - slack / 2);
    return levels;
}

/* ---- costs ---- */

/* What a channel of an element becomes. */
static uint32_t decoded(const svo_i_coder *p, const svo_i_coding *made, const svo_i_coded *values, uint32_t i,
                        uint32_t channel)
{
    const uint32_t step = svo_i_coding_step(p, channel);
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

static void keep_better(svo_i_coder *p, const svo_i_coded *values, uint32_t count, svo_i_coding *best)
{
    uint64_t differences = 0;
    for (uint32_t i = 0; i < count && is_lossy(p); ++i) {
        for (uint32_t c = 0; c < p->channels; ++c) {
            differences += svo_i_coding_distance(decoded(p, &p->tried, values, i, c), values[i][c]);
        }
    }
    p->tried.cost = (uint64_t)p->tried.bits * svo_i_coding_bit(p) + STEP_BITS * differences;
    if (p->tried.cost < best->cost) {
        *best = p->tried;
    }
}

static void find_range(const svo_i_coder *p, const svo_i_coded *values, uint32_t count, svo_i_coded low,
                       svo_i_coded high)
{
    memcpy(low, values[0], sizeof(svo_i_coded));
    memcpy(high, values[0], sizeof(svo_i_coded));
    for (uint32_t i = 1; i < count; ++i) {
        for (uint32_t c = 0; c < p->channels; ++c) {
            low[c] = values[i][c] < low[c] ? values[i][c] : low[c];
            high[c] = values[i][c] > high[c] ? values[i][c] : high[c];
        }
    }
}

/* ---- least and levels: radix, green, delta ---- */

static void set_radix(svo_i_coder *p, uint32_t mode, uint32_t count)
{
    svo_i_coding *made = &p->tried;
    uint64_t product = 1;
    for (uint32_t c = 0; c < p->channels; ++c) {
        product *= made->levels[c];
    }
    made->mode = mode;
    made->what = bits_below(product);
    made->bits = 16 * p->channels + count * made->what;
}

static void fit_levels(svo_i_coder *p, const svo_i_coded low, const svo_i_coded high, uint32_t count)
{
    svo_i_coding *made = &p->tried;
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

static bool fit_green(svo_i_coder *p, const svo_i_coded *values, uint32_t count)
{
    svo_i_coding *made = &p->tried;
    int32_t low[SVO_I_CODED_CHANNELS];
    int32_t high[SVO_I_CODED_CHANNELS];
    svo_i_coding_green(values[0], low);
    memcpy(high, low, sizeof high);
    for (uint32_t i = 1; i < count; ++i) {
        int32_t value[SVO_I_CODED_CHANNELS];
        svo_i_coding_green(values[i], value);
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
    svo_i_coded low, high;
} box;

/* Takes a value into a box unless that would get wider than so many errors; a color in its middle may stand for two. */
static bool widen(const svo_i_coder *p, const uint16_t *value, uint32_t errors, box *of)
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
static void choose_nearest(const svo_i_coder *p, const svo_i_coded *values, uint32_t count, uint32_t colors,
                           svo_i_coding *made)
{
    for (uint32_t i = 0; i < count; ++i) {
        uint64_t least = UINT64_MAX;
        for (uint32_t k = 0; k < colors; ++k) {
            uint64_t off = 0;
            bool fits = true;
            for (uint32_t c = 0; fits && c < p->channels; ++c) {
                const uint32_t difference = svo_i_coding_distance(values[i][c], made->palette[k][c]);
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
static void center_colors(const svo_i_coder *p, const svo_i_coded *values, uint32_t count, uint32_t colors,
                          svo_i_coding *made)
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
static bool fit_palette(svo_i_coder *p, const svo_i_coded *values, uint32_t count, uint32_t errors, uint32_t bits_max)
{
    svo_i_coding *made = &p->tried;
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
            memcpy(boxes[colors].low, values[i], sizeof(svo_i_coded));
            memcpy(boxes[colors++].high, values[i], sizeof(svo_i_coded));
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
static bool fit_ends(svo_i_coder *p, const svo_i_coded *values, uint32_t count, const svo_i_coded low,
                     const svo_i_coded high, uint32_t *main_channel)
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
static uint32_t find_weight(const svo_i_coder *p, const uint16_t *value, uint32_t main, uint32_t most)
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
            const uint32_t off = svo_i_coding_distance(mixed, value[c]);
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

static bool fit_weights(svo_i_coder *p, const svo_i_coded *values, uint32_t count, uint32_t main, uint32_t width)
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
static bool refine_line(svo_i_coder *p, const svo_i_coded *values, uint32_t count, uint32_t main, uint32_t width)
{
    svo_i_coding *made = &p->tried;
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
static void fit_line(svo_i_coder *p, const svo_i_coded *values, uint32_t count, uint32_t main, svo_i_coding *best)
{
    const svo_i_coding ends = p->tried;
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

/* ---- all of them ---- */

void svo_i_code_block(svo_i_coder *p, const svo_i_coded *values, uint32_t count, svo_i_coding *best)
{
    svo_i_coded low;
    svo_i_coded high;
    uint32_t main = 0;
    best->cost = UINT64_MAX;
    find_range(p, values, count, low, high);
    fit_levels(p, low, high, count);
    keep_better(p, values, count, best);
    if (p->has_green && fit_green(p, values, count)) {
        keep_better(p, values, count, best);
    }
    for (uint32_t errors = is_lossy(p) ? 1 : 2; errors <= 2; ++errors) {
        if (fit_palette(p, values, count, errors, (uint32_t)(best->cost / svo_i_coding_bit(p)) + 1)) {
            keep_better(p, values, count, best);
        }
    }
    if (is_lossy(p) && best->bits > 2 * p->channels * p->channel_bits + count &&
        fit_ends(p, values, count, low, high, &main)) {
        fit_line(p, values, count, main, best);
    }
}
