/* SPDX-License-Identifier: MIT */
/* Pictures of numbers, distances or steps: their range is that of what is in view, and a bar in them says it. */
#ifndef SVOCL_TOOLS_SUPPORT_VALUE_SCALE_H
#define SVOCL_TOOLS_SUPPORT_VALUE_SCALE_H

#include "support/json.h"
#include "svocl/trace.h"

/* What the ends of the bar stand for: world units or steps. */
typedef struct value_scale {
    bool is_shown; /* a picture has numbers, and something was in view */
    double low, high;
    const char *unit;
} value_scale;

/* Whether a picture of that view has numbers. */
bool value_scale_suits(svo_render_view view);

/*
 * Turns the numbers of a picture, floats as SVO_PIXELS_LINEAR has them, into bytes: RGBA as output says, in the range
 * of what is in view, with a bar where it has room. scale: of the frames of a film the first one's range holds for all.
 */
void value_scale_color(const svo_render_options *asked, const svo_picture_output *output, const float *numbers,
                       uint8_t *rgba, value_scale *scale);

/* Adds "range" and "range_unit" where the picture has numbers. */
void value_scale_report(cJSON *document, const value_scale *scale);

#endif
