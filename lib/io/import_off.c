/* SPDX-License-Identifier: MIT */
/*
 * OFF in the import child, as Geomview's manual describes it: [ST][C][N][4]OFF, in text. Normals and colors of vertices
 * are read; texture coordinates are not, since the format names no texture, nor are colors of faces.
 */
#include <inttypes.h>

#include "core/message.h"
#include "io/import_faces.h"
#include "io/import_formats.h"
#include "io/import_text.h"

#define VERTEX_BYTES_MIN 6 /* three digits and what is between them */
#define FACE_BYTES_MIN   2 /* a count and a line break */

typedef struct off_reader {
    const mesh_reader *reader;
    text_cursor cursor;
    number_reader numbers;
    bool has_uvs, has_colors, has_normals, has_weights;
    uint64_t vertex_count, face_count;
    face_list faces;
} off_reader;

/* Goes to the next line that holds more than blanks and a comment. Returns false at the end of the file. */
static bool skip_to_data(text_cursor *cursor)
{
    while (!text_skip_blanks(cursor) || *cursor->at == '#') {
        if (cursor->at == cursor->end) {
            return false;
        }
        text_skip_line(cursor);
    }
    return true;
}

static bool take_letters(text_cursor *cursor, const char *letters)
{
    const size_t length = strlen(letters);
    if ((size_t)(cursor->end - cursor->at) < length || memcmp(cursor->at, letters, length) != 0) {
        return false;
    }
    cursor->at += length;
    return true;
}

/* "STCN4OFF" or a part of it. Geomview lets a file begin with its counts. */
static svo_status read_kind(off_reader *off)
{
    text_cursor *cursor = &off->cursor;
    if (!skip_to_data(cursor)) {
        return svo_i_fail(off->reader->message, SVO_IMPORT_FAILED, "no OFF file: it is empty");
    }
    if (*cursor->at >= '0' && *cursor->at <= '9') {
        text_cursor number = *cursor;
        text_skip_word(&number);
        if (number.at - cursor->at != 4 || memcmp(cursor->at, "4OFF", 4) != 0) {
            return SVO_OK;
        }
    }
    const text_word word = text_copy_word(cursor);
    off->has_uvs = take_letters(cursor, "ST");
    off->has_colors = take_letters(cursor, "C");
    off->has_normals = take_letters(cursor, "N");
    off->has_weights = take_letters(cursor, "4");
    if (!text_take_word(cursor, "OFF")) {
        return svo_i_fail(off->reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": '%s' is none of the kinds [ST][C][N][4]OFF", cursor->line, word.text);
    }
    (void)text_skip_blanks(cursor);
    if (text_take_word(cursor, "BINARY")) {
        return svo_i_fail(off->reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": binary OFF is not read",
                          cursor->line);
    }
    return SVO_OK;
}

static svo_status read_count(off_reader *off, const char *what, uint64_t bytes_each, uint64_t *count)
{
    int64_t value = 0;
    text_cursor *cursor = &off->cursor;
    if (!skip_to_data(cursor) || !text_take_integer(cursor, &value) || value < 0) {
        return svo_i_fail(off->reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": '%s' is no number of %s",
                          cursor->line, text_copy_word(cursor).text, what);
    }
    const uint64_t left_bytes = (uint64_t)(cursor->end - cursor->at);
    if ((uint64_t)value > left_bytes / bytes_each) {
        return svo_i_fail(off->reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": %" PRId64 " %s do not fit into the %" PRIu64 " bytes that are left",
                          cursor->line, value, what, left_bytes);
    }
    *count = (uint64_t)value;
    return SVO_OK;
}

/* The number of edges may be missing; nothing depends on it. */
static svo_status read_counts(off_reader *off)
{
    int64_t edge_count = 0;
    SVO_I_TRY(read_count(off, "vertices", VERTEX_BYTES_MIN, &off->vertex_count));
    SVO_I_TRY(read_count(off, "faces", FACE_BYTES_MIN, &off->face_count));
    if (text_skip_blanks(&off->cursor)) {
        (void)text_take_integer(&off->cursor, &edge_count);
    }
    return SVO_OK;
}

/* One to four numbers, all whole for 0 .. 255, else 0 .. 1. Green and blue are 0, alpha is 1 where they are missing. */
static svo_status read_color(off_reader *off, uint8_t rgba[4])
{
    float channels[4] = {0, 0, 0, 1};
    bool is_whole = true;
    int count = 0;
    for (; count < 4 && text_skip_blanks(&off->cursor) && *off->cursor.at != '#'; ++count) {
        const char *begin = off->cursor.at;
        SVO_I_TRY(svo_i_read_float(&off->numbers, &off->cursor, &channels[count]));
        is_whole = is_whole && memchr(begin, '.', (size_t)(off->cursor.at - begin)) == NULL;
    }
    for (int i = 0; i < 4; ++i) {
        rgba[i] = svo_i_import_color_byte(is_whole && i < count ? channels[i] / 255.0f : channels[i]);
    }
    return SVO_OK;
}

static svo_status read_vector(off_reader *off, float vector[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        SVO_I_TRY(svo_i_read_float(&off->numbers, &off->cursor, &vector[axis]));
    }
    return SVO_OK;
}

static svo_status ends_early(const off_reader *off, const char *what, uint64_t count, uint64_t declared)
{
    return svo_i_fail(off->reader->message, SVO_IMPORT_FAILED,
                      "line %" PRIu64 ": the file ends after %" PRIu64 " of %" PRIu64 " %s", off->cursor.line, count,
                      declared, what);
}

static svo_status read_vertex(off_reader *off, gather_vertex *vertex)
{
    float weight = 1;
    SVO_I_TRY(read_vector(off, vertex->position));
    if (off->has_weights) {
        SVO_I_TRY(svo_i_read_float(&off->numbers, &off->cursor, &weight));
        for (int axis = 0; axis < 3; ++axis) {
            vertex->position[axis] /= weight;
        }
    }
    if (off->has_normals) {
        SVO_I_TRY(read_vector(off, vertex->normal));
    }
    return off->has_colors ? read_color(off, vertex->color) : SVO_OK;
}

static svo_status read_vertices(off_reader *off)
{
    for (uint64_t i = 0; i < off->vertex_count; ++i) {
        if (!skip_to_data(&off->cursor)) {
            return ends_early(off, "vertices", i, off->vertex_count);
        }
        SVO_I_TRY(read_vertex(off, &off->faces.vertices[i]));
        text_skip_line(&off->cursor);
    }
    return SVO_OK;
}

static svo_status read_index(off_reader *off, int64_t *index)
{
    text_cursor *cursor = &off->cursor;
    if (!text_skip_blanks(cursor) || !text_take_integer(cursor, index) || !text_at_word_end(cursor)) {
        return svo_i_fail(off->reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": '%s' is no vertex index",
                          cursor->line, text_copy_word(cursor).text);
    }
    if (*index < 0 || (uint64_t)*index >= off->vertex_count) {
        return svo_i_fail(off->reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": vertex %" PRId64 " is not in 0 .. %" PRIu64, cursor->line, *index,
                          off->vertex_count - 1);
    }
    return SVO_OK;
}

static svo_status read_face(off_reader *off)
{
    int64_t corner_count = 0;
    text_cursor *cursor = &off->cursor;
    (void)text_skip_blanks(cursor);
    if (!text_take_integer(cursor, &corner_count) || corner_count < 0 || !text_at_word_end(cursor)) {
        return svo_i_fail(off->reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": '%s' is no number of corners",
                          cursor->line, text_copy_word(cursor).text);
    }
    if (corner_count > (cursor->end - cursor->at) / 2 + 1) {
        return svo_i_fail(off->reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": %" PRId64 " corners do not fit into the file", cursor->line, corner_count);
    }
    SVO_I_TRY(svo_i_faces_reserve(&off->faces, (uint64_t)corner_count));
    for (int64_t i = 0; i < corner_count; ++i) {
        SVO_I_TRY(read_index(off, &off->faces.corners[i]));
    }
    return svo_i_faces_add(&off->faces, (uint32_t)corner_count, false);
}

static svo_status read_faces(off_reader *off)
{
    for (uint64_t i = 0; i < off->face_count; ++i) {
        if (!skip_to_data(&off->cursor)) {
            return ends_early(off, "faces", i, off->face_count);
        }
        SVO_I_TRY(read_face(off));
        text_skip_line(&off->cursor);
    }
    return SVO_OK;
}

svo_status svo_i_read_off(mesh_reader *reader)
{
    off_reader off = {.reader = reader, .numbers = {.reader = reader}};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_read_begin_text(reader, &off.cursor));
    SVO_I_TRY(read_kind(&off));
    SVO_I_TRY(read_counts(&off));
    reader->mesh->has_normals = off.has_normals;
    reader->mesh->has_colors = off.has_colors;
    SVO_I_TRY_CLEANUP(svo_i_faces_begin(&off.faces, reader, off.vertex_count));
    text_skip_line(&off.cursor);
    SVO_I_TRY_CLEANUP(read_vertices(&off));
    SVO_I_TRY_CLEANUP(svo_i_faces_end_vertices(&off.faces, false));
    SVO_I_TRY_CLEANUP(read_faces(&off));
    svo_i_faces_end(&off.faces);
    svo_i_read_warn_odd(&off.numbers);
    if (skip_to_data(&off.cursor)) {
        svo_i_read_warn(reader, "line %" PRIu64 ": more follows after the %" PRIu64 " faces that are declared",
                        off.cursor.line, off.face_count);
    }
cleanup:
    svo_i_faces_free(&off.faces);
    return status;
}
