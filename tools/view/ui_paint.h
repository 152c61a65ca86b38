/* SPDX-License-Identifier: MIT */
/* Draws panels by OpenGL, whichever toolkit made their triangles. */
#ifndef SVOCL_TOOLS_VIEW_UI_PAINT_H
#define SVOCL_TOOLS_VIEW_UI_PAINT_H

#include "svocl/status.h"
#include "view/gl.h"
#include "view/ui.h"

typedef struct ui_paint ui_paint;

/* Makes the program and the texture of glyphs (ui_glyphs) in the current context, whose functions must outlive it. NULL
   with a reason on failure. */
ui_paint *ui_paint_create(const view_gl *gl, const uint8_t *glyphs, unsigned width, unsigned height, svo_message *why);
void ui_paint_destroy(ui_paint **paint);

/* Draws over what is there, in a window of so many pixels. False on failure. */
bool ui_paint_draw(ui_paint *paint, const ui_drawing *drawing, unsigned width, unsigned height, float scale,
                   svo_message *why);

#endif
