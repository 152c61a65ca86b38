/* SPDX-License-Identifier: MIT */
/*
 * PLY in the import child: vertices with normals, colors and texture coordinates, faces, triangle strips, the first
 * material's diffuse color, and a texture named in a comment. Other elements are skipped with a warning; other
 * properties without one.
 */
#include "io/import_ply.h"

#include <inttypes.h>

#include "core/message.h"
#include "io/import_faces.h"
#include "io/import_material.h"
#include "io/import_ply_value.h"

/* What a property of a vertex is for: components of gather_vertex. */
typedef enum vertex_slot {
    SLOT_NONE = 0,
    SLOT_POSITION,
    SLOT_NORMAL = SLOT_POSITION + 3,
    SLOT_UV = SLOT_NORMAL + 3,
    SLOT_COLOR = SLOT_UV + 2,
    SLOT_END = SLOT_COLOR + 4
} vertex_slot;

typedef struct ply_reader {
    mesh_reader *reader;
    ply_header header;
    ply_source source;
    face_list faces;
    bool has_vertices;
    svo_material material;
} ply_reader;

/* Names */

static vertex_slot slot_of(const char *name)
{
    static const struct {
        const char *name;
        int slot;
    } names[] = {{"x", SLOT_POSITION},
                 {"y", SLOT_POSITION + 1},
                 {"z", SLOT_POSITION + 2},
                 {"nx", SLOT_NORMAL},
                 {"ny", SLOT_NORMAL + 1},
                 {"nz", SLOT_NORMAL + 2},
                 {"red", SLOT_COLOR},
                 {"green", SLOT_COLOR + 1},
                 {"blue", SLOT_COLOR + 2},
                 {"alpha", SLOT_COLOR + 3},
                 {"r", SLOT_COLOR},
                 {"g", SLOT_COLOR + 1},
                 {"b", SLOT_COLOR + 2},
                 {"a", SLOT_COLOR + 3},
                 {"diffuse_red", SLOT_COLOR},
                 {"diffuse_green", SLOT_COLOR + 1},
                 {"diffuse_blue", SLOT_COLOR + 2},
                 {"u", SLOT_UV},
                 {"v", SLOT_UV + 1},
                 {"s", SLOT_UV},
                 {"t", SLOT_UV + 1},
                 {"tx", SLOT_UV},
                 {"ty", SLOT_UV + 1},
                 {"texture_u", SLOT_UV},
                 {"texture_v", SLOT_UV + 1}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strcmp(name, names[i].name) == 0) {
            return (vertex_slot)names[i].slot;
        }
    }
    return SLOT_NONE;
}

/* A color channel as a byte. Bytes are copied, 16 bits scaled, floats taken from [0, 1]; wider whole numbers hold what
   a byte would. */
static svo_status read_color(ply_source *source, ply_type type, uint8_t *channel)
{
    float value = 0;
    SVO_I_TRY(svo_i_ply_float(source, type, &value));
    switch (type) {
    case PLY_FLOAT:
    case PLY_DOUBLE:
        break;
    case PLY_UINT16:
        value /= 65535.0f;
        break;
    case PLY_INT16:
        value = (value + 32767) / 65535.0f;
        break;
    case PLY_INT8:
        value = (value + 127) / 255.0f;
        break;
    default:
        value /= 255.0f;
        break;
    }
    *channel = svo_i_import_color_byte(value);
    return SVO_OK;
}

/* Vertices */

static svo_status read_vertex_value(ply_source *source, ply_type type, vertex_slot slot, gather_vertex *vertex)
{
    if (slot >= SLOT_COLOR) {
        return read_color(source, type, &vertex->color[slot - SLOT_COLOR]);
    }
    float *target = NULL;
    if (slot >= SLOT_UV) {
        target = &vertex->uv[slot - SLOT_UV];
    } else {
        target = slot >= SLOT_NORMAL ? &vertex->normal[slot - SLOT_NORMAL] : &vertex->position[slot - SLOT_POSITION];
    }
    return svo_i_ply_float(source, type, target);
}

static void note_slots(ply_reader *ply, const ply_element *element, vertex_slot slots[PLY_PROPERTIES_MAX])
{
    gather *mesh = ply->reader->mesh;
    for (size_t i = 0; i < element->property_count; ++i) {
        const bool is_list = element->properties[i].count_type != PLY_NO_TYPE;
        slots[i] = is_list ? SLOT_NONE : slot_of(element->properties[i].name);
        mesh->has_normals = mesh->has_normals || (slots[i] >= SLOT_NORMAL && slots[i] < SLOT_UV);
        mesh->has_colors = mesh->has_colors || slots[i] >= SLOT_COLOR;
        if (!mesh->has_uvs && slots[i] >= SLOT_UV && slots[i] < SLOT_COLOR) {
            slots[i] = SLOT_NONE;
        }
    }
}

/* Channels that are missing beside others are 0, but alpha is 255. */
static gather_vertex blank_vertex(const vertex_slot slots[PLY_PROPERTIES_MAX], size_t property_count)
{
    gather_vertex vertex = {.color = {255, 255, 255, 255}};
    for (size_t i = 0; i < property_count; ++i) {
        if (slots[i] >= SLOT_COLOR && slots[i] < SLOT_COLOR + 3) {
            memset(vertex.color, 0, 3);
        }
    }
    return vertex;
}

static svo_status read_vertices(ply_reader *ply, const ply_element *element)
{
    vertex_slot slots[PLY_PROPERTIES_MAX] = {SLOT_NONE};
    ply_source *source = &ply->source;
    if (ply->has_vertices) {
        return svo_i_fail(ply->reader->message, SVO_IMPORT_FAILED, "element vertex is declared twice");
    }
    ply->has_vertices = true;
    note_slots(ply, element, slots);
    if (element->count > 0 && element->property_count == 0) {
        return svo_i_fail(ply->reader->message, SVO_IMPORT_FAILED, "element vertex has no property");
    }
    const gather_vertex blank = blank_vertex(slots, element->property_count);
    SVO_I_TRY(svo_i_faces_begin(&ply->faces, ply->reader, element->count));
    for (uint64_t i = 0; i < element->count; ++i) {
        gather_vertex *vertex = &ply->faces.vertices[i];
        *vertex = blank;
        source->instance = i;
        SVO_I_TRY(svo_i_ply_begin_instance(source));
        for (size_t k = 0; k < element->property_count; ++k) {
            const ply_property *property = &element->properties[k];
            SVO_I_TRY(slots[k] != SLOT_NONE ? read_vertex_value(source, property->type, slots[k], vertex)
                                            : svo_i_ply_skip(source, property));
        }
        svo_i_ply_end_instance(source);
        if (ply->reader->mesh->has_uvs) {
            vertex->uv[1] = 1 - vertex->uv[1]; /* v = 0 is PLY's last row and svo_texture's first */
        }
    }
    return svo_i_faces_end_vertices(&ply->faces, ply->reader->mesh->has_uvs);
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

static size_t find_index_list(const ply_element *element)
{
    const size_t found = svo_i_ply_find(element, "vertex_indices");
    return found < element->property_count ? found : svo_i_ply_find(element, "vertex_index");
}

static svo_status read_faces(ply_reader *ply, const ply_element *element)
{
    ply_source *source = &ply->source;
    const size_t indices = find_index_list(element), uvs = svo_i_ply_find(element, "texcoord");
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
    const size_t indices = find_index_list(element);
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
                SVO_I_TRY(read_color(source, property->type, &rgba[channel]));
                has_color = true;
            }
        }
        svo_i_ply_end_instance(source);
    }
    if (has_color) {
        memcpy(ply->material.rgba, rgba, sizeof rgba);
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

/* Whether vertices or faces have texture coordinates. */
static bool declares_uvs(const ply_header *header)
{
    for (size_t i = 0; i < header->element_count; ++i) {
        const ply_element *element = &header->elements[i];
        const bool is_vertex = strcmp(element->name, "vertex") == 0;
        for (size_t k = 0; k < element->property_count; ++k) {
            const vertex_slot slot = slot_of(element->properties[k].name);
            if ((is_vertex && slot >= SLOT_UV && slot < SLOT_COLOR) ||
                strcmp(element->properties[k].name, "texcoord") == 0) {
                return true;
            }
        }
    }
    return false;
}

/* The texture that the header names, before the data is read: without it texture coordinates are left out. */
static svo_status read_texture(ply_reader *ply)
{
    mesh_reader *reader = ply->reader;
    if (!declares_uvs(&ply->header) || ply->header.texture_file[0] == '\0' || reader->path == NULL) {
        return SVO_OK;
    }
    texture_list textures = {.mesh_path = reader->path, .stream = reader->stream};
    const bool done = svo_i_import_texture(&textures, ply->header.texture_file, SVO_WRAP_REPEAT, SVO_WRAP_REPEAT,
                                           &ply->material.texture_index);
    reader->mesh->has_uvs = ply->material.texture_index != SVO_NO_TEXTURE;
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
    svo_i_faces_warn(&ply->faces);
    svo_i_read_warn_odd(&source->numbers);
    if (source->long_count > 0) {
        svo_i_read_warn(ply->reader, "%" PRIu64 " lines have more values than are declared; the first is line %" PRIu64,
                        source->long_count, source->first_long_line);
    }
    const uint64_t left_bytes = (uint64_t)(source->cursor.end - source->cursor.at);
    if (source->format != PLY_ASCII && left_bytes > 0) {
        svo_i_read_warn(ply->reader, "%" PRIu64 " bytes follow after the elements that are declared", left_bytes);
    }
    if (!svo_i_gather_material(ply->reader->mesh, &ply->material, NULL)) {
        return svo_i_read_out_of_memory(ply->reader);
    }
    svo_i_gather_drop_plain_materials(ply->reader->mesh);
    return SVO_OK;
}

svo_status svo_i_read_ply(mesh_reader *reader)
{
    ply_reader ply = {.reader = reader,
                      .source = {.reader = reader, .numbers = {.reader = reader}},
                      .material = {.rgba = {255, 255, 255, 255}, .texture_index = SVO_NO_TEXTURE}};
    const svo_status status = read_all(&ply);
    svo_i_faces_free(&ply.faces);
    svo_i_ply_header_free(&ply.header);
    return status;
}
