/* SPDX-License-Identifier: MIT */
/*
 * PLY in the import child: vertices with normals, colors and texture coordinates, faces, triangle strips, the first
 * material's diffuse color, and a texture named in a comment. Other elements are skipped with a warning; other
 * properties without one.
 */
#include <inttypes.h>

#include "core/message.h"
#include "io/import_faces.h"
#include "io/import_formats.h"
#include "io/import_ply_file.h"

typedef struct ply_reader {
    mesh_reader *reader;
    ply_header header;
    ply_source source;
    face_list faces;
    bool has_vertices;
    gather_material material;
} ply_reader;

/* Vertices */

static svo_status read_vertices(ply_reader *ply, const ply_element *element)
{
    ply_slot slots[PLY_PROPERTIES_MAX] = {PLY_SLOT_NONE};
    gather *mesh = ply->reader->mesh;
    ply_source *source = &ply->source;
    if (ply->has_vertices) {
        return svo_i_fail(ply->reader->message, SVO_IMPORT_FAILED, "element vertex is declared twice");
    }
    ply->has_vertices = true;
    svo_i_ply_note_slots(element, mesh->has_uvs, slots, &mesh->has_normals, &mesh->has_colors);
    if (element->count > 0 && element->property_count == 0) {
        return svo_i_fail(ply->reader->message, SVO_IMPORT_FAILED, "element vertex has no property");
    }
    const gather_vertex blank = svo_i_ply_blank_vertex(element, slots);
    SVO_I_TRY(svo_i_faces_begin(&ply->faces, ply->reader, element->count));
    for (uint64_t i = 0; i < element->count; ++i) {
        gather_vertex *vertex = &ply->faces.vertices[i];
        *vertex = blank;
        source->instance = i;
        SVO_I_TRY(svo_i_ply_begin_instance(source));
        SVO_I_TRY(svo_i_ply_read_vertex(source, element, slots, vertex));
        svo_i_ply_end_instance(source);
        if (mesh->has_uvs) {
            vertex->uv[1] = 1 - vertex->uv[1]; /* v = 0 is PLY's last row and svo_texture's first */
        }
    }
    return svo_i_faces_end_vertices(&ply->faces, mesh->has_uvs);
}

/* Faces */

static svo_status read_corners(ply_reader *ply, const ply_property *property, uint64_t *corner_count)
{
    ply_source *source = &ply->source;
    SVO_I_TRY(svo_i_ply_list_length(source, property, corner_count));
    SVO_I_TRY(svo_i_faces_reserve(&ply->faces, *corner_count));
    for (uint64_t i = 0; i < *corner_count; ++i) {
        SVO_I_TRY(svo_i_ply_integer(source, property->type, &ply->faces.corners[i]));
    }
    return SVO_OK;
}

/* Two coordinates per corner; lists of other lengths are no texture coordinates of this face. */
static svo_status read_corner_uvs(ply_reader *ply, const ply_property *property, uint64_t *pair_count)
{
    uint64_t length = 0;
    float value = 0;
    SVO_I_TRY(svo_i_ply_list_length(&ply->source, property, &length));
    SVO_I_TRY(svo_i_faces_reserve_uvs(&ply->faces, length / 2));
    for (uint64_t i = 0; i < length; ++i) {
        SVO_I_TRY(svo_i_ply_float(&ply->source, property->type, &value));
        if (i / 2 < length / 2) {
            ply->faces.corner_uvs[i / 2][i % 2] = i % 2 == 0 ? value : 1 - value;
        }
    }
    *pair_count = length % 2 == 0 ? length / 2 : 0;
    return SVO_OK;
}

static svo_status read_faces(ply_reader *ply, const ply_element *element)
{
    ply_source *source = &ply->source;
    const size_t indices = svo_i_ply_find_index_list(element), uvs = svo_i_ply_find(element, "texcoord");
    if (indices == element->property_count || element->properties[indices].count_type == PLY_NO_TYPE) {
        return element->count == 0
                   ? SVO_OK
                   : svo_i_fail(ply->reader->message, SVO_IMPORT_FAILED, "element face has no list vertex_indices");
    }
    for (uint64_t i = 0; i < element->count; ++i) {
        uint64_t corner_count = 0, pair_count = 0;
        source->instance = i;
        SVO_I_TRY(svo_i_ply_begin_instance(source));
        for (size_t k = 0; k < element->property_count; ++k) {
            const ply_property *property = &element->properties[k];
            if (k == indices) {
                SVO_I_TRY(read_corners(ply, property, &corner_count));
            } else if (k == uvs && property->count_type != PLY_NO_TYPE) {
                SVO_I_TRY(read_corner_uvs(ply, property, &pair_count));
            } else {
                SVO_I_TRY(svo_i_ply_skip(source, property));
            }
        }
        svo_i_ply_end_instance(source);
        const bool with_uvs = ply->reader->mesh->has_uvs && corner_count > 0 && pair_count == corner_count;
        SVO_I_TRY(svo_i_faces_add(&ply->faces, (uint32_t)corner_count, with_uvs));
    }
    return SVO_OK;
}

/* Strips */

/* A strip's next triangle; every second one is turned, so that all face the same side. */
static svo_status add_strip_triangle(face_list *faces, int64_t a, int64_t b, int64_t c, bool turned)
{
    faces->corners[0] = turned ? b : a;
    faces->corners[1] = turned ? a : b;
    faces->corners[2] = c;
    return svo_i_faces_add(faces, 3, false);
}

/* One list of vertex indices; -1 ends a strip. */
static svo_status read_strip_list(ply_reader *ply, const ply_property *property)
{
    uint64_t length = 0, in_strip = 0;
    int64_t last[2] = {0, 0};
    SVO_I_TRY(svo_i_ply_list_length(&ply->source, property, &length));
    SVO_I_TRY(svo_i_faces_reserve(&ply->faces, 3));
    for (uint64_t i = 0; i < length; ++i) {
        int64_t index = 0;
        SVO_I_TRY(svo_i_ply_integer(&ply->source, property->type, &index));
        if (index == -1) {
            in_strip = 0;
            continue;
        }
        if (in_strip >= 2) {
            SVO_I_TRY(add_strip_triangle(&ply->faces, last[0], last[1], index, in_strip % 2 != 0));
        }
        last[0] = last[1];
        last[1] = index;
        ++in_strip;
    }
    return SVO_OK;
}

static svo_status read_strips(ply_reader *ply, const ply_element *element)
{
    const size_t indices = svo_i_ply_find_index_list(element);
    if (element->count > 0 &&
        (indices == element->property_count || element->properties[indices].count_type == PLY_NO_TYPE)) {
        return svo_i_fail(ply->reader->message, SVO_IMPORT_FAILED, "element %s has no list vertex_indices",
                          element->name);
    }
    for (uint64_t i = 0; i < element->count; ++i) {
        ply->source.instance = i;
        SVO_I_TRY(svo_i_ply_begin_instance(&ply->source));
        for (size_t k = 0; k < element->property_count; ++k) {
            SVO_I_TRY(k == indices ? read_strip_list(ply, &element->properties[k])
                                   : svo_i_ply_skip(&ply->source, &element->properties[k]));
        }
        svo_i_ply_end_instance(&ply->source);
    }
    return SVO_OK;
}

/* Materials */

/* The diffuse color of the first one: faces do not say which they have. */
static svo_status read_materials(ply_reader *ply, const ply_element *element)
{
    static const char *const names[4] = {"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"};
    ply_source *source = &ply->source;
    uint8_t rgba[4] = {0, 0, 0, 255};
    bool has_color = false;
    for (uint64_t i = 0; i < element->count && element->property_count > 0; ++i) { /* else any count fits */
        source->instance = i;
        SVO_I_TRY(svo_i_ply_begin_instance(source));
        for (size_t k = 0; k < element->property_count; ++k) {
            const ply_property *property = &element->properties[k];
            size_t channel = 0;
            while (channel < 4 && strcmp(property->name, names[channel]) != 0) {
                ++channel;
            }
            if (i > 0 || channel == 4 || property->count_type != PLY_NO_TYPE) {
                SVO_I_TRY(svo_i_ply_skip(source, property));
            } else {
                SVO_I_TRY(svo_i_ply_read_color(source, property->type, &rgba[channel]));
                has_color = true;
            }
        }
        svo_i_ply_end_instance(source);
    }
    if (has_color) {
        memcpy(ply->material.base.rgba, rgba, sizeof rgba);
    }
    if (element->count > 1) {
        svo_i_read_warn(ply->reader, "%" PRIu64 " materials; the whole mesh gets the first", element->count);
    }
    return SVO_OK;
}

/* All of it */

static svo_status read_element(ply_reader *ply, const ply_element *element)
{
    const char *name = element->name;
    ply->source.element = element;
    SVO_I_TRY(svo_i_ply_check_fit(&ply->source, element));
    if (strcmp(name, "vertex") == 0) {
        return read_vertices(ply, element);
    }
    if (strcmp(name, "material") == 0) {
        return read_materials(ply, element);
    }
    const bool is_face = strcmp(name, "face") == 0;
    if (!is_face && strcmp(name, "tristrips") != 0) {
        if (element->count > 0) {
            svo_i_read_warn(ply->reader, "%" PRIu64 " of element %s are left out", element->count, name);
        }
        return svo_i_ply_skip_element(&ply->source, element);
    }
    if (!ply->has_vertices) {
        return svo_i_fail(ply->reader->message, SVO_IMPORT_FAILED, "element %s comes before element vertex", name);
    }
    return is_face ? read_faces(ply, element) : read_strips(ply, element);
}

/* The texture that the header names, before the data is read: without it texture coordinates are left out. */
static svo_status read_texture(ply_reader *ply)
{
    mesh_reader *reader = ply->reader;
    if (!svo_i_ply_declares_uvs(&ply->header) || ply->header.texture_file[0] == '\0' || reader->path == NULL) {
        return SVO_OK;
    }
    texture_list textures = {.mesh_path = reader->path, .stream = reader->stream, .work = reader->work};
    const texture_source image = {.name = ply->header.texture_file, .alpha_from = TEXTURE_KEEP_ALPHA};
    const bool done = svo_i_import_texture(&textures, &image, &ply->material.base.texture_index);
    reader->mesh->has_uvs = ply->material.base.texture_index != SVO_NO_TEXTURE;
    svo_i_texture_list_free(&textures);
    return done ? SVO_OK : svo_i_read_out_of_memory(reader);
}

static svo_status read_all(ply_reader *ply)
{
    ply_source *source = &ply->source;
    SVO_I_TRY(svo_i_ply_read_header(ply->reader, &source->cursor, &ply->header));
    source->format = ply->header.format;
    SVO_I_TRY(read_texture(ply));
    for (size_t i = 0; i < ply->header.element_count; ++i) {
        SVO_I_TRY(read_element(ply, &ply->header.elements[i]));
    }
    if (!ply->has_vertices) {
        return svo_i_fail(ply->reader->message, SVO_IMPORT_FAILED, "no element vertex");
    }
    svo_i_faces_end(&ply->faces);
    svo_i_read_warn_odd(&source->numbers);
    if (source->long_count > 0) {
        svo_i_read_warn(ply->reader, "%" PRIu64 " lines have more values than are declared; the first is line %" PRIu64,
                        source->long_count, source->first_long_line);
    }
    const uint64_t left_bytes = (uint64_t)(source->cursor.end - source->cursor.at);
    if (source->format != PLY_ASCII && left_bytes > 0) {
        svo_i_read_warn(ply->reader, "%" PRIu64 " bytes follow after the elements that are declared", left_bytes);
    }
    if (!svo_i_gather_material(ply->reader->mesh, &ply->material)) {
        return svo_i_read_out_of_memory(ply->reader);
    }
    svo_i_gather_drop_plain_materials(ply->reader->mesh);
    return SVO_OK;
}

svo_status svo_i_read_ply(mesh_reader *reader)
{
    ply_reader ply = {.reader = reader,
                      .source = {.reader = reader, .numbers = {.reader = reader}},
                      .material = svo_i_gather_plain_material()};
    const svo_status status = read_all(&ply);
    svo_i_faces_free(&ply.faces);
    svo_i_ply_header_free(&ply.header);
    return status;
}
