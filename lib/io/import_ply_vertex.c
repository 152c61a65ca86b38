/* SPDX-License-Identifier: MIT */
/* Vertices of PLY files, in the import child and where a file is read in blocks. */
#include "io/import_ply_vertex.h"

#include "io/import_material.h"

static ply_slot slot_of(const char *name)
{
    static const struct {
        const char *name;
        int slot;
    } names[] = {{"x", PLY_SLOT_POSITION},
                 {"y", PLY_SLOT_POSITION + 1},
                 {"z", PLY_SLOT_POSITION + 2},
                 {"nx", PLY_SLOT_NORMAL},
                 {"ny", PLY_SLOT_NORMAL + 1},
                 {"nz", PLY_SLOT_NORMAL + 2},
                 {"red", PLY_SLOT_COLOR},
                 {"green", PLY_SLOT_COLOR + 1},
                 {"blue", PLY_SLOT_COLOR + 2},
                 {"alpha", PLY_SLOT_COLOR + 3},
                 {"r", PLY_SLOT_COLOR},
                 {"g", PLY_SLOT_COLOR + 1},
                 {"b", PLY_SLOT_COLOR + 2},
                 {"a", PLY_SLOT_COLOR + 3},
                 {"diffuse_red", PLY_SLOT_COLOR},
                 {"diffuse_green", PLY_SLOT_COLOR + 1},
                 {"diffuse_blue", PLY_SLOT_COLOR + 2},
                 {"u", PLY_SLOT_UV},
                 {"v", PLY_SLOT_UV + 1},
                 {"s", PLY_SLOT_UV},
                 {"t", PLY_SLOT_UV + 1},
                 {"tx", PLY_SLOT_UV},
                 {"ty", PLY_SLOT_UV + 1},
                 {"texture_u", PLY_SLOT_UV},
                 {"texture_v", PLY_SLOT_UV + 1}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strcmp(name, names[i].name) == 0) {
            return (ply_slot)names[i].slot;
        }
    }
    return PLY_SLOT_NONE;
}

svo_status svo_i_ply_read_color(ply_source *source, ply_type type, uint8_t *channel)
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

static svo_status read_vertex_value(ply_source *source, ply_type type, ply_slot slot, gather_vertex *vertex)
{
    if (slot >= PLY_SLOT_COLOR) {
        return svo_i_ply_read_color(source, type, &vertex->color[slot - PLY_SLOT_COLOR]);
    }
    float *target = NULL;
    if (slot >= PLY_SLOT_UV) {
        target = &vertex->uv[slot - PLY_SLOT_UV];
    } else {
        target = slot >= PLY_SLOT_NORMAL ? &vertex->normal[slot - PLY_SLOT_NORMAL]
                                         : &vertex->position[slot - PLY_SLOT_POSITION];
    }
    return svo_i_ply_float(source, type, target);
}

void svo_i_ply_note_slots(const ply_element *element, bool with_uvs, ply_slot slots[PLY_PROPERTIES_MAX],
                          bool *has_normals, bool *has_colors)
{
    for (size_t i = 0; i < element->property_count; ++i) {
        const bool is_list = element->properties[i].count_type != PLY_NO_TYPE;
        slots[i] = is_list ? PLY_SLOT_NONE : slot_of(element->properties[i].name);
        *has_normals = *has_normals || (slots[i] >= PLY_SLOT_NORMAL && slots[i] < PLY_SLOT_UV);
        *has_colors = *has_colors || slots[i] >= PLY_SLOT_COLOR;
        if (!with_uvs && slots[i] >= PLY_SLOT_UV && slots[i] < PLY_SLOT_COLOR) {
            slots[i] = PLY_SLOT_NONE;
        }
    }
}

gather_vertex svo_i_ply_blank_vertex(const ply_element *element, const ply_slot slots[PLY_PROPERTIES_MAX])
{
    gather_vertex vertex = {.color = {255, 255, 255, 255}};
    for (size_t i = 0; i < element->property_count; ++i) {
        if (slots[i] >= PLY_SLOT_COLOR && slots[i] < PLY_SLOT_COLOR + 3) {
            memset(vertex.color, 0, 3);
        }
    }
    return vertex;
}

svo_status svo_i_ply_read_vertex(ply_source *source, const ply_element *element,
                                 const ply_slot slots[PLY_PROPERTIES_MAX], gather_vertex *vertex)
{
    for (size_t k = 0; k < element->property_count; ++k) {
        const ply_property *property = &element->properties[k];
        SVO_I_TRY(slots[k] != PLY_SLOT_NONE ? read_vertex_value(source, property->type, slots[k], vertex)
                                            : svo_i_ply_skip(source, property));
    }
    return SVO_OK;
}

bool svo_i_ply_declares_uvs(const ply_header *header)
{
    for (size_t i = 0; i < header->element_count; ++i) {
        const ply_element *element = &header->elements[i];
        const bool is_vertex = strcmp(element->name, "vertex") == 0;
        for (size_t k = 0; k < element->property_count; ++k) {
            const ply_slot slot = slot_of(element->properties[k].name);
            if ((is_vertex && slot >= PLY_SLOT_UV && slot < PLY_SLOT_COLOR) ||
                strcmp(element->properties[k].name, "texcoord") == 0) {
                return true;
            }
        }
    }
    return false;
}

size_t svo_i_ply_find_index_list(const ply_element *element)
{
    const size_t found = svo_i_ply_find(element, "vertex_indices");
    return found < element->property_count ? found : svo_i_ply_find(element, "vertex_index");
}
