/* SPDX-License-Identifier: MIT */
/* Pictures of numbers, distances or steps: their range is that of what is in view, and a bar in them says it. */
#ifndef SVOCL_TOOLS_SUPPORT_VALUE_SCALE_H
#define SVOCL_TOOLS_SUPPORT_VALUE_SCALE_H

#include "support/json.h"
#include "svocl/trace.h"

/* What the ends of the bar stand for: world units or steps. */
typedef struct value_scale {
    bool is_shown; /* the picture has numbers, and something is in view */
    double low, high;
    const char *unit;
} value_scale;

/* Whether a picture of that view has numbers. */
bool value_scale_suits(svo_render_view view);

/* svo_tree_render in the range of what is in view, with the bar where it has room. asked: with its camera. */
svo_status value_scale_render(svo_device *device, svo_tree *tree, const svo_render_options *asked,
                              cl_command_queue queue, uint8_t *rgba, value_scale *out);

/* Adds "range" and "range_unit" where the picture has numbers. */
void value_scale_report(cJSON *document, const value_scale *scale);

#endif
