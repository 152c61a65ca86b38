/* SPDX-License-Identifier: MIT */
/* Where panels stand, the line at the bottom, the box of work; and the sections that tell: frames, memory, what was
   picked, keys, the log. */
#include "view/panels.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support/table.h"
#include "view/dialogs.h"
#include "view/input.h"
#include "view/panels_pages.h"

/* ---- figures of the last frames ---- */

#define MEAN_MS 500.0F

/* Means of the last frames, half a second of them at most. */
typedef struct means {
    float ms; /* from frame to frame; 0: no frame yet */
    float stage_ms[VIEW_STAGES];
    double rays_a_second; /* 0: nothing was drawn */
} means;

/* The frame so many frames ago; 0: the last one. NULL: there was none, or it is forgotten. */
static const view_frame *frame_before(const view_state *state, size_t ago)
{
    return ago < state->frame_count && ago < VIEW_FRAMES_KEPT
               ? &state->frames[(state->frame_count - 1 - ago) % VIEW_FRAMES_KEPT]
               : NULL;
}

static means mean_of(const view_state *state)
{
    means sums = {.ms = 0};
    float drawn_ms = 0;
    double rays = 0;
    size_t count = 0;
    const view_frame *frame = frame_before(state, 0);
    for (; frame != NULL && (count == 0 || sums.ms + frame->ms <= MEAN_MS); frame = frame_before(state, ++count)) {
        sums.ms += frame->ms;
        for (int i = 0; i < VIEW_STAGES; ++i) {
            sums.stage_ms[i] += frame->stage_ms[i];
        }
        rays += (double)frame->rays;
        drawn_ms += frame->rays > 0 ? frame->stage_ms[VIEW_STAGE_PICTURE] : 0;
    }
    const float share = count > 0 ? 1.0F / (float)count : 0;
    sums.ms *= share;
    for (int i = 0; i < VIEW_STAGES; ++i) {
        sums.stage_ms[i] *= share;
    }
    sums.rays_a_second = drawn_ms > 0 ? 1000 * rays / (double)drawn_ms : 0;
    return sums;
}

panels_text panels_time(const view_state *state)
{
    panels_text made = {""};
    size_t ago = 0;
    const view_frame *frame = frame_before(state, 0);
    while (frame != NULL && frame->rays == 0) {
        frame = frame_before(state, ++ago);
    }
    frame = frame != NULL ? frame : frame_before(state, 0);
    (void)snprintf(made.text, sizeof made.text, "%s%.1f ms", state->is_idle ? "idle, " : "",
                   frame != NULL ? (double)frame->work_ms : 0.0);
    return made;
}

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
    for (size_t i = 0; i < count && frame_before(state, i) != NULL; ++i) {
        longest = fmaxf(longest, frame_before(state, i)->ms);
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
    for (size_t i = 0; i < count && frame_before(state, i) != NULL; ++i) {
        const float x = place.x + place.width - step * (float)(i + 1);
        draw_frame(toolkit, frame_before(state, i), (ui_place){x, place.y, step, place.height}, range);
    }
    draw_goal(toolkit, place, state->settings.goal_ms, range);
    (void)snprintf(text, sizeof text, "%.0f ms", (double)range);
    ui_fill_text(toolkit, place.x + 4, place.y + 2, UI_COLOR_DIM, text);
    ui_tooltip(toolkit, "The last frames, the newest at the right, each as high as the time of its stages; gray is "
                        "waiting. The line is the goal while something moves.");
}

/* Each stage's color and mean, two in a row. */
static void draw_legend(ui *toolkit, const means *recent)
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
        (void)snprintf(text, sizeof text, "%.1f", (double)recent->stage_ms[i]);
        ui_fill(toolkit, (ui_place){x, roundf(y + step / 2) - 4, 8, 8}, stage_colors[i]);
        ui_fill_text(toolkit, x + 13, y + UI_INSET_Y, UI_COLOR_DIM, view_stage_name((view_stage)i));
        ui_fill_text(toolkit, x + width - ui_text_width(toolkit, text), y + UI_INSET_Y, UI_COLOR_TEXT, text);
    }
    ui_tooltip(toolkit, "Milliseconds of each stage, the mean of half a second.");
}

static void describe_frames(ui *toolkit, view_state *state)
{
    const means recent = mean_of(state);
    const view_frame *last = frame_before(state, 0);
    ui_value(toolkit, "Frame", "%s", panels_time(state).text);
    ui_tooltip(toolkit, "The work of the last frame that was drawn, without waiting.");
    if (state->is_idle || !(recent.ms > 0)) {
        ui_value(toolkit, "Rate", "-");
    } else {
        ui_value(toolkit, "Rate", "%.0f /s", 1000.0 / (double)recent.ms);
    }
    ui_tooltip(toolkit, "Frames a second, the mean of half a second.");
    ui_value(toolkit, "Rays", "%s", recent.rays_a_second > 0 ? figure_rate(recent.rays_a_second).text : "-");
    ui_tooltip(toolkit, "Rays from the camera, by the time that OpenCL took for the pictures.");
    const unsigned coarse = last != NULL ? last->coarse : 0;
    ui_value(toolkit, "Detail", coarse > 1 ? "1 of %u pixels" : "all pixels", coarse * coarse);
    ui_value(toolkit, "Pictures", "%s", state->share != NULL ? state->share : "-");
    ui_tooltip(toolkit, state->share_reason != NULL ? state->share_reason : "");
    draw_graph(toolkit, state);
    draw_legend(toolkit, &recent);
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

static void describe_memory(ui *toolkit, view_state *state)
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

/* ---- what was picked ---- */

#define LIST_SHOWN 8

static void describe_payload(ui *toolkit, const view_selection *selection)
{
    if (selection->has_color) {
        const uint8_t *color = selection->color;
        ui_value(toolkit, "Color", "%u %u %u, %u", color[0], color[1], color[2], color[3]);
        ui_tooltip(toolkit, "Red, green, blue and alpha of the node, 0 to 255.");
    }
    if (selection->has_normal) {
        const float *normal = selection->normal;
        ui_value(toolkit, "Normal", "%.2f %.2f %.2f", (double)normal[0], (double)normal[1], (double)normal[2]);
    }
    if (selection->has_material) {
        ui_value(toolkit, "Material", "%u", selection->material);
    }
    if (selection->has_fill) {
        ui_value(toolkit, "Fill", "%u", selection->fill);
        ui_tooltip(toolkit, "How much surface the node holds.");
    }
}

static void describe_list(ui *toolkit, const view_selection *selection)
{
    ui_value(toolkit, "In the leaf", "%s", figure_count(selection->list_count).text);
    ui_tooltip(toolkit, "Triangles that touch the leaf; the picture shows them.");
    const size_t shown = selection->list_kept < LIST_SHOWN ? selection->list_kept : LIST_SHOWN;
    char text[16 * LIST_SHOWN] = "";
    size_t used = 0;
    for (size_t i = 0; i < shown; ++i) {
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%u", i > 0 ? ", " : "", selection->list[i]);
    }
    if (shown > 0) {
        ui_note(toolkit, "%s%s", text, selection->list_count > shown ? " ..." : "");
    }
}

static void describe_selection(ui *toolkit, view_state *state)
{
    const view_selection *selection = &state->selection;
    if (!selection->is_hit) {
        ui_note(toolkit, "Click on the picture.");
        return;
    }
    const float *point = selection->point;
    if (selection->triangle != SVO_NO_TRIANGLE) {
        ui_value(toolkit, "Triangle", "%u", selection->triangle);
        ui_tooltip(toolkit, "Its position in the mesh.");
    }
    ui_value(toolkit, "t", "%.5g", (double)selection->t);
    ui_tooltip(toolkit, "World units from the eye.");
    ui_value(toolkit, "At", "%.4g %.4g %.4g", (double)point[0], (double)point[1], (double)point[2]);
    if (selection->instance != SVO_NO_INSTANCE) {
        ui_value(toolkit, "Instance", "%u", selection->instance);
    }
    if (selection->node != SVO_NO_NODE) {
        ui_value(toolkit, selection->level == state->shown.level ? "Leaf" : "Node", "%u", selection->node);
        ui_value(toolkit, "Level", "%u", selection->level);
        describe_payload(toolkit, selection);
    }
    if (selection->list_count > 0) {
        describe_list(toolkit, selection);
    }
}

/* ---- help ---- */

static void describe_help(ui *toolkit, view_state *state)
{
    (void)state;
    for (size_t i = 0; input_describe(i).keys != NULL; ++i) {
        const input_binding binding = input_describe(i);
        ui_value(toolkit, binding.keys, "%s", binding.words);
    }
}

/* ---- log ---- */

#define LOG_LINES_SHOWN 12

static void describe_log(ui *toolkit, view_state *state)
{
    const size_t kept = state->log_count < VIEW_LOG_LINES ? state->log_count : VIEW_LOG_LINES;
    const size_t shown = kept < LOG_LINES_SHOWN ? kept : LOG_LINES_SHOWN;
    for (size_t back = shown; back > 0; --back) {
        ui_text(toolkit, "%s", view_log_line(state, back - 1));
    }
    if (shown == 0) {
        ui_note(toolkit, "Nothing yet.");
    }
}

/* ---- columns ---- */

#define MARGIN 6.0F /* between the window's edge and panels */

typedef struct section {
    view_panel panel;
    const char *title, *key;
    panels_page *describe;
} section;

static const section left_sections[] = {
    {VIEW_PANEL_HELP, "Keys", "F1", describe_help},       {VIEW_PANEL_FRAMES, "Frames", "F2", describe_frames},
    {VIEW_PANEL_MEMORY, "Memory", "F3", describe_memory}, {VIEW_PANEL_SELECTION, "Picked", "F7", describe_selection},
    {VIEW_PANEL_LOG, "Log", "F10", describe_log},
};
static const section right_sections[] = {
    {VIEW_PANEL_PICTURE, "View", "F4", panels_picture},
    {VIEW_PANEL_CAMERA, "Camera", "F5", panels_camera},
    {VIEW_PANEL_LIGHTS, "Lights", "F6", panels_lights},
    {VIEW_PANEL_PROBES, "Probes", "F12", panels_probes},
    {VIEW_PANEL_INSTANCES, "Instances", "F8", panels_instances},
    {VIEW_PANEL_MOTION, "Motion", "K", panels_motion},
    {VIEW_PANEL_BRUSH, "Brush", "J", panels_brush},
    {VIEW_PANEL_SETTINGS, "Settings", "F9", panels_settings},
};

static void describe_column(ui *toolkit, view_state *state, const char *name, ui_place place, const section *sections,
                            size_t count)
{
    ui_panel_begin(toolkit, name, place);
    for (size_t i = 0; i < count; ++i) {
        bool is_open = state->settings.open[sections[i].panel];
        if (ui_section(toolkit, sections[i].title, sections[i].key, &is_open)) {
            view_toggle_panel(state, sections[i].panel);
        }
        if (is_open) {
            ui_push(toolkit, (int)sections[i].panel);
            sections[i].describe(toolkit, state);
            ui_pop(toolkit);
            ui_gap(toolkit);
        }
    }
    (void)ui_panel_end(toolkit);
}

/* The columns leave the picture's center free. */
static float column_width(float width, bool large)
{
    return fminf(large ? 300 : 220, floorf((width - 2 * MARGIN) * 0.33F));
}

/* ---- the line at the bottom ---- */

/* What is shown, how large and how fast, and the last line of the log. */
static void describe_line(ui *toolkit, const view_state *state, ui_place place)
{
    char level[32] = "";
    char through[64] = "";
    char moving[64] = "";
    char text[4096]; /* more than the widest window shows */
    char shown[sizeof text];
    if (state->shown.level > 0) {
        (void)snprintf(level, sizeof level, "   level %u", state->shown.level);
    }
    if (state->shown.through) {
        (void)snprintf(through, sizeof through, " through probes, %.2f %% unknown",
                       (double)state->probes.found[SVO_PROBE_UNKNOWN]);
    }
    if (view_shows_film(state)) {
        (void)snprintf(moving, sizeof moving, "   frame %llu of %llu", (unsigned long long)state->film.frame,
                       (unsigned long long)state->film.frame_count);
    }
    (void)snprintf(text, sizeof text, "%s%s%s%s   %u x %u%s   %s   %s", view_picture_name(state->shown.picture),
                   through, level, moving, state->width, state->height, state->is_refined ? "" : " coarse",
                   panels_time(state).text, view_log_line(state, 0));
    const bool is_whole = ui_fit(toolkit, text, place.width - 2 * UI_PADDING, shown, sizeof shown);
    ui_panel_begin(toolkit, "#line", place);
    ui_text(toolkit, "%s", shown);
    if (!is_whole) {
        ui_tooltip(toolkit, text);
    }
    (void)ui_panel_end(toolkit);
}

/* ---- the box of work ---- */

#define BOX_WIDTH  420.0F
#define BAR_HEIGHT 8.0F

/* The step, what it is doing, and how long all of it has taken. */
static void write_step(char *out, size_t out_bytes, const panels_work *work)
{
    const progress_view *at = &work->progress;
    char stage[64] = "";
    char seconds[32] = "";
    if (at->stage != NULL) {
        (void)snprintf(stage, sizeof stage, ": %s, %.0f %%", at->stage, at->part * 100);
    }
    if (work->seconds >= 1) {
        (void)snprintf(seconds, sizeof seconds, ", %.0f s", work->seconds);
    }
    (void)snprintf(out, out_bytes, "%s%s%s", at->what[0] != '\0' ? at->what : "preparing", stage, seconds);
}

static void draw_bar(ui *toolkit, const progress_view *at)
{
    ui_place place;
    (void)ui_canvas(toolkit, "bar", BAR_HEIGHT, &place, NULL);
    const double done = at->step > 0 ? (at->step - 1 + at->part) / at->step_count : 0;
    ui_fill(toolkit, place, UI_COLOR_FIELD);
    place.width = floorf(place.width * (float)(done < 1 ? done : 1));
    ui_fill(toolkit, place, UI_COLOR_ACCENT);
}

void panels_describe_work(ui *toolkit, const panels_work *work, float width, float height)
{
    char text[512];
    char shown[sizeof text];
    const char *slash = strrchr(work->name, '/');
    const char *name = slash != NULL && slash[1] != '\0' ? slash + 1 : work->name;
    const float columns = fminf(BOX_WIDTH, width - 2 * MARGIN);
    const float line = ui_row_height(toolkit) - 2 * UI_INSET_Y; /* with its gap */
    const float rows = 3 * line + 1 + UI_GAP + BAR_HEIGHT + 2 * UI_PADDING;
    const ui_place place = {floorf((width - columns) / 2), floorf((height - rows) / 2), columns, rows};
    ui_raise(toolkit);
    ui_panel_begin(toolkit, "#work", place);
    ui_fill(toolkit, (ui_place){place.x + 1, place.y + 1, columns - 2, rows - 2},
            UI_COLOR_PANEL | UI_RGBA(0, 0, 0, 255));
    (void)ui_fit(toolkit, name, columns - 2 * UI_PADDING, shown, sizeof shown);
    ui_heading(toolkit, shown);
    write_step(text, sizeof text, work);
    (void)ui_fit(toolkit, text, columns - 2 * UI_PADDING, shown, sizeof shown);
    ui_text(toolkit, "%s", shown);
    draw_bar(toolkit, &work->progress);
    ui_note(toolkit, "%s",
            work->is_stopped ? "Canceled; this step ends first."
            : work->is_first ? "Esc cancels and ends svocl."
            : work->can_stop ? "Esc cancels."
                             : "This cannot be canceled; the window can be closed.");
    (void)ui_panel_end(toolkit);
}

/* ---- all of it ---- */

bool panels_text_is_large(const view_state *state)
{
    const float scale = state->settings.text_scale;
    return scale > 0 ? scale > 1 : (float)state->height / state->scale >= 720;
}

static void describe_columns(ui *toolkit, view_state *state, float width, float height)
{
    const float line = ui_row_height(toolkit) - UI_GAP - 2 * UI_INSET_Y + 2 * UI_PADDING;
    const float column = column_width(width, panels_text_is_large(state));
    const float rest = height - line - 3 * MARGIN;
    const ui_place left = {MARGIN, MARGIN, column, rest};
    const ui_place right = {width - MARGIN - column, MARGIN, column, rest};
    const ui_place below = {MARGIN, height - MARGIN - line, width - 2 * MARGIN, line};
    describe_column(toolkit, state, "#left", left, left_sections, sizeof left_sections / sizeof *left_sections);
    describe_column(toolkit, state, "#right", right, right_sections, sizeof right_sections / sizeof *right_sections);
    describe_line(toolkit, state, below);
    panels_guides(toolkit, state,
                  (ui_place){left.x + column + MARGIN, MARGIN, width - 2 * (2 * MARGIN + column), rest});
}

void panels_describe(ui *toolkit, view_state *state)
{
    const float width = (float)state->width / state->scale;
    const float height = (float)state->height / state->scale;
    if (state->settings.panels) {
        describe_columns(toolkit, state, width, height);
    }
    dialogs_describe(toolkit, state);
}
