/* SPDX-License-Identifier: MIT */
/* Frame times as a graph of stages, and memory by buffer. */
#include <math.h>
#include <stdio.h>

#include "support/table.h"
#include "view/panels_figures.h"
#include "view/panels_pages.h"
#include "view/ui.h"

/* Its height, in rows of text, in low and in high windows. */
#define GRAPH_ROWS_LOW  2.5F
#define GRAPH_ROWS_HIGH 4.0F
#define HIGH_WINDOW     600.0F

static const uint32_t stage_colors[VIEW_STAGES] = {
    UI_RGBA(140, 148, 160, 255), UI_RGBA(236, 118, 106, 255), UI_RGBA(94, 176, 239, 255),
    UI_RGBA(126, 205, 140, 255), UI_RGBA(196, 150, 236, 255), UI_RGBA(242, 200, 108, 255),
};

/* ---- the graph ---- */

/* What the graph's top stands for: the least round figure above the longest of so many frames. */
static float graph_range(const view_state *state, size_t count)
{
    static const float rounds[] = {10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000};
    float longest = 0;
    for (size_t i = 0; i < count && panels_frame(state, i) != NULL; ++i) {
        longest = fmaxf(longest, panels_frame(state, i)->ms);
    }
    size_t i = 0;
    while (i + 1 < sizeof rounds / sizeof rounds[0] && rounds[i] < longest) {
        ++i;
    }
    return rounds[i];
}

/* One frame from the bottom up; on top what no stage took, as waiting for the screen does. */
static void draw_frame(ui *toolkit, const view_frame *frame, ui_place column, float range)
{
    float bottom = column.y + column.height;
    for (int i = 0; i < VIEW_STAGES; ++i) {
        const float height = fminf(frame->stage_ms[i] / range * column.height, bottom - column.y);
        if (height > 0) {
            bottom -= height;
            ui_fill(toolkit, (ui_place){column.x, bottom, column.width, height}, stage_colors[i]);
        }
    }
    const float top = column.y + column.height * (1 - fminf(frame->ms / range, 1));
    if (bottom > top) {
        ui_fill(toolkit, (ui_place){column.x, top, column.width, bottom - top}, UI_COLOR_PRESSED);
    }
}

/* A line at the time that a frame should take, where the graph has it. */
static void draw_goal(ui *toolkit, ui_place place, float goal_ms, float range)
{
    const float y = roundf(place.y + place.height * (1 - goal_ms / range));
    if (y > place.y) {
        ui_fill(toolkit, (ui_place){place.x, y, place.width, 1}, UI_RGBA(255, 255, 255, 110));
    }
}

static void draw_graph(ui *toolkit, const view_state *state)
{
    ui_place place;
    char text[32];
    const float rows = (float)state->height / state->scale < HIGH_WINDOW ? GRAPH_ROWS_LOW : GRAPH_ROWS_HIGH;
    (void)ui_canvas(toolkit, "graph", roundf(rows * ui_row_height(toolkit)), &place, NULL);
    const float step = 2;
    const size_t most = (size_t)(place.width / step);
    const size_t count = most < VIEW_FRAMES_KEPT ? most : VIEW_FRAMES_KEPT;
    const float range = graph_range(state, count);
    ui_fill(toolkit, place, UI_COLOR_FIELD);
    for (size_t i = 0; i < count && panels_frame(state, i) != NULL; ++i) {
        const float x = place.x + place.width - step * (float)(i + 1);
        draw_frame(toolkit, panels_frame(state, i), (ui_place){x, place.y, step, place.height}, range);
    }
    draw_goal(toolkit, place, state->settings.goal_ms, range);
    (void)snprintf(text, sizeof text, "%.0f ms", (double)range);
    ui_fill_text(toolkit, place.x + 4, place.y + 2, UI_COLOR_DIM, text);
    ui_tooltip(toolkit, "The last frames, the newest at the right, each as high as the time of its stages; gray is "
                        "waiting. The line is the goal while something moves.");
}

/* Each stage's color and mean, two in a row. */
static void draw_legend(ui *toolkit, const panels_means *means)
{
    const int rows = (VIEW_STAGES + 1) / 2;
    const float step = ui_row_height(toolkit) - UI_GAP;
    ui_place place;
    char text[32];
    (void)ui_canvas(toolkit, "legend", step * (float)rows, &place, NULL);
    for (int i = 0; i < VIEW_STAGES; ++i) {
        const float width = (place.width - UI_PADDING) / 2;
        const float x = i < rows ? place.x : place.x + width + UI_PADDING;
        const float y = place.y + step * (float)(i % rows);
        (void)snprintf(text, sizeof text, "%.1f", (double)means->stage_ms[i]);
        ui_fill(toolkit, (ui_place){x, roundf(y + step / 2) - 4, 8, 8}, stage_colors[i]);
        ui_fill_text(toolkit, x + 13, y + UI_INSET_Y, UI_COLOR_DIM, view_stage_name((view_stage)i));
        ui_fill_text(toolkit, x + width - ui_text_width(toolkit, text), y + UI_INSET_Y, UI_COLOR_TEXT, text);
    }
    ui_tooltip(toolkit, "Milliseconds of each stage, the mean of half a second.");
}

void panels_frames(ui *toolkit, view_state *state)
{
    const panels_means means = panels_mean(state);
    const view_frame *last = panels_frame(state, 0);
    ui_value(toolkit, "Frame", "%s", panels_time(state).text);
    ui_tooltip(toolkit, "The work of the last frame that was drawn, without waiting.");
    if (state->is_idle || !(means.ms > 0)) {
        ui_value(toolkit, "Rate", "-");
    } else {
        ui_value(toolkit, "Rate", "%.0f /s", 1000.0 / (double)means.ms);
    }
    ui_tooltip(toolkit, "Frames a second, the mean of half a second.");
    ui_value(toolkit, "Rays", "%s", means.rays_a_second > 0 ? figure_rate(means.rays_a_second).text : "-");
    ui_tooltip(toolkit, "Rays from the camera, by the time that OpenCL took for the pictures.");
    const unsigned coarse = last != NULL ? last->coarse : 0;
    ui_value(toolkit, "Detail", coarse > 1 ? "1 of %u pixels" : "all pixels", coarse * coarse);
    ui_value(toolkit, "Pictures", "%s", state->share != NULL ? state->share : "-");
    ui_tooltip(toolkit, state->share_reason != NULL ? state->share_reason : "");
    draw_graph(toolkit, state);
    draw_legend(toolkit, &means);
}

/* ---- memory ---- */

static void write_right(ui *toolkit, float right, float y, uint32_t color, const char *text)
{
    ui_fill_text(toolkit, right - ui_text_width(toolkit, text), y, color, text);
}

/* A buffer's name, bytes and planned bytes over a bar of its share of the largest. */
static void draw_buffer(ui *toolkit, const view_memory *buffer, uint64_t largest)
{
    ui_place place;
    char name[VIEW_NAME_BYTES];
    (void)ui_canvas(toolkit, "buffer", ui_row_height(toolkit) - UI_GAP, &place, NULL);
    const float column = roundf(ui_text_width(toolkit, "999.9 MiB ") + UI_GAP);
    const float share = largest > 0 ? (float)((double)buffer->bytes / (double)largest) : 0;
    const float y = place.y + UI_INSET_Y;
    ui_fill(toolkit, (ui_place){place.x, place.y, place.width * share, place.height}, UI_COLOR_FIELD);
    (void)ui_fit(toolkit, buffer->name, place.width - 2 * column, name, sizeof name);
    ui_fill_text(toolkit, place.x + 2, y, UI_COLOR_TEXT, name);
    write_right(toolkit, place.x + place.width - column, y, UI_COLOR_TEXT, figure_bytes(buffer->bytes).text);
    write_right(toolkit, place.x + place.width, y, UI_COLOR_DIM,
                buffer->planned_bytes > 0 ? figure_bytes(buffer->planned_bytes).text : "-");
    ui_tooltip(toolkit, buffer->name);
}

static void draw_memory_heading(ui *toolkit)
{
    ui_place place;
    (void)ui_canvas(toolkit, "columns", ui_row_height(toolkit) - UI_GAP, &place, NULL);
    const float column = roundf(ui_text_width(toolkit, "999.9 MiB ") + UI_GAP);
    write_right(toolkit, place.x + place.width - column, place.y + UI_INSET_Y, UI_COLOR_ACCENT, "held");
    write_right(toolkit, place.x + place.width, place.y + UI_INSET_Y, UI_COLOR_ACCENT, "planned");
    ui_tooltip(toolkit, "Bytes on the device beside what the plan said beforehand; a dash where it lists none.");
}

void panels_memory(ui *toolkit, view_state *state)
{
    view_memory total = {.name = "all"};
    uint64_t largest = 0;
    draw_memory_heading(toolkit);
    for (size_t i = 0; i < state->memory_count; ++i) {
        const view_memory *buffer = &state->memory[i];
        total.bytes += buffer->bytes;
        total.planned_bytes += buffer->planned_bytes;
        largest = buffer->bytes > largest ? buffer->bytes : largest;
    }
    for (size_t i = 0; i < state->memory_count; ++i) {
        ui_push(toolkit, (int)i);
        draw_buffer(toolkit, &state->memory[i], largest);
        ui_pop(toolkit);
    }
    draw_buffer(toolkit, &total, 0);
}
