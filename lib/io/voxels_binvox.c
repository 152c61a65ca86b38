/* SPDX-License-Identifier: MIT */
/*
 * The .binvox reader (https://www.patrickmin.com/binvox/binvox.html). A header of words ends in the line "data"; then
 * come runs of a value and a count, one byte each, over a grid whose y runs fastest, then z, then x.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "io/import_number.h"
#include "io/voxels_formats.h"

#define MAGIC "#binvox"

/* The words of a header. */
typedef struct header {
    bool has_dim, has_translate, has_scale;
    uint32_t dim[3]; /* x, z, y, as in the file */
    double translate[3];
    double scale;
} header;

/* The header as words: what spaces separate, without comments. */
typedef struct words {
    const voxel_reader *reader;
    const char *at, *end;
    const char *word;
    size_t word_bytes;
} words;

static svo_status damaged(const words *w, const char *what)
{
    const size_t offset = (size_t)((w->word != NULL ? w->word : w->at) - (const char *)w->reader->bytes);
    return svo_i_voxels_damaged(w->reader, "header: %s, at byte %zu", what, offset);
}

static bool is_space(char letter)
{
    return letter == ' ' || letter == '\t' || letter == '\r' || letter == '\n';
}

/* Goes to the next word. Fails where the file ends. */
static svo_status next_word(words *w)
{
    bool comment = false;
    w->word = NULL;
    while (w->at < w->end && (comment || is_space(*w->at) || *w->at == '#')) {
        comment = *w->at == '#' || (comment && *w->at != '\n');
        ++w->at;
    }
    const char *begin = w->at;
    while (w->at < w->end && !is_space(*w->at) && *w->at != '#') {
        ++w->at;
    }
    if (begin == w->at) {
        return damaged(w, "it ends without data");
    }
    w->word = begin;
    w->word_bytes = (size_t)(w->at - begin);
    return SVO_OK;
}

static bool is_word(const words *w, const char *name)
{
    return w->word_bytes == strlen(name) && memcmp(w->word, name, w->word_bytes) == 0;
}

static svo_status read_number(words *w, const char *what, double *value)
{
    SVO_I_TRY(next_word(w));
    const char *end = svo_i_number_double(w->word, w->word + w->word_bytes, value);
    return end == w->word + w->word_bytes && isfinite(*value) ? SVO_OK : damaged(w, what);
}

static svo_status read_sizes(words *w, header *read)
{
    for (int i = 0; i < 3; ++i) {
        double size = 0.0;
        SVO_I_TRY(read_number(w, "dim is not three numbers", &size));
        if (!(size >= 1.0 && size <= SVO_VOXELS_EXTENT_MAX) || rint(size) != size) {
            return damaged(w, "dim is not in 1 .. 2097152");
        }
        read->dim[i] = (uint32_t)size;
    }
    return SVO_OK;
}

/* Reads one word and what belongs to it, other than data. */
static svo_status read_word(words *w, header *read)
{
    bool *once = is_word(w, "dim")         ? &read->has_dim
                 : is_word(w, "translate") ? &read->has_translate
                 : is_word(w, "scale")     ? &read->has_scale
                                           : NULL;
    if (once == NULL || *once) {
        return damaged(w, once == NULL ? "a word that is not known" : "a word that was there before");
    }
    *once = true;
    if (once == &read->has_dim) {
        return read_sizes(w, read);
    }
    if (once == &read->has_scale) {
        SVO_I_TRY(read_number(w, "scale is not a number", &read->scale));
        return read->scale > 0.0 ? SVO_OK : damaged(w, "scale is not above 0");
    }
    for (int axis = 0; axis < 3; ++axis) {
        SVO_I_TRY(read_number(w, "translate is not three numbers", &read->translate[axis]));
    }
    return SVO_OK;
}

/* Reads the header. *data: the first byte of the runs. */
static svo_status read_header(voxel_reader *reader, header *read, size_t *data)
{
    words w = {.reader = reader, .at = (const char *)reader->bytes + strlen(MAGIC)};
    w.end = (const char *)reader->bytes + reader->byte_count;
    SVO_I_TRY(next_word(&w));
    if (!is_word(&w, "1") && !is_word(&w, "2")) {
        return damaged(&w, "the version is neither 1 nor 2");
    }
    reader->info.version = (uint32_t)(*w.word - '0');
    SVO_I_TRY(next_word(&w));
    while (!is_word(&w, "data")) {
        SVO_I_TRY(read_word(&w, read));
        SVO_I_TRY(next_word(&w));
    }
    if (!read->has_dim) {
        return damaged(&w, "no dim before data");
    }
    while (w.at < w.end && *w.at != '\n') {
        if (!is_space(*w.at++)) {
            return damaged(&w, "data is not alone in its line");
        }
    }
    *data = (size_t)(w.at - (const char *)reader->bytes) + 1;
    return w.at < w.end ? SVO_OK : damaged(&w, "no line ends after data");
}

/* Checks that the runs fill the grid exactly. *filled: the voxels in runs of values other than 0. */
static svo_status check_runs(const voxel_reader *reader, size_t data, uint64_t cells, uint64_t *filled)
{
    uint64_t sum = 0;
    if ((reader->byte_count - data) % 2 != 0) {
        return svo_i_voxels_damaged(reader, "data: the last run is cut off, at byte %zu", reader->byte_count - 1);
    }
    for (size_t at = data; at < reader->byte_count; at += 2) {
        const uint8_t value = reader->bytes[at];
        const uint8_t count = reader->bytes[at + 1];
        if (count == 0 || count > cells - sum) {
            return svo_i_voxels_damaged(reader, "data: a run of %d voxels where %" PRIu64 " are left, at byte %zu",
                                        count, cells - sum, at);
        }
        if (value > 1 && reader->info.version == 1) {
            return svo_i_voxels_damaged(reader, "data: value %d is neither 0 nor 1, at byte %zu", value, at);
        }
        sum += count;
        *filled += value != 0 ? count : 0;
    }
    return sum == cells
               ? SVO_OK
               : svo_i_voxels_damaged(reader, "data: %" PRIu64 " voxels, the grid has %" PRIu64 ", at byte %zu", sum,
                                      cells, reader->byte_count);
}

/* Goes to the next cell of the grid. */
static void next_cell(const header *read, uint32_t cell[3])
{
    if (++cell[1] == read->dim[2]) {
        cell[1] = 0;
        if (++cell[2] == read->dim[1]) {
            cell[2] = 0;
            ++cell[0];
        }
    }
}

/* Values of version 2 stand for materials. */
static void add_runs(voxel_reader *reader, const header *read, size_t data)
{
    uint32_t cell[3] = {0, 0, 0}; /* x, y, z */
    for (size_t at = data; at < reader->byte_count; at += 2) {
        const uint8_t value = reader->bytes[at];
        for (unsigned i = 0; i < reader->bytes[at + 1]; ++i, next_cell(read, cell)) {
            if (value != 0) {
                svo_i_voxels_add(reader, (svo_voxel){.x = (int32_t)cell[0],
                                                     .y = (int32_t)cell[1],
                                                     .z = (int32_t)cell[2],
                                                     .rgba = {255, 255, 255, 255},
                                                     .material = reader->info.version == 2 ? value : 0});
            }
        }
    }
}

svo_status svo_i_voxels_read_binvox(voxel_reader *reader)
{
    header read = {.scale = 0.0};
    size_t data = 0;
    uint64_t filled = 0;
    SVO_I_TRY(read_header(reader, &read, &data));
    SVO_I_TRY(check_runs(reader, data, (uint64_t)read.dim[0] * read.dim[1] * read.dim[2], &filled));
    SVO_I_TRY(svo_i_voxels_reserve(reader, filled));
    add_runs(reader, &read, data);
    uint32_t longest = 0;
    for (int i = 0; i < 3; ++i) {
        longest = read.dim[i] > longest ? read.dim[i] : longest;
    }
    reader->voxel_edge = read.has_scale ? read.scale / (double)longest : 1.0;
    memcpy(reader->origin, read.translate, sizeof reader->origin);
    reader->info.instance_voxels = filled;
    if (!(reader->voxel_edge > 0.0)) {
        return svo_i_voxels_damaged(reader, "header: scale %g is too small for dim, before byte %zu", read.scale, data);
    }
    return SVO_OK;
}
