/* SPDX-License-Identifier: MIT */
/*
 * The vertices of .ply files as points, in blocks. In binary files they are records of one length, and what comes
 * before them must be so too; in text each is a line. import_ply_file.c reads the header.
 */
#include "io/points_read.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "io/import_text.h"

/* ---- the header ---- */

static point_slot slot_of(const char *name)
{
    static const struct {
        const char *name;
        int slot;
    } names[] = {{"x", POINT_X},
                 {"y", POINT_X + 1},
                 {"z", POINT_X + 2},
                 {"red", POINT_RED},
                 {"green", POINT_RED + 1},
                 {"blue", POINT_RED + 2},
                 {"r", POINT_RED},
                 {"g", POINT_RED + 1},
                 {"b", POINT_RED + 2},
                 {"diffuse_red", POINT_RED},
                 {"diffuse_green", POINT_RED + 1},
                 {"diffuse_blue", POINT_RED + 2},
                 {"intensity", POINT_INTENSITY},
                 {"scalar_intensity", POINT_INTENSITY},
                 {"scalar_Intensity", POINT_INTENSITY}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strcmp(name, names[i].name) == 0) {
            return (point_slot)names[i].slot;
        }
    }
    return POINT_NO_SLOT;
}

static bool is_fraction(ply_type type)
{
    return type == PLY_FLOAT || type == PLY_DOUBLE;
}

/* Whether the channels of colors are as wide as 16 bits: fractions become such. */
static bool is_wide(ply_type type)
{
    return is_fraction(type) || type == PLY_UINT16 || type == PLY_INT16;
}

/* The place of each value of a vertex. Of several for one component the last one counts. */
static svo_status note_values(points_reader *reader, const ply_element *vertices)
{
    size_t offset = 0;
    bool wide = false;
    bool narrow = false;
    for (size_t i = 0; i < vertices->property_count; ++i) {
        const ply_property *property = &vertices->properties[i];
        point_slot slot = property->count_type == PLY_NO_TYPE ? slot_of(property->name) : POINT_NO_SLOT;
        slot = slot == POINT_INTENSITY && is_fraction(property->type) ? POINT_NO_SLOT : slot;
        if (slot != POINT_NO_SLOT) {
            reader->values[slot] = (point_value){offset, property->type};
        }
        wide = wide || (slot >= POINT_RED && slot < POINT_INTENSITY && is_wide(property->type));
        narrow = narrow || (slot >= POINT_RED && slot < POINT_INTENSITY && !is_wide(property->type));
        reader->slots[i] = (uint8_t)slot;
        reader->types[i] = property->type;
        offset += svo_i_ply_type_bytes(property->type);
    }
    reader->record_bytes = offset;
    reader->value_count = vertices->property_count;
    reader->rgb_max = wide ? 65535 : 255;
    for (int axis = 0; axis < 3; ++axis) {
        if (reader->values[POINT_X + axis].type == PLY_NO_TYPE) {
            return svo_i_points_damaged(reader, "element vertex has no property %c, before byte %" PRIu64, "xyz"[axis],
                                        reader -> begin);
        }
    }
    return wide && narrow ? svo_i_points_fail(reader, SVO_UNSUPPORTED, "colors whose channels have different types")
                          : SVO_OK;
}

/* Adds what an element before the vertices takes. */
static svo_status pass_element(points_reader *reader, const ply_element *element, bool is_text)
{
    const size_t bytes = svo_i_ply_fixed_bytes(element);
    const uint64_t left = reader->file.byte_count - reader->begin;
    if (element->count == 0 || element->property_count == 0) {
        return SVO_OK;
    }
    if (!is_text && bytes == 0) {
        return svo_i_points_fail(reader, SVO_UNSUPPORTED, "element %s, which has lists, comes before element vertex",
                                 element->name);
    }
    if (element->count > left / (is_text ? 1 : bytes)) {
        return svo_i_points_damaged(
            reader, "%" PRIu64 " of element %s do not fit in the %" PRIu64 " bytes from byte %" PRIu64 " on",
            element->count, element->name, left, reader->begin);
    }
    reader->lines_before += element->count;
    reader->begin += is_text ? 0 : element->count * bytes;
    return SVO_OK;
}

static svo_status take_vertices(points_reader *reader, const ply_element *vertices, bool is_text)
{
    SVO_I_TRY(note_values(reader, vertices));
    const size_t bytes = svo_i_ply_fixed_bytes(vertices);
    const uint64_t left = reader->file.byte_count - reader->begin;
    if (bytes == 0) {
        return svo_i_points_fail(reader, SVO_UNSUPPORTED, "element vertex has a list");
    }
    /* The last value of a text needs no break behind it. */
    const uint64_t room = is_text ? (left + 1) / (2 * vertices->property_count) : left / bytes;
    if (vertices->count > room || vertices->count > SVO_POINTS_MAX) {
        return svo_i_points_damaged(reader,
                                    "%" PRIu64 " of element vertex, where there is room for %" PRIu64 " in the %" PRIu64
                                    " bytes from byte %" PRIu64 " on",
                                    vertices->count, room, left, reader->begin);
    }
    reader->info->point_count = vertices->count;
    return SVO_OK;
}

static svo_status take_header(points_reader *reader, const ply_header *header)
{
    const bool is_text = header->format == PLY_ASCII;
    reader->is_big_endian = header->format == PLY_BIG_ENDIAN;
    for (size_t i = 0; i < header->element_count; ++i) {
        if (strcmp(header->elements[i].name, "vertex") == 0) {
            return take_vertices(reader, &header->elements[i], is_text);
        }
        SVO_I_TRY(pass_element(reader, &header->elements[i], is_text));
    }
    return svo_i_points_damaged(reader, "no element vertex in the header, before byte %" PRIu64, reader->begin);
}

/* ---- binary ---- */

static double value_of(uint64_t bits, ply_type type)
{
    const uint32_t low = (uint32_t)bits;
    float single = 0.0f;
    double value = 0.0;
    switch (type) {
    case PLY_INT8:
        return (int8_t)(uint8_t)bits;
    case PLY_INT16:
        return (int16_t)(uint16_t)bits;
    case PLY_INT32:
        return (int32_t)low;
    case PLY_FLOAT:
        memcpy(&single, &low, sizeof single);
        return (double)single;
    case PLY_DOUBLE:
        memcpy(&value, &bits, sizeof value);
        return value;
    default:
        return (double)bits;
    }
}

/* A whole number that a channel or an intensity can be: the nearest, and 0 for what is no number. */
static uint16_t whole_of(double value, double most)
{
    const double rounded = floor(value + 0.5);
    return rounded >= most ? (uint16_t)most : rounded > 0.0 ? (uint16_t)rounded : 0;
}

/* Signed types hold colors as the importer of meshes has them: the least but one is 0. */
static uint16_t channel_of(const points_reader *reader, double value, ply_type type)
{
    const double most = reader->rgb_max;
    const double shifted = type == PLY_INT8 ? value + 127.0 : type == PLY_INT16 ? value + 32767.0 : value;
    return whole_of(is_fraction(type) ? value * most : shifted, most);
}

static void put_value(const points_reader *reader, svo_point *point, size_t slot, double value, ply_type type)
{
    if (slot < POINT_RED) {
        point->at[slot] = value;
    } else if (slot < POINT_INTENSITY) {
        point->rgb[slot - POINT_RED] = channel_of(reader, value, type);
    } else {
        point->intensity = whole_of(value, UINT16_MAX);
    }
}

static bool turn_record(const points_reader *reader, const uint8_t *record, svo_point *point)
{
    *point = (svo_point){.intensity = 0};
    for (size_t slot = 0; slot < POINT_SLOTS; ++slot) {
        const point_value *value = &reader->values[slot];
        if (value->type != PLY_NO_TYPE) {
            const uint64_t bits =
                point_bits(record + value->offset, svo_i_ply_type_bytes(value->type), reader->is_big_endian);
            put_value(reader, point, slot, value_of(bits, value->type), value->type);
        }
    }
    return true;
}

static svo_status next_records(points_reader *reader, svo_point *points, size_t *count)
{
    return svo_i_points_next_records(reader, turn_record, points, count);
}

/* ---- text ---- */

/* The next line that is not empty, without what ends it; the cursor has its end. */
static svo_status take_line(points_reader *reader, text_cursor *line)
{
    for (;;) {
        SVO_I_TRY(svo_i_points_need(reader, POINTS_WINDOW_BYTES / 2));
        const char *begin = (const char *)reader->window + reader->window_at;
        const char *end = (const char *)reader->window + reader->window_count;
        if (begin == end) {
            return svo_i_points_damaged(reader,
                                        "line %" PRIu64 ": the file ends in vertex %" PRIu64 " of %" PRIu64
                                        " (counted from 0), at byte %" PRIu64,
                                        reader->line, reader->at, reader->info->point_count, reader->file.byte_count);
        }
        *line = (text_cursor){.at = begin, .end = end, .line = reader->line};
        text_cursor behind = *line;
        text_skip_line(&behind);
        if (behind.at == end && reader->window_end < reader->file.byte_count) {
            return svo_i_points_damaged(reader, "line %" PRIu64 " is longer than %zu bytes, from byte %" PRIu64 " on",
                                        reader->line, POINTS_WINDOW_BYTES / 2,
                                        reader->window_end - reader->window_count + reader->window_at);
        }
        reader->window_at = (size_t)(behind.at - (const char *)reader->window);
        reader->line = behind.line;
        if (text_skip_blanks(line)) {
            line->end = behind.at;
            return SVO_OK;
        }
    }
}

/* Fails at the word of a line. */
static svo_status refuse_word(const points_reader *reader, const text_cursor *line, const char *what)
{
    const uint64_t in_window = (uint64_t)(line->at - (const char *)reader->window);
    return svo_i_points_damaged(reader, "line %" PRIu64 ": '%s' %s, at byte %" PRIu64, line->line,
                                text_copy_word(line).text, what, reader->window_end - reader->window_count + in_window);
}

static svo_status read_line(points_reader *reader, svo_point *point)
{
    text_cursor line;
    *point = (svo_point){.intensity = 0};
    SVO_I_TRY(take_line(reader, &line));
    for (size_t i = 0; i < reader->value_count; ++i) {
        double value = 0.0;
        if (!text_skip_blanks(&line)) {
            return refuse_word(reader, &line, "where another value is declared");
        }
        const char *behind = svo_i_number_double(line.at, line.end, &value);
        text_cursor word = line;
        text_skip_word(&word);
        if (behind != word.at) {
            return refuse_word(reader, &line, "is not a number");
        }
        line.at = behind;
        if (reader->slots[i] != POINT_NO_SLOT) {
            put_value(reader, point, reader->slots[i], value, reader->types[i]);
        }
    }
    return text_skip_blanks(&line) ? refuse_word(reader, &line, "behind the last value that is declared") : SVO_OK;
}

static svo_status next_lines(points_reader *reader, svo_point *points, size_t *count)
{
    *count = 0;
    for (uint64_t i = 0; i < reader->lines_before && reader->at == 0; ++i) {
        text_cursor line;
        SVO_I_TRY(take_line(reader, &line));
    }
    for (; *count < POINTS_AT_A_TIME && reader->at < reader->info->point_count; ++reader->at) {
        SVO_I_TRY(read_line(reader, &points[(*count)++]));
    }
    return SVO_OK;
}

/* ---- opening ---- */

svo_status svo_i_points_open_ply(points_reader *reader)
{
    svo_message words = {""};
    ply_header header = {.element_count = 0};
    text_cursor cursor;
    const mesh_reader text = {
        .bytes = (const char *)reader->window, .byte_count = reader->window_count, .message = &words};
    reader->info->format = SVO_VOXEL_FORMAT_PLY;
    svo_status status = svo_i_ply_read_header(&text, &cursor, &header);
    if (status == SVO_OK) {
        reader->begin = (uint64_t)(cursor.at - (const char *)reader->window);
        reader->begin_line = cursor.line;
        reader->next = header.format == PLY_ASCII ? next_lines : next_records;
        status = take_header(reader, &header);
    } else if (status == SVO_IMPORT_FAILED) {
        status = svo_i_points_damaged(reader, "the header, before byte %zu: %s", reader->window_count, words.text);
    } else {
        status = svo_i_points_fail(reader, status, "%s", words.text);
    }
    svo_i_ply_header_free(&header);
    return status;
}
