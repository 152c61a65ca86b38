/* SPDX-License-Identifier: MIT */
/*
 * Panels in immediate mode: in each frame the caller describes them anew, and a widget says at once whether it was
 * used. Dear ImGui makes them (ui_imgui*.cpp), behind functions for C: labels stand at the left, what they label at the
 * right.
 *
 * None of this knows a window or OpenGL. What the user did comes in as ui_input, which ui_events gathers of a window's
 * events; what is seen goes out as ui_drawing. So the same inputs give the same triangles.
 *
 * After memory ran out, widgets do nothing, and ui_end says so.
 */
#ifndef SVOCL_TOOLS_VIEW_UI_H
#define SVOCL_TOOLS_VIEW_UI_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- drawings ---- */

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

/* ---- colors and distances ---- */

#define UI_COLOR_PANEL   UI_RGBA(22, 25, 31, 226)
#define UI_COLOR_EDGE    UI_RGBA(255, 255, 255, 24)
#define UI_COLOR_TEXT    UI_RGBA(226, 230, 236, 255)
#define UI_COLOR_DIM     UI_RGBA(150, 158, 170, 255)
#define UI_COLOR_ACCENT  UI_RGBA(94, 176, 239, 255)
#define UI_COLOR_CHOSEN  UI_RGBA(42, 98, 148, 255)
#define UI_COLOR_FIELD   UI_RGBA(54, 61, 74, 255)
#define UI_COLOR_HOVER   UI_RGBA(68, 78, 95, 255)
#define UI_COLOR_PRESSED UI_RGBA(84, 97, 118, 255)
#define UI_COLOR_WARNING UI_RGBA(242, 178, 92, 255)

/* Probes by their state. */
#define UI_COLOR_PROBE_OFF      UI_RGBA(235, 87, 130, 255)
#define UI_COLOR_PROBE_IN_PLACE UI_RGBA(94, 176, 239, 255)
#define UI_COLOR_PROBE_MOVED    UI_RGBA(248, 186, 84, 255)

/* Axes of the world. */
#define UI_COLOR_AXIS_X UI_RGBA(240, 96, 104, 255)
#define UI_COLOR_AXIS_Y UI_RGBA(108, 205, 108, 255)
#define UI_COLOR_AXIS_Z UI_RGBA(104, 156, 255, 255)

/* Pixel sizes of text. */
#define UI_TEXT_SMALL 13.0F
#define UI_TEXT_LARGE 16.0F

#define UI_PADDING      8.0F /* between a panel's edge and what it holds */
#define UI_GAP          4.0F /* between rows, and between widgets of a row */
#define UI_INSET_X      5.0F /* between a widget's edge and its text */
#define UI_INSET_Y      2.0F
#define UI_LABEL_SHARE  0.36F /* of a panel's width: labels */
#define UI_ROUNDING     3.0F
#define UI_SCROLL_WIDTH 6.0F

/* ---- events of the window, whether a hand or a script made them ---- */

typedef enum view_event_kind {
    VIEW_EVENT_KEY, /* key went down or up */
    VIEW_EVENT_TEXT, /* text was typed */
    VIEW_EVENT_MOVE, /* the mouse is at x, y */
    VIEW_EVENT_BUTTON, /* of the mouse, at x, y */
    VIEW_EVENT_WHEEL, /* by steps, at x, y */
    VIEW_EVENT_RESIZE, /* the window has x times y pixels */
    VIEW_EVENT_DROP, /* a file was dropped on the window: path */
    VIEW_EVENT_QUIT
} view_event_kind;

enum { VIEW_BUTTON_LEFT = 0, VIEW_BUTTON_RIGHT, VIEW_BUTTON_MIDDLE };

/* Keys are their lowercase letter or digit, or one of these. */
enum {
    VIEW_KEY_NONE = 0,
    VIEW_KEY_BACKSPACE = 8,
    VIEW_KEY_TAB = 9,
    VIEW_KEY_ENTER = 13,
    VIEW_KEY_ESCAPE = 27,
    VIEW_KEY_SPACE = 32,
    VIEW_KEY_DELETE = 127,
    VIEW_KEY_LEFT = 256,
    VIEW_KEY_RIGHT,
    VIEW_KEY_UP,
    VIEW_KEY_DOWN,
    VIEW_KEY_HOME,
    VIEW_KEY_END,
    VIEW_KEY_F1, /* F2 to F12 follow */
    VIEW_KEY_F12 = VIEW_KEY_F1 + 11,
    VIEW_KEYS
};

typedef struct view_event {
    view_event_kind kind;
    int key;
    int button;
    bool is_down;
    bool shift, control; /* held */
    int x, y; /* pixels from the window's left upper corner */
    float steps; /* of the wheel, away from the user is positive */
    char text[32]; /* UTF-8 */
    char path[1024]; /* "": it was longer */
} view_event;

/* ---- what the user did since the last frame ---- */

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
    UI_KEY_TAB,
    UI_KEY_UP,
    UI_KEY_DOWN,
    UI_KEY_A, /* with control: all; copy, paste, cut */
    UI_KEY_C,
    UI_KEY_V,
    UI_KEY_X,
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
    bool control, shift; /* held */
    bool large; /* larger text */
    char typed[UI_TYPED_BYTES]; /* UTF-8 */
} ui_input;

/* A rectangle in pixels. */
typedef struct ui_place {
    float x, y, width, height;
} ui_place;

/* What is held, and what was pressed since the last frame even if it is held no more. */
typedef struct ui_events {
    ui_input next; /* without size and time; its buttons and keys are those that went down */
    bool buttons[3]; /* held */
    bool keys[UI_KEY_COUNT];
} ui_events;

/* No mouse, nothing held. */
void ui_events_begin(ui_events *events);

void ui_events_take(ui_events *events, const view_event *event);

/* The input of the next frame; forgets what is over. */
ui_input ui_events_frame(ui_events *events, unsigned width, unsigned height, float seconds);

/* ---- the toolkit ---- */

typedef struct ui ui;

/* The toolkit's name and version, for people. */
const char *ui_toolkit(void);

/* scale: pixels of the screen for each pixel of the panels; text is made for it. NULL when memory runs out. There is
   one at a time. */
ui *ui_create(float scale);
void ui_destroy(ui **panels);

/* The texture UI_TEXTURE_GLYPHS: width * height bytes of coverage, top to bottom, which live as long as panels. */
const uint8_t *ui_glyphs(const ui *panels, unsigned *width, unsigned *height);

/* The text that other programs copied, and the text for them. read returns a string that lives until its next call. */
typedef struct ui_clipboard {
    const char *(*read)(void *user);
    void (*write)(void *user, const char *text);
    void *user;
} ui_clipboard;

/* Without one, fields paste what they copied themselves. */
void ui_set_clipboard(ui *panels, const ui_clipboard *clipboard);

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
/* The next panel stands above the others. */
void ui_raise(ui *panels);

/* A heading that opens and closes what stands below it; key, of the keyboard, stands at its right. Returns whether it
   was clicked, which changes is_open. */
bool ui_section(ui *panels, const char *title, const char *key, bool *is_open);

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
/* A text that is at most so wide: all of it, or its first words and "...". Returns whether it is all. */
bool ui_fit(const ui *panels, const char *text, float width, char *out, size_t out_bytes);

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

/* What keys do in a field of a path. */
typedef enum ui_path_edit { UI_PATH_COMPLETE, UI_PATH_PREVIOUS, UI_PATH_NEXT } ui_path_edit;
typedef struct ui_path_keys {
    void (*edit)(void *user, ui_path_edit kind); /* may change the text */
    void *user;
} ui_path_keys;

/* A line of text as wide as the panel, for a path: Tab, Up and Down are for keys. takes_focus: it is to be typed into.
   Returns true when Enter ended it. */
bool ui_path(ui *panels, char *text, size_t text_bytes, bool takes_focus, const ui_path_keys *keys);

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
