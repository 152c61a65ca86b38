/* SPDX-License-Identifier: MIT */
/* What helps to read the picture: the axes of the world, and what the colors of a view of numbers mean. */
#include <math.h>
#include <stdio.h>

#include "view/camera.h"
#include "view/panels_pages.h"
#include "view/ui.h"

#define AXES_EDGE    76.0F
#define LEGEND_WIDTH 300.0F
#define LEGEND_LEAST 110.0F
#define BAR_HEIGHT   12.0F
#define BAR_STRIPS   96
#define GAP          6.0F

/* ---- axes ---- */

/* An axis as the camera sees it: on the picture, and away from the eye. */
typedef struct seen_axis {
    float end[2];
    float away;
    int axis; /* -1: drawn */
} seen_axis;

static void see_axes(const view_state *state, seen_axis axes[3])
{
    float right[3];
    float above[3];
    float sight[3];
    camera_axes(state, right, above, sight);
    for (int axis = 0; axis < 3; ++axis) {
        axes[axis] = (seen_axis){{right[axis], -above[axis]}, sight[axis], axis};
    }
}

static void describe_axes(ui *toolkit, view_state *state, ui_place place)
{
    static const uint32_t colors[3] = {UI_COLOR_AXIS_X, UI_COLOR_AXIS_Y, UI_COLOR_AXIS_Z};
    static const char *const names[3] = {"x", "y", "z"};
    seen_axis axes[3];
    ui_place canvas;
    see_axes(state, axes);
    ui_panel_begin(toolkit, "#axes", place);
    (void)ui_canvas(toolkit, "#axes", AXES_EDGE - 2 * UI_PADDING, &canvas, NULL);
    const float middle[2] = {canvas.x + 0.5F * canvas.width, canvas.y + 0.5F * canvas.height};
    const float reach = 0.36F * fminf(canvas.width, canvas.height);
    for (int drawn = 0; drawn < 3; ++drawn) { /* far ones first */
        int next = -1;
        for (int i = 0; i < 3; ++i) {
            next = axes[i].axis >= 0 && (next < 0 || axes[i].away > axes[next].away) ? i : next;
        }
        const seen_axis *axis = &axes[next];
        const float end[2] = {middle[0] + reach * axis->end[0], middle[1] + reach * axis->end[1]};
        for (int thick = 0; thick < 2; ++thick) {
            const float shift = 0.6F * (float)thick;
            ui_line(toolkit, (const float[2]){middle[0] + shift, middle[1] + shift},
                    (const float[2]){end[0] + shift, end[1] + shift}, colors[next]);
        }
        const float beside[2] = {middle[0] + 1.28F * reach * axis->end[0], middle[1] + 1.28F * reach * axis->end[1]};
        ui_fill_text(toolkit, beside[0] - 0.5F * ui_text_width(toolkit, names[next]),
                     beside[1] - 0.35F * ui_row_height(toolkit), colors[next], names[next]);
        axes[next].axis = -1;
    }
    if (state->ground_spacing > 0) {
        ui_note(toolkit, "grid %g", (double)state->ground_spacing);
    }
    (void)ui_panel_end(toolkit);
}

/* ---- legends ---- */

static float clamped(float value)
{
    return value < 0 ? 0 : value > 1 ? 1 : value;
}

static uint32_t pack(const float rgb[3])
{
    return UI_RGBA((uint32_t)(clamped(rgb[0]) * 255 + 0.5F), (uint32_t)(clamped(rgb[1]) * 255 + 0.5F),
                   (uint32_t)(clamped(rgb[2]) * 255 + 0.5F), 255);
}

/* The colors of kernels/rays/view.cl and kernels/light/picture.cl at a share of the bar. */
static uint32_t color_at(view_picture picture, float share)
{
    static const float peaks[3] = {0.90F, 0.55F, 0.15F};
    static const float widths[3] = {0.55F, 0.45F, 0.35F};
    static const float least[3] = {0.05F, 0.03F, 0.20F};
    float rgb[3];
    for (int i = 0; i < 3; ++i) {
        const float away = (share - peaks[i]) / widths[i];
        const float coded = share <= 0.0031308F ? 12.92F * share : 1.055F * powf(share, 1 / 2.4F) - 0.055F;
        rgb[i] = picture == VIEW_STEPS   ? fmaxf(1 - away * away, least[i])
                 : picture == VIEW_DEPTH ? 1 - 0.9F * share
                                         : coded;
    }
    return pack(rgb);
}

/* The color of a level, on the faces that have it in full. */
static uint32_t color_of_level(unsigned level)
{
    uint32_t mixed = (level * 7 + 1) * 2654435769u;
    mixed = (mixed ^ mixed >> 15) * 2246822519u;
    mixed ^= mixed >> 13;
    float rgb[3];
    for (unsigned i = 0; i < 3; ++i) {
        rgb[i] = 0.25F + (float)(mixed >> 8 * i & 255u) * (0.75F / 255);
    }
    return pack(rgb);
}

/* A number at a share of a row of text, inside of it. */
static void write_at(ui *toolkit, ui_place row, float share, const char *text)
{
    const float width = ui_text_width(toolkit, text);
    const float x = fminf(fmaxf(row.x + share * row.width - 0.5F * width, row.x), row.x + row.width - width);
    ui_fill_text(toolkit, x, row.y, UI_COLOR_TEXT, text);
}

static void describe_bar(ui *toolkit, const view_state *state, float low, float high, const char *format)
{
    ui_place bar;
    ui_place row;
    char text[32];
    (void)ui_canvas(toolkit, "#bar", BAR_HEIGHT, &bar, NULL);
    for (int i = 0; i < BAR_STRIPS; ++i) {
        const float begin = floorf(bar.x + bar.width * (float)i / BAR_STRIPS);
        const float end = floorf(bar.x + bar.width * (float)(i + 1) / BAR_STRIPS);
        ui_fill(toolkit, (ui_place){begin, bar.y, end - begin, bar.height},
                color_at(state->shown.picture, ((float)i + 0.5F) / BAR_STRIPS));
    }
    (void)ui_canvas(toolkit, "#numbers", ui_row_height(toolkit) - UI_GAP - 2 * UI_INSET_Y, &row, NULL);
    for (int i = 0; i <= 2; ++i) {
        (void)snprintf(text, sizeof text, format, (double)(low + 0.5F * (float)i * (high - low)));
        write_at(toolkit, row, 0.5F * (float)i, text);
    }
}

/* The levels that leaves and larger nodes may have, one patch each. */
static void describe_levels(ui *toolkit, const view_state *state)
{
    enum { SHOWN = 8 };
    ui_place bar;
    ui_place row;
    char text[16];
    const unsigned last = state->shown.level;
    const unsigned first = last > SHOWN ? last - SHOWN + 1 : 1;
    const unsigned count = last >= first ? last - first + 1 : 1;
    (void)ui_canvas(toolkit, "#bar", BAR_HEIGHT, &bar, NULL);
    (void)ui_canvas(toolkit, "#numbers", ui_row_height(toolkit) - UI_GAP - 2 * UI_INSET_Y, &row, NULL);
    for (unsigned i = 0; i < count; ++i) {
        const float width = bar.width / (float)count;
        ui_fill(toolkit, (ui_place){bar.x + width * (float)i, bar.y, width - 2, bar.height}, color_of_level(first + i));
        (void)snprintf(text, sizeof text, "%u", first + i);
        write_at(toolkit, row, ((float)i + 0.5F) / (float)count, text);
    }
}

/* Only views of numbers have one. */
static void describe_legend(ui *toolkit, const view_state *state, ui_place place)
{
    ui_panel_begin(toolkit, "#legend", place);
    switch (state->shown.picture) {
    case VIEW_DEPTH:
        ui_note(toolkit, "Distance from the eye, world units");
        describe_bar(toolkit, state, state->depth_range[0], state->depth_range[1], "%.4g");
        break;
    case VIEW_STEPS:
        ui_note(toolkit, "Cells that the ray visited");
        describe_bar(toolkit, state, 0, 64, "%.0f");
        break;
    case VIEW_AO:
        ui_note(toolkit, "Openness: share of the hemisphere");
        describe_bar(toolkit, state, 0, 1, "%.1f");
        break;
    default:
        ui_note(toolkit, "Level of the node");
        describe_levels(toolkit, state);
        break;
    }
    (void)ui_panel_end(toolkit);
}

static bool has_legend(const view_state *state)
{
    const view_picture picture = state->shown.picture;
    const bool is_of_tree = !state->is_scene && !state->shown.through;
    return is_of_tree &&
           (picture == VIEW_DEPTH || picture == VIEW_STEPS || picture == VIEW_LEVEL || picture == VIEW_AO);
}

void panels_guides(ui *toolkit, view_state *state, ui_place free)
{
    const float text = ui_row_height(toolkit);
    const float axes_height = AXES_EDGE + (state->ground_spacing > 0 ? text : 0);
    const float legend_height = 2 * text + BAR_HEIGHT + 2 * UI_PADDING;
    const float bottom = free.y + free.height;
    if (state->settings.axes && free.width >= AXES_EDGE && free.height > 3 * axes_height) {
        describe_axes(toolkit, state, (ui_place){free.x, bottom - axes_height, AXES_EDGE, axes_height});
        free.x += AXES_EDGE + GAP;
        free.width -= AXES_EDGE + GAP;
    }
    if (has_legend(state) && free.width >= LEGEND_LEAST && free.height > 3 * legend_height) {
        const float width = fminf(LEGEND_WIDTH, free.width);
        describe_legend(toolkit, state,
                        (ui_place){free.x + free.width - width, bottom - legend_height, width, legend_height});
    }
}
