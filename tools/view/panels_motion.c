/* SPDX-License-Identifier: MIT */
/* Motions: what plays, its time, and how fast. */
#include "view/panels_pages.h"
#include "view/play.h"

static void choose_speed(ui *toolkit, view_state *state)
{
    static const char *const names[2 * VIEW_SPEED_MAX + 1] = {"1/16", "1/8", "1/4", "1/2", "1", "2", "4", "8", "16"};
    int chosen = state->film.speed_log2 + VIEW_SPEED_MAX;
    if (ui_choice(toolkit, "Speed", names, 2 * VIEW_SPEED_MAX + 1, &chosen)) {
        play_choose_speed(state, chosen - VIEW_SPEED_MAX);
    }
    ui_tooltip(toolkit, "Of the motions' time, in a second. Keys Up and Down.");
}

void panels_motion(ui *toolkit, view_state *state)
{
    view_film *film = &state->film;
    const char *const buttons[] = {"Back", film->is_playing ? "Pause" : "Play", "Next"};
    if (state->mover_count == 0) {
        ui_note(toolkit, "Nothing moves. Instances of a scene's file may have a 'motion'.");
        return;
    }
    const int pressed = ui_buttons(toolkit, buttons, 3);
    if (pressed == 1) {
        play_toggle(state);
    } else if (pressed >= 0) {
        play_step(state, pressed - 1);
    }
    ui_tooltip(toolkit, "Space plays and pauses; Left and Right step by a frame.");
    int frame = (int)film->frame;
    if (ui_slider_count(toolkit, "Frame", &frame, 0, (int)film->frame_count - 1)) {
        play_seek(state, (uint64_t)frame);
    }
    ui_tooltip(toolkit, "As svocl render --animate numbers them.");
    ui_value(toolkit, "Time", "%.3f of %.3g .. %.3g", film->time, (double)film->first_time, (double)film->last_time);
    choose_speed(toolkit, state);
    ui_checkbox(toolkit, "Loop", &film->loops);
    ui_tooltip(toolkit, "The first frame follows the last one; otherwise that stays.");
    if (state->is_scene) {
        ui_note(toolkit, "Instances are edited at their first keys.");
    }
}
