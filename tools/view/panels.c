/* SPDX-License-Identifier: MIT */
/* Where panels stand, the line at the bottom, and the sections that are text alone. */
#include "view/panels.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view/input.h"
#include "view/open_dialog.h"
#include "view/panels_figures.h"
#include "view/panels_pages.h"
#include "view/question.h"
#include "view/ui.h"

#define MARGIN 6.0F /* between the window's edge and panels */

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

typedef struct section {
    view_panel panel;
    const char *title, *key;
    panels_page *describe;
} section;

static const section left_sections[] = {
    {VIEW_PANEL_HELP, "Keys", "F1", describe_help},     {VIEW_PANEL_FRAMES, "Frames", "F2", panels_frames},
    {VIEW_PANEL_MEMORY, "Memory", "F3", panels_memory}, {VIEW_PANEL_SELECTION, "Picked", "F7", panels_selection},
    {VIEW_PANEL_LOG, "Log", "F10", describe_log},
};
static const section right_sections[] = {
    {VIEW_PANEL_PICTURE, "View", "F4", panels_picture},          {VIEW_PANEL_CAMERA, "Camera", "F5", panels_camera},
    {VIEW_PANEL_LIGHTS, "Lights", "F6", panels_lights},          {VIEW_PANEL_PROBES, "Probes", "F12", panels_probes},
    {VIEW_PANEL_INSTANCES, "Instances", "F8", panels_instances}, {VIEW_PANEL_MOTION, "Motion", "K", panels_motion},
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
        (void)snprintf(through, sizeof through, " through probes (%s), %.2f %% unknown",
                       svo_probe_choice_name(state->shown.choice), (double)state->probes.found[SVO_PROBE_UNKNOWN]);
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

/* ---- boxes ---- */

#define BOX_WIDTH  420.0F
#define BAR_HEIGHT 8.0F

static void describe_notice(ui *toolkit, view_state *state, float width, float height)
{
    static const char *const buttons[] = {"Close"};
    if (state->notice[0] == '\0') {
        return;
    }
    panels_begin_box(toolkit, "#notice", BOX_WIDTH, width, height);
    ui_text(toolkit, "%s", state->notice);
    if (ui_buttons(toolkit, buttons, 1) == 0) {
        state->notice[0] = '\0';
    }
    (void)ui_panel_end(toolkit);
}

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
    question_describe(toolkit, state);
    panels_open(toolkit, state, width, height);
    describe_notice(toolkit, state, width, height);
}
