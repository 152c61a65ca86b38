/* SPDX-License-Identifier: MIT */
/* Where panels stand, the line at the bottom, and the sections that are text alone. */
#include "view/panels.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view/input.h"
#include "view/panels_figures.h"
#include "view/panels_pages.h"
#include "view/question.h"
#include "view/ui_theme.h"

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
    for (size_t i = state->log_count - shown; i < state->log_count; ++i) {
        ui_text(toolkit, "%s", state->log[i % VIEW_LOG_LINES]);
    }
    if (shown == 0) {
        ui_note(toolkit, "Nothing yet.");
    }
}

/* ---- columns ---- */

typedef struct section {
    view_panel panel;
    const char *title;
    panels_page *describe;
} section;

static const section left_sections[] = {
    {VIEW_PANEL_HELP, "Keys", describe_help},     {VIEW_PANEL_FRAMES, "Frames", panels_frames},
    {VIEW_PANEL_MEMORY, "Memory", panels_memory}, {VIEW_PANEL_SELECTION, "Picked", panels_selection},
    {VIEW_PANEL_LOG, "Log", describe_log},
};
static const section right_sections[] = {
    {VIEW_PANEL_PICTURE, "View", panels_picture},          {VIEW_PANEL_CAMERA, "Camera", panels_camera},
    {VIEW_PANEL_LIGHTS, "Lights", panels_lights},          {VIEW_PANEL_PROBES, "Probes", panels_probes},
    {VIEW_PANEL_INSTANCES, "Instances", panels_instances}, {VIEW_PANEL_MOTION, "Motion", panels_motion},
    {VIEW_PANEL_SETTINGS, "Settings", panels_settings},
};

static void describe_column(ui *toolkit, view_state *state, const char *name, ui_place place, const section *sections,
                            size_t count)
{
    ui_panel_begin(toolkit, name, place);
    for (size_t i = 0; i < count; ++i) {
        bool is_open = state->settings.open[sections[i].panel];
        if (ui_section(toolkit, sections[i].title, &is_open)) {
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
static float column_width(const view_state *state, bool large)
{
    return fminf(large ? 300 : 220, floorf(((float)state->width - 2 * MARGIN) * 0.33F));
}

/* ---- the line at the bottom ---- */

/* What is shown, how large and how fast, and the last line of the log. */
static void describe_line(ui *toolkit, view_state *state, float height)
{
    char level[32] = "";
    char through[64] = "";
    char moving[64] = "";
    char text[256 + VIEW_LINE_BYTES];
    char shown[sizeof text];
    const char *last = state->log_count > 0 ? state->log[(state->log_count - 1) % VIEW_LOG_LINES] : "";
    const ui_place place = {MARGIN, (float)state->height - MARGIN - height, (float)state->width - 2 * MARGIN, height};
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
    (void)snprintf(text, sizeof text, "%s%s%s%s   %u x %u%s   %.1f ms   %s", view_picture_name(state->shown.picture),
                   through, level, moving, state->width, state->height, state->is_refined ? "" : " coarse",
                   (double)panels_mean(state).ms, last);
    panels_fit(toolkit, text, place.width - 2 * UI_PADDING, shown, sizeof shown);
    ui_panel_begin(toolkit, "#line", place);
    ui_text(toolkit, "%s", shown);
    (void)ui_panel_end(toolkit);
}

/* ---- all of it ---- */

bool panels_text_is_large(const view_state *state)
{
    const float scale = state->settings.text_scale;
    return scale > 0 ? scale > 1 : state->height >= 720;
}

void panels_describe(ui *toolkit, view_state *state)
{
    question_describe(toolkit, state);
    if (!state->settings.panels) {
        return;
    }
    const float line = ui_row_height(toolkit) - UI_GAP - 2 * UI_INSET_Y + 2 * UI_PADDING;
    const float width = column_width(state, panels_text_is_large(state));
    const float height = (float)state->height - line - 3 * MARGIN;
    const ui_place left = {MARGIN, MARGIN, width, height};
    const ui_place right = {(float)state->width - MARGIN - width, MARGIN, width, height};
    describe_column(toolkit, state, "#left", left, left_sections, sizeof left_sections / sizeof *left_sections);
    describe_column(toolkit, state, "#right", right, right_sections, sizeof right_sections / sizeof *right_sections);
    describe_line(toolkit, state, line);
}
