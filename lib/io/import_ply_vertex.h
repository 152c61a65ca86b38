/* SPDX-License-Identifier: MIT */
/* Vertices of PLY files: what their properties are for, and their values. */
#ifndef SVO_LIB_IO_IMPORT_PLY_VERTEX_H
#define SVO_LIB_IO_IMPORT_PLY_VERTEX_H

#include "io/import_ply_value.h"

/* What a property of a vertex is for: components of gather_vertex. */
typedef enum ply_slot {
    PLY_SLOT_NONE = 0,
    PLY_SLOT_POSITION,
    PLY_SLOT_NORMAL = PLY_SLOT_POSITION + 3,
    PLY_SLOT_UV = PLY_SLOT_NORMAL + 3,
    PLY_SLOT_COLOR = PLY_SLOT_UV + 2,
    PLY_SLOT_END = PLY_SLOT_COLOR + 4
} ply_slot;

/* The slot of each property. with_uvs: texture coordinates are read. Sets *has_normals and *has_colors where the
   element has them. */
void svo_i_ply_note_slots(const ply_element *element, bool with_uvs, ply_slot slots[PLY_PROPERTIES_MAX],
                          bool *has_normals, bool *has_colors);
/* What a vertex has before its values are read: zero, but white. Color channels that are missing beside others are 0,
   but alpha is 255. */
gather_vertex svo_i_ply_blank_vertex(const ply_element *element, const ply_slot slots[PLY_PROPERTIES_MAX]);
/* Reads the values of a vertex. */
svo_status svo_i_ply_read_vertex(ply_source *source, const ply_element *element,
                                 const ply_slot slots[PLY_PROPERTIES_MAX], gather_vertex *vertex);
/* A color channel as a byte. Bytes are copied, 16 bits scaled, floats taken from [0, 1]; wider whole numbers hold what
   a byte would. */
svo_status svo_i_ply_read_color(ply_source *source, ply_type type, uint8_t *channel);

/* Whether vertices or faces have texture coordinates. */
bool svo_i_ply_declares_uvs(const ply_header *header);
/* The list of a face's vertices; property_count: there is none. */
size_t svo_i_ply_find_index_list(const ply_element *element);

#endif
