/* SPDX-License-Identifier: MIT */
/*
 * Random (triangle, voxel) records for the overlap test, as the library would make them: snapped triangles, the corner
 * of their first voxel taken off, axes turned. Hard cases are made on purpose, by kind.
 */
#ifndef SVOCL_TESTS_AGREE_SAMPLE_H
#define SVOCL_TESTS_AGREE_SAMPLE_H

#include "oracle.h"
#include "probe.h"

/* Which arithmetic the records are for; each has the coordinates that kernels/overlap.clh allows for it. */
typedef enum sample_width { SAMPLE_NARROW, SAMPLE_REGULAR, SAMPLE_WIDE } sample_width;

typedef enum sample_kind {
    SAMPLE_SMALL, /* a few voxels */
    SAMPLE_LARGE,
    SAMPLE_SLIVER, /* needles, down to a unit across */
    SAMPLE_SEGMENT, /* all corners on a line */
    SAMPLE_POINT,
    SAMPLE_FACE, /* in the plane of a voxel's face */
    SAMPLE_LATTICE, /* corners of voxels */
    SAMPLE_EXTREME, /* coordinates at the ends of their range, and beside voxel boundaries there */
    SAMPLE_KINDS
} sample_kind;
const char *sample_kind_name(sample_kind kind);

typedef struct sample {
    sample_kind kind;
    probe_input record;
    /* The same for the oracle: the record's (u, v, t) are its (x, y, z), for thin coverage after turning them back. */
    oracle_triangle triangle;
    oracle_box box;
    oracle_coverage coverage;
    bool axis_is_longest; /* t is the axis that the library would choose, which spans ask for */
} sample;

/* Record number index of the sequence that seed starts: half-open and closed ones, or thin ones. */
void sample_make(sample_width width, uint64_t seed, uint32_t index, sample *out);
void sample_make_thin(sample_width width, uint64_t seed, uint32_t index, sample *out);

/* SplitMix64 (Steele, Lea and Flood 2014). */
uint64_t sample_random(uint64_t *state);

#endif
