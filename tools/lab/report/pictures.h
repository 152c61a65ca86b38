/* SPDX-License-Identifier: MIT */
/* The pictures of a report: scenes built and rendered by the program, as PNG in memory. */
#ifndef SVOCL_TOOLS_REPORT_PICTURES_H
#define SVOCL_TOOLS_REPORT_PICTURES_H

#include "support/program.h"

#define PICTURES_MAX 4u

typedef struct picture {
    const char *name, *caption; /* static */
    unsigned width, height;
    unsigned char *png; /* by malloc */
    size_t png_bytes;
} picture;

typedef struct pictures {
    picture list[PICTURES_MAX];
    size_t count;
} pictures;

/* Opens a session of its own and advances the progress bar by one step per picture. Returns the exit code; on failure
   out is empty. */
int pictures_make(program *state, bool quick, pictures *out);
void pictures_free(pictures *made);

#endif
