/* SPDX-License-Identifier: MIT */
/* Failures, warnings, counts and numbers, as all readers word and read them. */
#define _POSIX_C_SOURCE 200809L
#include "io/import_reader.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>

#include "core/message.h"
#include "io/import_number.h"

static bool begins_with(const char *bytes, size_t byte_count, const char *text)
{
    return byte_count >= strlen(text) && memcmp(bytes, text, strlen(text)) == 0;
}

svo_status svo_i_read_out_of_memory(const mesh_reader *reader)
{
    return svo_i_fail(reader->message, SVO_OUT_OF_HOST_MEMORY, "out of memory");
}

void svo_i_read_warn(const mesh_reader *reader, const char *format, ...)
{
    svo_message text;
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(&text, SVO_OK, format, arguments);
    va_end(arguments);
    (void)svo_i_stream_frame(reader->stream, STREAM_WARNING, text.text, strlen(text.text));
}

void svo_i_read_count_vertices(const mesh_reader *reader, uint64_t used_count, uint64_t declared_count)
{
    reader->counts->declared_vertices = declared_count;
    reader->counts->used_vertices = used_count;
    if (used_count < declared_count) {
        svo_i_read_warn(reader, "%" PRIu64 " of %" PRIu64 " vertices belong to no face", declared_count - used_count,
                        declared_count);
    }
}

void svo_i_read_count_faces(const mesh_reader *reader, uint64_t left_out_count, uint64_t declared_count)
{
    reader->counts->declared_faces = declared_count;
    reader->counts->read_faces = declared_count - left_out_count;
    if (left_out_count > 0) {
        svo_i_read_warn(reader, "%" PRIu64 " of %" PRIu64 " faces have fewer than 3 corners and are left out",
                        left_out_count, declared_count);
    }
}

svo_status svo_i_read_begin_text(const mesh_reader *reader, text_cursor *cursor)
{
    const char *bytes = reader->bytes;
    const size_t byte_count = reader->byte_count;
    *cursor = (text_cursor){.at = bytes, .end = bytes + byte_count, .line = 1};
    if (begins_with(bytes, byte_count, "\xff\xfe") || begins_with(bytes, byte_count, "\xfe\xff")) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "byte 0: UTF-16 text; UTF-8 or ASCII is needed");
    }
    cursor->at += begins_with(bytes, byte_count, "\xef\xbb\xbf") ? 3 : 0;
    return SVO_OK;
}

static svo_status no_number(const number_reader *numbers, const text_cursor *cursor)
{
    if (text_at_line_end(cursor)) {
        return svo_i_fail(numbers->reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": the line ends where a number is needed", cursor->line);
    }
    return svo_i_fail(numbers->reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": '%s' is not a number",
                      cursor->line, text_copy_word(cursor).text);
}

svo_status svo_i_read_float(number_reader *numbers, text_cursor *cursor, float *value)
{
    (void)text_skip_blanks(cursor);
    const char *behind = svo_i_number_float(cursor->at, cursor->end, value);
    if (behind == NULL) {
        return no_number(numbers, cursor);
    }
    const text_cursor word = *cursor;
    cursor->at = behind;
    if (!text_at_word_end(cursor)) {
        if (numbers->odd_count++ == 0) {
            numbers->first_odd = text_copy_word(&word);
            numbers->first_odd_line = cursor->line;
        }
        text_skip_word(cursor);
    }
    return SVO_OK;
}

void svo_i_read_warn_odd(const number_reader *numbers)
{
    if (numbers->odd_count > 0) {
        svo_i_read_warn(numbers->reader,
                        "%" PRIu64
                        " words are numbers only in part, which was read; the first is '%s' in line %" PRIu64,
                        numbers->odd_count, numbers->first_odd.text, numbers->first_odd_line);
    }
}
