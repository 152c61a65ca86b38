/* SPDX-License-Identifier: MIT */
/*
 * STL in the import child, in text and binary. A facet's normal is that of its corners. The two attribute bytes of a
 * binary facet hold a color by two conventions: VisCAM's, and Magics's, whose header has "COLOR=" and the color of the
 * facets without one.
 */
#include <inttypes.h>

#include "core/message.h"
#include "io/import_faces.h"
#include "io/import_formats.h"

#define HEADER_BYTES 80
#define PROBE_BYTES  500 /* of a text file, which must be free of bytes that no text has */

/* Binary */

static uint32_t read_u32(const char *bytes)
{
    const uint8_t *b = (const uint8_t *)bytes;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static void read_floats(const char *bytes, float *out, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        const uint32_t bits = read_u32(bytes + 4 * i);
        memcpy(&out[i], &bits, sizeof bits);
    }
}

/* The header's color, or white; whether the file follows Magics. */
static bool read_color(const char *bytes, uint8_t rgba[4])
{
    static const char mark[] = "COLOR=";
    const size_t mark_bytes = sizeof mark - 1;
    memset(rgba, 255, 4);
    for (size_t i = 0; i + mark_bytes + 4 <= HEADER_BYTES; ++i) {
        if (memcmp(bytes + i, mark, mark_bytes) == 0) {
            memcpy(rgba, bytes + i + mark_bytes, 4);
            return true;
        }
    }
    return false;
}

/* VisCAM: bit 15 set, then blue, green, red from the lowest bits. Magics: bit 15 clear, then red, green, blue. */
static bool has_color(const char *facet, bool is_magics)
{
    return (((uint8_t)facet[STL_FACET_BYTES - 1] & 0x80u) == 0) == is_magics;
}

static void facet_color(const char *facet, const stl_begin *begin, uint8_t rgba[4])
{
    const uint32_t attribute = (uint8_t)facet[48] | (uint32_t)(uint8_t)facet[49] << 8;
    if (!has_color(facet, begin->is_magics)) {
        memcpy(rgba, begin->color, 4);
        return;
    }
    for (unsigned i = 0; i < 3; ++i) {
        const uint32_t channel = attribute >> (5 * (begin->is_magics ? i : 2 - i)) & 31u;
        rgba[i] = svo_i_import_color_byte((float)channel * (1.0f / 31.0f));
    }
    rgba[3] = 255;
}

bool svo_i_stl_read_facet(const char *facet, const stl_begin *begin, float values[12], uint8_t rgba[4])
{
    read_floats(facet, values, 12);
    facet_color(facet, begin, rgba);
    return has_color(facet, begin->is_magics);
}

stl_begin svo_i_stl_read_begin(const char *bytes)
{
    stl_begin begin = {.facet_count = read_u32(bytes + HEADER_BYTES)};
    begin.is_magics = read_color(bytes, begin.color);
    return begin;
}

static bool gather_facet(gather *mesh, const float facet[12], const uint8_t rgba[4])
{
    uint32_t corners[3];
    gather_vertex vertex = {.color = {rgba[0], rgba[1], rgba[2], rgba[3]}};
    memcpy(vertex.normal, facet, sizeof vertex.normal);
    for (size_t i = 0; i < 3; ++i) {
        memcpy(vertex.position, facet + 3 + 3 * i, sizeof vertex.position);
        if (!svo_i_gather_vertex(mesh, &vertex, &corners[i])) {
            return false;
        }
    }
    return svo_i_gather_triangle(mesh, corners, 0);
}

/* Whether any facet has a color of its own. */
static bool any_color(const char *facets, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        if (has_color(facets + (size_t)i * STL_FACET_BYTES, false)) {
            return true;
        }
    }
    return false;
}

static svo_status read_binary(const mesh_reader *reader)
{
    const stl_begin begin = svo_i_stl_read_begin(reader->bytes);
    const uint32_t count = begin.facet_count;
    const uint64_t needed_bytes = STL_BEGIN_BYTES + (uint64_t)count * STL_FACET_BYTES;
    if (needed_bytes > reader->byte_count) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED,
                          "byte %d: %" PRIu32 " facets need %" PRIu64 " bytes, and the file has %zu", HEADER_BYTES,
                          count, needed_bytes, reader->byte_count);
    }
    const char *facets = reader->bytes + STL_BEGIN_BYTES;
    reader->mesh->has_normals = true;
    reader->mesh->has_colors = begin.is_magics || any_color(facets, count);
    /* Closed surfaces have half as many vertices as triangles. */
    if (!svo_i_gather_reserve(reader->mesh, count / 2, count, true)) {
        return svo_i_read_out_of_memory(reader);
    }
    for (uint32_t i = 0; i < count; ++i, facets += STL_FACET_BYTES) {
        float facet[12];
        uint8_t rgba[4];
        (void)svo_i_stl_read_facet(facets, &begin, facet, rgba);
        if (!gather_facet(reader->mesh, facet, rgba)) {
            return svo_i_read_out_of_memory(reader);
        }
    }
    svo_i_read_count_vertices(reader, 3 * (uint64_t)count, 3 * (uint64_t)count);
    svo_i_read_count_faces(reader, 0, count);
    if (reader->byte_count > needed_bytes) {
        svo_i_read_warn(reader, "%" PRIu64 " bytes follow after the %" PRIu32 " facets that are declared",
                        reader->byte_count - needed_bytes, count);
    }
    return SVO_OK;
}

/* Text */

typedef struct stl_text {
    const mesh_reader *reader;
    text_cursor cursor;
    number_reader numbers;
    polygon shape; /* the facet's corners */
    float normal[3];
    uint32_t corner_count;
    uint64_t facet_line, facet_count, vertex_count;
    bool in_facet;
    uint64_t unknown_count, first_unknown_line;
    text_word first_unknown;
} stl_text;

static svo_status read_vector(stl_text *stl, float vector[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        SVO_I_TRY(svo_i_read_float(&stl->numbers, &stl->cursor, &vector[axis]));
    }
    return SVO_OK;
}

/* Gathers the facet that was open, if one was. */
static svo_status end_facet(stl_text *stl)
{
    static const uint8_t white[4] = {255, 255, 255, 255};
    if (!stl->in_facet) {
        return SVO_OK;
    }
    stl->in_facet = false;
    if (stl->corner_count < 3) {
        return svo_i_fail(stl->reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": the facet has %" PRIu32 " vertices; 3 are needed", stl->facet_line,
                          stl->corner_count);
    }
    ++stl->facet_count;
    stl->vertex_count += stl->corner_count;
    svo_i_polygon_cut(&stl->shape, stl->corner_count);
    float facet[12];
    memcpy(facet, stl->normal, sizeof stl->normal);
    for (uint32_t i = 0; i < stl->corner_count - 2; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t corner = stl->shape.triangles[3 * (size_t)i + k];
            memcpy(facet + 3 + 3 * (size_t)k, stl->shape.corners[corner], sizeof stl->shape.corners[corner]);
        }
        if (!gather_facet(stl->reader->mesh, facet, white)) {
            return svo_i_read_out_of_memory(stl->reader);
        }
    }
    return SVO_OK;
}

static svo_status begin_facet(stl_text *stl)
{
    SVO_I_TRY(end_facet(stl));
    stl->in_facet = true;
    stl->corner_count = 0;
    stl->facet_line = stl->cursor.line;
    memset(stl->normal, 0, sizeof stl->normal);
    (void)text_skip_blanks(&stl->cursor);
    return text_take_keyword(&stl->cursor, "normal") ? read_vector(stl, stl->normal) : SVO_OK;
}

/* More than three vertices in a facet are no STL, but some programs write them. */
static svo_status add_vertex(stl_text *stl)
{
    if (!stl->in_facet) {
        return svo_i_fail(stl->reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": a vertex outside of a facet",
                          stl->cursor.line);
    }
    float position[3];
    SVO_I_TRY(read_vector(stl, position));
    if (stl->corner_count >= stl->shape.corner_capacity) {
        polygon larger = {.crossed_count = stl->shape.crossed_count};
        if (!svo_i_polygon_reserve(&larger, 2 * (size_t)stl->corner_count + 4)) {
            return svo_i_read_out_of_memory(stl->reader);
        }
        if (stl->corner_count > 0) {
            memcpy(larger.corners, stl->shape.corners, stl->corner_count * sizeof *larger.corners);
        }
        svo_i_polygon_free(&stl->shape);
        stl->shape = larger;
    }
    memcpy(stl->shape.corners[stl->corner_count++], position, sizeof position);
    return SVO_OK;
}

static void skip_unknown(stl_text *stl)
{
    if (stl->unknown_count++ == 0) {
        stl->first_unknown = text_copy_word(&stl->cursor);
        stl->first_unknown_line = stl->cursor.line;
    }
    text_skip_word(&stl->cursor);
}

/* The next keyword and what belongs to it. Names of solids are the rest of their line. */
static svo_status read_keyword(stl_text *stl)
{
    text_cursor *cursor = &stl->cursor;
    if (text_take_keyword(cursor, "vertex")) {
        return add_vertex(stl);
    }
    if (text_take_keyword(cursor, "facet")) {
        return begin_facet(stl);
    }
    if (text_take_keyword(cursor, "endfacet")) {
        return end_facet(stl);
    }
    if (text_take_keyword(cursor, "solid") || text_take_keyword(cursor, "endsolid")) {
        text_skip_line(cursor);
        return end_facet(stl);
    }
    if (!text_take_keyword(cursor, "outer") && !text_take_keyword(cursor, "loop") &&
        !text_take_keyword(cursor, "endloop")) {
        skip_unknown(stl);
    }
    return SVO_OK;
}

static svo_status read_keywords(stl_text *stl)
{
    for (;;) {
        if (!text_skip_blanks(&stl->cursor)) {
            if (stl->cursor.at == stl->cursor.end) {
                return SVO_OK;
            }
            text_skip_line_end(&stl->cursor);
            continue;
        }
        SVO_I_TRY(read_keyword(stl));
    }
}

static svo_status check_end(const stl_text *stl)
{
    if (stl->in_facet) {
        return svo_i_fail(stl->reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": the file ends in the facet that begins in line %" PRIu64, stl->cursor.line,
                          stl->facet_line);
    }
    if (stl->unknown_count > 0) {
        svo_i_read_warn(stl->reader,
                        "%" PRIu64 " words are none of STL's and are skipped; the first is '%s' in line %" PRIu64,
                        stl->unknown_count, stl->first_unknown.text, stl->first_unknown_line);
    }
    svo_i_read_warn_odd(&stl->numbers);
    svo_i_read_count_vertices(stl->reader, stl->vertex_count, stl->vertex_count);
    svo_i_read_count_faces(stl->reader, 0, stl->facet_count);
    return SVO_OK;
}

static svo_status read_text(const mesh_reader *reader)
{
    svo_status status = SVO_OK;
    stl_text stl = {.reader = reader, .numbers = {.reader = reader}};
    SVO_I_TRY(svo_i_read_begin_text(reader, &stl.cursor));
    reader->mesh->has_normals = true;
    SVO_I_TRY_CLEANUP(read_keywords(&stl));
    SVO_I_TRY_CLEANUP(check_end(&stl));
cleanup:
    svo_i_polygon_free(&stl.shape);
    return status;
}

bool svo_i_stl_is_text(const char *bytes, size_t byte_count, uint64_t whole_bytes)
{
    if (byte_count >= STL_BEGIN_BYTES &&
        STL_BEGIN_BYTES + (uint64_t)read_u32(bytes + HEADER_BYTES) * STL_FACET_BYTES == whole_bytes) {
        return false;
    }
    text_cursor cursor = {.at = bytes, .end = bytes + byte_count, .line = 1};
    while (!text_skip_blanks(&cursor) && cursor.at != cursor.end) {
        text_skip_line_end(&cursor);
    }
    if (!text_take_keyword(&cursor, "solid")) {
        return false;
    }
    const size_t probe_bytes = byte_count < PROBE_BYTES ? byte_count : PROBE_BYTES;
    return memchr(bytes, '\0', probe_bytes) == NULL;
}

svo_status svo_i_read_stl(mesh_reader *reader)
{
    if (svo_i_stl_is_text(reader->bytes, reader->byte_count, reader->byte_count)) {
        return read_text(reader);
    }
    if (reader->byte_count < STL_BEGIN_BYTES) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED,
                          "no STL file: no 'solid' at its begin, and %zu bytes, where a binary one has at least %d",
                          reader->byte_count, STL_BEGIN_BYTES);
    }
    return read_binary(reader);
}
