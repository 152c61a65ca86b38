/* SPDX-License-Identifier: MIT */
/* Reads Radiance pictures (Ward, "Real Pixels", 1991), .hdr or .pic, of red, green and blue with shared exponents. */
#ifndef SVOCL_TOOLS_SUPPORT_HDR_FILE_H
#define SVOCL_TOOLS_SUPPORT_HDR_FILE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#define HDR_WORDS_BYTES 128

typedef struct hdr_picture {
    float *texels; /* owned: rows from the top, three channels, linear */
    uint32_t width, height;
    char words[HDR_WORDS_BYTES]; /* what is wrong, where it was not read */
} hdr_picture;

/* Reads a picture of at most that size. False: out->words says what is wrong, and there is no picture. */
bool hdr_file_read(FILE *stream, uint32_t width_max, uint32_t height_max, hdr_picture *out);
void hdr_file_free(hdr_picture *picture);

#endif
