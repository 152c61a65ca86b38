/* SPDX-License-Identifier: MIT */
/*
 * The .svx writer: a grid as large as the voxels' bounds, cut along y, with an image for each slice and channel. Colors
 * and materials are left out where all voxels are white or of material 0. Images are not packed; the archive is. It is
 * made in memory, since its beginning is known last.
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <zip.h>

#include "io/voxels_files.h"
#include "io/voxels_formats.h"

#define MANIFEST_BYTES 2048
#define DOS_DATE       0x21 /* the first day that an archive can have, so that equal voxels make equal files */
#define MATERIAL_MAX   255 /* of an image with 8 bits */

#define BLOCK_BYTES_MAX 65535u /* of zlib's stored blocks */
#define ADLER           65521u
#define CHUNK_BYTES     12u /* length, kind and checksum */
#define HEADER_BYTES    13u

/*
 * ---- images ----
 *
 * PNG (https://www.w3.org/TR/png/), whose pixels are stored in blocks of zlib's format, not packed.
 */

/* A file that is being written, into memory that is large enough. */
typedef struct png_writer {
    uint8_t *bytes; /* owned */
    size_t count;
    size_t chunk; /* where the kind of the chunk begins */
    uint32_t sums[256]; /* checksums of single bytes */
} png_writer;

static void put(png_writer *png, const void *bytes, size_t count)
{
    memcpy(png->bytes + png->count, bytes, count);
    png->count += count;
}

static void put_u32(png_writer *png, uint32_t value)
{
    const uint8_t bytes[4] = {(uint8_t)(value >> 24), (uint8_t)(value >> 16), (uint8_t)(value >> 8), (uint8_t)value};
    put(png, bytes, sizeof bytes);
}

static void begin_chunk(png_writer *png, const char *kind, size_t content_bytes)
{
    put_u32(png, (uint32_t)content_bytes);
    png->chunk = png->count;
    put(png, kind, 4);
}

static void end_chunk(png_writer *png)
{
    uint32_t sum = 0xffffffffu;
    for (size_t i = png->chunk; i < png->count; ++i) {
        sum = png->sums[(sum ^ png->bytes[i]) & 255u] ^ sum >> 8;
    }
    put_u32(png, ~sum);
}

static void put_header(png_writer *png, uint32_t width, uint32_t height, uint32_t channels)
{
    const uint8_t format[5] = {8, channels == 3 ? 2 : 0, 0, 0, 0}; /* bits, color, packing, filters, no interlace */
    begin_chunk(png, "IHDR", HEADER_BYTES);
    put_u32(png, width);
    put_u32(png, height);
    put(png, format, sizeof format);
    end_chunk(png);
}

/* Bytes of the pixels' chunk: zlib's header, the heads of its blocks, the rows, and its checksum. */
static size_t pixel_bytes(size_t row_bytes, uint32_t height)
{
    const size_t rows = (row_bytes + 1) * height;
    return 2 + (rows + BLOCK_BYTES_MAX - 1) / BLOCK_BYTES_MAX * 5 + rows + 4;
}

/* Puts the rows, each after the byte of its filter, in blocks. */
static void put_rows(png_writer *png, const uint8_t *pixels, size_t row_bytes, uint32_t height)
{
    const uint8_t zlib_header[2] = {0x78, 0x01};
    size_t left = (row_bytes + 1) * height;
    size_t in_block = 0;
    uint32_t low = 1;
    uint32_t high = 0;
    begin_chunk(png, "IDAT", pixel_bytes(row_bytes, height));
    put(png, zlib_header, sizeof zlib_header);
    for (size_t i = 0; left > 0; ++i, --left, --in_block) {
        if (in_block == 0) {
            in_block = left < BLOCK_BYTES_MAX ? left : BLOCK_BYTES_MAX;
            const uint8_t head[5] = {in_block == left ? 1 : 0, (uint8_t)in_block, (uint8_t)(in_block >> 8),
                                     (uint8_t)~in_block, (uint8_t)(~in_block >> 8)};
            put(png, head, sizeof head);
        }
        const size_t column = i % (row_bytes + 1);
        const uint8_t byte = column == 0 ? 0 : pixels[i / (row_bytes + 1) * row_bytes + column - 1];
        png->bytes[png->count++] = byte;
        low = (low + byte) % ADLER;
        high = (high + low) % ADLER;
    }
    put_u32(png, high << 16 | low);
    end_chunk(png);
}

/* An image that is not packed, for svo_i_free; NULL when out of memory. pixels: rows of one gray byte or of three color
   bytes a pixel. */
static uint8_t *make_png(const svo_i_memory *memory, const uint8_t *pixels, uint32_t width, uint32_t height,
                         uint32_t channels, size_t *byte_count)
{
    static const uint8_t signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    const size_t row_bytes = (size_t)width * channels;
    const size_t all = sizeof signature + (size_t)3 * CHUNK_BYTES + HEADER_BYTES + pixel_bytes(row_bytes, height);
    png_writer png = {.bytes = svo_i_alloc(memory, all)};
    if (png.bytes == NULL) {
        return NULL;
    }
    svo_i_voxels_byte_sums(png.sums);
    put(&png, signature, sizeof signature);
    put_header(&png, width, height, channels);
    put_rows(&png, pixels, row_bytes, height);
    begin_chunk(&png, "IEND", 0);
    end_chunk(&png);
    *byte_count = png.count;
    return png.bytes;
}

/* ---- the archive ---- */

typedef struct svx_writer {
    voxel_writer *out;
    zip_t *archive;
    uint32_t size[3];
    bool color, material; /* whether the channel is written */
    svo_voxel *sorted; /* by slice and row; owned */
    uint8_t **entries; /* bytes that the archive refers to until it is closed; owned */
    size_t entry_count, entry_capacity;
} svx_writer;

static svo_status no_memory(const svx_writer *w)
{
    return svo_i_voxels_write_fail(w->out, SVO_OUT_OF_HOST_MEMORY, "no memory for a .svx archive");
}

/* Adds an entry. Takes over bytes, which came from svo_i_alloc, also on failure. */
static svo_status add_entry(svx_writer *w, const char *name, uint8_t *bytes, size_t byte_count)
{
    if (w->entry_count == w->entry_capacity) {
        const size_t capacity = 2 * w->entry_capacity + 64;
        uint8_t **larger = svo_i_grow(w->out->memory, (void *)w->entries, capacity * sizeof *larger);
        if (larger == NULL) {
            svo_i_free(bytes);
            return no_memory(w);
        }
        w->entries = larger;
        w->entry_capacity = capacity;
    }
    w->entries[w->entry_count++] = bytes;
    zip_source_t *source = zip_source_buffer(w->archive, bytes, byte_count, 0);
    if (source == NULL) {
        return no_memory(w);
    }
    const zip_int64_t index = zip_file_add(w->archive, name, source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
        zip_source_free(source);
        return no_memory(w);
    }
    return zip_file_set_dostime(w->archive, (zip_uint64_t)index, 0, DOS_DATE, 0) == 0 ? SVO_OK : no_memory(w);
}

/* Adds the text of a channel to the manifest. Returns the new length. */
static size_t put_channel(char *text, size_t used, const char *type, const char *folder, int bits)
{
    return used + (size_t)snprintf(text + used, MANIFEST_BYTES - used,
                                   "    <channel type=\"%s\" bits=\"%d\" slices=\"%s/slice%%04d.png\" />\n", type, bits,
                                   folder);
}

static svo_status add_manifest(svx_writer *w)
{
    char number[4][VOXEL_NUMBER_BYTES];
    char *text = svo_i_alloc(w->out->memory, MANIFEST_BYTES);
    if (text == NULL) {
        return no_memory(w);
    }
    for (int axis = 0; axis < 3; ++axis) {
        (void)svo_i_voxel_number(number[axis], svo_i_voxels_world(w->out, axis, (double)w->out->list.low[axis]), 17);
    }
    (void)svo_i_voxel_number(number[3], w->out->list.voxel_edge, 17);
    size_t used = (size_t)snprintf(text, MANIFEST_BYTES,
                                   "<?xml version=\"1.0\"?>\n"
                                   "<grid version=\"1.0\" gridSizeX=\"%u\" gridSizeY=\"%u\" gridSizeZ=\"%u\"\n"
                                   "      originX=\"%s\" originY=\"%s\" originZ=\"%s\" voxelSize=\"%s\"\n"
                                   "      subvoxelBits=\"8\" slicesOrientation=\"Y\">\n  <channels>\n",
                                   w->size[0], w->size[1], w->size[2], number[0], number[1], number[2], number[3]);
    used = put_channel(text, used, "DENSITY", "density", 8);
    used = w->color ? put_channel(text, used, "COLOR-RGB", "color", 24) : used;
    used = w->material ? put_channel(text, used, "MATERIAL", "material", 8) : used;
    used += (size_t)snprintf(text + used, MANIFEST_BYTES - used, "  </channels>\n</grid>\n");
    return add_entry(w, SVX_MANIFEST, (uint8_t *)text, used);
}

/* Draws the voxels of a slice. channels: bytes per pixel. */
static void draw(const svx_writer *w, svx_kind kind, const svo_voxel *voxels, size_t count, uint8_t *pixels)
{
    for (size_t i = 0; i < count; ++i) {
        const size_t column = (size_t)(voxels[i].x - w->out->list.low[0]);
        const size_t pixel = (size_t)(voxels[i].z - w->out->list.low[2]) * w->size[0] + column;
        if (kind == SVX_COLOR) {
            memcpy(pixels + 3 * pixel, voxels[i].rgba, 3);
        } else {
            pixels[pixel] = kind == SVX_DENSITY ? 255 : (uint8_t)voxels[i].material;
        }
    }
}

static svo_status add_image(svx_writer *w, svx_kind kind, uint32_t slice, const svo_voxel *voxels, size_t count)
{
    static const char *const folders[SVX_KINDS] = {"density", "color", "material"};
    const uint32_t channels = kind == SVX_COLOR ? 3 : 1;
    char name[64];
    size_t byte_count = 0;
    uint8_t *pixels = svo_i_alloc_zeroed(w->out->memory, (size_t)w->size[0] * w->size[2], channels);
    if (pixels == NULL) {
        return no_memory(w);
    }
    draw(w, kind, voxels, count, pixels);
    uint8_t *png = make_png(w->out->memory, pixels, w->size[0], w->size[2], channels, &byte_count);
    svo_i_free(pixels);
    if (png == NULL) {
        return no_memory(w);
    }
    (void)snprintf(name, sizeof name, "%s/slice%04u.png", folders[kind], slice);
    return add_entry(w, name, png, byte_count);
}

static svo_status add_slices(svx_writer *w)
{
    const bool writes[SVX_KINDS] = {true, w->color, w->material};
    const uint64_t all = w->out->list.voxel_count;
    uint64_t begin = 0;
    for (uint32_t slice = 0; slice < w->size[1]; ++slice) {
        uint64_t end = begin;
        while (end < all && w->sorted[end].y - w->out->list.low[1] == (int32_t)slice) {
            ++end;
        }
        for (int kind = 0; kind < SVX_KINDS; ++kind) {
            if (writes[kind]) {
                SVO_I_TRY(add_image(w, (svx_kind)kind, slice, w->sorted + begin, (size_t)(end - begin)));
            }
        }
        begin = end;
    }
    return SVO_OK;
}

/* Finds the size of the grid and what channels are needed. */
static svo_status measure(svx_writer *w)
{
    const svo_voxels_info *list = &w->out->list;
    for (int axis = 0; axis < 3; ++axis) {
        w->size[axis] = list->voxel_count > 0 ? (uint32_t)(list->high[axis] - list->low[axis]) : 1;
    }
    const uint64_t slice = (uint64_t)w->size[0] * w->size[2];
    if (w->size[0] > SVX_SIDE_MAX || w->size[2] > SVX_SIDE_MAX || slice > SVX_PIXELS_MAX ||
        slice * w->size[1] > SVX_CELLS_MAX) {
        return svo_i_voxels_write_fail(
            w->out, SVO_INVALID_ARGUMENT,
            "a .svx grid of %u x %u x %u is above the limits of %d a side of a slice, 2^27 pixels and "
            "2^31 cells",
            w->size[0], w->size[1], w->size[2], SVX_SIDE_MAX);
    }
    w->material = list->material_count > 1 && list->material_count <= MATERIAL_MAX + 1;
    for (uint64_t i = 0; i < list->voxel_count && !w->color; ++i) {
        const uint8_t *rgba = w->out->voxels[i].rgba;
        w->color = rgba[0] != 255 || rgba[1] != 255 || rgba[2] != 255;
    }
    return SVO_OK;
}

/* Copies the finished archive to the file. */
static svo_status copy_archive(voxel_writer *out, zip_source_t *source)
{
    uint8_t part[4096];
    zip_int64_t got = 0;
    if (zip_source_open(source) != 0) {
        return svo_i_voxels_write_fail(out, SVO_OUT_OF_HOST_MEMORY, "no memory for a .svx archive");
    }
    svo_status status = SVO_OK;
    while (status == SVO_OK && (got = zip_source_read(source, part, sizeof part)) > 0) {
        status = svo_i_voxels_put(out, part, (size_t)got);
    }
    (void)zip_source_close(source);
    if (status == SVO_OK && got < 0) {
        status = svo_i_voxels_write_fail(out, SVO_FILE_ERROR, "the finished .svx archive cannot be read back: %s",
                                         zip_error_strerror(zip_source_error(source)));
    }
    return status;
}

static svo_status fill_archive(svx_writer *w)
{
    SVO_I_TRY(add_manifest(w));
    return add_slices(w);
}

svo_status svo_i_voxels_write_svx(voxel_writer *writer)
{
    svx_writer w = {.out = writer};
    zip_error_t error;
    SVO_I_TRY(measure(&w));
    SVO_I_TRY(svo_i_voxels_sorted(writer, writer->list.low, SVO_I_VOXEL_SLICES, &w.sorted));
    zip_error_init(&error);
    zip_source_t *source = zip_source_buffer_create(NULL, 0, 0, &error);
    w.archive = source != NULL ? zip_open_from_source(source, ZIP_TRUNCATE, &error) : NULL;
    svo_status status = SVO_OK;
    if (w.archive == NULL) {
        zip_source_free(source);
        status = no_memory(&w);
    } else {
        zip_source_keep(source);
        status = fill_archive(&w);
        if (status == SVO_OK && zip_close(w.archive) != 0) {
            status = no_memory(&w);
        } else if (status == SVO_OK) {
            w.archive = NULL;
            status = copy_archive(writer, source);
        }
        if (w.archive != NULL) {
            zip_discard(w.archive);
        }
        zip_source_free(source);
    }
    zip_error_fini(&error);
    for (size_t i = 0; i < w.entry_count; ++i) {
        svo_i_free(w.entries[i]);
    }
    svo_i_free((void *)w.entries);
    svo_i_free(w.sorted);
    return status;
}
