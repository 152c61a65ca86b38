/* SPDX-License-Identifier: MIT */
/* MTL files: what becomes a material of the mesh and its finish. */
#define _POSIX_C_SOURCE 200809L
#include "io/import_mtl.h"

#include <inttypes.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/message.h"
#include "io/import_material.h"
#include "io/import_number.h"

#define DEFAULT_GRAY  0.6f /* of a material that is used or named, but has no color */
#define DEFAULT_NAME  "DefaultMaterial" /* as some programs call the absence of a material: white */
#define MATERIALS_MAX UINT16_MAX

typedef struct mtl_reader {
    mtl_library *library;
    const mesh_reader *reader;
    text_cursor cursor;
    uint32_t current;
    uint64_t bad_count, first_bad_line;
    text_word first_bad;
} mtl_reader;

/* The library */

mtl_material *svo_i_mtl_get(const mtl_library *library, uint32_t number)
{
    return (mtl_material *)library->materials.items + number;
}

static size_t find_slot(const mtl_library *library, const char *name, size_t length)
{
    size_t slot = (size_t)XXH3_64bits(name, length) & (library->slot_count - 1);
    while (library->slots[slot] != MTL_NO_MATERIAL) {
        const char *other = svo_i_mtl_get(library, library->slots[slot])->name;
        if (strlen(other) == length && memcmp(other, name, length) == 0) {
            break;
        }
        slot = (slot + 1) & (library->slot_count - 1);
    }
    return slot;
}

/* Keeps the table at most half full. */
static bool grow_slots(mtl_library *library)
{
    if (2 * (library->materials.count + 1) <= library->slot_count) {
        return true;
    }
    const size_t slot_count = library->slot_count == 0 ? 64 : 2 * library->slot_count;
    uint32_t *slots = malloc(slot_count * sizeof *slots);
    if (slots == NULL) {
        return false;
    }
    memset(slots, 0xff, slot_count * sizeof *slots);
    free(library->slots);
    library->slots = slots;
    library->slot_count = slot_count;
    for (uint32_t i = 0; i < library->materials.count; ++i) {
        const char *name = svo_i_mtl_get(library, i)->name;
        slots[find_slot(library, name, strlen(name))] = i;
    }
    return true;
}

uint32_t svo_i_mtl_find(mtl_library *library, const char *name, size_t length)
{
    if (memchr(name, '\0', length) != NULL) {
        length = strlen(name);
    }
    if (!grow_slots(library)) {
        return MTL_NO_MATERIAL;
    }
    const size_t slot = find_slot(library, name, length);
    if (library->slots[slot] != MTL_NO_MATERIAL) {
        return library->slots[slot];
    }
    char *copy = text_copy(name, length);
    mtl_material *material = copy != NULL ? list_add(&library->materials, sizeof *material) : NULL;
    if (material == NULL) {
        free(copy);
        return MTL_NO_MATERIAL;
    }
    *material = (mtl_material){.name = copy,
                               .diffuse = {DEFAULT_GRAY, DEFAULT_GRAY, DEFAULT_GRAY},
                               .opacity = 1,
                               .uv_scale = {1, 1},
                               .index = {MTL_NO_MATERIAL, MTL_NO_MATERIAL}};
    library->slots[slot] = (uint32_t)library->materials.count - 1;
    return library->slots[slot];
}

void svo_i_mtl_free(mtl_library *library)
{
    for (uint32_t i = 0; i < library->materials.count; ++i) {
        free(svo_i_mtl_get(library, i)->name);
        free(svo_i_mtl_get(library, i)->texture);
    }
    free(library->materials.items);
    free(library->slots);
    *library = (mtl_library){.slot_count = 0};
}

/* Statements */

static bool take_number(text_cursor *cursor, float *value)
{
    (void)text_skip_blanks(cursor);
    const char *behind = svo_i_number_float(cursor->at, cursor->end, value);
    if (behind != NULL) {
        cursor->at = behind;
        text_skip_word(cursor);
    }
    return behind != NULL;
}

static void note_bad(mtl_reader *mtl)
{
    if (mtl->bad_count++ == 0) {
        mtl->first_bad = text_copy_word(&mtl->cursor);
        mtl->first_bad_line = mtl->cursor.line;
    }
}

/* "Kd r [g b]"; one number is for all three. Spectral curves and CIE coordinates are not read. */
static void read_color(mtl_reader *mtl, float color[3])
{
    float rgb[3];
    if (!take_number(&mtl->cursor, &rgb[0])) {
        note_bad(mtl);
        return;
    }
    if (!take_number(&mtl->cursor, &rgb[1]) || !take_number(&mtl->cursor, &rgb[2])) {
        rgb[1] = rgb[2] = rgb[0];
    }
    memcpy(color, rgb, sizeof rgb);
}

static void read_exponent(mtl_reader *mtl, mtl_material *material)
{
    if (!take_number(&mtl->cursor, &material->finish.exponent)) {
        note_bad(mtl);
    }
}

static void read_opacity(mtl_reader *mtl, mtl_material *material, bool is_transparency)
{
    float value = 1;
    (void)text_skip_blanks(&mtl->cursor);
    (void)text_take_keyword(&mtl->cursor, "-halo");
    if (take_number(&mtl->cursor, &value)) {
        material->opacity = is_transparency ? 1 - value : value;
    } else {
        note_bad(mtl);
    }
}

/* Up to three numbers behind "-o", "-s" or "-t", the first two of which are kept. */
static void read_pair(text_cursor *cursor, float pair[2])
{
    float value = 0;
    for (int i = 0; i < 3; ++i) {
        text_cursor at = *cursor;
        if (!take_number(&at, &value)) {
            return;
        }
        *cursor = at;
        if (i < 2) {
            pair[i] = value;
        }
    }
}

/* One option of a texture statement and its values. */
static void read_texture_option(mtl_reader *mtl, mtl_material *material)
{
    text_cursor *cursor = &mtl->cursor;
    float ignored[2];
    if (text_take_keyword(cursor, "-clamp")) {
        (void)text_skip_blanks(cursor);
        material->clamps = text_take_keyword(cursor, "on");
        text_skip_word(cursor);
    } else if (text_take_keyword(cursor, "-o")) {
        read_pair(cursor, material->uv_offset);
    } else if (text_take_keyword(cursor, "-s")) {
        read_pair(cursor, material->uv_scale);
    } else if (text_take_keyword(cursor, "-t") || text_take_keyword(cursor, "-mm")) {
        read_pair(cursor, ignored);
    } else {
        text_skip_word(cursor);
        (void)text_skip_blanks(cursor);
        text_skip_word(cursor);
    }
}

static svo_status read_texture(mtl_reader *mtl, mtl_material *material)
{
    size_t length = 0;
    material->clamps = false;
    while (text_skip_blanks(&mtl->cursor) && *mtl->cursor.at == '-') {
        read_texture_option(mtl, material);
    }
    const char *path = text_rest_of_line(&mtl->cursor, &length);
    char *copy = text_copy(path, length);
    if (copy == NULL) {
        return svo_i_read_out_of_memory(mtl->reader);
    }
    free(material->texture);
    material->texture = copy;
    return SVO_OK;
}

static svo_status read_name(mtl_reader *mtl)
{
    size_t length = 0;
    const char *name = text_rest_of_line(&mtl->cursor, &length);
    mtl->current = svo_i_mtl_find(mtl->library, name, length);
    if (mtl->current == MTL_NO_MATERIAL) {
        return svo_i_read_out_of_memory(mtl->reader);
    }
    svo_i_mtl_get(mtl->library, mtl->current)->is_defined = true;
    return SVO_OK;
}

static svo_status read_statement(mtl_reader *mtl)
{
    text_cursor *cursor = &mtl->cursor;
    if (text_take_keyword(cursor, "newmtl")) {
        return read_name(mtl);
    }
    if (mtl->current == MTL_NO_MATERIAL) {
        return SVO_OK;
    }
    mtl_material *material = svo_i_mtl_get(mtl->library, mtl->current);
    if (text_take_keyword(cursor, "Kd")) {
        read_color(mtl, material->diffuse);
    } else if (text_take_keyword(cursor, "Ke")) {
        read_color(mtl, material->finish.emission);
    } else if (text_take_keyword(cursor, "Ks")) {
        read_color(mtl, material->finish.specular);
    } else if (text_take_keyword(cursor, "Ns")) {
        read_exponent(mtl, material);
    } else if (text_take_keyword(cursor, "map_Kd")) {
        return read_texture(mtl, material);
    } else if (text_take_keyword(cursor, "d")) {
        read_opacity(mtl, material, false);
    } else if (text_take_keyword(cursor, "Tr")) {
        read_opacity(mtl, material, true);
    }
    return SVO_OK;
}

svo_status svo_i_mtl_read(mtl_library *library, const mesh_reader *reader, const char *name, const char *bytes,
                          size_t byte_count)
{
    mtl_reader mtl = {.library = library,
                      .reader = reader,
                      .cursor = {.at = bytes, .end = bytes + byte_count, .line = 1},
                      .current = MTL_NO_MATERIAL};
    for (; mtl.cursor.at != mtl.cursor.end; text_skip_line(&mtl.cursor)) {
        if (text_skip_blanks(&mtl.cursor)) {
            SVO_I_TRY(read_statement(&mtl));
        }
    }
    if (mtl.bad_count > 0) {
        svo_i_read_warn(reader, "%s: %" PRIu64 " values are not read; the first is '%s' in line %" PRIu64, name,
                        mtl.bad_count, mtl.first_bad.text, mtl.first_bad_line);
    }
    return SVO_OK;
}

/* Gathering */

static svo_material base_of(const mtl_material *source)
{
    svo_material material = {.rgba = {255, 255, 255, 255}, .texture_index = SVO_NO_TEXTURE};
    const bool is_gray =
        source->diffuse[0] == DEFAULT_GRAY && source->diffuse[1] == DEFAULT_GRAY && source->diffuse[2] == DEFAULT_GRAY;
    if (is_gray && (source->name[0] == '\0' || strcmp(source->name, DEFAULT_NAME) == 0)) {
        return material;
    }
    for (int i = 0; i < 3; ++i) {
        material.rgba[i] = svo_i_import_color_byte(source->diffuse[i]);
    }
    material.rgba[3] = svo_i_import_color_byte(source->opacity);
    return material;
}

svo_status svo_i_mtl_gather(mtl_library *library, const mesh_reader *reader, texture_list *textures, uint32_t number,
                            bool textured, uint32_t *default_index, uint16_t *index)
{
    mtl_material *source = number != MTL_NO_MATERIAL ? svo_i_mtl_get(library, number) : NULL;
    uint32_t *known = source != NULL ? &source->index[textured] : default_index;
    if (*known == MTL_NO_MATERIAL) {
        svo_material material = {.rgba = {255, 255, 255, 255}, .texture_index = SVO_NO_TEXTURE};
        svo_finish finish = {.exponent = 0};
        if (reader->mesh->material_count == MATERIALS_MAX) {
            return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "it has more than %d materials", MATERIALS_MAX);
        }
        if (source != NULL) {
            material = base_of(source);
            finish = source->finish;
            svo_i_import_tame_finish(&finish);
        }
        if (source != NULL && textured && source->texture != NULL && source->texture[0] != '\0' &&
            reader->path != NULL) {
            const svo_wrap wrap = source->clamps ? SVO_WRAP_CLAMP : SVO_WRAP_REPEAT;
            const texture_source image = {
                .name = source->texture, .wrap_u = wrap, .wrap_v = wrap, .alpha_from = TEXTURE_KEEP_ALPHA};
            if (!svo_i_import_texture(textures, &image, &material.texture_index)) {
                return svo_i_read_out_of_memory(reader);
            }
        }
        if (!svo_i_gather_material(reader->mesh, &material, &finish)) {
            return svo_i_read_out_of_memory(reader);
        }
        *known = (uint32_t)reader->mesh->material_count - 1;
    }
    *index = (uint16_t)*known;
    return SVO_OK;
}
