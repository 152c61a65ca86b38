/* SPDX-License-Identifier: MIT */
/* The plain toolkit's widgets. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view/ui_text.h"
#include "view/ui_theme.h"

/* ---- buttons and lists ---- */

static bool button(ui *panels, const char *name, ui_place place, bool chosen)
{
    const ui_text_use use = ui_text_widget(panels, ui_text_id(panels, name), place);
    ui_text_back(panels, place, use, chosen);
    ui_text_write(panels, place, 0.5F, UI_COLOR_TEXT, name);
    return use.clicked;
}

int ui_buttons(ui *panels, const char *const *names, int count)
{
    const ui_place row = ui_text_row(panels, ui_text_height(panels) + 2 * UI_INSET_Y);
    const float step = (row.width + UI_GAP) / (float)count;
    int pressed = -1;
    for (int i = 0; i < count; ++i) {
        const float begin = roundf(row.x + step * (float)i);
        const float end = roundf(row.x + step * (float)(i + 1));
        const ui_place place = {begin, row.y, end - begin - UI_GAP, row.height};
        if (button(panels, names[i], place, false)) {
            pressed = i;
        }
    }
    panels->item = row;
    return pressed;
}

bool ui_tabs(ui *panels, const char *const *names, int count, int *chosen)
{
    ui_place row = ui_text_row(panels, ui_text_height(panels) + 2 * UI_INSET_Y);
    const int before = *chosen;
    float x = row.x;
    for (int i = 0; i < count; ++i) {
        const float width = ui_text_width(panels, names[i]) + 2 * UI_INSET_X;
        if (x > row.x && x + width > row.x + row.width) {
            panels->y -= UI_GAP / 2;
            row = ui_text_row(panels, row.height);
            x = row.x;
        }
        if (button(panels, names[i], (ui_place){x, row.y, width, row.height}, i == before)) {
            *chosen = i;
        }
        x += width + UI_GAP / 2;
    }
    return *chosen != before;
}

bool ui_item(ui *panels, const char *text, bool chosen)
{
    ui_place row = ui_text_row(panels, ui_text_height(panels) + 2 * UI_INSET_Y);
    const ui_text_use use = ui_text_widget(panels, ui_text_id(panels, text), row);
    if (chosen || use.hovered) {
        ui_text_back(panels, row, use, chosen);
    }
    row.x += UI_INSET_X;
    row.width -= 2 * UI_INSET_X;
    ui_text_write(panels, row, 0, UI_COLOR_TEXT, text);
    return use.clicked;
}

/* A triangle that points down where the section is open, else to the right. */
static void draw_arrow(ui *panels, ui_place row, bool is_open)
{
    const float x = row.x + UI_INSET_X;
    const float y = row.y + row.height / 2;
    const float r = 4;
    if (is_open) {
        ui_text_triangle(panels, (const float[6]){x, y - r / 2, x + 2 * r, y - r / 2, x + r, y + r / 2 + 1});
    } else {
        ui_text_triangle(panels, (const float[6]){x + r / 2, y - r, x + 3 * r / 2 + 1, y, x + r / 2, y + r});
    }
}

bool ui_section(ui *panels, const char *title, bool *is_open)
{
    ui_place row = ui_text_row(panels, ui_text_height(panels) + 2 * UI_INSET_Y);
    const ui_text_use use = ui_text_widget(panels, ui_text_id(panels, title), row);
    *is_open ^= use.clicked;
    ui_text_back(panels, row, use, false);
    draw_arrow(panels, row, *is_open);
    row.x += UI_INSET_X + 14;
    row.width -= 2 * UI_INSET_X + 14;
    ui_text_write(panels, row, 0, UI_COLOR_TEXT, title);
    return use.clicked;
}

/* ---- values ---- */

bool ui_checkbox(ui *panels, const char *label, bool *value)
{
    const ui_place row = ui_text_row(panels, ui_text_height(panels) + 2 * UI_INSET_Y);
    const ui_text_use use = ui_text_widget(panels, ui_text_id(panels, label), row);
    const ui_place box = {row.x, row.y, row.height, row.height};
    ui_text_back(panels, box, use, false);
    if (use.clicked) {
        *value = !*value;
    }
    if (*value) {
        ui_text_fill(panels, (ui_place){box.x + 4, box.y + 4, box.width - 8, box.height - 8}, UI_COLOR_ACCENT);
    }
    const ui_place text = {row.x + box.width + UI_INSET_X, row.y, row.width - box.width - UI_INSET_X, row.height};
    ui_text_write(panels, text, 0, UI_COLOR_TEXT, label);
    return use.clicked;
}

/* A click on the left third goes to the name before, elsewhere to the next one. */
bool ui_choice(ui *panels, const char *label, const char *const *names, int count, int *chosen)
{
    const ui_place place = ui_text_labeled(panels, label);
    const ui_text_use use = ui_text_widget(panels, ui_text_id(panels, label), place);
    ui_text_back(panels, place, use, false);
    if (use.clicked) {
        const bool back = panels->now.mouse[0] < place.x + place.width / 3;
        *chosen = (*chosen + (back ? count - 1 : 1)) % count;
    }
    const ui_place inner = {place.x + UI_INSET_X, place.y, place.width - 2 * UI_INSET_X, place.height};
    ui_text_write(panels, inner, 0, UI_COLOR_DIM, "<");
    ui_text_write(panels, inner, 1, UI_COLOR_DIM, ">");
    ui_text_write(panels, inner, 0.5F, UI_COLOR_TEXT, *chosen >= 0 && *chosen < count ? names[*chosen] : "");
    return use.clicked;
}

static void write_number(ui *panels, ui_place place, const char *format, double value)
{
    char text[64];
    (void)snprintf(text, sizeof text, format, value);
    ui_text_write(panels, place, 0.5F, UI_COLOR_TEXT, text);
}

bool ui_slider(ui *panels, const char *label, float *value, float low, float high, const char *format)
{
    const ui_place place = ui_text_labeled(panels, label);
    const ui_text_use use = ui_text_widget(panels, ui_text_id(panels, label), place);
    const float before = *value;
    if (use.held) {
        const float at = (panels->now.mouse[0] - place.x) / place.width;
        *value = low + (high - low) * fminf(fmaxf(at, 0), 1);
    }
    ui_text_back(panels, place, use, false);
    const float share = high > low ? fminf(fmaxf((*value - low) / (high - low), 0), 1) : 0;
    ui_text_fill(panels, (ui_place){place.x, place.y, roundf(place.width * share), place.height}, UI_COLOR_CHOSEN);
    write_number(panels, place, format, (double)*value);
    return *value != before;
}

bool ui_slider_count(ui *panels, const char *label, int *value, int low, int high)
{
    float number = (float)*value;
    const int before = *value;
    if (ui_slider(panels, label, &number, (float)low, (float)high, "%.0f")) {
        *value = (int)roundf(number);
    }
    return *value != before;
}

/* One number that dragging changes. */
static bool drag(ui *panels, uint32_t id, ui_place place, float step, float *value)
{
    const ui_text_use use = ui_text_widget(panels, id, place);
    const float moved = panels->now.mouse[0] - panels->before.mouse[0];
    ui_text_back(panels, place, use, false);
    if (!use.held || use.began || moved == 0) {
        return false;
    }
    *value += moved * step;
    return true;
}

bool ui_numbers(ui *panels, const char *label, float *values, int count, float step, const char *format)
{
    const ui_place row = ui_text_labeled(panels, label);
    const float width = (row.width + UI_GAP) / (float)count;
    bool changed = false;
    for (int i = 0; i < count; ++i) {
        const float begin = roundf(row.x + width * (float)i);
        const ui_place place = {begin, row.y, roundf(row.x + width * (float)(i + 1)) - begin - UI_GAP, row.height};
        changed |= drag(panels, ui_text_id(panels, label) + (uint32_t)i, place, step, &values[i]);
        write_number(panels, place, format, (double)values[i]);
    }
    panels->item = row;
    return changed;
}

static float display_coded(float linear)
{
    const float value = fminf(fmaxf(linear, 0), 1);
    return value <= 0.0031308F ? value * 12.92F : 1.055F * powf(value, 1 / 2.4F) - 0.055F;
}

bool ui_color(ui *panels, const char *label, float rgb[3])
{
    const bool changed = ui_numbers(panels, label, rgb, 3, 0.01F, "%.2f");
    for (int i = 0; i < 3; ++i) {
        rgb[i] = fmaxf(rgb[i], 0);
    }
    const ui_place row = panels->item;
    const uint32_t shown =
        UI_RGBA((uint32_t)(255 * display_coded(rgb[0]) + 0.5F), (uint32_t)(255 * display_coded(rgb[1]) + 0.5F),
                (uint32_t)(255 * display_coded(rgb[2]) + 0.5F), 255);
    ui_text_fill(panels, (ui_place){row.x, row.y + row.height, row.width, 2}, shown);
    return changed;
}

/* ---- fields of text ---- */

static bool pressed(const ui *panels, ui_key key)
{
    return panels->now.keys[key] && !panels->before.keys[key];
}

/* The text before its last character. */
static void erase_last(char *text)
{
    size_t length = strlen(text);
    while (length > 0 && ((unsigned char)text[--length] & 0xC0U) == 0x80) {
    }
    text[length] = '\0';
}

/* Takes what was typed; returns whether Enter ended it. */
static bool edit(ui *panels, char *text, size_t text_bytes)
{
    const size_t length = strlen(text);
    if (length + strlen(panels->now.typed) < text_bytes) {
        memcpy(text + length, panels->now.typed, strlen(panels->now.typed) + 1);
    }
    if (pressed(panels, UI_KEY_BACKSPACE)) {
        erase_last(text);
    }
    const bool entered = pressed(panels, UI_KEY_ENTER);
    if (entered || pressed(panels, UI_KEY_ESCAPE)) {
        panels->focus = 0;
    }
    return entered;
}

void ui_focus(ui *panels)
{
    panels->focus_next = true;
}

bool ui_field(ui *panels, const char *label, char *text, size_t text_bytes)
{
    const ui_place place = ui_text_labeled(panels, label);
    const uint32_t id = ui_text_id(panels, label);
    const ui_text_use use = ui_text_widget(panels, id, place);
    bool entered = false;
    if (use.began || panels->focus_next) {
        panels->focus = id;
        panels->focus_next = false;
    }
    if (panels->focus == id) {
        panels->focus_seen = true;
        entered = edit(panels, text, text_bytes);
    }
    ui_text_back(panels, place, use, panels->focus == id);
    ui_place inner = {place.x + UI_INSET_X, place.y, place.width - 2 * UI_INSET_X, place.height};
    const char *end = text; /* the end of a long text is shown */
    while (ui_text_width(panels, end) > inner.width) {
        end += ui_glyph_bytes(end);
    }
    ui_text_write(panels, inner, 0, UI_COLOR_TEXT, end);
    if (panels->focus == id) {
        const float cursor = inner.x + ui_text_width(panels, end);
        ui_text_fill(panels, (ui_place){cursor, inner.y + 2, 1, inner.height - 4}, UI_COLOR_ACCENT);
    }
    return entered;
}
