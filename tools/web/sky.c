/* SPDX-License-Identifier: MIT */
#include "web/sky.h"

#include <math.h>
#include <stdlib.h>

#include "web/pack.h"

#define PI 3.14159265358979323846

/* Elements of a row or a column of the map, in part or whole, that an element of the page's sky covers. */
typedef struct covered {
    uint32_t first, last;
    double begin, end;
} covered;

static covered cover(uint32_t index, uint32_t count, uint32_t map_count)
{
    covered range = {.begin = (double)index * map_count / count, .end = (double)(index + 1) * map_count / count};
    range.first = (uint32_t)range.begin;
    range.last = (uint32_t)ceil(range.end) - 1;
    range.last = range.last < map_count ? range.last : map_count - 1;
    return range;
}

/* How much of an element lies in the range: 0 to 1 element. */
static double share_of(const covered *range, uint32_t element, double *low, double *high)
{
    *low = fmax(range->begin, element);
    *high = fmin(range->end, element + 1.0);
    return fmax(*high - *low, 0);
}

/* A row's height in the cosine of the angle from the zenith is its share of the solid angle. */
static void average(const svo_light_setup *setup, const covered *columns, const covered *rows, float mean[3])
{
    double sums[3] = {0, 0, 0};
    double weight = 0;
    for (uint32_t row = rows->first; row <= rows->last; ++row) {
        double low, high;
        (void)share_of(rows, row, &low, &high);
        const double height = fabs(cos(PI * low / setup->sky_height) - cos(PI * high / setup->sky_height));
        for (uint32_t column = columns->first; column <= columns->last; ++column) {
            double left, right;
            const double share = height * share_of(columns, column, &left, &right);
            const float *texel = setup->sky_map + 3 * ((size_t)row * setup->sky_width + column);
            weight += share;
            for (int channel = 0; channel < 3; ++channel) {
                sums[channel] += share * (double)texel[channel];
            }
        }
    }
    for (int channel = 0; channel < 3; ++channel) {
        mean[channel] = weight > 0 ? (float)(sums[channel] / weight) : 0.0F;
    }
}

static uint32_t half(uint32_t count)
{
    return count > 1 ? count / 2 : 1;
}

bool web_sky_make(const svo_light_setup *setup, size_t byte_limit, web_sky *out)
{
    uint32_t width = setup->sky_width < WEB_SKY_WIDTH_MAX ? setup->sky_width : WEB_SKY_WIDTH_MAX;
    uint32_t height = setup->sky_height < WEB_SKY_HEIGHT_MAX ? setup->sky_height : WEB_SKY_HEIGHT_MAX;
    *out = (web_sky){.width = 0};
    if (setup->sky_map == NULL || width == 0 || height == 0) {
        return true;
    }
    while ((size_t)4 * width * height > byte_limit && (width > 1 || height > 1)) {
        width = half(width);
        height = half(height);
    }
    out->texels = malloc((size_t)width * height * sizeof *out->texels);
    if (out->texels == NULL) {
        return false;
    }
    out->width = width;
    out->height = height;
    for (uint32_t row = 0; row < height; ++row) {
        const covered rows = cover(row, height, setup->sky_height);
        for (uint32_t i = 0; i < width; ++i) {
            const covered columns = cover(i, width, setup->sky_width);
            float mean[3];
            average(setup, &columns, &rows, mean);
            web_pack_light(mean, out->texels[(size_t)row * width + i]);
        }
    }
    return true;
}
