/* SPDX-License-Identifier: MIT */
/*
 * The map of the sky and, behind it, its means for cones: levels of half the width and height, rounded up, down to a
 * single texel. A texel of a level is the mean over its solid angle, so that each level has the flux of the map. Where
 * the map is bright in places, shares follow by which rays of paths aim at its texels. All of it is computed on the
 * host, so that each device has the same.
 */
#include "light/sky.h"

#include <math.h>
#include <string.h>

#include "core/memory.h"

#define PI 3.14159265358979323846

/* Paths aim at a map whose squared radiance has a mean of more than so many times the square of the mean. One that is
   the same all around has 1, half a sky 2, a clear sky with its sun thousands. */
#define UNEVEN 2.0

/* ---- checks ---- */

static svo_status check_size(const svo_light *light, const char *function, const char *what, uint32_t texels,
                             uint32_t most)
{
    return texels >= 1 && texels <= most
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: setup.%s %u is not in 1 .. %u", function,
                                   what, texels, most);
}

svo_status svo_i_light_check_sky(const svo_light *light, const char *function, const svo_light_setup *setup)
{
    if (setup->sky_map == NULL) {
        return setup->sky_width == 0 && setup->sky_height == 0
                   ? SVO_OK
                   : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                       "%s: setup.sky_map is NULL; its size is %u x %u", function, setup->sky_width,
                                       setup->sky_height);
    }
    SVO_I_TRY(check_size(light, function, "sky_width", setup->sky_width, SVO_SKY_WIDTH_MAX));
    SVO_I_TRY(check_size(light, function, "sky_height", setup->sky_height, SVO_SKY_HEIGHT_MAX));
    const size_t values = (size_t)3 * setup->sky_width * setup->sky_height;
    for (size_t i = 0; i < values; ++i) {
        if (!isfinite(setup->sky_map[i]) || setup->sky_map[i] < 0.0F) {
            return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                     "%s: setup.sky_map[%zu] %g, of column %zu and row %zu, is negative or not finite",
                                     function, i, (double)setup->sky_map[i], i / 3 % setup->sky_width,
                                     i / 3 / setup->sky_width);
        }
    }
    return SVO_OK;
}

/* ---- means ---- */

typedef struct sky_level {
    float *texels; /* three channels each */
    uint32_t width, height;
} sky_level;

static sky_level level_after(const sky_level *level)
{
    return (sky_level){.texels = level->texels + (size_t)3 * level->width * level->height,
                       .width = (level->width + 1) / 2,
                       .height = (level->height + 1) / 2};
}

static bool is_last(const sky_level *level)
{
    return level->width == 1 && level->height == 1;
}

/* Texels of all levels. */
static uint64_t count_texels(uint32_t width, uint32_t height)
{
    sky_level level = {.texels = NULL, .width = width, .height = height};
    uint64_t count = (uint64_t)width * height;
    while (!is_last(&level)) {
        level.width = (level.width + 1) / 2;
        level.height = (level.height + 1) / 2;
        count += (uint64_t)level.width * level.height;
    }
    return count;
}

/* Of a range of so many parts: what part index has of the parts first to first + 2 of another division into `finer`.
   Shares of the sphere, if by_angle, of rows; else of columns. */
typedef struct overlap {
    uint32_t first, count; /* of the finer parts, at most 3 */
    double shares[3]; /* 1 in all */
} overlap;

static double height_above(double row, double rows)
{
    return cos(PI * row / rows);
}

static overlap overlap_of(uint32_t index, uint32_t parts, uint32_t finer, bool by_angle)
{
    const double width = (double)finer / parts;
    const double begin = index * width;
    const double end = index + 1 == parts ? finer : (index + 1) * width;
    overlap out = {.first = (uint32_t)begin};
    double sum = 0;
    for (uint32_t part = out.first; part < finer && part < end && out.count < 3; ++part) {
        const double low = fmax(begin, part);
        const double high = fmin(end, part + 1.0);
        const double share = by_angle ? height_above(low, finer) - height_above(high, finer) : high - low;
        out.shares[out.count++] = share;
        sum += share;
    }
    for (uint32_t k = 0; k < out.count; ++k) {
        out.shares[k] /= sum;
    }
    return out;
}

/* The mean of the texels that a row and a column overlap. */
static void average(const sky_level *finer, const overlap *row, const overlap *column, float out[3])
{
    double sum[3] = {0, 0, 0};
    for (uint32_t j = 0; j < row->count; ++j) {
        const float *texels = finer->texels + 3 * ((size_t)(row->first + j) * finer->width + column->first);
        for (uint32_t i = 0; i < column->count; ++i) {
            const double share = row->shares[j] * column->shares[i];
            for (int channel = 0; channel < 3; ++channel) {
                sum[channel] += share * (double)texels[3 * i + (uint32_t)channel];
            }
        }
    }
    for (int channel = 0; channel < 3; ++channel) {
        out[channel] = (float)sum[channel];
    }
}

static void make_level(const sky_level *finer, const sky_level *level)
{
    for (uint32_t j = 0; j < level->height; ++j) {
        const overlap row = overlap_of(j, level->height, finer->height, true);
        for (uint32_t i = 0; i < level->width; ++i) {
            const overlap column = overlap_of(i, level->width, finer->width, false);
            average(finer, &row, &column, level->texels + 3 * ((size_t)j * level->width + i));
        }
    }
}

/* ---- shares ---- */

static double brightest(const svo_light_setup *setup, uint32_t column, uint32_t row)
{
    const float *texel = setup->sky_map + 3 * ((size_t)setup->sky_width * row + column);
    return (double)fmaxf(texel[0], fmaxf(texel[1], texel[2]));
}

/* What a texel of a row has of all directions. */
static double share_of_sphere(const svo_light_setup *setup, uint32_t row)
{
    const double height = height_above(row, setup->sky_height) - height_above(row + 1.0, setup->sky_height);
    return height / 2 / setup->sky_width;
}

/* Means over all directions: of radiance, and of its square. */
typedef struct sky_means {
    double radiance, square;
} sky_means;

static sky_means means_of(const svo_light_setup *setup)
{
    sky_means means = {0, 0};
    for (uint32_t row = 0; row < setup->sky_height; ++row) {
        const double share = share_of_sphere(setup, row);
        for (uint32_t column = 0; column < setup->sky_width; ++column) {
            const double radiance = brightest(setup, column, row);
            means.radiance += share * radiance;
            means.square += share * radiance * radiance;
        }
    }
    return means;
}

/* Where a share ends, of what stands before it and of all. */
static uint32_t end_of(double before, double all)
{
    return all > 0 ? (uint32_t)fmin(before / all * SVO_SKY_SHARES, SVO_SKY_SHARES) : SVO_SKY_SHARES;
}

/* Texels of a row, in proportion to what they have above the mean: rays that aim nowhere find the rest (Karlik, Sik,
   Vevoda, Skrivan and Krivanek, "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling",
   2019). Returns the sum. */
static double share_row(const svo_light_setup *setup, double mean, uint32_t row, uint32_t *ends)
{
    double sum = 0;
    double before = 0;
    for (uint32_t column = 0; column < setup->sky_width; ++column) {
        sum += fmax(brightest(setup, column, row) - mean, 0);
    }
    for (uint32_t column = 0; column < setup->sky_width; ++column) {
        before += fmax(brightest(setup, column, row) - mean, 0);
        ends[column] = end_of(before, sum);
    }
    ends[setup->sky_width - 1] = SVO_SKY_SHARES;
    return sum * share_of_sphere(setup, row);
}

/* Rows, then the texels of each: sky_height * (1 + sky_width) words. sums: of rows, scratch. */
static void make_shares(const svo_light_setup *setup, double mean, double *sums, uint32_t *ends)
{
    double all = 0;
    double before = 0;
    for (uint32_t row = 0; row < setup->sky_height; ++row) {
        sums[row] = share_row(setup, mean, row, ends + setup->sky_height + (size_t)setup->sky_width * row);
        all += sums[row];
    }
    for (uint32_t row = 0; row < setup->sky_height; ++row) {
        before += sums[row];
        ends[row] = end_of(before, all);
    }
    ends[setup->sky_height - 1] = SVO_SKY_SHARES;
}

/* ---- the map of a light ---- */

/* The map and its means. */
static void make_levels(const svo_light_setup *setup, float *texels)
{
    sky_level level = {.texels = texels, .width = setup->sky_width, .height = setup->sky_height};
    memcpy(texels, setup->sky_map, (size_t)svo_i_sky_map_bytes(setup->sky_width, setup->sky_height));
    while (!is_last(&level)) {
        const sky_level next = level_after(&level);
        make_level(&level, &next);
        level = next;
    }
}

svo_status svo_i_light_make_sky(svo_i_device_work *work, svo_light *light, const svo_light_setup *setup)
{
    const sky_means means = means_of(setup);
    const bool has_shares = means.square > UNEVEN * means.radiance * means.radiance;
    const uint64_t values = 3 * count_texels(setup->sky_width, setup->sky_height);
    const uint64_t shares = has_shares ? setup->sky_height * (UINT64_C(1) + setup->sky_width) : 0;
    const uint64_t bytes = values * sizeof(cl_float) + shares * sizeof(cl_uint);
    svo_status status = SVO_OK;
    double *sums = svo_i_alloc_zeroed(&light->device->memory, setup->sky_height, sizeof *sums);
    cl_uint *words = bytes <= SIZE_MAX ? svo_i_alloc(&light->device->memory, (size_t)bytes) : NULL;
    SVO_I_TRY_CLEANUP(sums != NULL && words != NULL
                          ? SVO_OK
                          : svo_i_device_fail(light->device, SVO_OUT_OF_HOST_MEMORY,
                                              "%s: no memory for a sky map of %u x %u", work->function,
                                              setup->sky_width, setup->sky_height));
    make_levels(setup, (float *)(void *)words);
    if (has_shares) {
        make_shares(setup, means.radiance, sums, words + values);
    }
    SVO_I_TRY_CLEANUP(svo_i_work_result(work, "sky_map", bytes, &light->sky_map));
    SVO_I_TRY_CLEANUP(svo_i_work_write(work, light->sky_map, words, bytes));
    light->params.sky_size = setup->sky_width | setup->sky_height << 16;
    light->info.sky_bytes = bytes;
    light->aims_at_sky = has_shares;

cleanup:
    svo_i_free(words);
    svo_i_free(sums);
    return status;
}

svo_status svo_i_light_share_sky(const svo_light *from, const char *function, svo_light *to)
{
    if (from->sky_map == NULL) {
        return SVO_OK;
    }
    const cl_int error = clRetainMemObject(from->sky_map);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(from->device, function, "clRetainMemObject", error);
    }
    to->sky_map = from->sky_map;
    to->params.sky_size = from->params.sky_size;
    to->info.sky_bytes = from->info.sky_bytes;
    to->aims_at_sky = from->aims_at_sky;
    return SVO_OK;
}

void svo_i_light_drop_sky(svo_light *light)
{
    svo_i_buffer_release(&light->sky_map);
    light->params.sky_size = 0;
    light->info.sky_bytes = 0;
    light->aims_at_sky = false;
}
