/* SPDX-License-Identifier: MIT */
/*
 * Materials in the import child: the diffuse or base color, that color's texture, emission and the specular lobe. Other
 * properties are ignored.
 */
#include "io/import_material.h"

#include <assimp/material.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "io/import_stream.h"

#define DEFAULT_GRAY 0.6f /* of assimp's default material */

uint8_t svo_i_import_color_byte(float value)
{
    if (!(value > 0)) {
        return 0;
    }
    return value < 1 ? (uint8_t)(value * 255.0f + 0.5f) : 255;
}

static svo_wrap wrap_of(enum aiTextureMapMode mode)
{
    switch (mode) {
    case aiTextureMapMode_Clamp:
    case aiTextureMapMode_Decal:
        return SVO_WRAP_CLAMP;
    case aiTextureMapMode_Mirror:
        return SVO_WRAP_MIRROR;
    default:
        return SVO_WRAP_REPEAT;
    }
}

/* Scale and offset from the file. assimp 5.2.5 has a step that applies them, but that step scales about the center. */
static bool read_uv_transform(const texture_list *textures, const struct aiMaterial *source, enum aiTextureType type,
                              texture_use *use)
{
    struct aiUVTransform transform;
    if (aiGetMaterialUVTransform(source, AI_MATKEY_UVTRANSFORM(type, 0), &transform) != aiReturn_SUCCESS) {
        return true;
    }
    use->scale[0] = transform.mScaling.x;
    use->scale[1] = transform.mScaling.y;
    use->offset[0] = transform.mTranslation.x;
    use->offset[1] = transform.mTranslation.y;
    return transform.mRotation == 0 ||
           svo_i_stream_text(textures->stream, STREAM_WARNING,
                             "a material rotates its texture; the rotation is ignored") == 0;
}

static bool add_texture(texture_list *textures, const struct aiMaterial *source, svo_material *material,
                        texture_use *use)
{
    struct aiString path;
    enum aiTextureMapMode modes[3] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
    static const enum aiTextureType types[] = {aiTextureType_DIFFUSE, aiTextureType_BASE_COLOR};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i) {
        if (aiGetMaterialTextureCount(source, types[i]) > 0 &&
            aiGetMaterialTexture(source, types[i], 0, &path, NULL, &use->uv_channel, NULL, NULL, modes, NULL) ==
                aiReturn_SUCCESS &&
            path.length > 0) {
            const texture_source image = {.name = path.data,
                                          .wrap_u = wrap_of(modes[0]),
                                          .wrap_v = wrap_of(modes[1]),
                                          .alpha_from = TEXTURE_KEEP_ALPHA};
            return read_uv_transform(textures, source, types[i], use) &&
                   svo_i_import_texture(textures, &image, &material->texture_index);
        }
    }
    return true;
}

/* assimp adds a gray material where the file has none; it is no color of the mesh. */
static bool is_assimp_default(const struct aiMaterial *source, const struct aiColor4D *color)
{
    struct aiString name = {0};
    (void)aiGetMaterialString(source, AI_MATKEY_NAME, &name);
    return (name.length == 0 || strcmp(name.data, AI_DEFAULT_MATERIAL_NAME) == 0) && color->r == DEFAULT_GRAY &&
           color->g == DEFAULT_GRAY && color->b == DEFAULT_GRAY;
}

static struct aiColor4D base_color(const struct aiMaterial *source)
{
    const struct aiColor4D white = {1, 1, 1, 1};
    struct aiColor4D base = white, color = white;
    const bool has_base = aiGetMaterialColor(source, AI_MATKEY_BASE_COLOR, &base) == aiReturn_SUCCESS;
    if (aiGetMaterialColor(source, AI_MATKEY_COLOR_DIFFUSE, &color) != aiReturn_SUCCESS) {
        color = base;
    }
    if (is_assimp_default(source, &color)) {
        return white;
    }
    /* Where there is a base color (glTF), its alpha is the opacity already. */
    ai_real opacity = 1;
    if (!has_base && aiGetMaterialFloatArray(source, AI_MATKEY_OPACITY, &opacity, NULL) == aiReturn_SUCCESS) {
        color.a *= opacity;
    }
    return color;
}

bool svo_i_import_material(texture_list *textures, const struct aiMaterial *source, bool with_texture,
                           svo_material *material, texture_use *use)
{
    const struct aiColor4D color = base_color(source);
    *material = (svo_material){.rgba = {svo_i_import_color_byte(color.r), svo_i_import_color_byte(color.g),
                                        svo_i_import_color_byte(color.b), svo_i_import_color_byte(color.a)},
                               .texture_index = SVO_NO_TEXTURE};
    *use = (texture_use){.scale = {1, 1}};
    return !with_texture || add_texture(textures, source, material, use);
}

static float tame(float value, float most)
{
    return !isfinite(value) || value < 0 ? 0 : value > most ? most : value;
}

void svo_i_import_tame_finish(svo_finish *finish)
{
    bool shines = false;
    for (int i = 0; i < 3; ++i) {
        finish->emission[i] = tame(finish->emission[i], FLT_MAX);
        finish->specular[i] = tame(finish->specular[i], 1);
        shines = shines || finish->specular[i] > 0;
    }
    finish->exponent = shines ? tame(finish->exponent, FLT_MAX) : 0;
}

void svo_i_import_finish(const struct aiMaterial *source, svo_finish *finish)
{
    const struct aiColor4D black = {0, 0, 0, 1};
    struct aiColor4D emission = black, specular = black;
    ai_real exponent = 0;
    /* Where there is none, the values stay. */
    (void)aiGetMaterialColor(source, AI_MATKEY_COLOR_EMISSIVE, &emission);
    (void)aiGetMaterialColor(source, AI_MATKEY_COLOR_SPECULAR, &specular);
    (void)aiGetMaterialFloatArray(source, AI_MATKEY_SHININESS, &exponent, NULL);
    *finish = (svo_finish){.emission = {emission.r, emission.g, emission.b},
                           .specular = {specular.r, specular.g, specular.b},
                           .exponent = exponent};
    svo_i_import_tame_finish(finish);
}
