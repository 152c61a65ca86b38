/* SPDX-License-Identifier: MIT */
/*
 * Payload arrays to packed ones, in units of 256 elements. Of each unit the eighths, quarters and halves that make
 * blocks are found from the smallest ones up: two neighbors become one block where that costs no more. Integers alone
 * decide, so the words are the same on every machine.
 */
#include "compact/packing.h"

#include <string.h>

#include "compact/packing_blocks.h"

#define HEADER_BITS 32u
/* Blocks of a unit of 8, 16, ... 256 elements. */
#define LEAST_BLOCKS (SVO_PACKED_UNIT >> SVO_PACKED_LEAST_LOG2)
#define BLOCKS       (2 * LEAST_BLOCKS - 1)
/* Words of a unit's blocks at most: one block of raw elements of 48 bits has fewer. */
#define UNIT_WORDS_MAX (LEAST_BLOCKS + (1u << SVO_PACKED_OFFSET_BITS) / 32u + 2u)

typedef struct packer {
    const svo_i_packing *what;
    const svo_i_memory *memory;
    const char *function;
    svo_message *message;
    uint32_t head; /* word 0 */
    svo_i_coder coder;
    uint32_t alpha; /* of colors with three channels */
    uint32_t *words;
    size_t word_count, word_capacity;
    svo_i_coded unit[SVO_PACKED_UNIT]; /* as coded */
    uint32_t unit_count; /* of these; fewer at the end */
    svo_i_coding blocks[BLOCKS]; /* those of 8 elements, then those of 16, ... */
} packer;

/* ---- blocks ---- */

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
            svo_i_coding *own = &p->blocks[row + i];
            best[row + i] = 0;
            own->bits = SVO_I_NOT_CODED;
            if (left == 0) {
                continue;
            }
            svo_i_code_block(&p->coder, (const svo_i_coded *)p->unit + begin, left < 1u << log2 ? left : 1u << log2,
                             own);
            best[row + i] = own->cost + (uint64_t)HEADER_BITS * svo_i_coding_bit(&p->coder);
            if (log2 > SVO_PACKED_LEAST_LOG2) {
                const uint32_t below = row_of(log2 - 1) + 2 * i;
                const uint64_t halves = best[below] + best[below + 1];
                if (halves < best[row + i]) {
                    best[row + i] = halves;
                    own->bits = SVO_I_NOT_CODED;
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
    for (uint32_t c = 0; c < p->coder.channels; ++c) {
        put_bits(data, bit, color[c], p->coder.channel_bits);
    }
}

/* The level of a channel of a value. */
static uint32_t level_of(const packer *p, const svo_i_coding *made, const uint16_t *value, uint32_t channel)
{
    int32_t green[SVO_I_CODED_CHANNELS];
    if (made->mode == SVO_PACKED_GREEN) {
        svo_i_coding_green(value, green);
        return (uint32_t)(green[channel] - made->first[channel]) & 255;
    }
    return ((uint32_t)value[channel] + p->coder.error[channel] - made->first[channel]) /
           svo_i_coding_step(&p->coder, channel);
}

static void put_levels(const packer *p, const svo_i_coding *made, uint32_t *data, uint32_t *bit, const uint16_t *value)
{
    uint32_t code = 0;
    uint32_t scale = 1;
    for (uint32_t c = 0; c < p->coder.channels; ++c) {
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

static void put_block(const packer *p, const svo_i_coding *made, const svo_i_coded *values, uint32_t count,
                      uint32_t *data, uint32_t *bit)
{
    const bool by_levels = made->mode <= SVO_PACKED_DELTA;
    for (uint32_t c = 0; made->mode <= SVO_PACKED_GREEN && c < p->coder.channels; ++c) {
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
static uint32_t list_blocks(const packer *p, uint32_t log2, uint32_t index, const svo_i_coding **out, uint32_t *begins)
{
    const svo_i_coding *own = &p->blocks[row_of(log2) + index];
    if (index << log2 >= p->unit_count) {
        return 0;
    }
    if (own->bits != SVO_I_NOT_CODED) {
        out[0] = own;
        begins[0] = index << log2;
        return 1;
    }
    const uint32_t first = list_blocks(p, log2 - 1, 2 * index, out, begins);
    return first + list_blocks(p, log2 - 1, 2 * index + 1, out + first, begins + first);
}

static svo_status put_unit(packer *p, uint32_t unit_index)
{
    const svo_i_coding *list[LEAST_BLOCKS];
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
        put_block(p, list[k], (const svo_i_coded *)p->unit + begins[k], begins[k + 1] - begins[k], headers + count,
                  &bit);
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
    if (p->coder.channel_bits == 16) {
        for (int axis = 0; axis < 3; ++axis) {
            out[axis] = (uint16_t)((uint16_t)normal[axis] ^ 0x8000u);
        }
    } else if (previous != NULL && memcmp(normal, previous, 3 * sizeof *normal) == 0) {
        memcpy(out, known, sizeof(svo_i_coded)); /* flat surfaces */
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
        for (uint32_t c = 0; c < p->coder.channels; ++c) {
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
    p->coder.channel_bits = what->buffer == SVO_COMPACT_COLORS || octahedral ? 8 : 16;
    p->coder.channels = what->buffer == SVO_COMPACT_NORMALS ? 3 : 1;
    if (what->buffer == SVO_COMPACT_COLORS) {
        p->coder.channels = find_alpha(what, &p->alpha) ? 3 : 4;
    }
    p->coder.has_green = what->buffer == SVO_COMPACT_COLORS;
    p->coder.most = (1u << p->coder.channel_bits) - 1;
    for (uint32_t c = 0; c < 3; ++c) {
        p->coder.error[c] = what->error;
    }
    p->head = SVO_PACKED_VERSION | p->coder.channels << 8 | p->coder.channel_bits << 11 |
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
    const uint32_t components = is_color ? 4 : p->coder.channels;
    uint64_t sum = 0;
    uint32_t largest = 0;
    for (uint64_t i = 0; i < p->what->count; ++i) {
        uint32_t shown[SVO_I_CODED_CHANNELS];
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
            const uint32_t off = svo_i_coding_distance(shown[c] ^ flip, component(p, i, c));
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
    p->words[2] = svo_i_coding_step(&p->coder, 0);
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
    if (p->coder.error[0] > 0 || p->what->normal_bits > 0) {
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
