/* SPDX-License-Identifier: MIT */
/* Colors are as svo_material describes them, in double precision. */
#include "path/albedo.h"

#include <math.h>
#include <string.h>

/* ---- a triangle's corners and material ---- */

/* IEC 61966-2-1. */
static double decode_srgb(double value)
{
    return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

static uint32_t corner_of(const svo_mesh *mesh, uint32_t triangle, size_t corner)
{
    const size_t place = (size_t)triangle * 3 + corner;
    return mesh->indices != NULL ? mesh->indices[place] : (uint32_t)place;
}

static const svo_material *material_of(const svo_mesh *mesh, uint32_t triangle, size_t *index)
{
    const size_t named = mesh->triangle_materials != NULL ? mesh->triangle_materials[triangle] : 0;
    *index = named < mesh->material_count ? named : 0;
    return mesh->material_count > 0 ? &mesh->materials[*index] : NULL;
}

/* ---- textures ---- */

static uint32_t wrapped(int64_t texel, uint32_t count, svo_wrap wrap)
{
    const int64_t period = wrap == SVO_WRAP_MIRROR ? 2 * (int64_t)count : (int64_t)count;
    if (wrap == SVO_WRAP_CLAMP) {
        return texel < 0 ? 0 : texel >= (int64_t)count ? count - 1 : (uint32_t)texel;
    }
    const int64_t inside = (texel % period + period) % period;
    return (uint32_t)(inside < (int64_t)count ? inside : period - 1 - inside);
}

/* Bilinear: texel i covers i .. i + 1 and has its value in the middle. Red, green and blue weigh by alpha. */
static void sample_texture(const svo_texture *image, const double uv[2], double color[4])
{
    const double x = uv[0] * image->width - 0.5;
    const double y = uv[1] * image->height - 0.5;
    const double share[2] = {x - floor(x), y - floor(y)};
    memset(color, 0, 4 * sizeof *color);
    for (int k = 0; k < 4; ++k) {
        const uint32_t column = wrapped((int64_t)floor(x) + (k & 1), image->width, image->wrap_u);
        const uint32_t row = wrapped((int64_t)floor(y) + (k >> 1), image->height, image->wrap_v);
        const double weight = ((k & 1) != 0 ? share[0] : 1 - share[0]) * ((k >> 1) != 0 ? share[1] : 1 - share[1]);
        const uint8_t *texel = image->rgba + 4 * ((size_t)row * image->width + column);
        for (int channel = 0; channel < 4; ++channel) {
            color[channel] += weight * texel[channel] / 255 * (channel < 3 ? texel[3] / 255.0 : 1);
        }
    }
    for (int channel = 0; channel < 3; ++channel) {
        color[channel] = color[3] > 0 ? color[channel] / color[3] : 0;
    }
}

/* As svo_mesh.uvs says. */
static double clamped_uv(float value)
{
    return isfinite(value) ? fmin(fmax((double)value, -32767.0), 32767.0) : 0.0;
}

static void multiply_texel(const svo_mesh *mesh, const svo_material *material, uint32_t triangle,
                           const double weights[3], double color[4])
{
    double uv[2] = {0, 0};
    double texel[4];
    if (material->texture_index >= mesh->texture_count || mesh->uvs == NULL) {
        return;
    }
    for (size_t corner = 0; corner < 3; ++corner) {
        const float *own = mesh->uvs + 2 * (size_t)corner_of(mesh, triangle, corner);
        uv[0] += weights[corner] * clamped_uv(own[0]);
        uv[1] += weights[corner] * clamped_uv(own[1]);
    }
    sample_texture(&mesh->textures[material->texture_index], uv, texel);
    for (int channel = 0; channel < 4; ++channel) {
        color[channel] *= texel[channel];
    }
}

/* ---- materials ---- */

static void multiply_vertex_colors(const svo_mesh *mesh, uint32_t triangle, const double weights[3], double color[4])
{
    for (int channel = 0; channel < 4 && mesh->colors != NULL; ++channel) {
        double own = 0;
        for (size_t corner = 0; corner < 3; ++corner) {
            own += weights[corner] * mesh->colors[4 * (size_t)corner_of(mesh, triangle, corner) + (size_t)channel];
        }
        color[channel] *= own / 255;
    }
}

double path_albedo(const svo_mesh *mesh, uint32_t triangle, double u, double v, double albedo[3])
{
    const double weights[3] = {1 - u - v, u, v};
    double color[4] = {1, 1, 1, 1};
    size_t index = 0;
    const svo_material *material = material_of(mesh, triangle, &index);
    if (material == NULL && mesh->colors == NULL) {
        albedo[0] = albedo[1] = albedo[2] = PATH_CLAY;
        return 1;
    }
    for (int channel = 0; channel < 4 && material != NULL; ++channel) {
        color[channel] = material->rgba[channel] / 255.0;
    }
    multiply_vertex_colors(mesh, triangle, weights, color);
    if (material != NULL) {
        multiply_texel(mesh, material, triangle, weights, color);
    }
    for (int channel = 0; channel < 3; ++channel) {
        albedo[channel] = decode_srgb(color[channel]);
    }
    return color[3];
}

bool path_is_clear(const svo_mesh *mesh)
{
    bool clear = false;
    for (size_t i = 0; i < mesh->material_count; ++i) {
        clear = clear || mesh->materials[i].rgba[3] != 255;
    }
    for (size_t i = 0; i < mesh->vertex_count && mesh->colors != NULL; ++i) {
        clear = clear || mesh->colors[4 * i + 3] != 255;
    }
    for (size_t i = 0; i < mesh->texture_count; ++i) {
        const svo_texture *image = &mesh->textures[i];
        for (size_t k = 0; k < (size_t)image->width * image->height && !clear; ++k) {
            clear = image->rgba[4 * k + 3] != 255;
        }
    }
    return clear;
}

void path_emission(const svo_mesh *mesh, const svo_light_setup *setup, uint32_t triangle, double emission[3])
{
    size_t index = 0;
    (void)material_of(mesh, triangle, &index);
    const bool emits = index < setup->finish_count;
    for (int channel = 0; channel < 3; ++channel) {
        emission[channel] = emits ? (double)setup->finishes[index].emission[channel] : 0;
    }
}
