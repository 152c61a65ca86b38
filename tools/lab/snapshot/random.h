/* SPDX-License-Identifier: MIT */
/* Numbers that are the same everywhere. */
#ifndef SVOCL_TOOLS_SNAPSHOT_RANDOM_H
#define SVOCL_TOOLS_SNAPSHOT_RANDOM_H

#include <stdint.h>

/* Numbers in [0, 1) with 24 bits, by a 64-bit linear congruential generator (Knuth, MMIX). */
static inline float next_random(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (float)(*state >> 40) * 0x1p-24f;
}

#endif
