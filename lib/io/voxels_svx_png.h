/* SPDX-License-Identifier: MIT */
/* PNG images of a known size, for .svx files. */
#ifndef SVO_LIB_IO_VOXELS_SVX_PNG_H
#define SVO_LIB_IO_VOXELS_SVX_PNG_H

#include <stddef.h>
#include <stdint.h>

#include "core/memory.h"

/* A file in memory, and the size that its image must have. */
typedef struct svx_png {
    const uint8_t *bytes;
    size_t byte_count;
    uint32_t width, height;
} svx_png;

/* The pixels of an image, which are stb_image's: by malloc. */
typedef struct svx_image {
    void *gray; /* a uint8_t or, with 16 bits, a uint16_t per pixel; NULL for a color image */
    uint32_t bits; /* of a gray pixel: 8 or 16 */
    uint8_t *rgba; /* four bytes per pixel; NULL for a gray image */
} svx_image;

/* The most bytes that an image of that size may have as a file. */
uint64_t svo_i_svx_png_bytes_max(uint32_t width, uint32_t height);

/*
 * Decodes an image of exactly its size, as color or as gray. Memory is bounded by the size, whatever the file says.
 *
 * memory: for what the check needs while it runs.
 * Returns NULL, or why not; "out of memory" is that very text. *offset: the byte of the file that it is about.
 */
const char *svo_i_svx_png_read(const svo_i_memory *memory, const svx_png *png, int color, svx_image *image,
                               size_t *offset);
void svo_i_svx_png_free(svx_image *image);

/* A pixel of a gray image. */
uint32_t svo_i_svx_png_gray(const svx_image *image, size_t pixel);

extern const char svo_i_svx_png_no_memory[];

#endif
