/* SPDX-License-Identifier: MIT */
/*
 * Finds the range by pictures of wider ones, colors the numbers and draws the bar. The text is that of stb_easy_font,
 * whose letters are rectangles of pixels.
 */
#include "support/value_scale.h"

#include <math.h>
#include <stb/stb_easy_font.h>
#include <stdio.h>
#include <string.h>

/* More steps are shown as so many. */
#define STEPS_MAX 4080.0F
/* Each picture but the last one makes the range at most so many times as wide as what is in view is. */
#define NARROWING_PASSES 2

/* Of the bar, in pixels of text of size 1. */
#define BAR_WIDTH   120
#define BAR_HEIGHT  8
#define TEXT_HEIGHT 10
#define MARGIN      4

#define TEXT_BYTES 48
/* Of rectangles of a text: 64 bytes for each, at most 12 for a letter. */
#define QUADS_BYTES (TEXT_BYTES * 12 * 64)

bool value_scale_suits(svo_render_view view)
{
    return view == SVO_VIEW_DEPTH || view == SVO_VIEW_STEPS;
}

/* ---- the range ---- */

/* Widths of a leaf from the eye to beyond the grid. */
static float farthest(const svo_tree_info *info, const svo_camera *camera, double leaf_edge)
{
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double away = info->origin[axis] + 0.5 * info->edge - (double)camera->eye[axis];
        square += away * away;
    }
    return (float)((sqrt(square) + 0.9 * info->edge) / leaf_edge);
}

/* Narrows the range to the values of a picture; false if it has none. Steps are counted from 0. */
static bool narrow(svo_render_options *asked, const uint8_t *rgba)
{
    int least = 255;
    int most = -1;
    for (size_t i = 0; i < (size_t)asked->width * asked->height; ++i) {
        const int value = rgba[4 * i];
        if (rgba[4 * i + 3] != 0) {
            least = value < least ? value : least;
            most = value > most ? value : most;
        }
    }
    if (most < 0) {
        return false;
    }
    const float low = asked->range_low;
    const float step = (asked->range_high - low) / 255.0F;
    asked->range_high = low + ((float)most + 0.5F) * step;
    if (asked->view == SVO_VIEW_DEPTH) {
        asked->range_low = low + fmaxf((float)least - 0.5F, 0.0F) * step;
    }
    return true;
}

/* ---- colors ---- */

static uint8_t byte_of(float share)
{
    return (uint8_t)(fminf(fmaxf(share, 0.0F), 1.0F) * 255.0F + 0.5F);
}

/* Near is bright; steps go from dark blue over green and yellow to red, as kernels/rays/view.cl colors them. */
static void color_value(svo_render_view view, float value, uint8_t rgb[3])
{
    static const float peaks[3] = {0.90F, 0.55F, 0.15F};
    static const float widths[3] = {0.55F, 0.45F, 0.35F};
    static const float least[3] = {0.05F, 0.03F, 0.20F};
    for (int channel = 0; channel < 3; ++channel) {
        const float away = (value - peaks[channel]) / widths[channel];
        rgb[channel] =
            byte_of(view == SVO_VIEW_STEPS ? fmaxf(1.0F - away * away, least[channel]) : 0.93F - 0.85F * value);
    }
}

static void color_all(const svo_render_options *asked, uint8_t *rgba)
{
    for (size_t i = 0; i < (size_t)asked->width * asked->height; ++i) {
        if (rgba[4 * i + 3] != 0) {
            color_value(asked->view, (float)rgba[4 * i] / 255.0F, rgba + 4 * i);
        }
        rgba[4 * i + 3] = 255;
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
                memcpy(to->rgba + 4 * ((size_t)row * (size_t)to->width + (size_t)column), rgb, 3);
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

static void draw_bar(const svo_render_options *asked, const value_scale *scale, uint8_t *rgba)
{
    static const uint8_t paper[3] = {255, 255, 255};
    char title[TEXT_BYTES];
    char low[TEXT_BYTES];
    char high[TEXT_BYTES];
    canvas to = {.rgba = rgba, .width = (int)asked->width, .height = (int)asked->height};
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

svo_status value_scale_render(svo_device *device, svo_tree *tree, const svo_render_options *asked,
                              cl_command_queue queue, uint8_t *rgba, value_scale *out)
{
    svo_render_options drawn = *asked;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(tree, &info);
    const bool is_depth = drawn.view == SVO_VIEW_DEPTH;
    const double leaf_edge = info.edge / (double)(1u << info.depth);
    drawn.range_high = is_depth ? farthest(&info, &drawn.camera, leaf_edge) : STEPS_MAX;
    *out = (value_scale){.is_shown = true, .unit = is_depth ? "world units" : "steps"};
    for (int pass = 0; pass <= NARROWING_PASSES; ++pass) {
        const svo_status status = svo_tree_render(device, tree, &drawn, queue, rgba);
        if (status != SVO_OK) {
            return status;
        }
        out->is_shown = out->is_shown && (pass == NARROWING_PASSES || narrow(&drawn, rgba));
    }
    out->low = (double)drawn.range_low * (is_depth ? leaf_edge : 1);
    out->high = is_depth ? (double)drawn.range_high * leaf_edge : floor((double)drawn.range_high);
    color_all(&drawn, rgba);
    if (out->is_shown) {
        draw_bar(&drawn, out, rgba);
    }
    return SVO_OK;
}

void value_scale_report(cJSON *document, const value_scale *scale)
{
    if (scale->is_shown) {
        const double range[2] = {scale->low, scale->high};
        cJSON_AddItemToObject(document, "range", cJSON_CreateDoubleArray(range, 2));
        json_add_text(document, "range_unit", scale->unit);
    }
}
