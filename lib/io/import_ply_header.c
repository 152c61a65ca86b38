/* SPDX-License-Identifier: MIT */
/* The header of a PLY file: its format, and the elements with their properties. */
#include "io/import_ply_header.h"

#include <inttypes.h>
#include <stdlib.h>

#include "core/message.h"

size_t svo_i_ply_type_bytes(ply_type type)
{
    static const size_t bytes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
    return bytes[type];
}

size_t svo_i_ply_find(const ply_element *element, const char *name)
{
    size_t i = 0;
    while (i < element->property_count && strcmp(element->properties[i].name, name) != 0) {
        ++i;
    }
    return i;
}

void svo_i_ply_header_free(ply_header *header)
{
    for (size_t i = 0; i < header->element_count; ++i) {
        free(header->elements[i].properties);
    }
    header->element_count = 0;
}

static svo_status refuse(const mesh_reader *reader, const text_cursor *cursor, const char *expected)
{
    return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": '%s' where %s is needed", cursor->line,
                      text_copy_word(cursor).text, expected);
}

static svo_status take_format(const mesh_reader *reader, text_cursor *cursor, ply_header *header)
{
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    (void)text_skip_blanks(cursor);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (text_take_word(cursor, names[i])) {
            header->format = (ply_format)i;
            return SVO_OK;
        }
    }
    return refuse(reader, cursor, "ascii, binary_little_endian or binary_big_endian");
}

static svo_status take_name(const mesh_reader *reader, text_cursor *cursor, char name[PLY_NAME_BYTES])
{
    (void)text_skip_blanks(cursor);
    const char *begin = cursor->at;
    text_skip_word(cursor);
    const size_t length = (size_t)(cursor->at - begin);
    if (length == 0 || length >= PLY_NAME_BYTES) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": a name of %zu bytes, which is not in 1 .. %d", cursor->line, length,
                          PLY_NAME_BYTES - 1);
    }
    memcpy(name, begin, length);
    name[length] = '\0';
    return SVO_OK;
}

static svo_status take_element(const mesh_reader *reader, text_cursor *cursor, ply_header *header)
{
    int64_t count = 0;
    if (header->element_count == PLY_ELEMENTS_MAX) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": more than %d elements", cursor->line,
                          PLY_ELEMENTS_MAX);
    }
    ply_element *element = &header->elements[header->element_count];
    *element = (ply_element){.count = 0};
    SVO_I_TRY(take_name(reader, cursor, element->name));
    (void)text_skip_blanks(cursor);
    const text_cursor number = *cursor;
    if (!text_take_integer(cursor, &count) || count < 0 || !text_at_word_end(cursor)) {
        return refuse(reader, &number, "a number of elements from 0 on");
    }
    element->properties = malloc(PLY_PROPERTIES_MAX * sizeof *element->properties);
    if (element->properties == NULL) {
        return svo_i_read_out_of_memory(reader);
    }
    element->count = (uint64_t)count;
    ++header->element_count;
    return SVO_OK;
}

static svo_status take_type(const mesh_reader *reader, text_cursor *cursor, ply_type *type)
{
    static const struct {
        const char *name;
        ply_type type;
    } names[] = {{"float", PLY_FLOAT},    {"uchar", PLY_UINT8}, {"int", PLY_INT32},   {"uint", PLY_UINT32},
                 {"double", PLY_DOUBLE},  {"char", PLY_INT8},   {"short", PLY_INT16}, {"ushort", PLY_UINT16},
                 {"float32", PLY_FLOAT},  {"uint8", PLY_UINT8}, {"int32", PLY_INT32}, {"uint32", PLY_UINT32},
                 {"float64", PLY_DOUBLE}, {"int8", PLY_INT8},   {"int16", PLY_INT16}, {"uint16", PLY_UINT16},
                 {"double64", PLY_DOUBLE}};
    (void)text_skip_blanks(cursor);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (text_take_word(cursor, names[i].name)) {
            *type = names[i].type;
            return SVO_OK;
        }
    }
    return refuse(reader, cursor, "a type (char, uchar, short, ushort, int, uint, float, double)");
}

static svo_status take_property(const mesh_reader *reader, text_cursor *cursor, ply_header *header)
{
    if (header->element_count == 0) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": a property before the first element",
                          cursor->line);
    }
    ply_element *element = &header->elements[header->element_count - 1];
    if (element->property_count == PLY_PROPERTIES_MAX) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": element %s has more than %d properties", cursor->line, element->name,
                          PLY_PROPERTIES_MAX);
    }
    ply_property *property = &element->properties[element->property_count];
    *property = (ply_property){.count_type = PLY_NO_TYPE};
    (void)text_skip_blanks(cursor);
    const bool is_list = text_take_word(cursor, "list");
    if (is_list) {
        SVO_I_TRY(take_type(reader, cursor, &property->count_type));
    }
    SVO_I_TRY(take_type(reader, cursor, &property->type));
    SVO_I_TRY(take_name(reader, cursor, property->name));
    if (property->count_type == PLY_FLOAT || property->count_type == PLY_DOUBLE) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": the length of list %s is no whole number", cursor->line, property->name);
    }
    ++element->property_count;
    return SVO_OK;
}

/* "comment TextureFile NAME", as MeshLab writes it. */
static void take_comment(text_cursor *cursor, ply_header *header)
{
    size_t length = 0;
    (void)text_skip_blanks(cursor);
    if (text_take_word(cursor, "TextureFile")) {
        const char *name = text_rest_of_line(cursor, &length);
        if (length < sizeof header->texture_file) {
            memcpy(header->texture_file, name, length);
            header->texture_file[length] = '\0';
        }
    }
}

/* A line of the header. *done: it was the last. */
static svo_status take_line(const mesh_reader *reader, text_cursor *cursor, ply_header *header, bool *has_format,
                            bool *done)
{
    if (!text_skip_blanks(cursor)) {
        return SVO_OK;
    }
    if (text_take_word(cursor, "format")) {
        *has_format = true;
        return take_format(reader, cursor, header);
    }
    if (text_take_word(cursor, "element")) {
        return take_element(reader, cursor, header);
    }
    if (text_take_word(cursor, "property")) {
        return take_property(reader, cursor, header);
    }
    if (text_take_word(cursor, "comment")) {
        take_comment(cursor, header);
        return SVO_OK;
    }
    *done = text_take_word(cursor, "end_header");
    return *done || text_take_word(cursor, "obj_info")
               ? SVO_OK
               : refuse(reader, cursor, "format, element, property, comment, obj_info or end_header");
}

/* The break after end_header. Behind CR alone, LF is data, unless all lines end with CR LF. */
static void skip_last_break(text_cursor *cursor, bool cr_alone)
{
    while (!text_at_line_end(cursor)) {
        ++cursor->at;
    }
    if (cr_alone && cursor->at != cursor->end) {
        ++cursor->at;
        ++cursor->line;
    } else {
        text_skip_line_end(cursor);
    }
}

svo_status svo_i_ply_read_header(const mesh_reader *reader, text_cursor *cursor, ply_header *header)
{
    bool has_format = false, done = false;
    SVO_I_TRY(svo_i_read_begin_text(reader, cursor));
    if (!text_take_word(cursor, "ply") && !text_take_word(cursor, "PLY")) {
        return refuse(reader, cursor, "ply");
    }
    const bool cr_alone = cursor->end - cursor->at > 1 && cursor->at[0] == '\r' && cursor->at[1] != '\n';
    while (!done) {
        text_skip_line(cursor);
        if (cursor->at == cursor->end) {
            return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": the file ends before end_header",
                              cursor->line);
        }
        SVO_I_TRY(take_line(reader, cursor, header, &has_format, &done));
    }
    skip_last_break(cursor, cr_alone);
    return has_format
               ? SVO_OK
               : svo_i_fail(reader->message, SVO_IMPORT_FAILED, "the header names no format (ascii, binary_...)");
}
