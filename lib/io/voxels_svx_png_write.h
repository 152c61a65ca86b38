/* SPDX-License-Identifier: MIT */
/* Writes PNG images for .svx files. */
#ifndef SVO_LIB_IO_VOXELS_SVX_PNG_WRITE_H
#define SVO_LIB_IO_VOXELS_SVX_PNG_WRITE_H

#include <stddef.h>
#include <stdint.h>

#include "core/memory.h"

/* An image that is not packed, for svo_i_free; NULL when out of memory. pixels: rows of one gray byte or of three color
   bytes a pixel. */
uint8_t *svo_i_svx_png_write(const svo_i_memory *memory, const uint8_t *pixels, uint32_t width, uint32_t height,
                             uint32_t channels, size_t *byte_count);

#endif
