/* SPDX-License-Identifier: MIT */
/* The sky of a page where it depends on direction: the map of a light's setup, with fewer texels where it has many. */
#ifndef SVOCL_TOOLS_WEB_SKY_H
#define SVOCL_TOOLS_WEB_SKY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/light.h"

#define WEB_SKY_WIDTH_MAX  512u
#define WEB_SKY_HEIGHT_MAX 256u

/* Rows from the zenith down, as svo_light_setup.sky_map has them; texels by web_pack_light. */
typedef struct web_sky {
    uint32_t width, height; /* 0: there is no map */
    unsigned char (*texels)[4]; /* by malloc */
} web_sky;

/* Each texel is the mean of the setup's map over its solid angle. Without a map there is none. byte_limit: halves width
   and height until the texels take no more. False when out of memory. */
bool web_sky_make(const svo_light_setup *setup, size_t byte_limit, web_sky *out);

#endif
