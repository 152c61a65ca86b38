/* SPDX-License-Identifier: MIT */
/* The sky of a file of lights: one radiance, a gradient, or a picture of all directions. */
#ifndef SVOCL_TOOLS_SUPPORT_SKY_FILE_H
#define SVOCL_TOOLS_SUPPORT_SKY_FILE_H

#include "support/json_source.h"

/* What svo_light_setup takes. */
typedef struct sky_file {
    float radiance[3]; /* of all directions; zero where there is a map */
    float *texels; /* owned; NULL: there is no map */
    uint32_t width, height;
    /* What the map was made of: a picture, scaled and turned by degrees, or a gradient. */
    char *path; /* owned; NULL: a gradient */
    double scale, turn;
    float gradient[3][3]; /* zenith, horizon, ground */
} sky_file;

/* Reads the value of "sky". Returns the exit code; out is closed in any case. */
int sky_file_read(const json_source *source, const cJSON *value, sky_file *out);
void sky_file_close(sky_file *sky);

/* A member of three numbers that are not negative, which must be there. what: names the object. */
int sky_file_color(const json_source *source, const cJSON *object, const char *what, const char *name, float out[3]);

#endif
