/* SPDX-License-Identifier: MIT */
/* Files of lights: sources, sky and camera, in JSON. docs/light.md describes them. */
#ifndef SVOCL_TOOLS_SUPPORT_LIGHTS_FILE_H
#define SVOCL_TOOLS_SUPPORT_LIGHTS_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "support/program.h"
#include "support/sky_file.h"
#include "svocl/light.h"
#include "svocl/trace.h"

/* Most lights of a file. */
#define LIGHTS_FILE_SOURCES_MAX 1024

typedef struct lights_file {
    svo_light_source *sources; /* NULL: none */
    size_t source_count;
    sky_file sky; /* dark: not given */
    svo_camera camera;
    bool has_camera;
} lights_file;

/* Reads and checks the file. Returns the exit code; on failure nothing stays open. */
int lights_file_open(program *state, const char *path, lights_file *out);
void lights_file_close(lights_file *file);

/* Its lights and its sky, which the setup borrows. */
svo_light_setup lights_file_setup(const lights_file *file);

#endif
