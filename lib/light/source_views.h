/* SPDX-License-Identifier: MIT */
/* What a light source sees, as pixels: one photon goes through each. Pure arithmetic; photons.c shoots. */
#ifndef SVO_LIB_LIGHT_SOURCE_VIEWS_H
#define SVO_LIB_LIGHT_SOURCE_VIEWS_H

#include <stdbool.h>
#include <stdint.h>

#include "shared/light_layout.h"
#include "svocl/light_types.h"

#define SVO_I_VIEW_PIXELS_MAX  16384u /* along a side */
#define SVO_I_VIEWS_OF_ONE_MAX 6u /* a point source sees a cube's faces */

/* What sources shine on. */
typedef struct svo_i_lit_box {
    double low[3], high[3]; /* world: bounds of the leaves */
    double leaf_edge;
} svo_i_lit_box;

/* A rectangle of pixels. */
typedef struct svo_i_light_view {
    svo_light_view_params params; /* but for first, count and flux */
    uint32_t photon_count; /* of whole tiles */
    double middle[2]; /* of a point source: x and y at the rectangle's middle, where the depth is 1 */
    double half[2]; /* half a pixel */
    bool has_axis, is_disk; /* of a spot or a disk; of a disk */
    double axis[3]; /* of these, on the view's right, up and forward */
    double inner_cosine, outer_cosine;
    double pixel; /* area of a pixel; of a point source where the depth is 1 */
} svo_i_light_view;

/* Whether its value is 0: no photon is shot. */
bool svo_i_source_is_dark(const svo_light_source *source);

/* A direction without length is refused before. resolution: pixels along the longer side; 0: so many that a leaf that
   faces the light gets four photons, even at the far end of the box. Returns the number of views; those that would not
   see the box are left out. */
uint32_t svo_i_light_views(const svo_light_source *source, const svo_i_lit_box *box, uint32_t resolution,
                           svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX]);

/* The weights of photons first .. first + count - 1, by + - * / and square root alone: the same on every machine.
   Returns how many are not 0. */
uint32_t svo_i_view_weights(const svo_i_light_view *view, uint32_t first, uint32_t count, svo_photon_weight *weights);

/* At most so much solid angle, or for parallel light area, do the photons of a view have together. */
static inline double svo_i_view_measure(const svo_i_light_view *view)
{
    return view->pixel * view->params.columns * view->params.rows;
}

/* The cosine of an angle in 0 .. pi / 2, by + and * alone. */
double svo_i_plain_cosine(double angle);

#endif
