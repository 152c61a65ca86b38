/* SPDX-License-Identifier: MIT */
/* Tables of the codes of distances, for kernels/probes. */
#ifndef SVO_LIB_PROBES_ENCODING_H
#define SVO_LIB_PROBES_ENCODING_H

#include <stdint.h>

/* Entries of a table: one for each code. */
#define SVO_I_PROBE_CODES 65535u

/* d^2 from which on a distance d, world units, has each code: the bits of a double. The same on every host. */
void svo_i_probe_thresholds(float farthest, float leaf_edge, uint64_t thresholds[SVO_I_PROBE_CODES]);
/* The distance of each code, in 1 / SVO_PROBE_LENGTH_UNIT leaf edges. */
void svo_i_probe_lengths(float farthest, float leaf_edge, uint32_t lengths[SVO_I_PROBE_CODES]);

/* The direction of a texel's center in whole numbers, |x| + |y| + |z| = resolution. */
void svo_i_probe_texel_vector(uint32_t resolution, uint32_t column, uint32_t row, int32_t vector[3]);

/* C F + 1, of whose powers the tables are made. */
static inline double svo_i_probe_growth(float farthest, float leaf_edge)
{
    return (double)farthest / (double)leaf_edge + 1;
}

#endif
