/* SPDX-License-Identifier: MIT */
/* What the readers and the writers of voxel files share: messages, growing lists, the buffer before the sink;
   and what a list does not hold of a file. */
#include "io/voxels_files.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/struct_size.h"
#include "io/voxels_formats.h"

bool svo_i_voxels_are_turned(svo_axes axes, svo_voxel_format format)
{
    const bool is_z_up =
        format == SVO_VOXEL_FORMAT_VOX || format == SVO_VOXEL_FORMAT_SLAB6 || format == SVO_VOXEL_FORMAT_BT;
    return axes == SVO_AXES_Z_UP || (axes == SVO_AXES_AUTO && is_z_up);
}

/* ---- numbers ---- */

const char *svo_i_voxel_number(char text[VOXEL_NUMBER_BYTES], double value, int digits)
{
    char local[VOXEL_NUMBER_BYTES];
    size_t used = 0;
    (void)snprintf(local, sizeof local, "%.*g", digits, value);
    for (size_t i = 0; local[i] != '\0'; ++i) {
        if (strchr("0123456789+-e", local[i]) != NULL) {
            text[used++] = local[i];
        } else if (used == 0 || text[used - 1] != '.') { /* the locale's decimal point may have several bytes */
            text[used++] = '.';
        }
    }
    text[used] = '\0';
    return text;
}

/* ---- reading ---- */

static svo_status fail(const voxel_reader *reader, svo_status status, const char *format, va_list arguments)
{
    svo_message detail;
    svo_i_fail_v(&detail, status, format, arguments);
    return svo_i_fail(reader->message, status, "%s: %s", reader->name, detail.text);
}

svo_status svo_i_voxels_damaged(const voxel_reader *reader, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(reader, SVO_FILE_DAMAGED, format, arguments);
    va_end(arguments);
    return SVO_FILE_DAMAGED;
}

svo_status svo_i_voxels_fail(const voxel_reader *reader, svo_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(reader, status, format, arguments);
    va_end(arguments);
    return status;
}

void svo_i_voxels_warn(voxel_reader *reader, const char *format, ...)
{
    ++reader->info.warnings;
    if (reader->options.log == NULL) {
        return;
    }
    svo_message detail;
    svo_message line;
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(&detail, SVO_OK, format, arguments);
    va_end(arguments);
    svo_i_message_set(&line, "%s: %s", reader->name, detail.text);
    reader->options.log(reader->options.log_user, SVO_LOG_WARNING, line.text);
}

svo_status svo_i_voxels_limit(const voxel_reader *reader, uint64_t voxel_count)
{
    const uint64_t limit = reader->options.voxels_max;
    if (voxel_count <= limit) {
        return SVO_OK;
    }
    return reader->limit_is_default && limit < SVO_VOXELS_MAX
               ? svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY,
                                   "%" PRIu64 " voxels need %s of memory, and %s are there for %" PRIu64
                                   " (voxels_max)",
                                   voxel_count, svo_i_bytes(voxel_count * BUILT_VOXEL_BYTES).text,
                                   svo_i_bytes(svo_i_host_memory_bytes()).text, limit)
               : svo_i_voxels_fail(reader, SVO_INVALID_ARGUMENT,
                                   "%" PRIu64 " voxels are above the limit of %" PRIu64 " (voxels_max)", voxel_count,
                                   limit);
}

svo_status svo_i_voxels_reserve(voxel_reader *reader, uint64_t voxel_count)
{
    SVO_I_TRY(svo_i_voxels_limit(reader, voxel_count));
    if (voxel_count <= reader->voxel_capacity) {
        return SVO_OK;
    }
    size_t bytes = 0;
    svo_voxel *grown = svo_i_mul_size((size_t)voxel_count, sizeof *grown, &bytes)
                           ? svo_i_grow(&reader->memory, reader->voxels, bytes)
                           : NULL;
    if (grown == NULL) {
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %" PRIu64 " voxels", voxel_count);
    }
    reader->voxels = grown;
    reader->voxel_capacity = voxel_count;
    return SVO_OK;
}

void svo_i_voxels_add(voxel_reader *reader, svo_voxel voxel)
{
    reader->voxels[reader->voxel_count++] = voxel;
}

svo_status svo_i_voxels_append(voxel_reader *reader, svo_voxel voxel)
{
    if (reader->voxel_count == reader->voxel_capacity) {
        const uint64_t limit = reader->options.voxels_max;
        uint64_t capacity = reader->voxel_capacity < 512 ? 1024 : 2 * reader->voxel_capacity;
        capacity = capacity > limit ? limit : capacity;
        capacity = reader->voxel_count < capacity ? capacity : limit + 1; /* which is refused */
        SVO_I_TRY(svo_i_voxels_reserve(reader, capacity));
    }
    svo_i_voxels_add(reader, voxel);
    return SVO_OK;
}

/* Appends a text and a terminator. Returns its offset in *offset. */
static bool put_text(voxel_reader *reader, const char *text, size_t bytes, size_t *offset)
{
    size_t needed = 0;
    if (!svo_i_add_size(reader->text_bytes + 1, bytes, &needed)) {
        return false;
    }
    if (needed > reader->text_capacity) {
        const size_t capacity = needed > SIZE_MAX / 2 ? needed : 2 * needed + 256;
        char *grown = svo_i_grow(&reader->memory, reader->texts, capacity);
        if (grown == NULL) {
            return false;
        }
        reader->texts = grown;
        reader->text_capacity = capacity;
    }
    *offset = reader->text_bytes;
    if (bytes > 0) {
        memcpy(reader->texts + *offset, text, bytes);
    }
    reader->texts[*offset + bytes] = '\0';
    reader->text_bytes = needed;
    return true;
}

svo_status svo_i_voxels_add_property(voxel_reader *reader, uint32_t material, const char *key, size_t key_bytes,
                                     const char *value, size_t value_bytes)
{
    voxel_property added = {.material = material};
    if (reader->property_count == reader->property_capacity) {
        const size_t capacity = 2 * reader->property_capacity + 64;
        voxel_property *grown = svo_i_grow(&reader->memory, reader->properties, capacity * sizeof *grown);
        if (grown == NULL) {
            return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %zu properties", capacity);
        }
        reader->properties = grown;
        reader->property_capacity = capacity;
    }
    if (!put_text(reader, key, key_bytes, &added.key) || !put_text(reader, value, value_bytes, &added.value)) {
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for the texts of %zu properties",
                                 reader->property_count + 1);
    }
    reader->properties[reader->property_count++] = added;
    return SVO_OK;
}

/* ---- checksums ---- */

void svo_i_voxels_byte_sums(uint32_t sums[256])
{
    for (uint32_t byte = 0; byte < 256; ++byte) {
        uint32_t sum = byte;
        for (int bit = 0; bit < 8; ++bit) {
            sum = sum >> 1 ^ ((sum & 1u) != 0 ? 0xedb88320u : 0u);
        }
        sums[byte] = sum;
    }
}

/* ---- writing ---- */

svo_status svo_i_voxels_write_fail(const voxel_writer *writer, svo_status status, const char *format, ...)
{
    svo_message detail;
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(&detail, status, format, arguments);
    va_end(arguments);
    return svo_i_fail(writer->sink.message, status, "%s: %s", writer->sink.name, detail.text);
}

svo_status svo_i_voxels_flush(voxel_writer *writer)
{
    const size_t byte_count = writer->used;
    writer->used = 0;
    if (byte_count > 0 && !svo_i_sink_write(&writer->sink, writer->buffer, byte_count)) {
        return svo_i_voxels_write_fail(writer, SVO_FILE_ERROR, "%zu bytes before byte %llu could not be written",
                                       byte_count, (unsigned long long)writer->info.bytes);
    }
    return SVO_OK;
}

svo_status svo_i_voxels_put(voxel_writer *writer, const void *bytes, size_t byte_count)
{
    const uint8_t *from = bytes;
    writer->info.bytes += byte_count;
    while (byte_count > 0) {
        const size_t room = VOXEL_BUFFER_BYTES - writer->used;
        const size_t part = byte_count < room ? byte_count : room;
        memcpy(writer->buffer + writer->used, from, part);
        writer->used += part;
        from += part;
        byte_count -= part;
        if (writer->used == VOXEL_BUFFER_BYTES) {
            SVO_I_TRY(svo_i_voxels_flush(writer));
        }
    }
    return SVO_OK;
}

svo_status svo_i_voxels_sorted(const voxel_writer *writer, const int32_t low[3], svo_i_voxel_order order,
                               svo_voxel **out)
{
    const size_t count = (size_t)writer->list.voxel_count;
    svo_voxel *sorted = svo_i_alloc(writer->memory, count * sizeof *sorted + 1);
    svo_voxel *spare = svo_i_alloc(writer->memory, count * sizeof *spare + 1);
    if (sorted == NULL || spare == NULL) {
        svo_i_free(sorted);
        svo_i_free(spare);
        return svo_i_voxels_write_fail(writer, SVO_OUT_OF_HOST_MEMORY, "no memory to sort %zu voxels", count);
    }
    if (count > 0) {
        memcpy(sorted, writer->voxels, count * sizeof *sorted);
        svo_i_voxel_sort(sorted, spare, count, low, svo_i_voxel_bits(low, writer->list.high), order);
    }
    svo_i_free(spare);
    *out = sorted;
    return SVO_OK;
}

double svo_i_voxels_world(const voxel_writer *writer, int axis, double place)
{
    return writer->list.origin[axis] + place * writer->list.voxel_edge;
}

bool svo_i_voxels_has(const voxel_writer *writer, const int32_t place[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        if (place[axis] < writer->list.low[axis] || place[axis] >= writer->list.high[axis]) {
            return false;
        }
    }
    const svo_voxel key = {.x = place[0], .y = place[1], .z = place[2]};
    const uint64_t code = svo_i_voxel_code(&key, writer->list.low);
    uint64_t begin = 0;
    uint64_t end = writer->list.voxel_count;
    while (begin < end) {
        const uint64_t middle = begin + (end - begin) / 2;
        const uint64_t found = svo_i_voxel_code(&writer->voxels[middle], writer->list.low);
        if (found == code) {
            return true;
        }
        if (found < code) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    return false;
}

/* ---- what a list does not hold ---- */

/* Adds ", 3 names" to the line, or ", 1 name". */
static void add_part(svo_message *text, uint64_t count, const char *one, const char *several)
{
    const size_t used = strlen(text->text);
    if (count > 0) {
        (void)snprintf(text->text + used, sizeof text->text - used, "%s%" PRIu64 " %s", used > 0 ? ", " : "", count,
                       count == 1 ? one : several);
    }
}

svo_status svo_voxels_left_out(const svo_voxel_file_info *info, svo_message *text)
{
    static const char function[] = "svo_voxels_left_out";
    svo_voxel_file_info file;
    if (text == NULL || info == NULL) {
        return svo_i_fail(text, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function, text == NULL ? "text" : "info");
    }
    SVO_I_TRY(
        svo_i_struct_read(text, function, "info", info, &file, SVO_I_STRUCT_SIZES(svo_voxel_file_info, warnings)));
    text->text[0] = '\0';
    if (file.instances > 1) {
        (void)snprintf(text->text, sizeof text->text, "the division into %" PRIu64 " instances", file.instances);
    }
    add_part(text, file.left_out_models, "model", "models");
    add_part(text, file.hidden_instances, "hidden instance", "hidden instances");
    add_part(text, file.left_out_frames, "frame", "frames");
    add_part(text, file.names, "name", "names");
    add_part(text, file.layers, "layer", "layers");
    add_part(text, file.groups, "group", "groups");
    add_part(text, file.cameras, "camera", "cameras");
    add_part(text, file.render_settings, "render setting", "render settings");
    add_part(text, file.notes, "list of notes", "lists of notes");
    add_part(text, file.palette_orders, "order of the palette", "orders of the palette");
    add_part(text, file.unused_colors, "color that no voxel has", "colors that no voxel has");
    add_part(text, file.other_chunks, "chunk of another kind", "chunks of other kinds");
    return SVO_OK;
}

/* ---- formats that the library was built without ---- */

#ifndef SVOCL_SVX
svo_status svo_i_voxels_read_svx(voxel_reader *reader)
{
    return svo_i_voxels_fail(reader, SVO_UNSUPPORTED, "%s", VOXELS_NO_SVX);
}

svo_status svo_i_voxels_write_svx(voxel_writer *writer)
{
    return svo_i_voxels_write_fail(writer, SVO_UNSUPPORTED, "%s", VOXELS_NO_SVX);
}
#endif

#ifndef SVOCL_NVDB
svo_status svo_i_voxels_read_nvdb(voxel_reader *reader)
{
    return svo_i_voxels_fail(reader, SVO_UNSUPPORTED, "%s", VOXELS_NO_NVDB);
}

svo_status svo_i_voxels_write_nvdb(voxel_writer *writer)
{
    return svo_i_voxels_write_fail(writer, SVO_UNSUPPORTED, "%s", VOXELS_NO_NVDB);
}
#endif

#ifndef SVOCL_VDB
svo_status svo_i_voxels_read_vdb(voxel_reader *reader)
{
    return svo_i_voxels_fail(reader, SVO_UNSUPPORTED, "%s", VOXELS_NO_VDB);
}

svo_status svo_i_voxels_write_vdb(voxel_writer *writer)
{
    return svo_i_voxels_write_fail(writer, SVO_UNSUPPORTED, "%s", VOXELS_NO_VDB);
}
#endif
