/* SPDX-License-Identifier: MIT */
/* Lights, sky and camera as a JSON file. docs/light.md describes the format. */
#ifndef SVOCL_TOOLS_SUPPORT_LIGHT_FILE_H
#define SVOCL_TOOLS_SUPPORT_LIGHT_FILE_H

#include "support/program.h"
#include "svocl/light_types.h"
#include "svocl/trace.h"

/* Most lights of a file. */
#define LIGHT_FILE_SOURCES_MAX 1024

typedef struct light_file {
    svo_light_source *sources; /* NULL: none */
    size_t source_count;
    float sky[3]; /* radiance; zero: not given */
    svo_camera camera;
    bool has_camera;
} light_file;

/* Reads and checks the file. Returns the exit code; on failure nothing stays open. */
int light_file_open(program *state, const char *path, light_file *out);
void light_file_close(light_file *file);

#endif
