/* SPDX-License-Identifier: MIT */
/*
 * PNG images of a known size (https://www.w3.org/TR/png/). stb_image decodes them; before it does, their chunks are
 * walked through and their data unpacked into memory that is just large enough, since stb_image would unpack without
 * bounds.
 */
#include "io/voxels_svx_png.h"

#include <stdbool.h>
#include <string.h>

#include "io/voxels_svx.h"

/* Static: a program that links the library may have its own stb_image. */
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS SVX_SIDE_MAX
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wconversion"
#include <stb/stb_image.h>
#pragma GCC diagnostic error "-Wconversion"

#define SIGNATURE_BYTES 8u
#define CHUNK_BYTES     12u /* length, kind and checksum */
#define HEADER_BYTES    13u
#define OTHER_BYTES     ((uint64_t)1 << 16) /* room for chunks besides the pixels */
#define PIXEL_BYTES_MAX 8u

const char svo_i_svx_png_no_memory[] = "out of memory";

static uint32_t u32_at(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* Bytes of the unpacked rows, each with its filter; interlaced images have less than four more a row. */
static uint64_t unpacked_bytes_max(uint32_t width, uint32_t height)
{
    return (uint64_t)height * ((uint64_t)width * PIXEL_BYTES_MAX + 4) + 64;
}

uint64_t svo_i_svx_png_bytes_max(uint32_t width, uint32_t height)
{
    const uint64_t unpacked = unpacked_bytes_max(width, height);
    return unpacked + unpacked / 1000 + OTHER_BYTES; /* zlib makes what it cannot pack hardly longer */
}

/* Walks through the chunks; copies the packed pixels to packed, which may be NULL, and counts them. */
static const char *walk_chunks(const uint8_t *bytes, size_t byte_count, uint8_t *packed, size_t *packed_bytes,
                               size_t *offset)
{
    size_t at = SIGNATURE_BYTES;
    *packed_bytes = 0;
    for (;;) {
        *offset = at;
        if (byte_count - at < CHUNK_BYTES || u32_at(bytes + at) > byte_count - at - CHUNK_BYTES) {
            return "a chunk is cut off";
        }
        const size_t length = u32_at(bytes + at);
        const uint8_t *kind = bytes + at + 4;
        if (memcmp(kind, "IDAT", 4) == 0) {
            if (packed != NULL) {
                memcpy(packed + *packed_bytes, kind + 4, length);
            }
            *packed_bytes += length;
        }
        /* stb_image would unpack its pixels in another way than check_unpacked. */
        if (memcmp(kind, "CgBI", 4) == 0) {
            return "a chunk CgBI, of a variant that is not read";
        }
        if (memcmp(kind, "IEND", 4) == 0) {
            return NULL;
        }
        at += CHUNK_BYTES + length;
    }
}

/* Unpacks the pixels into bounded memory, which is then given up. */
static const char *check_unpacked(const svo_i_memory *memory, const svx_png *png, size_t *offset)
{
    size_t packed_bytes = 0;
    const uint64_t bound = unpacked_bytes_max(png->width, png->height);
    const char *wrong = walk_chunks(png->bytes, png->byte_count, NULL, &packed_bytes, offset);
    if (wrong != NULL) {
        return wrong;
    }
    uint8_t *packed = svo_i_alloc(memory, packed_bytes + 1);
    char *unpacked = svo_i_alloc(memory, (size_t)bound);
    if (packed == NULL || unpacked == NULL) {
        wrong = svo_i_svx_png_no_memory;
    } else {
        (void)walk_chunks(png->bytes, png->byte_count, packed, &packed_bytes, offset);
        const int got = stbi_zlib_decode_buffer(unpacked, (int)bound, (const char *)packed, (int)packed_bytes);
        wrong = got < 0 ? "its pixels cannot be unpacked, or are more than its size says" : NULL;
        *offset = SIGNATURE_BYTES;
    }
    svo_i_free(packed);
    svo_i_free(unpacked);
    return wrong;
}

/* Why stb_image gave no pixels. */
static const char *decode_failure(void)
{
    const char *reason = stbi_failure_reason();
    return reason != NULL && strcmp(reason, "outofmem") == 0 ? svo_i_svx_png_no_memory : "it cannot be decoded";
}

/* Decodes pixels as deep as the file has them: where stb_image converts them and runs out of memory, it loses the
   others. Deep colors keep their high bytes. */
static const char *decode(const uint8_t *bytes, int byte_count, bool deep, bool color, svx_image *image)
{
    int width = 0;
    int height = 0;
    int channels = 0;
    const int wanted = color ? 4 : 1;
    void *pixels = deep ? (void *)stbi_load_16_from_memory(bytes, byte_count, &width, &height, &channels, wanted)
                        : (void *)stbi_load_from_memory(bytes, byte_count, &width, &height, &channels, wanted);
    if (pixels == NULL) {
        return decode_failure();
    }
    for (size_t i = 0; deep && color && i < 4 * (size_t)width * (size_t)height; ++i) {
        uint16_t value = 0;
        memcpy(&value, (const uint8_t *)pixels + 2 * i, sizeof value);
        ((uint8_t *)pixels)[i] = (uint8_t)(value >> 8);
    }
    image->gray = color ? NULL : pixels;
    image->rgba = color ? pixels : NULL;
    image->bits = deep ? 16 : 8;
    return NULL;
}

const char *svo_i_svx_png_read(const svo_i_memory *memory, const svx_png *png, int color, svx_image *image,
                               size_t *offset)
{
    static const uint8_t signature[SIGNATURE_BYTES] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    *image = (svx_image){.gray = NULL};
    *offset = 0;
    if (png->byte_count < SIGNATURE_BYTES + CHUNK_BYTES + HEADER_BYTES ||
        memcmp(png->bytes, signature, SIGNATURE_BYTES) != 0) {
        return "not a PNG image";
    }
    const uint8_t *header = png->bytes + SIGNATURE_BYTES + 8;
    *offset = SIGNATURE_BYTES + 8;
    if (memcmp(header - 4, "IHDR", 4) != 0 || u32_at(header) != png->width || u32_at(header + 4) != png->height) {
        return "its size is not that of a slice";
    }
    const char *wrong = check_unpacked(memory, png, offset);
    if (wrong != NULL) {
        return wrong;
    }
    return decode(png->bytes, (int)png->byte_count, header[8] == 16, color != 0, image);
}

uint32_t svo_i_svx_png_gray(const svx_image *image, size_t pixel)
{
    return image->bits == 16 ? ((const uint16_t *)image->gray)[pixel] : ((const uint8_t *)image->gray)[pixel];
}

void svo_i_svx_png_free(svx_image *image)
{
    stbi_image_free(image->gray);
    stbi_image_free(image->rgba);
    *image = (svx_image){.gray = NULL};
}
