/* SPDX-License-Identifier: MIT */
/* Inverse squares, and the soft edge of spots. */
#include "path/path_source.h"

#include <math.h>

static vector3 vector_of(const float numbers[3])
{
    return vector((double)numbers[0], (double)numbers[1], (double)numbers[2]);
}

/* 1 inside the inner angle, 0 outside the outer one; between them smooth in the cosine. */
static double spot_share(const svo_light_source *source, vector3 towards)
{
    const vector3 axis = vector_normalize(vector_of(source->direction));
    return smooth_ramp(cos((double)source->outer_angle), cos((double)source->inner_angle), -vector_dot(axis, towards));
}

bool path_source_view(const svo_light_source *source, vector3 place, source_view *view)
{
    if (source->kind == SVO_SOURCE_DIRECTIONAL) {
        const vector3 axis = vector_normalize(vector_of(source->direction));
        *view = (source_view){.direction = vector_scale(axis, -1), .distance = INFINITY, .strength = 1};
        return true;
    }
    const vector3 towards = vector_subtract(vector_of(source->position), place);
    view->distance = vector_length(towards);
    if (!(view->distance > 0)) {
        return false;
    }
    view->direction = vector_scale(towards, 1 / view->distance);
    view->strength = 1 / vector_dot(towards, towards);
    if (source->kind == SVO_SOURCE_SPOT) {
        view->strength *= spot_share(source, view->direction);
    }
    return view->strength > 0;
}
