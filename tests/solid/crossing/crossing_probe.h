/* SPDX-License-Identifier: MIT */
/* kernels/solid/crossing.clh in C, as it is and with planted mistakes: crossing_probe.c. */
#ifndef SVOCL_TESTS_AGREE_CROSSING_CROSSING_PROBE_H
#define SVOCL_TESTS_AGREE_CROSSING_CROSSING_PROBE_H

#include <stdbool.h>
#include <stdint.h>

/* A triangle as it was given, and a voxel of the grid. */
typedef struct crossing_pair {
    double vertices[9];
    double origin[3], edge;
    uint32_t depth;
    uint32_t cell[3];
} crossing_pair;

/* In place of a sense. */
#define CROSSING_UNDECIDED 2

typedef struct crossing_functions {
    /* svo_cross_snapped: the sense in which a line along an axis crosses a triangle (x, y, z of its corners, and by
       what they may be off along these axes) from low to below high; 0: not. */
    int (*snapped)(const int32_t *corners, const int32_t *errors, uint32_t axis, const int32_t point[2], int32_t low,
                   int32_t high);
    /* svo_cross_near: what doubles say of the following. */
    int (*near)(const crossing_pair *pair, uint32_t axis, bool upper);
    /* svo_cross_exactly: the same of the line through the voxel's center, inside the voxel, or from its center on. */
    int (*exact)(const crossing_pair *pair, uint32_t axis, bool upper);
} crossing_functions;

extern const crossing_functions crossing_sound;
/* Mistakes that snapped triangles show, */
extern const crossing_functions crossing_tie, crossing_both, crossing_none, crossing_far, crossing_turned,
    crossing_passing;
/* where snapping or doubles are said to decide, */
extern const crossing_functions crossing_sure_edge, crossing_half_edge, crossing_sure_height;
extern const crossing_functions crossing_near_side, crossing_near_height;
/* and that exact ones show. */
extern const crossing_functions crossing_exact_tie, crossing_exact_far, crossing_exact_height;

/* Snaps the pair's triangle on its grid of 2^snap_bits units; errors as above. */
void crossing_snap(const crossing_pair *pair, int snap_bits, int32_t corners[9], int32_t errors[3]);

/* The sign of a dot product whose terms take up to 78 bits. */
int crossing_sign(const int64_t a[3], const int32_t b[3]);

#endif
