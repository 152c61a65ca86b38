/* SPDX-License-Identifier: MIT */
/* Files of pictures and films: what each format holds, and its bytes. */
#ifndef SVOCL_TOOLS_SUPPORT_PICTURE_FILES_H
#define SVOCL_TOOLS_SUPPORT_PICTURE_FILES_H

#include "support/output.h"

/* Rows from top to bottom. */
typedef struct picture_pixels {
    uint32_t width, height;
    const uint8_t *bytes; /* red, green, blue, alpha of each pixel; NULL: floats */
    const float *floats; /* the same; colors are multiplied by alpha */
    bool has_alpha; /* else alpha is left out where a format can do without */
} picture_pixels;

typedef struct picture_format {
    const char *suffix; /* ".png" */
    int value; /* option_format */
    bool is_linear; /* floats, not bytes */
    bool has_alpha, has_negative;
    bool is_film; /* one frame after the other, each of them written by write */
    int (*write)(program *state, output_file *file, const picture_pixels *pixels); /* returns the exit code */
} picture_format;

/* The format after --format, else that of the suffix of -o, else, also of standard output, PNG. NULL: the suffix is
   that of none. */
const picture_format *picture_format_of(const options *given);
/* ".png, .exr, .hdr, .ppm, .y4m" */
const char *picture_format_suffixes(void);

/* Whether this build of the program writes the format; else a line says what is missing. Returns the exit code. */
int picture_format_check(program *state, const picture_format *format, const char *path);

/* Begins a film. */
void picture_film_begin(output_file *file, uint32_t width, uint32_t height, unsigned frames_per_second);

#endif
