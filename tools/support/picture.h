/* SPDX-License-Identifier: MIT */
/* Pictures: what they need of a tree, and PNG files. */
#ifndef SVOCL_TOOLS_SUPPORT_PICTURE_H
#define SVOCL_TOOLS_SUPPORT_PICTURE_H

#include "support/input.h"
#include "support/json.h"
#include "svocl/trace.h"

/* The svo_need bits that a picture of the source takes, from what is asked for: by default normals, and the colors that
   it has. A mesh without colors gets none, not white ones: it is shown as clay. */
uint32_t picture_need(const input *source, uint32_t asked);

/* Writes a picture, rows from top to bottom, to a path; - is standard output. Returns the exit code. */
int picture_write_as(program *state, const char *path, uint32_t width, uint32_t height, const uint8_t *rgba);

/* Writes a picture of --size to the path after -o; one step of the progress bar. Returns the exit code. */
int picture_write(program *state, const uint8_t *rgba);

/* The JSON document of a picture of --size: INPUT, the file and the size. What its command adds comes next. */
cJSON *picture_document(const program *state);
/* Ends the document by the time, the device and the camera, and prints it. Returns the exit code. */
int picture_print_document(program *state, cJSON *document, double render_ms, const svo_device *device,
                           const svo_camera *camera);

#endif
