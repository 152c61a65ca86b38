/* SPDX-License-Identifier: MIT */
/*
 * The plain toolkit: frames, panels and text. A panel is one column of rows. Widgets (ui_text_widgets.c) need no state
 * but the one that the mouse holds, the field with the focus, and how far each panel is scrolled.
 */
#include "view/ui_text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "view/ui_theme.h"

/* The opaque pixel of the glyphs' picture. */
static const float opaque[4] = {0.5F / UI_GLYPHS_WIDTH, 0.5F / UI_GLYPHS_HEIGHT, 0.5F / UI_GLYPHS_WIDTH,
                                0.5F / UI_GLYPHS_HEIGHT};

const char *ui_toolkit(void)
{
    return "plain text";
}

void ui_set_clipboard(ui *panels, const ui_clipboard *clipboard)
{
    (void)panels;
    (void)clipboard; /* these fields copy nothing */
}

ui *ui_create(float scale)
{
    (void)scale; /* text is stretched */
    ui *panels = calloc(1, sizeof *panels);
    if (panels == NULL) {
        return NULL;
    }
    panels->glyphs = ui_glyph_set_create();
    if (panels->glyphs == NULL) {
        free(panels);
        return NULL;
    }
    return panels;
}

void ui_destroy(ui **panels)
{
    if (*panels != NULL) {
        ui_glyph_set_destroy(&(*panels)->glyphs);
        ui_drawing_free(&(*panels)->drawing);
        free(*panels);
        *panels = NULL;
    }
}

const uint8_t *ui_glyphs(const ui *panels, unsigned *width, unsigned *height)
{
    *width = UI_GLYPHS_WIDTH;
    *height = UI_GLYPHS_HEIGHT;
    return ui_glyph_set_coverage(panels->glyphs);
}

/* ---- places ---- */

static bool contains(ui_place place, const float point[2])
{
    return point[0] >= place.x && point[0] < place.x + place.width && point[1] >= place.y &&
           point[1] < place.y + place.height;
}

float ui_text_height(const ui *panels)
{
    return panels->now.large ? UI_TEXT_LARGE : UI_TEXT_SMALL;
}

float ui_row_height(const ui *panels)
{
    return ui_text_height(panels) + 2 * UI_INSET_Y + UI_GAP;
}

ui_place ui_text_row(ui *panels, float height)
{
    const ui_place place = {panels->left, panels->y, panels->right - panels->left, height};
    panels->y += height + UI_GAP;
    return place;
}

ui_place ui_text_labeled(ui *panels, const char *label)
{
    ui_place place = ui_text_row(panels, ui_text_height(panels) + 2 * UI_INSET_Y);
    const float share = floorf(place.width * UI_LABEL_SHARE);
    const ui_place name = {place.x, place.y, share - UI_GAP, place.height};
    ui_text_write(panels, name, 0, UI_COLOR_DIM, label);
    place.x += share;
    place.width -= share;
    return place;
}

/* ---- drawing ---- */

/* The panel's clip leaves its own edges free. */
static void begin_batch(ui *panels, uint32_t texture)
{
    const ui_place place = panels->panel->place;
    const int clip[4] = {(int)place.x + 1, (int)place.y + 1, (int)(place.x + place.width) - 1,
                         (int)(place.y + place.height) - 1};
    ui_drawing_batch(&panels->drawing, texture, clip);
}

static void fill(ui *panels, ui_place place, uint32_t color)
{
    const float corners[4] = {place.x, place.y, place.x + place.width, place.y + place.height};
    ui_drawing_rectangle(&panels->drawing, corners, opaque, color);
}

static uint32_t dimmed(const ui *panels, uint32_t color)
{
    return panels->enabled ? color : (color & 0xFFFFFFU) | (color >> 25) << 24;
}

void ui_text_fill(ui *panels, ui_place place, uint32_t color)
{
    begin_batch(panels, UI_TEXTURE_GLYPHS);
    fill(panels, place, dimmed(panels, color));
}

void ui_text_triangle(ui *panels, const float corners[6])
{
    static const uint16_t indices[3] = {0, 1, 2};
    ui_vertex vertices[3];
    for (size_t i = 0; i < 3; ++i) {
        vertices[i] = (ui_vertex){corners[2 * i], corners[2 * i + 1], opaque[0], opaque[1], UI_COLOR_DIM};
    }
    begin_batch(panels, UI_TEXTURE_GLYPHS);
    ui_drawing_triangles(&panels->drawing, ui_drawing_vertices(&panels->drawing, vertices, 3), indices, 3);
}

/* The bytes of a text that fit a width. */
static size_t fitting(const ui *panels, const char *text, float width)
{
    size_t bytes = 0;
    while (text[bytes] != '\0') {
        const size_t next = bytes + ui_glyph_bytes(text + bytes);
        if (ui_glyph_set_measure(panels->glyphs, panels->now.large, text, next) > width) {
            break;
        }
        bytes = next;
    }
    return bytes;
}

void ui_text_write(ui *panels, ui_place place, float share, uint32_t color, const char *text)
{
    const size_t bytes = fitting(panels, text, place.width);
    const float width = ui_glyph_set_measure(panels->glyphs, panels->now.large, text, bytes);
    const float at[2] = {roundf(place.x + (place.width - width) * share),
                         roundf(place.y + (place.height - ui_text_height(panels)) / 2)};
    begin_batch(panels, UI_TEXTURE_GLYPHS);
    ui_glyph_set_draw(panels->glyphs, panels->now.large, at, dimmed(panels, color), text, bytes, &panels->drawing);
}

void ui_text_back(ui *panels, ui_place place, ui_text_use use, bool chosen)
{
    ui_text_fill(panels, place,
                 use.held      ? UI_COLOR_PRESSED
                 : chosen      ? UI_COLOR_CHOSEN
                 : use.hovered ? UI_COLOR_HOVER
                               : UI_COLOR_FIELD);
}

/* ---- frames ---- */

void ui_begin(ui *panels, const ui_input *input)
{
    panels->before = panels->now;
    panels->now = *input;
    ui_drawing_clear(&panels->drawing);
    for (size_t i = 0; i < panels->panel_count; ++i) {
        panels->panels[i].seen = false;
    }
    panels->held_seen = false;
    panels->focus_seen = false;
    panels->tooltip[0] = '\0';
    if (!input->buttons[0] && !panels->before.buttons[0]) {
        panels->held = 0;
    }
}

/* The tooltip stands below the mouse, over everything, within the window. */
static void draw_tooltip(ui *panels)
{
    const float width = fminf(260, panels->now.width - 2 * UI_PADDING);
    ui_text_panel above = {.place = {panels->now.mouse[0] + 12, panels->now.mouse[1] + 18, width, panels->now.height}};
    above.place.x = fmaxf(0, fminf(above.place.x, panels->now.width - width));
    panels->panel = &above;
    panels->enabled = true;
    panels->left = above.place.x + UI_PADDING;
    panels->right = above.place.x + width - UI_PADDING;
    panels->y = above.place.y + UI_INSET_Y * 2;
    const ui_drawing before = panels->drawing;
    ui_text(panels, "%s", panels->tooltip); /* to learn its height */
    above.place.height = panels->y - above.place.y;
    const float excess = above.place.y + above.place.height - panels->now.height;
    above.place.y -= excess > 0 ? excess : 0;
    panels->y = above.place.y + UI_INSET_Y * 2;
    panels->drawing.vertex_count = before.vertex_count;
    panels->drawing.index_count = before.index_count;
    panels->drawing.batch_count = before.batch_count;
    const int clip[4] = {0, 0, (int)panels->now.width, (int)panels->now.height};
    ui_drawing_batch(&panels->drawing, UI_TEXTURE_GLYPHS, clip);
    fill(panels, above.place, UI_COLOR_PRESSED | 0xFF000000U);
    ui_text(panels, "%s", panels->tooltip);
    panels->panel = NULL;
}

const ui_drawing *ui_end(ui *panels)
{
    if (panels->tooltip[0] != '\0') {
        draw_tooltip(panels);
    }
    panels->held = panels->held_seen ? panels->held : 0;
    panels->focus = panels->focus_seen ? panels->focus : 0;
    return panels->drawing.failed ? NULL : &panels->drawing;
}

bool ui_wants_mouse(const ui *panels)
{
    bool over = panels->held != 0;
    for (size_t i = 0; i < panels->panel_count; ++i) {
        over |= panels->panels[i].seen && contains(panels->panels[i].place, panels->now.mouse);
    }
    return over;
}

bool ui_wants_keys(const ui *panels)
{
    return panels->focus != 0;
}

/* ---- panels ---- */

/* FNV-1a. */
static uint32_t hash(uint32_t seed, const char *text)
{
    for (; *text != '\0'; ++text) {
        seed = (seed ^ (unsigned char)*text) * 16777619U;
    }
    return seed;
}

uint32_t ui_text_id(const ui *panels, const char *label)
{
    uint32_t id = hash(panels->panel->id, label);
    for (size_t i = 0; i < panels->depth; ++i) {
        id = (id ^ panels->salts[i]) * 16777619U;
    }
    return id != 0 ? id : 1;
}

static ui_text_panel *find_panel(ui *panels, uint32_t id)
{
    for (size_t i = 0; i < panels->panel_count; ++i) {
        if (panels->panels[i].id == id) {
            return &panels->panels[i];
        }
    }
    /* When there are too many, the last one loses its scroll. */
    panels->panel_count += panels->panel_count < UI_TEXT_PANELS_MAX ? 1 : 0;
    ui_text_panel *added = &panels->panels[panels->panel_count - 1];
    *added = (ui_text_panel){.id = id};
    return added;
}

/* Scrolls by the wheel, as far as there is something to see. */
static void scroll(const ui *panels, ui_text_panel *panel)
{
    const float most = fmaxf(0, panel->content_height - panel->place.height);
    if (contains(panel->place, panels->now.mouse)) {
        panel->scroll -= panels->now.wheel * 3 * ui_row_height(panels);
    }
    panel->scroll = roundf(fminf(fmaxf(panel->scroll, 0), most));
}

static void draw_scroll(ui *panels, const ui_text_panel *panel)
{
    if (panel->content_height <= panel->place.height) {
        return;
    }
    const float part = panel->place.height / panel->content_height;
    const ui_place bar = {panel->place.x + panel->place.width - UI_SCROLL_WIDTH + 2,
                          panel->place.y + panel->scroll * part, UI_SCROLL_WIDTH - 4, panel->place.height * part};
    ui_text_fill(panels, bar, UI_COLOR_PRESSED);
}

void ui_panel_begin(ui *panels, const char *name, ui_place place)
{
    ui_text_panel *panel = find_panel(panels, hash(2166136261U, name));
    panel->place = place;
    panel->seen = true;
    scroll(panels, panel);
    panels->panel = panel;
    panels->enabled = true;
    panels->depth = 0;
    const int clip[4] = {(int)place.x, (int)place.y, (int)(place.x + place.width), (int)(place.y + place.height)};
    ui_drawing_batch(&panels->drawing, UI_TEXTURE_GLYPHS, clip);
    panel->background = panels->drawing.vertex_count;
    fill(panels, place, UI_COLOR_PANEL);
    draw_scroll(panels, panel);
    panels->left = place.x + UI_PADDING;
    panels->right = place.x + place.width - UI_PADDING;
    panels->y = place.y + UI_PADDING - panel->scroll;
}

/* Now the height is known that the background takes. */
float ui_panel_end(ui *panels)
{
    ui_text_panel *panel = panels->panel;
    panel->content_height = panels->y + panel->scroll - panel->place.y - UI_GAP + UI_PADDING;
    panel->place.height = fminf(panel->content_height, panel->place.height);
    if (panels->drawing.vertex_count >= panel->background + 4) {
        const float bottom = panel->place.y + panel->place.height;
        panels->drawing.vertices[panel->background + 2].y = bottom;
        panels->drawing.vertices[panel->background + 3].y = bottom;
    }
    return panel->place.height;
}

void ui_push(ui *panels, int number)
{
    if (panels->depth < UI_TEXT_DEPTH_MAX) {
        panels->salts[panels->depth++] = (uint32_t)number + 1;
    }
}

void ui_pop(ui *panels)
{
    panels->depth -= panels->depth > 0 ? 1 : 0;
}

void ui_enable(ui *panels, bool enabled)
{
    panels->enabled = enabled;
}

ui_text_use ui_text_widget(ui *panels, uint32_t id, ui_place place)
{
    const bool down = panels->now.buttons[0];
    const bool began = down && !panels->before.buttons[0];
    const bool inside =
        contains(place, panels->now.mouse) && contains(panels->panel->place, panels->now.mouse) && panels->enabled;
    panels->item = place;
    if (inside && began && panels->held == 0) {
        panels->held = id;
        panels->focus = 0;
    }
    const bool mine = panels->held == id;
    panels->held_seen |= mine;
    return (ui_text_use){.hovered = inside && (panels->held == 0 || mine),
                         .held = mine && down,
                         .began = mine && began,
                         .clicked = mine && !down && inside};
}

void ui_tooltip(ui *panels, const char *text)
{
    if (contains(panels->item, panels->now.mouse) && contains(panels->panel->place, panels->now.mouse) &&
        panels->held == 0) {
        (void)snprintf(panels->tooltip, sizeof panels->tooltip, "%s", text);
    }
}

/* ---- text ---- */

void ui_gap(ui *panels)
{
    panels->y += UI_GAP;
}

void ui_heading(ui *panels, const char *text)
{
    const ui_place place = ui_text_row(panels, ui_text_height(panels) + 2 * UI_INSET_Y);
    ui_text_write(panels, place, 0, UI_COLOR_ACCENT, text);
    ui_text_fill(panels, (ui_place){place.x, place.y + place.height, place.width, 1}, UI_COLOR_EDGE);
}

/* The bytes of the first line of a text that is broken between words where it can be. */
static size_t first_line(const ui *panels, const char *text, float width)
{
    const size_t most = fitting(panels, text, width);
    if (text[most] == '\0' || most == 0) {
        return most;
    }
    size_t bytes = most;
    while (bytes > 0 && text[bytes] != ' ') {
        --bytes;
    }
    return bytes > 0 ? bytes : most;
}

static void write_wrapped(ui *panels, uint32_t color, const char *text)
{
    char line[UI_TEXT_LINE_BYTES];
    do {
        const ui_place place = ui_text_row(panels, ui_text_height(panels));
        size_t bytes = first_line(panels, text, place.width);
        (void)snprintf(line, sizeof line, "%.*s", (int)bytes, text);
        ui_text_write(panels, place, 0, color, line);
        panels->item = place;
        bytes += bytes == 0 && text[0] != '\0' ? ui_glyph_bytes(text) : 0;
        text += bytes;
        text += *text == ' ' ? 1 : 0;
    } while (*text != '\0');
}

static __attribute__((format(printf, 3, 0))) void write_lines(ui *panels, uint32_t color, const char *format,
                                                              va_list arguments)
{
    char text[UI_TEXT_LINE_BYTES];
    (void)vsnprintf(text, sizeof text, format, arguments);
    write_wrapped(panels, color, text);
}

void ui_text(ui *panels, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    write_lines(panels, UI_COLOR_TEXT, format, arguments);
    va_end(arguments);
}

void ui_note(ui *panels, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    write_lines(panels, UI_COLOR_DIM, format, arguments);
    va_end(arguments);
}

void ui_value(ui *panels, const char *label, const char *format, ...)
{
    char text[UI_TEXT_LINE_BYTES];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const ui_place place = ui_text_labeled(panels, label);
    ui_text_write(panels, place, 0, UI_COLOR_TEXT, text);
    panels->item = (ui_place){panels->left, place.y, panels->right - panels->left, place.height};
}

/* ---- free drawing ---- */

bool ui_canvas(ui *panels, const char *name, float height, ui_place *place, float mouse[2])
{
    *place = ui_text_row(panels, height);
    const ui_text_use use = ui_text_widget(panels, ui_text_id(panels, name), *place);
    if (mouse != NULL) {
        const bool known = use.hovered || use.held;
        const float x = (panels->now.mouse[0] - place->x) / place->width;
        const float y = (panels->now.mouse[1] - place->y) / place->height;
        mouse[0] = known ? fminf(fmaxf(x, 0), 1) : -1;
        mouse[1] = known ? fminf(fmaxf(y, 0), 1) : -1;
    }
    return use.held;
}

void ui_fill(ui *panels, ui_place place, uint32_t color)
{
    ui_text_fill(panels, place, color);
}

void ui_line(ui *panels, const float from[2], const float to[2], uint32_t color)
{
    static const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    const float x = to[0] - from[0];
    const float y = to[1] - from[1];
    const float length = hypotf(x, y);
    if (length == 0) {
        return;
    }
    const float across[2] = {0.6F * y / length, -0.6F * x / length};
    ui_vertex corners[4];
    for (int i = 0; i < 4; ++i) {
        const float *end = i == 0 || i == 3 ? from : to;
        const float side = i < 2 ? 1 : -1;
        corners[i] = (ui_vertex){end[0] + side * across[0], end[1] + side * across[1], opaque[0], opaque[1],
                                 dimmed(panels, color)};
    }
    begin_batch(panels, UI_TEXTURE_GLYPHS);
    ui_drawing_triangles(&panels->drawing, ui_drawing_vertices(&panels->drawing, corners, 4), indices, 6);
}

void ui_fill_text(ui *panels, float x, float y, uint32_t color, const char *text)
{
    const float at[2] = {roundf(x), roundf(y)};
    begin_batch(panels, UI_TEXTURE_GLYPHS);
    ui_glyph_set_draw(panels->glyphs, panels->now.large, at, dimmed(panels, color), text, strlen(text),
                      &panels->drawing);
}

void ui_fill_image(ui *panels, ui_place place, uint32_t texture, const float part[4])
{
    const float corners[4] = {place.x, place.y, place.x + place.width, place.y + place.height};
    begin_batch(panels, texture);
    ui_drawing_rectangle(&panels->drawing, corners, part, UI_RGBA(255, 255, 255, 255));
}

float ui_text_width(const ui *panels, const char *text)
{
    return ui_glyph_set_measure(panels->glyphs, panels->now.large, text, strlen(text));
}
