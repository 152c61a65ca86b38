/* SPDX-License-Identifier: MIT */
/* What the window shows below the panels: a picture in a texture, which comes from OpenCL by a buffer that both share,
   and lines and areas over it. */
#ifndef SVOCL_TOOLS_VIEW_CANVAS_H
#define SVOCL_TOOLS_VIEW_CANVAS_H

#include <stddef.h>
#include <stdint.h>

#include "support/program.h"
#include "svocl/gl.h"
#include "svocl/status.h"
#include "view/gl.h"
#include "view/state.h"

/* A corner of a triangle over the picture. */
typedef struct canvas_vertex {
    float x, y; /* pixels from the window's left upper corner */
    float color[4]; /* 0 .. 1, not multiplied by alpha */
} canvas_vertex;

typedef struct canvas canvas;

/* Makes textures and programs in the current context, whose functions must outlive the canvas. NULL with a reason on
   failure. */
canvas *canvas_create(const view_gl *gl, svo_message *why);
void canvas_destroy(canvas **which);

/* Rows of a picture, in an OpenGL buffer that has the whole picture from an offset on, rows from top to bottom. */
typedef struct canvas_rows {
    uint32_t buffer;
    size_t offset_bytes;
    unsigned width, height; /* of the picture */
    unsigned first_row, row_count;
} canvas_rows;

/* Takes rows of a picture; of a new size it must be all. False on failure. */
bool canvas_take_rows(canvas *which, const canvas_rows *rows, svo_message *why);
/* Makes a picture of twice the width out of the one that was taken, cut at the size, each pixel four times. False on
   failure. */
bool canvas_enlarge(canvas *which, unsigned width, unsigned height, svo_message *why);

/* Takes a square picture for panels, rows from top to bottom; canvas_map is its name for ui_fill_image. */
bool canvas_take_map(canvas *which, const uint8_t *rgba, unsigned edge, svo_message *why);
uint32_t canvas_map(const canvas *which);

/* Begins a frame of this many pixels, draws the picture over it, then count / 3 triangles. What is drawn until
   canvas_show is of the frame too. False on failure. */
bool canvas_draw(canvas *which, unsigned width, unsigned height, const canvas_vertex *vertices, size_t count,
                 svo_message *why);

/* Begins a frame with all of the one before. In a window of another size it has the picture alone. False on failure. */
bool canvas_continue(canvas *which, unsigned width, unsigned height, svo_message *why);

/* Puts the frame into the window. False on failure. */
bool canvas_show(canvas *which, svo_message *why);

/* Reads what was drawn, before it is shown, rows from top to bottom, as opaque pixels. False on failure. */
bool canvas_read(canvas *which, unsigned width, unsigned height, uint8_t *rgba, svo_message *why);

/* ---- pixels from OpenCL ---- */

/* The memory that pictures are drawn to by OpenCL and read from by OpenGL. */
typedef struct pixel_buffer {
    program *running;
    svo_gl_context *context; /* the window's, current in all calls */
    svo_gl_buffer *buffer; /* NULL: not made yet */
    svo_gl_buffer_info info; /* of it */
    svo_device *device; /* whose it is */
    cl_command_queue queue; /* of the picture that is being drawn */
} pixel_buffer;

/* Gives the memory to OpenCL, with room for so many bytes. What it is and why goes to the state and its log when it is
   made. Returns the exit code. */
int pixel_buffer_begin(pixel_buffer *which, svo_device *device, cl_command_queue queue, size_t bytes,
                       view_state *state);
/* Waits for the picture, which takes the event, and gives its first bytes to OpenGL. Returns the exit code. */
int pixel_buffer_finish(pixel_buffer *which, size_t used_bytes, cl_event drawn);

/* Before its device goes. */
void pixel_buffer_drop(pixel_buffer *which);

#endif
