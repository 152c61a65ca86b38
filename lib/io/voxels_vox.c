/* SPDX-License-Identifier: MIT */
/* The .vox reader: chunks, models and the palette. voxels_vox_nodes.c reads the scene, voxels_vox_scene.c places it. */
#include <inttypes.h>
#include <string.h>

#include "io/voxels_formats.h"
#include "io/voxels_vox_nodes.h"
#include "io/voxels_vox_scene.h"

#define CHUNK_HEAD_BYTES 12u
#define FILE_HEAD_BYTES  8u
#define PALETTE_BYTES    1024u
#define ORDER_BYTES      256u /* of an IMAP chunk */

/* The palette that files without RGBA mean: a cube of colors, whose sides fall in steps of 51 from white on without
   black, then ramps of red, green, blue and gray without the steps that the cube has. */
static void default_palette(uint8_t palette[256][4])
{
    size_t index = 1;
    memset(palette[0], 0, 4);
    for (unsigned i = 0; i < 215; ++i, ++index) {
        const uint8_t color[4] = {(uint8_t)(255 - i / 36 * 51), (uint8_t)(255 - i / 6 % 6 * 51),
                                  (uint8_t)(255 - i % 6 * 51), 255};
        memcpy(palette[index], color, 4);
    }
    for (unsigned ramp = 0; ramp < 4; ++ramp) {
        for (unsigned step = 14; step > 0; --step) {
            if (step % 3 == 0) {
                continue;
            }
            for (unsigned channel = 0; channel < 3; ++channel) {
                palette[index][channel] = (uint8_t)(ramp == channel || ramp == 3 ? step * 17 : 0);
            }
            palette[index++][3] = 255;
        }
    }
}

static svo_status read_pack(vox_file *file, vox_cursor *cursor)
{
    int32_t count = 0;
    SVO_I_TRY(svo_i_vox_read_i32(cursor, "the number of models", &count));
    if (count < 0) {
        return svo_i_vox_damaged(cursor, "%" PRId32 " models", count);
    }
    file->packed = count;
    return SVO_OK;
}

static svo_status read_size(vox_file *file, vox_cursor *cursor)
{
    if (file->has_size) {
        return svo_i_vox_damaged(cursor, "the size before it has no XYZI");
    }
    for (int axis = 0; axis < 3; ++axis) {
        SVO_I_TRY(svo_i_vox_read_i32(cursor, "a size", &file->size[axis]));
        if (file->size[axis] < 1 || file->size[axis] > VOX_SIDE_MAX) {
            return svo_i_vox_damaged(cursor, "size %c %" PRId32 " is not in 1 .. %d", "xyz"[axis], file -> size[axis],
                                     VOX_SIDE_MAX);
        }
    }
    file->has_size = true;
    return SVO_OK;
}

static svo_status read_voxels(vox_file *file, vox_cursor *cursor)
{
    int32_t count = 0;
    if (!file->has_size) {
        return svo_i_vox_damaged(cursor, "no SIZE before it");
    }
    SVO_I_TRY(svo_i_vox_read_i32(cursor, "the number of voxels", &count));
    if (count < 0 || (uint64_t)count * 4 != (uint64_t)(cursor->end - cursor->at)) {
        return svo_i_vox_damaged(cursor, "%" PRId32 " voxels in %td bytes", count, cursor->end - cursor->at);
    }
    vox_model model = {.voxels = cursor->at, .count = (uint32_t)count};
    memcpy(model.size, file->size, sizeof model.size);
    for (; cursor->at < cursor->end; cursor->at += 4) {
        for (int axis = 0; axis < 3; ++axis) {
            if (cursor->at[axis] >= model.size[axis]) {
                return svo_i_vox_damaged(cursor, "voxel %td: %c %d is not below %" PRId32,
                                         (cursor->at - model.voxels) / 4, "xyz"[axis], cursor -> at[axis],
                                         model.size[axis]);
            }
        }
        model.filled += cursor->at[3] != 0 ? 1 : 0;
    }
    SVO_I_TRY(svo_i_vox_grow(file->reader, (void **)&file->models, file->model_count, &file->model_capacity,
                             sizeof *file->models));
    file->models[file->model_count++] = model;
    file->has_size = false;
    return SVO_OK;
}

static svo_status read_palette(vox_file *file, vox_cursor *cursor)
{
    if (cursor->end - cursor->at != PALETTE_BYTES) {
        return svo_i_vox_damaged(cursor, "%td bytes of colors, not %u", cursor->end - cursor->at, PALETTE_BYTES);
    }
    memcpy(file->palette[1], cursor->at, PALETTE_BYTES - 4); /* the last entry is no voxel's */
    return SVO_OK;
}

/* The order in which an editor shows the palette; it changes no color. */
static svo_status check_order(vox_file *file, vox_cursor *cursor)
{
    (void)file;
    return cursor->end - cursor->at == ORDER_BYTES
               ? SVO_OK
               : svo_i_vox_damaged(cursor, "%td bytes of indices, not %u", cursor->end - cursor->at, ORDER_BYTES);
}

static svo_status read_content(vox_file *file, vox_cursor *cursor)
{
    static const struct {
        const char *id;
        svo_status (*read)(vox_file *file, vox_cursor *cursor);
    } chunks[] = {{"PACK", read_pack},
                  {"SIZE", read_size},
                  {"XYZI", read_voxels},
                  {"RGBA", read_palette},
                  {"IMAP", check_order},
                  {"MATT", svo_i_vox_read_matt},
                  {"MATL", svo_i_vox_read_matl},
                  {"LAYR", svo_i_vox_read_layer},
                  {"nTRN", svo_i_vox_read_transform},
                  {"nGRP", svo_i_vox_read_group},
                  {"nSHP", svo_i_vox_read_shape}};
    for (size_t i = 0; i < sizeof chunks / sizeof chunks[0]; ++i) {
        if (strcmp(cursor->id, chunks[i].id) == 0) {
            return chunks[i].read(file, cursor);
        }
    }
    return SVO_OK; /* not known: skipped */
}

/* Reads the head of a chunk; the cursor is then its content. *next: where its children end. */
static svo_status open_chunk(const vox_file *file, size_t offset, size_t end, vox_cursor *cursor, size_t *next)
{
    const uint8_t *bytes = file->reader->bytes;
    *cursor = (vox_cursor){.reader = file->reader, .id = "?", .offset = offset, .at = bytes + offset};
    if (end - offset < CHUNK_HEAD_BYTES) {
        return svo_i_vox_damaged(cursor, "truncated: its head has %u bytes, %zu are there", CHUNK_HEAD_BYTES,
                                 end - offset);
    }
    for (size_t i = 0; i < 4; ++i) {
        const uint8_t letter = bytes[offset + i];
        cursor->id[i] = (char)(letter > ' ' && letter < 127 ? letter : '?');
    }
    const int32_t content_bytes = svo_i_vox_i32_at(bytes + offset + 4);
    const int32_t children_bytes = svo_i_vox_i32_at(bytes + offset + 8);
    const size_t left = end - offset - CHUNK_HEAD_BYTES;
    if (content_bytes < 0 || children_bytes < 0 || (uint64_t)content_bytes + (uint64_t)children_bytes > left) {
        return svo_i_vox_damaged(cursor, "truncated: %" PRId32 " and %" PRId32 " bytes expected, %zu there",
                                 content_bytes, children_bytes, left);
    }
    cursor->at += CHUNK_HEAD_BYTES;
    cursor->end = cursor->at + content_bytes;
    *next = offset + CHUNK_HEAD_BYTES + (size_t)content_bytes + (size_t)children_bytes;
    return SVO_OK;
}

static svo_status read_chunks(vox_file *file, size_t offset, size_t end)
{
    while (offset < end) {
        vox_cursor cursor;
        size_t next = 0;
        SVO_I_TRY(open_chunk(file, offset, end, &cursor, &next));
        SVO_I_TRY(read_content(file, &cursor));
        offset = next;
    }
    return SVO_OK;
}

static svo_status read_file(vox_file *file)
{
    voxel_reader *reader = file->reader;
    vox_cursor main_chunk;
    size_t end = 0;
    if (reader->byte_count < FILE_HEAD_BYTES) {
        return svo_i_voxels_damaged(reader, "truncated: %u bytes expected at least, %zu there", FILE_HEAD_BYTES,
                                    reader->byte_count);
    }
    const int32_t version = svo_i_vox_i32_at(reader->bytes + 4);
    if (version != 150 && version != 200) {
        return svo_i_voxels_damaged(reader, "byte 4: version %" PRId32 " is not known, only 150 and 200", version);
    }
    reader->info.version = (uint32_t)version;
    SVO_I_TRY(open_chunk(file, FILE_HEAD_BYTES, reader->byte_count, &main_chunk, &end));
    if (strcmp(main_chunk.id, "MAIN") != 0) {
        return svo_i_vox_damaged(&main_chunk, "not MAIN");
    }
    if (end != reader->byte_count) {
        return svo_i_vox_damaged(&main_chunk, "it ends at byte %zu, the file at %zu", end, reader->byte_count);
    }
    SVO_I_TRY(read_chunks(file, (size_t)(main_chunk.end - reader->bytes), end));
    if (file->has_size) {
        return svo_i_voxels_damaged(reader, "byte %zu: the last SIZE has no XYZI", end);
    }
    if (file->packed >= 0 && (uint64_t)file->packed != file->model_count) {
        return svo_i_voxels_damaged(reader, "byte %zu: %zu models, PACK says %" PRId64, end, file->model_count,
                                    file->packed);
    }
    reader->info.models = file->model_count;
    return svo_i_vox_place(file);
}

svo_status svo_i_voxels_read_vox(voxel_reader *reader)
{
    vox_file file = {.reader = reader, .packed = -1};
    default_palette(file.palette);
    const svo_status status = read_file(&file);
    svo_i_free(file.models);
    svo_i_free(file.nodes);
    svo_i_free(file.layers);
    return status;
}
