/* SPDX-License-Identifier: MIT */
/* A source of light as a place sees it, without what stands between. */
#ifndef SVOCL_TOOLS_PATH_SOURCE_H
#define SVOCL_TOOLS_PATH_SOURCE_H

#include <stdbool.h>

#include "scenes/maths.h"
#include "svocl/light_types.h"

typedef struct source_view {
    vector3 direction; /* unit, towards the source */
    double distance; /* world units; infinite for directional light */
    double strength; /* irradiance of a surface that faces the source, for a value of 1 */
} source_view;

/* False where the source sends no light to the place. */
bool path_source_view(const svo_light_source *source, vector3 place, source_view *view);

#endif
