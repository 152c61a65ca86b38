/* SPDX-License-Identifier: MIT */
/* Placements of trees: what people write in place of a 3 x 4 matrix. */
#ifndef SVOCL_TOOLS_SUPPORT_SCENE_PLACE_H
#define SVOCL_TOOLS_SUPPORT_SCENE_PLACE_H

#include <stdbool.h>

/* A placement: scaled, then turned about x, y and z in degrees, then moved. */
typedef struct scene_place {
    float translate[3], rotate[3], scale[3];
} scene_place;

/* The matrix of a placement, row by row, as svo_instance has it. */
void scene_place_compose(const scene_place *place, float transform[12]);

/* Whether a matrix is flat, or so nearly flat that scenes refuse it (SVO_SCENE_DETERMINANT_MIN). */
bool scene_place_is_flat(const float transform[12]);

/* The placement of a matrix, where it has one: false if it shears. Angles and scales are rounded where that leaves the
   matrix the same bit for bit; otherwise the placement's matrix may differ from it by rounding. A matrix that mirrors
   has a negative scale of z. */
bool scene_place_find(const float transform[12], scene_place *out);

/* Whether composing the placement gives exactly this matrix. */
bool scene_place_is_exact(const scene_place *place, const float transform[12]);

#endif
