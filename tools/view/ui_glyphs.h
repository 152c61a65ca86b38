/* SPDX-License-Identifier: MIT */
/* Glyphs of the plain toolkit: two sizes of Latin text in one picture, made by stb_truetype. */
#ifndef SVOCL_TOOLS_VIEW_UI_GLYPHS_H
#define SVOCL_TOOLS_VIEW_UI_GLYPHS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "view/ui_drawing.h"

#define UI_GLYPHS_WIDTH  512u
#define UI_GLYPHS_HEIGHT 256u

typedef struct ui_glyph_set ui_glyph_set;

/* NULL when memory runs out. */
ui_glyph_set *ui_glyph_set_create(void);
void ui_glyph_set_destroy(ui_glyph_set **set);

/* UI_GLYPHS_WIDTH * UI_GLYPHS_HEIGHT bytes of coverage. Those of the first pixel are full, for plain rectangles. */
const uint8_t *ui_glyph_set_coverage(const ui_glyph_set *set);

/* Pixels of the first text_bytes bytes of a text. */
float ui_glyph_set_measure(const ui_glyph_set *set, bool large, const char *text, size_t text_bytes);

/* Appends the text to the drawing's current batch, with its line's top left corner there. */
void ui_glyph_set_draw(const ui_glyph_set *set, bool large, const float at[2], uint32_t color, const char *text,
                       size_t text_bytes, ui_drawing *drawing);

/* The bytes of the character at text, 1 or 2; other characters count byte by byte. */
size_t ui_glyph_bytes(const char *text);

#endif
