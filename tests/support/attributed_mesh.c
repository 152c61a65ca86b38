/* SPDX-License-Identifier: MIT */
/* Makes attributes for a random mesh, including unusual values: not finite, zero, far out of range. */
#include "attributed_mesh.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* Odd sizes, every wrap mode. */
static void make_textures(uint64_t *state, attributed_mesh *out)
{
    static const uint32_t sizes[ATTRIBUTED_TEXTURES][2] = {{1, 1}, {3, 5}, {64, 32}, {7, 1}, {2, 129}};
    static const svo_wrap wraps[ATTRIBUTED_TEXTURES][2] = {{SVO_WRAP_REPEAT, SVO_WRAP_CLAMP},
                                                           {SVO_WRAP_REPEAT, SVO_WRAP_MIRROR},
                                                           {SVO_WRAP_CLAMP, SVO_WRAP_REPEAT},
                                                           {SVO_WRAP_MIRROR, SVO_WRAP_MIRROR},
                                                           {SVO_WRAP_MIRROR, SVO_WRAP_CLAMP}};
    size_t total = 0;
    for (unsigned i = 0; i < ATTRIBUTED_TEXTURES; ++i) {
        total += (size_t)sizes[i][0] * sizes[i][1] * 4;
    }
    out->texels = malloc(total);
    assert_non_null(out->texels);
    for (size_t i = 0; i < total; ++i) {
        out->texels[i] = (uint8_t)random_word(state);
    }
    const uint8_t *next = out->texels;
    for (unsigned i = 0; i < ATTRIBUTED_TEXTURES; ++i) {
        out->textures[i] = (svo_texture){next, sizes[i][0], sizes[i][1], wraps[i][0], wraps[i][1]};
        next += (size_t)sizes[i][0] * sizes[i][1] * 4;
    }
}

/* The first is white without a texture; some refer to a texture that does not exist. */
static void make_materials(uint64_t *state, attributed_mesh *out)
{
    static const uint32_t texture_indices[ATTRIBUTED_MATERIALS] = {SVO_NO_TEXTURE,      0,    1, 2, 3, 4,
                                                                   ATTRIBUTED_TEXTURES, 77777};
    for (unsigned i = 0; i < ATTRIBUTED_MATERIALS; ++i) {
        out->materials[i].texture_index = texture_indices[i];
        for (unsigned channel = 0; channel < 4; ++channel) {
            out->materials[i].rgba[channel] = i == 0 ? 255 : (uint8_t)random_word(state);
        }
    }
    for (size_t t = 0; t < out->mesh.triangle_count; ++t) {
        out->triangle_materials[t] = (uint16_t)random_below(state, ATTRIBUTED_MATERIALS);
    }
}

static float random_normal_part(uint64_t *state, uint32_t sort)
{
    static const float odd[] = {NAN, INFINITY, -INFINITY, 0.0F, -0.0F, 1e-38F, 3e38F, -1e-45F};
    return sort == 0 ? odd[random_below(state, 8)] : (float)(random_unit(state) * 2.0 - 1.0);
}

static float random_uv(uint64_t *state)
{
    static const float odd[] = {NAN, INFINITY, -INFINITY, 1e30F, -1e30F, 32767.0F, -32766.75F, 1000.3F};
    return random_below(state, 32) == 0 ? odd[random_below(state, 8)] : (float)(random_unit(state) * 7.0 - 3.0);
}

static void make_vertex_attributes(uint64_t *state, attributed_mesh *out)
{
    for (size_t v = 0; v < out->mesh.vertex_count; ++v) {
        const uint32_t sort = random_below(state, 6);
        const bool as_before = v > 0 && random_below(state, 3) != 0; /* many triangles with a single color and normal */
        for (unsigned k = 0; k < 4; ++k) {
            out->colors[v * 4 + k] = as_before ? out->colors[v * 4 + k - 4] : (uint8_t)random_word(state);
        }
        for (unsigned k = 0; k < 3; ++k) {
            const float part = random_normal_part(state, sort);
            out->normals[v * 3 + k] = as_before ? out->normals[v * 3 + k - 3] : sort == 1 ? 0.0F : part;
        }
        out->uvs[v * 2] = random_uv(state);
        out->uvs[v * 2 + 1] = random_uv(state);
    }
}

void attributed_mesh_create(uint64_t seed, size_t triangle_count, double reach, attributed_mesh *out)
{
    uint64_t state = seed * 7919;
    *out = (attributed_mesh){0};
    random_mesh(seed, triangle_count, reach, &out->base);
    out->mesh = out->base.mesh;
    const size_t vertex_count = out->mesh.vertex_count;
    out->colors = malloc(vertex_count * 4);
    out->normals = malloc(vertex_count * 3 * sizeof(float));
    out->uvs = malloc(vertex_count * 2 * sizeof(float));
    out->triangle_materials = malloc(triangle_count * sizeof(uint16_t));
    assert_non_null(out->colors);
    assert_non_null(out->normals);
    assert_non_null(out->uvs);
    assert_non_null(out->triangle_materials);
    make_vertex_attributes(&state, out);
    make_textures(&state, out);
    make_materials(&state, out);
    out->mesh.colors = out->colors;
    out->mesh.normals = out->normals;
    out->mesh.uvs = out->uvs;
    out->mesh.triangle_materials = out->triangle_materials;
    out->mesh.materials = out->materials;
    out->mesh.material_count = ATTRIBUTED_MATERIALS;
    out->mesh.textures = out->textures;
    out->mesh.texture_count = ATTRIBUTED_TEXTURES;
}

void attributed_mesh_destroy(attributed_mesh *made)
{
    free(made->texels);
    free(made->triangle_materials);
    free(made->uvs);
    free(made->normals);
    free(made->colors);
    owned_mesh_free(&made->base);
}
