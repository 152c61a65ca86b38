/* SPDX-License-Identifier: MIT */
/*
 * A PLY file (Turk, "The PLY Polygon File Format", 1994), in the import child and where it is read in blocks: the
 * header, which says what its elements and their properties are, the values in three formats, and vertices of them.
 */
#include "io/import_ply_file.h"

#include <inttypes.h>
#include <stdlib.h>

#include "core/message.h"
#include "io/import_text.h"

/* ---- the header ---- */

size_t svo_i_ply_type_bytes(ply_type type)
{
    static const size_t bytes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
    return bytes[type];
}

size_t svo_i_ply_fixed_bytes(const ply_element *element)
{
    size_t bytes = 0;
    for (size_t i = 0; i < element->property_count; ++i) {
        if (element->properties[i].count_type != PLY_NO_TYPE) {
            return 0;
        }
        bytes += svo_i_ply_type_bytes(element->properties[i].type);
    }
    return bytes;
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

/*
 * ---- values ----
 *
 * In ascii files each instance of an element is on a line of its own; empty lines are skipped.
 */

static size_t left_bytes(const ply_source *source)
{
    return (size_t)(source->cursor.end - source->cursor.at);
}

/* The same to the end of the file. */
static uint64_t file_bytes_left(const ply_source *source)
{
    return left_bytes(source) + source->later_bytes;
}

/* "line 12" or "byte 345" of the file. */
static text_word place(const ply_source *source)
{
    text_word word;
    const bool is_text = source->format == PLY_ASCII;
    svo_message text;
    (void)svo_i_fail(&text, SVO_OK, "%s %" PRIu64, is_text ? "line" : "byte",
                     is_text ? source->cursor.line
                             : source->earlier_bytes + (uint64_t)(source->cursor.at - source->reader->bytes));
    memcpy(word.text, text.text, sizeof word.text - 1);
    word.text[sizeof word.text - 1] = '\0';
    return word;
}

static svo_status ends_early(const ply_source *source)
{
    const bool line_ends = source->format == PLY_ASCII && source->cursor.at != source->cursor.end;
    return svo_i_fail(source->reader->message, SVO_IMPORT_FAILED,
                      "%s: the %s ends in %s %" PRIu64 " of %" PRIu64 " (counted from 0)", place(source).text,
                      line_ends ? "line" : "file", source->element->name, source->instance, source->element->count);
}

svo_status svo_i_ply_check_fit(const ply_source *source, const ply_element *element)
{
    uint64_t each_bytes = 0;
    for (size_t i = 0; i < element->property_count; ++i) {
        const ply_property *property = &element->properties[i];
        const ply_type type = property->count_type != PLY_NO_TYPE ? property->count_type : property->type;
        each_bytes += source->format == PLY_ASCII ? 2 : svo_i_ply_type_bytes(type);
    }
    /* The last value of an ascii file needs no break behind it. */
    const uint64_t available_bytes = file_bytes_left(source) + (source->format == PLY_ASCII ? 1 : 0);
    if (each_bytes != 0 && element->count > available_bytes / each_bytes) {
        return svo_i_fail(source->reader->message, SVO_IMPORT_FAILED,
                          "%s: %" PRIu64 " of element %s need at least %" PRIu64 " bytes each, and %" PRIu64
                          " are left",
                          place(source).text, element->count, element->name, each_bytes, file_bytes_left(source));
    }
    return SVO_OK;
}

svo_status svo_i_ply_begin_instance(ply_source *source)
{
    if (source->format != PLY_ASCII || source->element->property_count == 0) {
        return SVO_OK;
    }
    while (!text_skip_blanks(&source->cursor)) {
        if (source->cursor.at == source->cursor.end) {
            return ends_early(source);
        }
        text_skip_line_end(&source->cursor);
    }
    return SVO_OK;
}

void svo_i_ply_end_instance(ply_source *source)
{
    if (source->format != PLY_ASCII || source->element->property_count == 0) {
        return;
    }
    if (text_skip_blanks(&source->cursor) && source->long_count++ == 0) {
        source->first_long_line = source->cursor.line;
    }
    text_skip_line(&source->cursor);
}

/* The bytes of a binary value as a number whose lowest byte is the first of a little-endian file. */
static svo_status take_bits(ply_source *source, size_t byte_count, uint64_t *bits)
{
    if (left_bytes(source) < byte_count) {
        return ends_early(source);
    }
    const uint8_t *bytes = (const uint8_t *)source->cursor.at;
    uint64_t value = 0;
    if (source->format == PLY_LITTLE_ENDIAN) {
        for (size_t i = byte_count; i > 0; --i) {
            value = value << 8 | bytes[i - 1];
        }
    } else {
        for (size_t i = 0; i < byte_count; ++i) {
            value = value << 8 | bytes[i];
        }
    }
    source->cursor.at += byte_count;
    *bits = value;
    return SVO_OK;
}

static int64_t integer_of(ply_type type, uint64_t bits)
{
    switch (type) {
    case PLY_INT8:
        return (int8_t)bits;
    case PLY_INT16:
        return (int16_t)bits;
    case PLY_INT32:
        return (int32_t)bits;
    default:
        return (int64_t)bits;
    }
}

svo_status svo_i_ply_float(ply_source *source, ply_type type, float *value)
{
    if (source->format == PLY_ASCII) {
        if (!text_skip_blanks(&source->cursor)) {
            return ends_early(source);
        }
        return svo_i_read_float(&source->numbers, &source->cursor, value);
    }
    uint64_t bits = 0;
    SVO_I_TRY(take_bits(source, svo_i_ply_type_bytes(type), &bits));
    if (type == PLY_FLOAT) {
        const uint32_t low = (uint32_t)bits;
        memcpy(value, &low, sizeof low);
    } else if (type == PLY_DOUBLE) {
        double exact = 0;
        memcpy(&exact, &bits, sizeof exact);
        *value = (float)exact;
    } else {
        *value = (float)integer_of(type, bits);
    }
    return SVO_OK;
}

static svo_status no_integer(const ply_source *source)
{
    return svo_i_fail(source->reader->message, SVO_IMPORT_FAILED, "%s: '%s' is no whole number", place(source).text,
                      text_copy_word(&source->cursor).text);
}

svo_status svo_i_ply_integer(ply_source *source, ply_type type, int64_t *value)
{
    if (source->format == PLY_ASCII) {
        if (!text_skip_blanks(&source->cursor)) {
            return ends_early(source);
        }
        const text_cursor word = source->cursor;
        if (!text_take_integer(&source->cursor, value) || !text_at_word_end(&source->cursor)) {
            source->cursor = word;
            return no_integer(source);
        }
        return SVO_OK;
    }
    uint64_t bits = 0;
    if (type == PLY_FLOAT || type == PLY_DOUBLE) {
        float number = 0;
        SVO_I_TRY(svo_i_ply_float(source, type, &number));
        *value = number >= -1e9f && number <= 1e9f ? (int64_t)number : INT64_MAX;
        return SVO_OK;
    }
    SVO_I_TRY(take_bits(source, svo_i_ply_type_bytes(type), &bits));
    *value = integer_of(type, bits);
    return SVO_OK;
}

svo_status svo_i_ply_list_length(ply_source *source, const ply_property *property, uint64_t *length)
{
    int64_t value = 0;
    SVO_I_TRY(svo_i_ply_integer(source, property->count_type, &value));
    const size_t each_bytes = source->format == PLY_ASCII ? 2 : svo_i_ply_type_bytes(property->type);
    if (value < 0 || (uint64_t)value > file_bytes_left(source) / each_bytes + 1) {
        return svo_i_fail(source->reader->message, SVO_IMPORT_FAILED,
                          "%s: list %s of %s %" PRIu64 " has length %" PRId64 ", and %" PRIu64 " bytes are left",
                          place(source).text, property->name, source->element->name, source->instance, value,
                          file_bytes_left(source));
    }
    *length = (uint64_t)value;
    return SVO_OK;
}

static svo_status skip_values(ply_source *source, ply_type type, uint64_t count)
{
    if (source->format != PLY_ASCII) {
        const uint64_t byte_count = count * svo_i_ply_type_bytes(type);
        if (byte_count > left_bytes(source)) {
            return ends_early(source);
        }
        source->cursor.at += byte_count;
        return SVO_OK;
    }
    for (uint64_t i = 0; i < count; ++i) {
        if (!text_skip_blanks(&source->cursor)) {
            return ends_early(source);
        }
        text_skip_word(&source->cursor);
    }
    return SVO_OK;
}

svo_status svo_i_ply_skip(ply_source *source, const ply_property *property)
{
    uint64_t count = 1;
    if (property->count_type != PLY_NO_TYPE) {
        SVO_I_TRY(svo_i_ply_list_length(source, property, &count));
    }
    return skip_values(source, property->type, count);
}

svo_status svo_i_ply_skip_element(ply_source *source, const ply_element *element)
{
    source->element = element;
    for (uint64_t i = 0; i < element->count && element->property_count > 0; ++i) {
        source->instance = i;
        SVO_I_TRY(svo_i_ply_begin_instance(source));
        for (size_t k = 0; k < element->property_count; ++k) {
            SVO_I_TRY(svo_i_ply_skip(source, &element->properties[k]));
        }
        svo_i_ply_end_instance(source);
    }
    return SVO_OK;
}

/* ---- vertices ---- */

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
