/* SPDX-License-Identifier: MIT */
/*
 * What panels look like: triangles in the order in which they are drawn, in pixels from the window's top left corner.
 * Both toolkits (ui.h) make such a list, so that one piece of OpenGL draws either.
 */
#ifndef SVOCL_TOOLS_VIEW_UI_DRAWING_H
#define SVOCL_TOOLS_VIEW_UI_DRAWING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A color as bytes red, green, blue, alpha in this order, not premultiplied. */
#define UI_RGBA(r, g, b, a) ((uint32_t)(r) | (uint32_t)(g) << 8 | (uint32_t)(b) << 16 | (uint32_t)(a) << 24)

#define UI_TEXTURE_GLYPHS 0u /* ui_batch.texture: the toolkit's glyphs, whose coverage multiplies alpha */

typedef struct ui_vertex {
    float x, y; /* pixels */
    float u, v; /* in the texture, 0 .. 1 from the top left */
    uint32_t color; /* UI_RGBA; multiplies the texture */
} ui_vertex;

/* Consecutive triangles of one texture within one rectangle. */
typedef struct ui_batch {
    uint32_t index_begin, index_count;
    uint32_t texture; /* UI_TEXTURE_GLYPHS, or the name of a picture that the caller gave to ui_fill_image */
    int clip[4]; /* left, top, right, bottom; nothing is drawn outside */
} ui_batch;

typedef struct ui_drawing {
    ui_vertex *vertices;
    uint32_t *indices; /* three a triangle */
    ui_batch *batches;
    size_t vertex_count, vertex_capacity;
    size_t index_count, index_capacity;
    size_t batch_count, batch_capacity;
    bool failed; /* out of memory: the list is not complete */
} ui_drawing;

void ui_drawing_clear(ui_drawing *drawing);
void ui_drawing_free(ui_drawing *drawing);

/* Further triangles have this texture and clip. */
void ui_drawing_batch(ui_drawing *drawing, uint32_t texture, const int clip[4]);

/* Appends vertices; returns the index of the first. */
uint32_t ui_drawing_vertices(ui_drawing *drawing, const ui_vertex *vertices, size_t count);
/* Appends triangles to the current batch; their indices count from the vertex first. */
void ui_drawing_triangles(ui_drawing *drawing, uint32_t first, const uint16_t *indices, size_t count);

/* Appends a rectangle: left, top, right, bottom, and the same in the texture. */
void ui_drawing_rectangle(ui_drawing *drawing, const float place[4], const float texture[4], uint32_t color);

#ifdef __cplusplus
}
#endif

#endif
