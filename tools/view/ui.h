/* SPDX-License-Identifier: MIT */
/*
 * Panels in immediate mode: in each frame the caller describes them anew, and a widget says at once whether it was
 * used. There are two implementations, and a build has one of them: ui_imgui*.cpp by Dear ImGui, and ui_text*.c with
 * plain widgets of its own around text by stb_truetype. Both look alike: labels at the left, what they label at the
 * right.
 *
 * Neither knows a window or OpenGL. What the user did comes in as ui_input, what is seen goes out as ui_drawing. So
 * the same inputs give the same triangles.
 *
 * After memory ran out, widgets do nothing, and ui_end says so.
 */
#ifndef SVOCL_TOOLS_VIEW_UI_H
#define SVOCL_TOOLS_VIEW_UI_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "view/ui_drawing.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ui ui;

/* Keys that fields of text understand. */
typedef enum ui_key {
    UI_KEY_BACKSPACE,
    UI_KEY_DELETE,
    UI_KEY_LEFT,
    UI_KEY_RIGHT,
    UI_KEY_HOME,
    UI_KEY_END,
    UI_KEY_ENTER,
    UI_KEY_ESCAPE,
    UI_KEY_COUNT
} ui_key;

#define UI_TYPED_BYTES 64

/* What happened since the last frame. A button or a key that went down and up in between counts as down for a frame. */
typedef struct ui_input {
    float width, height; /* of the window, pixels */
    float seconds; /* since the last frame, above 0 */
    float mouse[2]; /* pixels from the top left; negative: not in the window */
    float wheel; /* notches; positive is up */
    bool buttons[3]; /* left, right, middle: held */
    bool keys[UI_KEY_COUNT]; /* held */
    bool large; /* larger text */
    char typed[UI_TYPED_BYTES]; /* UTF-8 */
} ui_input;

/* A rectangle in pixels. */
typedef struct ui_place {
    float x, y, width, height;
} ui_place;

/* The toolkit's name and version, for people. */
const char *ui_toolkit(void);

/* NULL when memory runs out. There is one at a time. */
ui *ui_create(void);
void ui_destroy(ui **panels);

/* The texture UI_TEXTURE_GLYPHS: width * height bytes of coverage, top to bottom, which live as long as panels. */
const uint8_t *ui_glyphs(const ui *panels, unsigned *width, unsigned *height);

/* ---- frames ---- */

void ui_begin(ui *panels, const ui_input *input);

/* Ends a frame. The drawing lives until the next frame; NULL when memory ran out, after which nothing else is drawn. */
const ui_drawing *ui_end(ui *panels);

/* Whether the mouse is over a panel or drags something of one, as of the last frame: what it does is not for the
   picture. Likewise the keys while a field of text has the focus. */
bool ui_wants_mouse(const ui *panels);
bool ui_wants_keys(const ui *panels);

/* Pixels of a row with its gap, for places that follow the size of the text. */
float ui_row_height(const ui *panels);

/* ---- panels ---- */

/* Begins a panel; what follows stands in it from top to bottom until ui_panel_end. It is as high as that, at most
   place.height; what is longer scrolls. name: identifies the panel. */
void ui_panel_begin(ui *panels, const char *name, ui_place place);
/* Returns the height. */
float ui_panel_end(ui *panels);

/* A heading that opens and closes what stands below it. Returns whether it was clicked, which changes is_open. */
bool ui_section(ui *panels, const char *title, bool *is_open);

/* Widgets of one label in one panel are told apart by the numbers around them. */
void ui_push(ui *panels, int number);
void ui_pop(ui *panels);

/* Everything until ui_enable(true) is dim and does nothing. Each panel begins enabled. */
void ui_enable(ui *panels, bool enabled);

/* ---- text ---- */

void ui_heading(ui *panels, const char *text);
void ui_text(ui *panels, const char *format, ...) __attribute__((format(printf, 2, 3)));
void ui_note(ui *panels, const char *format, ...) __attribute__((format(printf, 2, 3))); /* dim */
void ui_value(ui *panels, const char *label, const char *format, ...) __attribute__((format(printf, 3, 4)));
void ui_gap(ui *panels);

/* ---- widgets ---- */

/* Buttons side by side, of equal width. Returns the one that was pressed, else -1. */
int ui_buttons(ui *panels, const char *const *names, int count);

/* Names of which one is chosen, side by side in as many rows as they need. Returns whether the choice changed. */
bool ui_tabs(ui *panels, const char *const *names, int count, int *chosen);

/* A line of a list. Returns whether it was clicked. */
bool ui_item(ui *panels, const char *text, bool chosen);

/* These return whether the value changed. */
bool ui_checkbox(ui *panels, const char *label, bool *value);
bool ui_choice(ui *panels, const char *label, const char *const *names, int count, int *chosen);
bool ui_slider(ui *panels, const char *label, float *value, float low, float high, const char *format);
bool ui_slider_count(ui *panels, const char *label, int *value, int low, int high);
/* 1 .. 3 numbers that dragging changes, by step for each pixel. */
bool ui_numbers(ui *panels, const char *label, float *values, int count, float step, const char *format);
/* Linear red, green and blue, each 0 or above. */
bool ui_color(ui *panels, const char *label, float rgb[3]);
/* The next field gets the keys. */
void ui_focus(ui *panels);
/* A line of text; returns true when Enter ended it. */
bool ui_field(ui *panels, const char *label, char *text, size_t text_bytes);

/* Explains the widget before it while the mouse is over it. */
void ui_tooltip(ui *panels, const char *text);

/* ---- free drawing ---- */

/* Takes room of the panel's width and this height for ui_fill and its neighbors, which use the window's pixels.
   Returns whether the mouse drags there; mouse, unless NULL, receives where it is, 0 .. 1 from the top left, or -1 when
   it is neither there nor dragging. */
bool ui_canvas(ui *panels, const char *name, float height, ui_place *place, float mouse[2]);
void ui_fill(ui *panels, ui_place place, uint32_t color);
void ui_line(ui *panels, const float from[2], const float to[2], uint32_t color);
void ui_fill_text(ui *panels, float x, float y, uint32_t color, const char *text);
/* texture: as the window knows it. part: left, top, right, bottom in it, 0 .. 1. */
void ui_fill_image(ui *panels, ui_place place, uint32_t texture, const float part[4]);
float ui_text_width(const ui *panels, const char *text);

#ifdef __cplusplus
}
#endif

#endif
