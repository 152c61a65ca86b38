/* SPDX-License-Identifier: MIT */
/* What the files of the plain toolkit share: where a frame's widgets are, and which one the mouse holds. */
#ifndef SVOCL_TOOLS_VIEW_UI_TEXT_H
#define SVOCL_TOOLS_VIEW_UI_TEXT_H

#include "view/ui.h"
#include "view/ui_glyphs.h"

#define UI_TEXT_PANELS_MAX 8
#define UI_TEXT_DEPTH_MAX  8
#define UI_TEXT_LINE_BYTES 512

/* What is remembered of a panel from frame to frame. */
typedef struct ui_text_panel {
    uint32_t id;
    ui_place place;
    float scroll; /* pixels that are above the top */
    float content_height; /* of the last frame */
    size_t background; /* the first vertex of it */
    bool seen; /* in this frame */
} ui_text_panel;

struct ui {
    ui_glyph_set *glyphs;
    ui_drawing drawing;
    ui_input now, before; /* this frame's and the last one's */
    ui_text_panel panels[UI_TEXT_PANELS_MAX];
    size_t panel_count;
    ui_text_panel *panel; /* the one that is being described */
    float left, right, y; /* where its next row goes */
    bool enabled;
    uint32_t salts[UI_TEXT_DEPTH_MAX]; /* of ui_push */
    size_t depth;
    uint32_t held; /* the widget that the button went down on; 0: none */
    bool held_seen; /* in this frame */
    uint32_t focus; /* the field that keys go to; 0: none */
    bool focus_seen;
    bool focus_next; /* the next field gets it */
    ui_place item; /* the last widget, for tooltips */
    char tooltip[UI_TEXT_LINE_BYTES];
};

/* What the mouse does with a widget. */
typedef struct ui_text_use {
    bool hovered, held;
    bool began; /* held since this frame */
    bool clicked; /* released on it in this frame */
} ui_text_use;

/* Takes the next row of the panel. */
ui_place ui_text_row(ui *panels, float height);
/* Takes a row, writes the label at its left, and returns the rest. */
ui_place ui_text_labeled(ui *panels, const char *label);
float ui_text_height(const ui *panels);

uint32_t ui_text_id(const ui *panels, const char *label);
/* The widget of this number and place, which becomes the one that tooltips are about. */
ui_text_use ui_text_widget(ui *panels, uint32_t id, ui_place place);

/* Plain rectangles and one line of text, cut to what fits; share: 0 puts it left, 1/2 in the middle, 1 right. */
void ui_text_fill(ui *panels, ui_place place, uint32_t color);
void ui_text_triangle(ui *panels, const float corners[6]);
void ui_text_write(ui *panels, ui_place place, float share, uint32_t color, const char *text);
/* A widget's background. */
void ui_text_back(ui *panels, ui_place place, ui_text_use use, bool chosen);

#endif
