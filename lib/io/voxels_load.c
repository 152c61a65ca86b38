/* SPDX-License-Identifier: MIT */
/*
 * Voxel files to lists of voxels: reads the file into memory, and finds its reader by its first bytes. Those of .binvox
 * files and of SLAB6's are here; voxels_vox.c, voxels_svx.c, voxels_nvdb.c, voxels_vdb.c and voxels_bt.c have the
 * others. Also .vox files to themselves, and by their models.
 */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "core/memory.h"
#include "core/struct_size.h"
#include "io/import_text.h"
#include "io/voxels_formats.h"
#include "io/voxels_vdb_file.h"

#define BINVOX_MAGIC      "#binvox"
#define VOX_MAGIC         "VOX "
#define TEARDOWN_MAGIC    "TDCZ"
#define SLAB6_HEAD_BYTES  12u
#define SLAB6_SIDE_MAX    1024
#define SLAB6_COLOR_BYTES 768u
#define SLAB6_EMPTY       255

/*
 * ---- .binvox ----
 *
 * As https://www.patrickmin.com/binvox/binvox.html has it: a header of words ends in the line "data"; then come runs of
 * a value and a count, one byte each, over a grid whose y runs fastest, then z, then x.
 */

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
    words w = {.reader = reader, .at = (const char *)reader->bytes + strlen(BINVOX_MAGIC)};
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

static svo_status read_binvox(voxel_reader *reader)
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

/*
 * ---- .vox of SLAB6 ----
 *
 * As slab6.txt of Ken Silverman's SLAB6 has it: three sizes of 32 bits, a byte for each voxel of which z runs fastest
 * and x slowest, and 256 colors of three bytes, 0 .. 63. z points down. Nothing marks the format but its length.
 */

/* Whether the bytes can be such a file. */
static bool read_slab6_sizes(const voxel_reader *reader, int32_t size[3])
{
    if (reader->byte_count < SLAB6_HEAD_BYTES + SLAB6_COLOR_BYTES) {
        return false;
    }
    memcpy(size, reader->bytes, SLAB6_HEAD_BYTES);
    for (int axis = 0; axis < 3; ++axis) {
        if (size[axis] < 1 || size[axis] > SLAB6_SIDE_MAX) {
            return false;
        }
    }
    return (uint64_t)size[0] * (uint64_t)size[1] * (uint64_t)size[2] ==
           reader->byte_count - SLAB6_HEAD_BYTES - SLAB6_COLOR_BYTES;
}

static svo_status read_slab6(voxel_reader *reader, const int32_t size[3])
{
    const size_t count = reader->byte_count - SLAB6_HEAD_BYTES - SLAB6_COLOR_BYTES;
    const uint8_t *cells = reader->bytes + SLAB6_HEAD_BYTES;
    const uint8_t *colors = cells + count;
    uint64_t filled = 0;
    for (size_t i = 0; i < SLAB6_COLOR_BYTES; ++i) {
        if (colors[i] > 63) {
            return svo_i_voxels_damaged(reader, "palette: %d is above 63, at byte %zu", colors[i],
                                        SLAB6_HEAD_BYTES + count + i);
        }
    }
    for (size_t i = 0; i < count; ++i) {
        filled += cells[i] != SLAB6_EMPTY ? 1 : 0;
    }
    SVO_I_TRY(svo_i_voxels_reserve(reader, filled));
    for (size_t i = 0; i < count; ++i) {
        const uint8_t *color = colors + 3 * (size_t)cells[i];
        if (cells[i] == SLAB6_EMPTY) {
            continue;
        }
        svo_voxel voxel = {.x = (int32_t)(i / (size_t)size[2] / (size_t)size[1]),
                           .y = size[1] - 1 - (int32_t)(i / (size_t)size[2] % (size_t)size[1]),
                           .z = size[2] - 1 - (int32_t)(i % (size_t)size[2]),
                           .rgba = {0, 0, 0, 255},
                           .material = (uint16_t)(cells[i] + 1)};
        for (int channel = 0; channel < 3; ++channel) {
            voxel.rgba[channel] = (uint8_t)(color[channel] << 2 | color[channel] >> 4);
        }
        svo_i_voxels_add(reader, voxel);
    }
    reader->info.instance_voxels = filled;
    return SVO_OK;
}

/* ---- loading ---- */

svo_voxel_format svo_voxel_format_of_path(const char *path)
{
    const char *dot = path != NULL ? strrchr(path, '.') : NULL;
    for (uint32_t format = SVO_VOXEL_FORMAT_VOX; format <= SVO_VOXEL_FORMAT_VDB && dot != NULL; ++format) {
        if (format != SVO_VOXEL_FORMAT_SLAB6 && strcasecmp(dot + 1, svo_name(SVO_NAME_VOXEL_FORMAT, format)) == 0) {
            return (svo_voxel_format)format;
        }
    }
    return SVO_VOXEL_FORMAT_AUTO;
}

static bool begins(const voxel_reader *reader, const char *magic)
{
    const size_t bytes = strlen(magic);
    return reader->byte_count >= bytes && memcmp(reader->bytes, magic, bytes) == 0;
}

static svo_status fail_teardown(const voxel_reader *reader)
{
    return svo_i_voxels_fail(reader, SVO_UNSUPPORTED,
                             "a .vox file that Teardown compressed (TDCZ), which svocl does not read");
}

static svo_status read_format(voxel_reader *reader)
{
    int32_t size[3];
    reader->info = (svo_voxel_file_info){.struct_size = sizeof reader->info, .models = 1, .instances = 1};
    if (begins(reader, VOX_MAGIC)) {
        reader->info.format = SVO_VOXEL_FORMAT_VOX;
        return svo_i_voxels_read_vox(reader);
    }
    if (begins(reader, BINVOX_MAGIC)) {
        reader->info.format = SVO_VOXEL_FORMAT_BINVOX;
        return read_binvox(reader);
    }
    if (begins(reader, "PK\3\4")) {
        reader->info.format = SVO_VOXEL_FORMAT_SVX;
        return svo_i_voxels_read_svx(reader);
    }
    if (begins(reader, "NanoVDB")) {
        reader->info.format = SVO_VOXEL_FORMAT_NVDB;
        return svo_i_voxels_read_nvdb(reader);
    }
    if (reader->byte_count >= VDB_MAGIC_BYTES && memcmp(reader->bytes, VDB_MAGIC "\0\0\0", VDB_MAGIC_BYTES) == 0) {
        reader->info.format = SVO_VOXEL_FORMAT_VDB;
        return svo_i_voxels_read_vdb(reader);
    }
    if (begins(reader, VOXELS_BT_MAGIC)) {
        reader->info.format = SVO_VOXEL_FORMAT_BT;
        return svo_i_voxels_read_bt(reader);
    }
    if (begins(reader, TEARDOWN_MAGIC)) {
        return fail_teardown(reader);
    }
    if (read_slab6_sizes(reader, size)) {
        reader->info.format = SVO_VOXEL_FORMAT_SLAB6;
        return read_slab6(reader, size);
    }
    return svo_i_voxels_damaged(
        reader, "byte 0: neither a .vox nor a .svx nor a .binvox nor a .nvdb nor a .vdb nor a .bt file");
}

/* From z up to y up. */
static void turn(voxel_reader *reader)
{
    for (uint64_t i = 0; i < reader->voxel_count; ++i) {
        svo_voxel *voxel = &reader->voxels[i];
        const int32_t y = voxel->y;
        voxel->y = voxel->z;
        voxel->z = -1 - y;
    }
    const double y = reader->origin[1];
    reader->origin[1] = reader->origin[2];
    reader->origin[2] = -y;
}

/* Makes the list of what was read. */
static svo_status make_list(voxel_reader *reader, svo_voxels **out)
{
    svo_voxels_source source = {.struct_size = sizeof source,
                                .voxels = reader->voxels,
                                .voxel_count = reader->voxel_count,
                                .property_count = reader->property_count,
                                .voxel_edge = reader->voxel_edge,
                                .memory = reader->options.memory};
    memcpy(source.origin, reader->origin, sizeof source.origin);
    svo_voxel_property *properties = svo_i_alloc(&reader->memory, (reader->property_count + 1) * sizeof *properties);
    if (properties == NULL) {
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %zu properties",
                                 reader->property_count);
    }
    for (size_t i = 0; i < reader->property_count; ++i) {
        const voxel_property *one = &reader->properties[i];
        properties[i] = (svo_voxel_property){
            .material = one->material, .key = reader->texts + one->key, .value = reader->texts + one->value};
    }
    source.properties = properties;
    const svo_status status = svo_voxels_create(&source, out, reader->message);
    if (status != SVO_OK) {
        svo_i_message_rename(reader->message, reader->name);
    }
    svo_i_free(properties);
    return status;
}

static void give_info(const voxel_reader *reader, svo_voxel_file_info *info)
{
    if (info != NULL) {
        (void)svo_i_struct_write(NULL, "", "info", &reader->info, info,
                                 SVO_I_STRUCT_SIZES(svo_voxel_file_info, warnings));
    }
}

static svo_status load(voxel_reader *reader, svo_voxels **out, svo_voxel_file_info *info)
{
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(read_format(reader));
    const svo_axes axes = (svo_axes)reader->options.axes;
    if (svo_i_voxels_are_turned(axes, (svo_voxel_format)reader->info.format)) {
        turn(reader);
    }
    SVO_I_TRY_CLEANUP(make_list(reader, out));
    (void)svo_voxels_set_axes(*out, axes);
    give_info(reader, info);
cleanup:
    svo_i_free(reader->voxels);
    svo_i_free(reader->properties);
    svo_i_free(reader->texts);
    return status;
}

/* Checks what a function takes and prepares the reader. */
static svo_status start(const char *function, const svo_voxels_load_options *options, const svo_voxel_file_info *info,
                        voxel_reader *reader)
{
    SVO_I_TRY(svo_i_struct_read(reader->message, function, "options", options, &reader->options,
                                SVO_I_STRUCT_SIZES(svo_voxels_load_options, log_user)));
    SVO_I_TRY(svo_i_memory_read(reader->message, function, "options.memory", reader->options.memory, &reader->memory));
    if (reader->options.axes > SVO_AXES_Z_UP) {
        return svo_i_fail(reader->message, SVO_INVALID_ARGUMENT, "%s: options.axes %u is not in 0 .. %d", function,
                          reader->options.axes, SVO_AXES_Z_UP);
    }
    const uint64_t most = SVO_VOXELS_MAX;
    reader->limit_is_default = reader->options.voxels_max == 0;
    if (reader->limit_is_default) {
        reader->options.voxels_max = svo_i_host_memory_bytes() / BUILT_VOXEL_BYTES;
    }
    if (reader->options.voxels_max > most) {
        reader->options.voxels_max = most;
    }
    return info == NULL ? SVO_OK
                        : svo_i_struct_check(reader->message, function, "info", info,
                                             SVO_I_STRUCT_SIZES(svo_voxel_file_info, warnings));
}

/* Reads the whole file; bytes of the caller's are used where they are. *owned: released by the caller. */
static svo_status take_bytes(const svo_i_source *source, voxel_reader *reader, uint8_t **owned)
{
    reader->bytes = source->bytes;
    reader->byte_count = (size_t)source->byte_count;
    if (reader->bytes != NULL) {
        return SVO_OK;
    }
    reader->bytes = *owned = svo_i_alloc(&reader->memory, reader->byte_count + 1);
    if (*owned == NULL) {
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for its %zu bytes", reader->byte_count);
    }
    return svo_i_source_read(source, 0, *owned, reader->byte_count);
}

svo_status svo_voxels_load(svo_source source, const svo_voxels_load_options *options, svo_voxels **out,
                           svo_voxel_file_info *info, svo_message *message)
{
    static const char function[] = "svo_voxels_load";
    voxel_reader reader = {.message = message};
    svo_i_source file;
    uint8_t *owned = NULL;
    svo_status status = SVO_OK;
    if (out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: out is NULL", function);
    }
    SVO_I_TRY(start(function, options, info, &reader));
    SVO_I_TRY(svo_i_source_open(function, source, message, &file));
    reader.name = file.name;
    SVO_I_TRY_CLEANUP(take_bytes(&file, &reader, &owned));
    SVO_I_TRY_CLEANUP(load(&reader, out, info));
cleanup:
    svo_i_source_close(&file);
    svo_i_free(owned);
    return status;
}

/* ---- a .vox file again ---- */

static svo_status check_vox(voxel_reader *reader)
{
    svo_status status = SVO_OK;
    if (begins(reader, TEARDOWN_MAGIC)) {
        return fail_teardown(reader);
    }
    if (!begins(reader, VOX_MAGIC)) {
        return svo_i_voxels_fail(reader, SVO_UNSUPPORTED, "no .vox file of MagicaVoxel, and others are not %s",
                                 reader->take_part != NULL ? "read by models" : "copied");
    }
    reader->info = (svo_voxel_file_info){.struct_size = sizeof reader->info, .format = SVO_VOXEL_FORMAT_VOX};
    SVO_I_TRY_CLEANUP(svo_i_voxels_check_vox(reader));
    if (!reader->limit_is_default && reader->take_part == NULL) {
        SVO_I_TRY_CLEANUP(svo_i_voxels_limit(reader, reader->info.instance_voxels));
    }
cleanup:
    svo_i_free(reader->voxels);
    svo_i_free(reader->properties);
    svo_i_free(reader->texts);
    return status;
}

/* The sink is opened after the checks, so that nothing is written of a file that is refused. */
static svo_status copy_vox(const char *function, voxel_reader *reader, svo_sink given)
{
    svo_i_sink sink;
    svo_status status = SVO_OK;
    SVO_I_TRY(check_vox(reader));
    SVO_I_TRY(svo_i_sink_open(function, given, reader->message, &sink));
    if (!svo_i_sink_write(&sink, reader->bytes, reader->byte_count)) {
        status = svo_i_fail(reader->message, SVO_FILE_ERROR, "%s: its %zu bytes could not be written", sink.name,
                            reader->byte_count);
    }
    return svo_i_sink_close(&sink, status);
}

svo_status svo_voxels_copy_vox(svo_source source, svo_sink sink, const svo_voxels_load_options *options,
                               svo_voxel_file_info *info, svo_message *message)
{
    static const char function[] = "svo_voxels_copy_vox";
    voxel_reader reader = {.message = message};
    svo_i_source file;
    uint8_t *owned = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(start(function, options, info, &reader));
    SVO_I_TRY(svo_i_source_open(function, source, message, &file));
    reader.name = file.name;
    SVO_I_TRY_CLEANUP(take_bytes(&file, &reader, &owned));
    SVO_I_TRY_CLEANUP(copy_vox(function, &reader, sink));
    give_info(&reader, info);
cleanup:
    svo_i_source_close(&file);
    svo_i_free(owned);
    return status;
}

/* ---- a .vox file by its models ---- */

static svo_status take_part(voxel_reader *reader, uint64_t model, const double *transforms, uint64_t count)
{
    const svo_axes axes = (svo_axes)reader->options.axes;
    svo_voxels *voxels = NULL;
    if (svo_i_voxels_are_turned(axes, SVO_VOXEL_FORMAT_VOX)) {
        turn(reader);
    }
    SVO_I_TRY(make_list(reader, &voxels));
    (void)svo_voxels_set_axes(voxels, axes);
    const svo_voxel_part part = {sizeof part, model, voxels, transforms, count};
    const svo_status status = reader->callback(reader->user, &part);
    svo_voxels_destroy(&voxels);
    return status == SVO_OK
               ? SVO_OK
               : svo_i_voxels_fail(reader, status, "the callback ended the reading at model %" PRIu64, model);
}

svo_status svo_voxels_load_parts(svo_source source, const svo_voxels_load_options *options,
                                 svo_voxel_part_callback callback, void *user, svo_voxel_file_info *info,
                                 svo_message *message)
{
    static const char function[] = "svo_voxels_load_parts";
    voxel_reader reader = {.message = message, .take_part = take_part, .callback = callback, .user = user};
    svo_i_source file;
    uint8_t *owned = NULL;
    svo_status status = SVO_OK;
    if (callback == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: callback is NULL", function);
    }
    SVO_I_TRY(start(function, options, info, &reader));
    SVO_I_TRY(svo_i_source_open(function, source, message, &file));
    reader.name = file.name;
    SVO_I_TRY_CLEANUP(take_bytes(&file, &reader, &owned));
    SVO_I_TRY_CLEANUP(check_vox(&reader));
    give_info(&reader, info);
cleanup:
    svo_i_source_close(&file);
    svo_i_free(owned);
    return status;
}
