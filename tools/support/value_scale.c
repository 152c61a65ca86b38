/* SPDX-License-Identifier: MIT */
/*
 * Finds the range, colors the numbers and draws the bar. The text is that of stb_easy_font, whose letters are
 * rectangles of pixels.
 */
#include "support/value_scale.h"

#include <math.h>
#include <stb/stb_easy_font.h>
#include <stdio.h>
#include <string.h>

#include "support/view_colors.h"

/* Of the bar, in pixels of text of size 1. */
#define BAR_WIDTH   120
#define BAR_HEIGHT  8
#define TEXT_HEIGHT 10
#define MARGIN      4

#define TEXT_BYTES 48
/* Of rectangles of a text: 64 bytes for each, at most 12 for a letter. */
#define QUADS_BYTES ((size_t)TEXT_BYTES * 12 * 64)

bool value_scale_suits(svo_render_view view)
{
    return view == SVO_VIEW_DEPTH || view == SVO_VIEW_STEPS;
}

/* ---- the range ---- */

/* Of the pixels that show something. Steps are counted from 0. */
static value_scale find_range(const svo_render_options *asked, const float *numbers)
{
    const bool is_depth = asked->view == SVO_VIEW_DEPTH;
    value_scale found = {.low = HUGE_VAL, .high = -HUGE_VAL, .unit = is_depth ? "world units" : "steps"};
    for (size_t i = 0; i < (size_t)asked->width * asked->height; ++i) {
        if (numbers[4 * i + 3] > 0) {
            found.low = fmin(found.low, (double)numbers[4 * i]);
            found.high = fmax(found.high, (double)numbers[4 * i]);
        }
    }
    found.is_shown = found.low <= found.high;
    found.low = is_depth ? found.low : 0;
    return found;
}

/* ---- colors ---- */

static uint8_t byte_of(float share)
{
    return (uint8_t)(fminf(fmaxf(share, 0.0F), 1.0F) * 255.0F + 0.5F);
}

/* Near is bright, but no distance is as white as the background. */
static void color_value(svo_render_view view, float value, uint8_t rgb[3])
{
    float steps[3];
    view_colors_steps(value, steps);
    for (int channel = 0; channel < 3; ++channel) {
        rgb[channel] = byte_of(view == SVO_VIEW_STEPS ? steps[channel] : 0.93F - 0.85F * value);
    }
}

/* What is behind a pixel that shows only a share of itself. */
static void put_behind(const svo_picture_output *output, float share, uint8_t rgba[4])
{
    const bool has_color = output->background == SVO_BACKGROUND_COLOR;
    for (int channel = 0; channel < 3 && output->background != SVO_BACKGROUND_TRANSPARENT; ++channel) {
        const float behind = has_color ? output->background_color[channel] : 1.0F;
        rgba[channel] = byte_of(share * (float)rgba[channel] / 255.0F + (1.0F - share) * behind);
    }
    rgba[3] = output->background == SVO_BACKGROUND_TRANSPARENT ? byte_of(share) : 255;
}

static void color_all(const svo_render_options *asked, const svo_picture_output *output, const float *numbers,
                      const value_scale *scale, uint8_t *rgba)
{
    const double width = scale->high > scale->low ? scale->high - scale->low : 1;
    for (size_t i = 0; i < (size_t)asked->width * asked->height; ++i) {
        const double value = ((double)numbers[4 * i] - scale->low) / width;
        color_value(asked->view, (float)fmin(fmax(value, 0), 1), rgba + 4 * i);
        put_behind(output, numbers[4 * i + 3], rgba + 4 * i);
    }
}

/* ---- the bar ---- */

/* A picture that is drawn into, and how many pixels one of a text is. */
typedef struct canvas {
    uint8_t *rgba;
    int width, height, size;
} canvas;

static void fill(const canvas *to, int x, int y, int width, int height, const uint8_t rgb[3])
{
    for (int row = y; row < y + height; ++row) {
        for (int column = x; column < x + width; ++column) {
            if (row >= 0 && row < to->height && column >= 0 && column < to->width) {
                uint8_t *pixel = to->rgba + 4 * ((size_t)row * (size_t)to->width + (size_t)column);
                memcpy(pixel, rgb, 3);
                pixel[3] = 255;
            }
        }
    }
}

/* stb_easy_font takes texts that are not const, and leaves them as they are. */
static void write_text(const canvas *to, int x, int y, char *text)
{
    static const uint8_t ink[3] = {20, 20, 20};
    static _Thread_local float quads[QUADS_BYTES / sizeof(float)]; /* x, y, z, color of four corners each */
    const int count = stb_easy_font_print(0, 0, text, NULL, quads, (int)sizeof quads);
    for (int i = 0; i < count; ++i) {
        const float *first = quads + (size_t)i * 16;
        const float *last = first + 8;
        fill(to, x + (int)first[0] * to->size, y + (int)first[1] * to->size, (int)(last[0] - first[0]) * to->size,
             (int)(last[1] - first[1]) * to->size, ink);
    }
}

static void draw_bar(const svo_render_options *asked, const value_scale *scale, canvas to)
{
    static const uint8_t paper[3] = {255, 255, 255};
    char title[TEXT_BYTES];
    char low[TEXT_BYTES];
    char high[TEXT_BYTES];
    to.size = to.height / 480 > 1 ? to.height / 480 : 1;
    const int width = BAR_WIDTH * to.size;
    const int height = (BAR_HEIGHT + 2 * TEXT_HEIGHT) * to.size;
    const int margin = MARGIN * to.size;
    if (to.width < 2 * (width + 4 * margin) || to.height < 3 * (height + 4 * margin)) {
        return;
    }
    const int x = 2 * margin;
    const int y = to.height - height - 2 * margin;
    fill(&to, x - margin, y - margin, width + 2 * margin, height + 2 * margin, paper);
    snprintf(title, sizeof title, "%s, %s", asked->view == SVO_VIEW_STEPS ? "nodes visited" : "distance", scale->unit);
    snprintf(low, sizeof low, "%.4g", scale->low);
    snprintf(high, sizeof high, "%.4g", scale->high);
    write_text(&to, x, y, title);
    for (int column = 0; column < width; ++column) {
        uint8_t rgb[3];
        color_value(asked->view, (float)column / (float)(width - 1), rgb);
        fill(&to, x + column, y + TEXT_HEIGHT * to.size, 1, BAR_HEIGHT * to.size, rgb);
    }
    const int labels = y + (TEXT_HEIGHT + BAR_HEIGHT + 2) * to.size;
    write_text(&to, x, labels, low);
    write_text(&to, x + width - stb_easy_font_width(high) * to.size, labels, high);
}

/* ---- the picture ---- */

void value_scale_color(const svo_render_options *asked, const svo_picture_output *output, const float *numbers,
                       uint8_t *rgba, value_scale *scale)
{
    if (!scale->is_shown) {
        *scale = find_range(asked, numbers);
    }
    color_all(asked, output, numbers, scale, rgba);
    if (scale->is_shown) {
        draw_bar(asked, scale, (canvas){.rgba = rgba, .width = (int)asked->width, .height = (int)asked->height});
    }
}

void value_scale_report(cJSON *document, const value_scale *scale)
{
    if (scale->is_shown) {
        const double range[2] = {scale->low, scale->high};
        cJSON_AddItemToObject(document, "range", cJSON_CreateDoubleArray(range, 2));
        json_add_text(document, "range_unit", scale->unit);
    }
}
