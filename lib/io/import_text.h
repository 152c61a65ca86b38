/* SPDX-License-Identifier: MIT */
/*
 * A position in the text of a mesh file, in the import child. The text need not end in a line break or a zero. A line
 * ends with LF, CR LF or CR alone. TEXT_CONTINUED stands for a break inside a line that goes on: a blank.
 */
#ifndef SVO_LIB_IO_IMPORT_TEXT_H
#define SVO_LIB_IO_IMPORT_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <strings.h>

#define TEXT_WORD_BYTES  64 /* of a word in a message, with the terminator */
#define TEXT_INTEGER_MAX INT64_C(1000000000000000000)
#define TEXT_CONTINUED   '\v'

typedef struct text_cursor {
    const char *at, *end;
    uint64_t line; /* of at, counted from 1 */
} text_cursor;

/* A word of the file, cut to fit, for a message. */
typedef struct text_word {
    char text[TEXT_WORD_BYTES];
} text_word;

static inline bool text_begins_with(const char *bytes, size_t byte_count, const char *text)
{
    return byte_count >= strlen(text) && memcmp(bytes, text, strlen(text)) == 0;
}

static inline bool text_is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\f' || c == TEXT_CONTINUED;
}

static inline bool text_at_line_end(const text_cursor *cursor)
{
    return cursor->at == cursor->end || *cursor->at == '\n' || *cursor->at == '\r';
}

static inline bool text_at_word_end(const text_cursor *cursor)
{
    return text_at_line_end(cursor) || text_is_blank(*cursor->at);
}

/* Returns whether something is left on the line. */
static inline bool text_skip_blanks(text_cursor *cursor)
{
    for (; cursor->at != cursor->end && text_is_blank(*cursor->at); ++cursor->at) {
        cursor->line += *cursor->at == TEXT_CONTINUED ? 1 : 0;
    }
    return !text_at_line_end(cursor);
}

static inline void text_skip_word(text_cursor *cursor)
{
    while (!text_at_word_end(cursor)) {
        ++cursor->at;
    }
}

static inline void text_skip_line_end(text_cursor *cursor)
{
    if (cursor->at != cursor->end) {
        const char c = *cursor->at++;
        cursor->at += c == '\r' && cursor->at != cursor->end && *cursor->at == '\n' ? 1 : 0;
        ++cursor->line;
    }
}

static inline void text_skip_line(text_cursor *cursor)
{
    for (; !text_at_line_end(cursor); ++cursor->at) {
        cursor->line += *cursor->at == TEXT_CONTINUED ? 1 : 0;
    }
    text_skip_line_end(cursor);
}

/* The rest of the line without blanks around it; the cursor stays. */
static inline const char *text_rest_of_line(text_cursor *cursor, size_t *length)
{
    (void)text_skip_blanks(cursor);
    text_cursor end = *cursor;
    while (!text_at_line_end(&end)) {
        ++end.at;
    }
    while (end.at != cursor->at && text_is_blank(end.at[-1])) {
        --end.at;
    }
    *length = (size_t)(end.at - cursor->at);
    return cursor->at;
}

/* Whether the word at the cursor is this one; if so, goes past it. */
static inline bool text_take_word(text_cursor *cursor, const char *word)
{
    const size_t length = strlen(word);
    text_cursor behind = *cursor;
    if ((size_t)(cursor->end - cursor->at) < length || memcmp(cursor->at, word, length) != 0) {
        return false;
    }
    behind.at += length;
    if (!text_at_word_end(&behind)) {
        return false;
    }
    *cursor = behind;
    return true;
}

/* The same in letters of either case. */
static inline bool text_take_keyword(text_cursor *cursor, const char *word)
{
    const size_t length = strlen(word);
    text_cursor behind = *cursor;
    text_skip_word(&behind);
    if ((size_t)(behind.at - cursor->at) != length || strncasecmp(cursor->at, word, length) != 0) {
        return false;
    }
    *cursor = behind;
    return true;
}

/* The word at the cursor, which stays. */
static inline text_word text_copy_word(const text_cursor *cursor)
{
    text_word word = {""};
    text_cursor from = *cursor;
    size_t length = 0;
    for (; length + 1 < sizeof word.text && !text_at_word_end(&from); ++from.at) {
        word.text[length++] = *from.at;
    }
    word.text[length] = '\0';
    return word;
}

/*
 * Reads a whole number with an optional sign and goes past it. TEXT_INTEGER_MAX stands for all beyond it, on both
 * sides.
 * Returns false, the cursor unmoved, where no digit begins.
 */
static inline bool text_take_integer(text_cursor *cursor, int64_t *value)
{
    const char *at = cursor->at;
    const bool negative = at != cursor->end && *at == '-';
    at += at != cursor->end && (*at == '-' || *at == '+') ? 1 : 0;
    if (at == cursor->end || *at < '0' || *at > '9') {
        return false;
    }
    int64_t magnitude = 0;
    for (; at != cursor->end && *at >= '0' && *at <= '9'; ++at) {
        magnitude = magnitude < TEXT_INTEGER_MAX / 10 ? magnitude * 10 + (*at - '0') : TEXT_INTEGER_MAX;
    }
    *value = negative ? -magnitude : magnitude;
    cursor->at = at;
    return true;
}

/* ---- numbers ---- */

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Reads a number that begins at text: an optional sign, digits with or without a decimal point, an optional exponent,
 * or nan, inf, infinity in any case. What is too large becomes infinite, what is too small zero.
 * Returns the first character behind it, at most end; NULL, with *value untouched, where no number begins.
 */
const char *svo_i_number_float(const char *text, const char *end, float *value);
const char *svo_i_number_double(const char *text, const char *end, double *value);

#ifdef __cplusplus
}
#endif

#endif
