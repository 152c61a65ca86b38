/* SPDX-License-Identifier: MIT */
/* Packed payload on the host: heads, checks and elements. lib/compact/packing.c makes it. */
#include "core/packed.h"

#include <inttypes.h>
#include <string.h>

#include "shared/packed.clh"
#include "svocl/plan.h"

uint64_t svo_i_packed_bytes(const uint32_t *words)
{
    return (uint64_t)words[7] * sizeof *words;
}

void svo_i_packed_errors(const uint32_t *words, svo_compact_buffer buffer, svo_compact_info *info)
{
    const int k = (int)buffer - (int)SVO_I_PAYLOAD_FIRST;
    const uint64_t components = svo_packed_channels(words[0]) < 3 ? 1 : 3; /* not alpha */
    const uint64_t sum = (uint64_t)words[6] << 32 | words[5];
    info->largest_error[k] = words[4];
    if (buffer == SVO_COMPACT_NORMALS) {
        const uint32_t half = words[0] >> 24;
        info->normal_bits = half > 0 ? svo_packed_highest_bit(half + 1) + 1 : 0;
    }
    info->mean_error[k] = words[1] > 0 ? (double)sum / (double)((uint64_t)words[1] * components) : 0.0;
}

bool svo_i_packed_is_opaque(const uint32_t words[SVO_I_PACKED_ALPHA_WORDS])
{
    return svo_packed_channels(words[0]) == 3 && words[3] == 255;
}

void svo_i_packed_read(const uint32_t *words, svo_compact_buffer buffer, uint64_t first, uint64_t count, void *out)
{
    const uint32_t halves = buffer == SVO_COMPACT_COLORS ? 2 : buffer == SVO_COMPACT_NORMALS ? 3 : 1;
    uint16_t *to = out;
    for (uint64_t i = 0; i < count; ++i) {
        uint32_t element[4];
        svo_packed_halves(words, (uint32_t)(first + i), halves, element);
        for (uint32_t k = 0; k < halves; ++k) {
            *to++ = (uint16_t)element[k];
        }
    }
}

/* ---- checks ---- */

typedef struct packed_check {
    const uint32_t *words;
    uint64_t byte_count, word_count;
    uint64_t element_count;
    svo_compact_buffer buffer;
    const char *name;
    svo_message *message;
} packed_check;

static svo_status damaged(const packed_check *c, uint64_t at, const char *what)
{
    return svo_i_fail(c->message, SVO_FILE_DAMAGED, "%s: packed %s, word %" PRIu64 ": %s", c->name,
                      svo_name(SVO_NAME_COMPACT_BUFFER, c->buffer), at, what);
}

/* Whether an array may have such channels. */
static bool fits_buffer(const packed_check *c)
{
    const uint32_t head = c->words[0];
    const uint32_t channels = svo_packed_channels(head);
    const uint32_t bits = svo_packed_channel_bits(head);
    const uint32_t kind = head >> 16 & 0xff;
    const uint32_t most = head >> 24;
    if (kind == SVO_PACKED_OCTAHEDRAL) {
        return c->buffer == SVO_COMPACT_NORMALS && channels == 3 && bits == 8 && most >= 7 && most <= 127 &&
               (most & (most + 1)) == 0 && c->words[2] == 1;
    }
    if (kind != SVO_PACKED_PLAIN || most != 0) {
        return false;
    }
    if (c->buffer == SVO_COMPACT_COLORS) {
        return bits == 8 && (channels == 4 ? c->words[3] == 0 : channels == 3 && c->words[3] <= 255);
    }
    return bits == 16 && channels == (c->buffer == SVO_COMPACT_NORMALS ? 3u : 1u) &&
           (c->words[2] == 1 || c->buffer == SVO_COMPACT_FILLS);
}

static svo_status check_head(const packed_check *c)
{
    if (c->word_count < SVO_PACKED_HEAD_WORDS || c->byte_count % sizeof(uint32_t) != 0) {
        return damaged(c, c->word_count, "the head is cut off");
    }
    const uint32_t *words = c->words;
    if ((words[0] & 0xff) != SVO_PACKED_VERSION || words[2] % 2 == 0 || words[2] > 2 * 65535 + 1 || !fits_buffer(c)) {
        return damaged(c, 0, "the kind is not known");
    }
    if (c->buffer != SVO_COMPACT_COLORS && words[3] != 0) {
        return damaged(c, 3, "an alpha is not of colors");
    }
    if (words[1] != c->element_count || words[7] != c->word_count) {
        return damaged(c, words[1] != c->element_count ? 1 : 7, "this many are not there");
    }
    const uint64_t sum = (uint64_t)words[6] << 32 | words[5];
    return words[4] <= 65535 && sum <= (uint64_t)words[4] * words[1] * 4 ? SVO_OK : damaged(c, 4, "errors disagree");
}

/* Whether a block's mode and what it says are possible. */
static bool is_known(uint32_t head, uint32_t header)
{
    const uint32_t what = header >> SVO_PACKED_WHAT_SHIFT;
    const uint32_t channels = svo_packed_channels(head);
    const bool bytes = svo_packed_channel_bits(head) == 8;
    switch (svo_packed_mode(header)) {
    case SVO_PACKED_GREEN:
        return bytes && (head >> 16 & 0xff) == SVO_PACKED_PLAIN && what <= 32;
    case SVO_PACKED_RADIX:
        return bytes && what <= 32;
    case SVO_PACKED_DELTA:
        return !bytes && what >> 5 * channels == 0 && (what & 31) <= 16 && (what >> 5 & 31) <= 16 && what >> 10 <= 16;
    case SVO_PACKED_PALETTE:
        return (what & 7) <= 6 && what >> 9 == 0 && what >> 3 < 1u << (what & 7);
    case SVO_PACKED_LINE:
        return what >= 1 && what <= SVO_PACKED_WEIGHT_MAX;
    default:
        return false;
    }
}

/* Checks the blocks of an entry of the directory, which begin at word *end, and sets that to what follows. */
static svo_status check_unit(const packed_check *c, uint64_t unit, uint64_t *end)
{
    const uint64_t entry = SVO_PACKED_HEAD_WORDS + 2 * unit;
    const uint64_t left = c->element_count - unit * SVO_PACKED_UNIT;
    const uint32_t elements = left < SVO_PACKED_UNIT ? (uint32_t)left : SVO_PACKED_UNIT;
    const uint32_t starts = c->words[entry];
    const uint32_t blocks = svo_count_bits(starts);
    uint64_t header = *end;
    uint64_t bit = 0;
    if ((starts & 1) == 0 || svo_packed_highest_bit(starts) << SVO_PACKED_LEAST_LOG2 >= elements) {
        return damaged(c, entry, "blocks do not begin at its elements");
    }
    if (c->words[entry + 1] != *end || *end + blocks > c->word_count) {
        return damaged(c, entry + 1, "headers are elsewhere");
    }
    for (uint32_t at = 0; at < SVO_PACKED_UNIT >> SVO_PACKED_LEAST_LOG2; ++at) {
        const uint32_t later = at < 31 ? starts >> (at + 1) << (at + 1) : 0;
        if ((starts >> at & 1) == 0) {
            continue;
        }
        const uint32_t next = svo_packed_highest_bit(later & (0u - later)) << SVO_PACKED_LEAST_LOG2;
        const uint32_t count = (later != 0 ? next : elements) - (at << SVO_PACKED_LEAST_LOG2);
        const uint32_t word = c->words[header];
        if (!is_known(c->words[0], word) || (word & ((1u << SVO_PACKED_OFFSET_BITS) - 1)) != bit) {
            return damaged(c, header, "no block begins so");
        }
        bit += svo_packed_begin_bits(c->words[0], word) + (uint64_t)count * svo_packed_element_bits(word);
        ++header;
    }
    *end += blocks + (bit + 31) / 32;
    return *end <= c->word_count ? SVO_OK : damaged(c, entry, "data is cut off");
}

svo_status svo_i_packed_check(const svo_compact *compact, svo_compact_buffer buffer, const char *name,
                              svo_message *message)
{
    const packed_check c = {.words = compact->host[buffer],
                            .byte_count = compact->info.bytes[buffer],
                            .word_count = compact->info.bytes[buffer] / sizeof(uint32_t),
                            .element_count = compact->info.payload_count,
                            .buffer = buffer,
                            .name = name,
                            .message = message};
    SVO_I_TRY(check_head(&c));
    const uint64_t units = (c.element_count + SVO_PACKED_UNIT - 1) / SVO_PACKED_UNIT;
    uint64_t end = SVO_PACKED_HEAD_WORDS + 2 * units;
    if (end > c.word_count) {
        return damaged(&c, c.word_count, "the directory is cut off");
    }
    for (uint64_t unit = 0; unit < units; ++unit) {
        SVO_I_TRY(check_unit(&c, unit, &end));
    }
    return end == c.word_count ? SVO_OK : damaged(&c, end, "nothing should follow");
}
