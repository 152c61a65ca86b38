/* SPDX-License-Identifier: MIT */
/* Pictures that the program wrote, for tests. */
#ifndef SVOCL_TESTS_PROGRAM_PICTURE_H
#define SVOCL_TESTS_PROGRAM_PICTURE_H

#include <stdint.h>

typedef struct program_picture {
    uint8_t *rgba; /* height rows of width * 4 bytes, top to bottom */
    int width, height;
} program_picture;

/* Reads a PNG file; the test fails if there is none. */
program_picture read_picture(const char *path);
void free_picture(program_picture *picture);

/* The same of linear floats: .hdr, or .exr where the program writes it. Pixels are red, green, blue, alpha; alpha is 1
   where the file has none. Released by free(). */
float *read_light(const char *path, int *width, int *height);

/* The four bytes of a pixel. */
const uint8_t *pixel_of(const program_picture *picture, int x, int y);

/* The mean of red, green and blue over all pixels, 0 .. 255. */
double mean_of(const program_picture *picture);

/* The mean of a PNG file, which is removed. */
double take_brightness(const char *path);

#endif
