/* SPDX-License-Identifier: MIT */
/*
 * Opacity on dense grids, for comparison with what the light of a tree stores and with what cones read from it. Call
 * inside a running cmocka test; the test fails when memory runs out.
 */
#ifndef SVOCL_TESTS_LIGHT_REFERENCE_H
#define SVOCL_TESTS_LIGHT_REFERENCE_H

#include <stdbool.h>
#include <stdint.h>

#include "svocl/light.h"

#define LIGHT_DEPTH_MAX 7

/* All levels of a grid. cells[l]: 8^l cells, x + y * 2^l + z * 4^l, with count values each. Bricks: cells[l] are the
   points of the lattice, (2^l + 1) along each axis, for l above 0. */
typedef struct light_levels {
    svo_light_form form;
    uint32_t depth;
    uint32_t count; /* values of a cell: 6 of faces, else 1 */
    const struct light_levels *opacity; /* of radiance of faces; NULL: this is opacity */
    bool whole; /* values are rounded to whole numbers */
    double *cells[LIGHT_DEPTH_MAX + 1];
} light_levels;

/* Filters the opacities of the leaves upwards. leaves: 8^depth cells with six values each, 65535 = 1; forms without
   direction take the largest. Faces keep opacities, no extinctions. */
void light_levels_make(svo_light_form form, uint32_t depth, const uint16_t *leaves, light_levels *out);
/* Filters premultiplied radiance of one channel, six values for each leaf; forms without direction take the first. */
void light_levels_make_light(const light_levels *opacity, const double *leaves, light_levels *out);
void light_levels_free(light_levels *levels);

/* Along an axis of a level: cells or points. */
uint32_t light_levels_width(const light_levels *levels, uint32_t level);
/* A value of a cell or point; 0 outside. */
double light_levels_get(const light_levels *levels, uint32_t level, const int at[3], uint32_t value);

#endif
