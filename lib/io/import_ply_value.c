/* SPDX-License-Identifier: MIT */
/* Values of a PLY file. In ascii files each instance of an element is on a line of its own; empty lines are skipped. */
#include "io/import_ply_value.h"

#include <inttypes.h>

#include "core/message.h"
#include "io/import_number.h"

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
