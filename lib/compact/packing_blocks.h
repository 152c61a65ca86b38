/* SPDX-License-Identifier: MIT */
/*
 * How blocks of packed payload are coded: of all modes, the one of the least cost among those that keep within the
 * error. The cost is the bits and, where elements may change, what they differ by, with a Lagrangian multiplier
 * (Sullivan and Wiegand, "Rate-Distortion Optimization for Video Compression", 1998).
 */
#ifndef SVO_LIB_COMPACT_PACKING_BLOCKS_H
#define SVO_LIB_COMPACT_PACKING_BLOCKS_H

#include <stdbool.h>
#include <stdint.h>

#include "core/compact.h"
#include "shared/packed.clh"

#define SVO_I_CODED_CHANNELS 4
#define SVO_I_NOT_CODED      UINT32_MAX

/* An element as it is coded. */
typedef uint16_t svo_i_coded[SVO_I_CODED_CHANNELS];

/* How a block is coded. */
typedef struct svo_i_coding {
    uint32_t bits; /* of the data; SVO_I_NOT_CODED */
    uint64_t cost; /* in units of svo_i_coding_bit */
    uint32_t mode, what; /* of the header */
    uint32_t levels[SVO_I_CODED_CHANNELS]; /* of radix, green and delta */
    svo_i_coded first, second; /* least; of a line the ends */
    svo_i_coded palette[SVO_PACKED_COLORS_MAX];
    uint8_t index[SVO_PACKED_UNIT]; /* of palettes and lines: per element */
} svo_i_coding;

/* What is known of all blocks of an array. */
typedef struct svo_i_coder {
    uint32_t channels, channel_bits, most; /* most: the greatest of a channel */
    uint32_t error[SVO_I_CODED_CHANNELS]; /* as coded */
    bool has_green; /* red and blue may be coded less green */
    svo_i_coding tried;
} svo_i_coder;

static inline uint32_t svo_i_coding_distance(uint32_t a, uint32_t b)
{
    return a > b ? a - b : b - a;
}

static inline uint32_t svo_i_coding_step(const svo_i_coder *p, uint32_t channel)
{
    return 2 * p->error[channel] + 1;
}

/* The unit of costs: one bit is so many. */
static inline uint32_t svo_i_coding_bit(const svo_i_coder *p)
{
    return svo_i_coding_step(p, 0);
}

/* Red and blue less green, alpha and green. */
static inline void svo_i_coding_green(const uint16_t *value, int32_t out[SVO_I_CODED_CHANNELS])
{
    out[0] = value[1];
    out[1] = (int32_t)value[0] - value[1];
    out[2] = (int32_t)value[2] - value[1];
    out[3] = value[3];
}

/* The best coding of some values, at most SVO_PACKED_UNIT. */
void svo_i_code_block(svo_i_coder *p, const svo_i_coded *values, uint32_t count, svo_i_coding *best);

#endif
