/* SPDX-License-Identifier: MIT */
/*
 * Radiance pictures. stb_image, which writes them here, does not notice where a file ends too early.
 *
 * A head of lines that ends with an empty one, the size, and rows: plain pixels of four bytes, or, where a row begins
 * with 2, 2 and the width in two bytes, the four channels one after the other, in runs of equal bytes (128 more than
 * their length, and the byte) and of others (their length, and the bytes).
 */
#include "support/hdr_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LINE_BYTES 512
/* Rows of these widths may be packed. */
#define PACKED_MIN 8u
#define PACKED_MAX 32767u
#define RUN        128

typedef struct reader {
    FILE *stream;
    uint32_t width, height;
    double exposure; /* that texels were multiplied by */
    char *words;
} reader;

static bool fail(const reader *from, const char *words)
{
    (void)snprintf(from->words, HDR_WORDS_BYTES, "%s", words);
    return false;
}

/* ---- the head ---- */

/* Without the line's end. */
static bool read_line(const reader *from, char line[LINE_BYTES])
{
    if (fgets(line, LINE_BYTES, from->stream) == NULL) {
        return fail(from, "it ends in its head");
    }
    const size_t length = strcspn(line, "\r\n");
    if (line[length] == '\0') {
        return fail(from, "its head has a line without end");
    }
    line[length] = '\0';
    return true;
}

/* Takes what a line of the head says of the texels. */
static bool take_line(reader *from, const char *line)
{
    if (strncmp(line, "FORMAT=", 7) == 0 && strcmp(line + 7, "32-bit_rle_rgbe") != 0) {
        (void)snprintf(from->words, HDR_WORDS_BYTES, "its format is '%.40s', not '32-bit_rle_rgbe'", line + 7);
        return false;
    }
    if (strncmp(line, "EXPOSURE=", 9) == 0) {
        from->exposure *= strtod(line + 9, NULL);
        if (!(from->exposure > 0) || !isfinite(from->exposure)) {
            return fail(from, "its exposure is not above 0");
        }
    }
    return true;
}

static bool read_head(reader *from, uint32_t width_max, uint32_t height_max)
{
    char line[LINE_BYTES];
    char rest = '\0';
    if (!read_line(from, line) || (strcmp(line, "#?RADIANCE") != 0 && strcmp(line, "#?RGBE") != 0)) {
        return fail(from, "not a Radiance .hdr file");
    }
    do {
        if (!read_line(from, line) || !take_line(from, line)) {
            return false;
        }
    } while (line[0] != '\0');
    if (!read_line(from, line)) {
        return false;
    }
    if (sscanf(line, "-Y %u +X %u %c", &from->height, &from->width, &rest) != 2) {
        (void)snprintf(from->words, HDR_WORDS_BYTES, "its size is '%.40s', not '-Y HEIGHT +X WIDTH'", line);
        return false;
    }
    if (from->width < 1 || from->width > width_max || from->height < 1 || from->height > height_max) {
        (void)snprintf(from->words, HDR_WORDS_BYTES, "%u x %u texels are not within 1 x 1 .. %u x %u", from->width,
                       from->height, width_max, height_max);
        return false;
    }
    return true;
}

/* ---- rows ---- */

static bool read_bytes(const reader *from, uint8_t *bytes, size_t count)
{
    return fread(bytes, 1, count, from->stream) == count || fail(from, "it ends too early");
}

/* Fills one channel of a packed row. */
static bool unpack(const reader *from, uint8_t *row, uint32_t channel)
{
    uint32_t column = 0;
    while (column < from->width) {
        uint8_t bytes[RUN];
        uint8_t length = 0;
        if (!read_bytes(from, &length, 1)) {
            return false;
        }
        const bool is_run = length > RUN;
        const uint32_t count = is_run ? length - (uint32_t)RUN : length;
        if (count == 0 || count > from->width - column) {
            return fail(from, "a row of it is damaged");
        }
        if (!read_bytes(from, bytes, is_run ? 1 : count)) {
            return false;
        }
        for (uint32_t i = 0; i < count; ++i, ++column) {
            row[(size_t)4 * column + channel] = bytes[is_run ? 0 : i];
        }
    }
    return true;
}

/* Runs as older files have them: 1, 1, 1 and a number. Mantissas of texels are not that small. */
static bool has_old_runs(const reader *from, const uint8_t *row)
{
    bool found = false;
    for (uint32_t i = 0; i < from->width; ++i) {
        found = found || (row[(size_t)4 * i] == 1 && row[(size_t)4 * i + 1] == 1 && row[(size_t)4 * i + 2] == 1);
    }
    return found;
}

/* Four bytes a texel. */
static bool read_row(const reader *from, uint8_t *row)
{
    if (!read_bytes(from, row, 4)) {
        return false;
    }
    const bool is_packed = from->width >= PACKED_MIN && from->width <= PACKED_MAX && row[0] == 2 && row[1] == 2 &&
                           ((uint32_t)row[2] << 8 | row[3]) == from->width;
    bool is_read = is_packed || read_bytes(from, row + 4, (size_t)4 * (from->width - 1));
    for (uint32_t channel = 0; channel < 4 && is_packed && is_read; ++channel) {
        is_read = unpack(from, row, channel);
    }
    if (is_read && !is_packed && has_old_runs(from, row)) {
        return fail(from, "its rows are packed in an old way");
    }
    return is_read;
}

static bool read_rows(const reader *from, uint8_t *row, float *texels)
{
    for (uint32_t j = 0; j < from->height; ++j) {
        if (!read_row(from, row)) {
            return false;
        }
        for (uint32_t i = 0; i < from->width; ++i, texels += 3) {
            const double unit =
                row[(size_t)4 * i + 3] != 0 ? ldexp(1, row[(size_t)4 * i + 3] - 136) / from->exposure : 0;
            for (uint32_t channel = 0; channel < 3; ++channel) {
                texels[channel] = (float)(row[(size_t)4 * i + channel] * unit);
            }
        }
    }
    return true;
}

bool hdr_file_read(FILE *stream, uint32_t width_max, uint32_t height_max, hdr_picture *out)
{
    reader from = {.stream = stream, .exposure = 1, .words = out->words};
    *out = (hdr_picture){.texels = NULL};
    if (!read_head(&from, width_max, height_max)) {
        return false;
    }
    uint8_t *row = malloc((size_t)4 * from.width);
    float *texels = calloc((size_t)from.width * from.height, 3 * sizeof *texels);
    const bool is_read = row != NULL && texels != NULL ? read_rows(&from, row, texels) : fail(&from, "out of memory");
    free(row);
    if (!is_read) {
        free(texels);
        return false;
    }
    out->texels = texels;
    out->width = from.width;
    out->height = from.height;
    return true;
}

void hdr_file_free(hdr_picture *picture)
{
    free(picture->texels);
    *picture = (hdr_picture){.texels = NULL};
}
