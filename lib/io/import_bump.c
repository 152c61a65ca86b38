/* SPDX-License-Identifier: MIT */
/*
 * Images of bump in the import child: files have normal maps there or heights, of which this makes normal maps. The
 * normal of a height field h(x, y) is (-dh/dx, -dh/dy, 1) (Blinn, "Simulation of Wrinkled Surfaces", 1978).
 */
#include "io/import_bump.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define WHITE_TEXELS 2.0 /* how far white lies above black */
#define LENGTH_ERROR 0.15 /* of normals, which images keep in bytes and often in coarser codes */

/* Whether a texel is a unit vector out of the surface. Gray ones are heights. */
static bool is_normal(const uint8_t texel[4])
{
    double squared = 0;
    for (int i = 0; i < 3; ++i) {
        const double component = 2 * texel[i] / 255.0 - 1;
        squared += component * component;
    }
    const bool is_gray = texel[0] == texel[1] && texel[1] == texel[2];
    return !is_gray && texel[2] > 127 && fabs(sqrt(squared) - 1) <= LENGTH_ERROR;
}

static bool is_normal_map(const uint8_t *pixels, size_t texel_count)
{
    size_t normals = 0;
    for (size_t i = 0; i < texel_count; ++i) {
        normals += is_normal(pixels + 4 * i) ? 1 : 0;
    }
    return normals >= texel_count - texel_count / 10;
}

/* Places on an axis around one, as textures go on there. */
typedef struct neighbors {
    size_t before, after;
} neighbors;

static neighbors neighbors_of(size_t at, size_t count, svo_wrap wrap)
{
    const bool repeats = wrap == SVO_WRAP_REPEAT;
    return (neighbors){.before = at > 0    ? at - 1
                                 : repeats ? count - 1
                                           : 0,
                       .after = at + 1 < count ? at + 1
                                : repeats      ? 0
                                               : count - 1};
}

/* The height of a texel, in texels: its luminance (ITU-R BT.709). */
static double height_of(const uint8_t *texel)
{
    return WHITE_TEXELS / 255 * (0.2126 * texel[0] + 0.7152 * texel[1] + 0.0722 * texel[2]);
}

static void put_normal(double across, double down, uint8_t texel[4])
{
    const double length = sqrt(across * across + down * down + 1);
    const double normal[3] = {-across / length, down / length, 1 / length}; /* y is up in the image */
    for (int i = 0; i < 3; ++i) {
        texel[i] = (uint8_t)(127.5 * normal[i] + 128);
    }
    texel[3] = 255;
}

uint8_t *svo_i_import_normals_of_bump(const uint8_t *pixels, size_t width, size_t height, svo_wrap wrap_u,
                                      svo_wrap wrap_v)
{
    uint8_t *made = malloc(4 * width * height);
    if (made != NULL && is_normal_map(pixels, width * height)) {
        memcpy(made, pixels, 4 * width * height);
        return made;
    }
    for (size_t y = 0; made != NULL && y < height; ++y) {
        const neighbors rows = neighbors_of(y, height, wrap_v);
        for (size_t x = 0; x < width; ++x) {
            const neighbors columns = neighbors_of(x, width, wrap_u);
            const double across = (height_of(pixels + 4 * (y * width + columns.after)) -
                                   height_of(pixels + 4 * (y * width + columns.before))) /
                                  2;
            const double down =
                (height_of(pixels + 4 * (rows.after * width + x)) - height_of(pixels + 4 * (rows.before * width + x))) /
                2;
            put_normal(across, down, made + 4 * (y * width + x));
        }
    }
    return made;
}
