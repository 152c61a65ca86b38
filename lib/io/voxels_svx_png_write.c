/* SPDX-License-Identifier: MIT */
/* PNG images (https://www.w3.org/TR/png/) whose pixels are stored in blocks of zlib's format, not packed. */
#include "io/voxels_svx_png_write.h"

#include <string.h>

#define BLOCK_BYTES_MAX 65535u /* of zlib's stored blocks */
#define ADLER           65521u
#define CHUNK_BYTES     12u /* length, kind and checksum */
#define HEADER_BYTES    13u

/* A file that is being written, into memory that is large enough. */
typedef struct png_writer {
    uint8_t *bytes; /* owned */
    size_t count;
    size_t chunk; /* where the kind of the chunk begins */
    uint32_t sums[256]; /* checksums of single bytes */
} png_writer;

static void fill_sums(png_writer *png)
{
    for (uint32_t byte = 0; byte < 256; ++byte) {
        uint32_t sum = byte;
        for (int bit = 0; bit < 8; ++bit) {
            sum = sum >> 1 ^ ((sum & 1u) != 0 ? 0xedb88320u : 0u);
        }
        png->sums[byte] = sum;
    }
}

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

uint8_t *svo_i_svx_png_write(const svo_i_memory *memory, const uint8_t *pixels, uint32_t width, uint32_t height,
                             uint32_t channels, size_t *byte_count)
{
    static const uint8_t signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    const size_t row_bytes = (size_t)width * channels;
    const size_t all = sizeof signature + (size_t)3 * CHUNK_BYTES + HEADER_BYTES + pixel_bytes(row_bytes, height);
    png_writer png = {.bytes = svo_i_alloc(memory, all)};
    if (png.bytes == NULL) {
        return NULL;
    }
    fill_sums(&png);
    put(&png, signature, sizeof signature);
    put_header(&png, width, height, channels);
    put_rows(&png, pixels, row_bytes, height);
    begin_chunk(&png, "IEND", 0);
    end_chunk(&png);
    *byte_count = png.count;
    return png.bytes;
}
