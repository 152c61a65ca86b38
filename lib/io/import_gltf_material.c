/* SPDX-License-Identifier: MIT */
/*
 * Materials of glTF (specification, 3.9): base color, its texture, emission, normal map, and what alpha means. Factors
 * are linear in the file and sRGB in svo_material, as texels are in both, so that a build's products of bytes are close
 * to products of light. Metal, roughness and what else changes highlights alone is not read.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/message.h"
#include "io/import_gltf.h"
#include "io/srgb.h"

#define GLOSS_EXPONENT 1000.0 /* of full glossiness */

uint8_t svo_i_gltf_alpha_byte(const gltf_alpha *alpha, double value)
{
    if (alpha->is_opaque) {
        return 255;
    }
    return alpha->is_mask ? (alpha->factor * value >= alpha->cutoff ? 255 : 0) : svo_i_import_color_byte((float)value);
}

/* The least alpha of a texel that is opaque, where others are transparent. */
static int alpha_from(const gltf_alpha *alpha)
{
    int least = 0;
    while (alpha->is_mask && least < 256 && svo_i_gltf_alpha_byte(alpha, least / 255.0) == 0) {
        ++least;
    }
    return alpha->is_opaque || alpha->is_mask ? least : TEXTURE_KEEP_ALPHA;
}

static svo_status read_alpha(const gltf_file *file, const cJSON *source, double factor, gltf_alpha *alpha)
{
    const cJSON *mode = svo_i_gltf_get(source, "alphaMode");
    const char *name = cJSON_IsString(mode) ? mode->valuestring : "OPAQUE";
    *alpha = (gltf_alpha){.is_mask = strcmp(name, "MASK") == 0, .factor = factor, .cutoff = 0.5};
    alpha->is_opaque = !alpha->is_mask && strcmp(name, "BLEND") != 0;
    return svo_i_gltf_numbers(file, source, "alphaCutoff", &alpha->cutoff, 1);
}

/* ---- textures ---- */

/* KHR_texture_transform: scaled, rotated counterclockwise as seen, where v points down, then moved. */
static svo_status read_uvs(const gltf_file *file, const cJSON *info, gltf_uvs *uvs)
{
    const cJSON *extension = svo_i_gltf_extension(info, "KHR_texture_transform");
    double set = 0;
    double offset[2] = {0, 0};
    double scale[2] = {1, 1};
    double rotation = 0;
    SVO_I_TRY(svo_i_gltf_numbers(file, info, "texCoord", &set, 1));
    SVO_I_TRY(svo_i_gltf_numbers(file, extension, "texCoord", &set, 1));
    SVO_I_TRY(svo_i_gltf_numbers(file, extension, "offset", offset, 2));
    SVO_I_TRY(svo_i_gltf_numbers(file, extension, "scale", scale, 2));
    SVO_I_TRY(svo_i_gltf_numbers(file, extension, "rotation", &rotation, 1));
    const double c = rotation != 0 ? cos(rotation) : 1;
    const double s = rotation != 0 ? sin(rotation) : 0;
    *uvs = (gltf_uvs){.set = set >= 0 && set < 1000 ? (uint32_t)set : 0,
                      .is_identity = extension == NULL,
                      .matrix = {{c * scale[0], s * scale[1], offset[0]}, {-s * scale[0], c * scale[1], offset[1]}}};
    return SVO_OK;
}

static svo_wrap wrap_of(const cJSON *sampler, const char *name)
{
    const cJSON *mode = svo_i_gltf_get(sampler, name);
    const double value = cJSON_IsNumber(mode) ? mode->valuedouble : 0;
    return value == 33071 ? SVO_WRAP_CLAMP : value == 33648 ? SVO_WRAP_MIRROR : SVO_WRAP_REPEAT;
}

/* Sends an image as source asks for it, with its name and its bytes. */
static svo_status send_image(gltf_file *file, texture_list *textures, uint32_t image, texture_source *source,
                             uint32_t *texture_index)
{
    const cJSON *item = file->tables[GLTF_IMAGE].items[image];
    const cJSON *uri = svo_i_gltf_get(item, "uri");
    char name[32];
    uint8_t *data = NULL;
    char *path = NULL;
    uint32_t view_index = GLTF_NONE;
    gltf_bytes content = {.bytes = NULL};
    (void)snprintf(name, sizeof name, "image %" PRIu32, image);
    if (cJSON_IsString(uri)) {
        SVO_I_TRY(svo_i_gltf_uri(file, uri->valuestring, &data, &content.byte_count, &path));
        content.bytes = data;
    } else {
        SVO_I_TRY(svo_i_gltf_index(file, item, "bufferView", GLTF_BUFFER_VIEW, &view_index));
        SVO_I_TRY(view_index != GLTF_NONE ? svo_i_gltf_view(file, view_index, &content) : SVO_OK);
    }
    source->name = path != NULL ? path : name;
    source->bytes = content.bytes;
    source->byte_count = (size_t)content.byte_count;
    bool done = true;
    if (file->reader->path != NULL) {
        done = svo_i_import_texture(textures, source, texture_index);
    }
    free(data);
    free(path);
    return done ? SVO_OK : svo_i_read_out_of_memory(file->reader);
}

/* Whether textures lie alike on a surface. */
static bool placed_alike(const gltf_uvs *a, const gltf_uvs *b)
{
    bool alike = a->set == b->set;
    for (int i = 0; i < 6; ++i) {
        alike = alike && a->matrix[i / 3][i % 3] == b->matrix[i / 3][i % 3];
    }
    return alike;
}

/* Sends the texture that info names, if any. alpha_from: as in texture_source. */
static svo_status add_texture(gltf_file *file, texture_list *textures, const cJSON *info, int alpha_from,
                              uint32_t *index)
{
    uint32_t texture = GLTF_NONE;
    uint32_t image = GLTF_NONE;
    uint32_t sampler = GLTF_NONE;
    SVO_I_TRY(svo_i_gltf_index(file, info, "index", GLTF_TEXTURE, &texture));
    if (texture == GLTF_NONE) {
        return SVO_OK;
    }
    const cJSON *item = file->tables[GLTF_TEXTURE].items[texture];
    SVO_I_TRY(svo_i_gltf_index(file, item, "source", GLTF_IMAGE, &image));
    SVO_I_TRY(svo_i_gltf_index(file, item, "sampler", GLTF_SAMPLER, &sampler));
    if (image == GLTF_NONE) {
        svo_i_read_warn(file->reader, "texture %" PRIu32 " has no image that is read, white is used", texture);
        return SVO_OK;
    }
    const cJSON *wraps = sampler != GLTF_NONE ? file->tables[GLTF_SAMPLER].items[sampler] : NULL;
    texture_source source = {
        .wrap_u = wrap_of(wraps, "wrapS"), .wrap_v = wrap_of(wraps, "wrapT"), .alpha_from = alpha_from};
    return send_image(file, textures, image, &source, index);
}

static svo_status add_normal_map(gltf_file *file, texture_list *textures, const cJSON *info, gltf_look *look)
{
    gltf_uvs uvs;
    double scale = 1;
    if (info == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(read_uvs(file, info, &uvs));
    SVO_I_TRY(svo_i_gltf_numbers(file, info, "scale", &scale, 1));
    if (look->material.base.texture_index == SVO_NO_TEXTURE) {
        look->uvs = uvs;
    } else if (!placed_alike(&uvs, &look->uvs)) {
        svo_i_read_warn(file->reader, "a normal map lies otherwise than the color and is left out");
        return SVO_OK;
    }
    look->material.normal_map.scale = isfinite((float)scale) ? (float)scale : 1;
    return add_texture(file, textures, info, TEXTURE_KEEP_ALPHA, &look->material.normal_map.texture_index);
}

/* ---- materials ---- */

static svo_status read_finish(const gltf_file *file, const cJSON *source, const cJSON *gloss, svo_finish *finish)
{
    double emission[3] = {0, 0, 0};
    double strength = 1;
    double specular[3] = {1, 1, 1};
    double glossiness = 1;
    SVO_I_TRY(svo_i_gltf_numbers(file, source, "emissiveFactor", emission, 3));
    SVO_I_TRY(svo_i_gltf_numbers(file, svo_i_gltf_extension(source, "KHR_materials_emissive_strength"),
                                 "emissiveStrength", &strength, 1));
    SVO_I_TRY(svo_i_gltf_numbers(file, gloss, "specularFactor", specular, 3));
    SVO_I_TRY(svo_i_gltf_numbers(file, gloss, "glossinessFactor", &glossiness, 1));
    *finish = (svo_finish){.exponent = gloss != NULL ? (float)(glossiness * GLOSS_EXPONENT) : 0};
    for (int i = 0; i < 3; ++i) {
        finish->emission[i] = (float)(emission[i] * strength);
        finish->specular[i] = gloss != NULL ? (float)specular[i] : 0;
    }
    svo_i_import_tame_finish(finish);
    return SVO_OK;
}

svo_status svo_i_gltf_material(gltf_file *file, texture_list *textures, uint32_t index, bool with_texture,
                               gltf_look *look)
{
    const cJSON *source = index != GLTF_NONE ? file->tables[GLTF_MATERIAL].items[index] : NULL;
    const cJSON *metal = svo_i_gltf_get(source, "pbrMetallicRoughness");
    const cJSON *gloss = svo_i_gltf_extension(source, "KHR_materials_pbrSpecularGlossiness");
    const cJSON *texture = svo_i_gltf_get(gloss, "diffuseTexture");
    double color[4] = {1, 1, 1, 1};
    *look = (gltf_look){.material = svo_i_gather_plain_material(), .uvs.is_identity = true};
    if (gloss != NULL) {
        SVO_I_TRY(svo_i_gltf_numbers(file, gloss, "diffuseFactor", color, 4));
    } else {
        SVO_I_TRY(svo_i_gltf_numbers(file, metal, "baseColorFactor", color, 4));
    }
    texture = texture != NULL ? texture : svo_i_gltf_get(metal, "baseColorTexture");
    SVO_I_TRY(read_alpha(file, source, color[3], &look->alpha));
    for (int i = 0; i < 3; ++i) {
        look->material.base.rgba[i] = svo_i_srgb_byte(color[i]);
    }
    /* Of a mask, what the factor does is in the texels and vertices already. */
    look->material.base.rgba[3] = svo_i_gltf_alpha_byte(&look->alpha, look->alpha.is_mask ? 1 : color[3]);
    SVO_I_TRY(read_finish(file, source, gloss, &look->material.finish));
    if (!with_texture) {
        return SVO_OK;
    }
    SVO_I_TRY(read_uvs(file, texture, &look->uvs));
    SVO_I_TRY(add_texture(file, textures, texture, alpha_from(&look->alpha), &look->material.base.texture_index));
    return file->reader->normal_maps ? add_normal_map(file, textures, svo_i_gltf_get(source, "normalTexture"), look)
                                     : SVO_OK;
}
