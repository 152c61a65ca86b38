/* SPDX-License-Identifier: MIT */
/* Pictures: what they need of a tree, and the files that commands draw, one or one for each frame. */
#ifndef SVOCL_TOOLS_SUPPORT_PICTURE_H
#define SVOCL_TOOLS_SUPPORT_PICTURE_H

#include "support/input.h"
#include "support/json.h"
#include "support/picture_files.h"
#include "svocl/trace.h"

/* The svo_need bits that a picture of the source takes, from what is asked for: by default normals, and the colors that
   it has. A mesh without colors gets none, not white ones: it is shown as clay. */
uint32_t picture_need(const input *source, uint32_t asked);

/* Writes bytes of a picture, rows from top to bottom, to a PNG file; - is standard output. Returns the exit code. */
int picture_write_as(program *state, const char *path, uint32_t width, uint32_t height, const uint8_t *rgba);

/* ---- what a command draws ---- */

/* Refuses what the format after -o does not hold, before long work. Returns the exit code. */
int picture_check(program *state);

/* Whether all files can be written: before long work, not after it. Returns the exit code. */
int picture_check_files(program *state, uint64_t frame_count);

/* The number of files or frames, without those of --animate: each takes a step of the progress bar. */
unsigned picture_frames(const options *given);

/* What of each pixel the format and the options ask of the library. */
svo_picture_output picture_output(const options *given);

/* Frames of --size on their way to -o. Stays where it is while it is open. */
typedef struct picture_stream {
    program *state;
    const picture_format *format;
    uint8_t *pixels; /* what is drawn next, as picture_output says */
    output_file film; /* of formats that have all frames in one file */
} picture_stream;

/* Allocates the pixels, and begins a film. Returns the exit code; on failure nothing stays open. */
int picture_open(program *state, picture_stream *out);
/* Writes what is in the pixels: to path, or as the next frame of a film. Returns the exit code. */
int picture_add(picture_stream *shown, const char *path);
/* Ends a film, or, after a failure, leaves none. Returns the exit code. */
int picture_close(picture_stream *shown, int exit_code);

#define PICTURE_PATH_BYTES 4200

/* The path of a frame: "film.png" becomes "film_007.png" with --animate, and "film-0007.png" with --turntable. */
void picture_frame_path(const options *given, uint64_t frame, char path[PICTURE_PATH_BYTES]);

/* Draws a picture as a camera sees it. Returns the exit code. */
typedef int (*picture_drawer)(void *user, const svo_camera *camera, const svo_picture_output *output, uint8_t *pixels);

/* Draws and writes what -o asks for, by a camera that stands, or with --turntable turns round its target. step: what
   the progress bar says. draw_ms: receives the time of all drawing. Returns the exit code. */
int picture_draw(program *state, const char *step, const svo_camera *camera, picture_drawer draw, void *user,
                 double *draw_ms);

/* "a.png: 640x480 pixels" or "a.png: 36 frames of 640x480 pixels" */
typedef struct picture_words {
    char text[PICTURE_PATH_BYTES];
} picture_words;
picture_words picture_describe(const options *given);

/* The JSON document of a picture of --size: INPUT, the file and the size. What its command adds comes next. */
cJSON *picture_document(const program *state);
/* Ends the document by the time, the device and the camera, and prints it. Returns the exit code. */
int picture_print_document(program *state, cJSON *document, double render_ms, const svo_device *device,
                           const svo_camera *camera);

#endif
