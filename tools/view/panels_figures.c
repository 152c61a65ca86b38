/* SPDX-License-Identifier: MIT */
/* Means over the ring of frames. */
#include "view/panels_figures.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "view/ui.h"

#define MEAN_MS 500.0F

const view_frame *panels_frame(const view_state *state, size_t ago)
{
    return ago < state->frame_count && ago < VIEW_FRAMES_KEPT
               ? &state->frames[(state->frame_count - 1 - ago) % VIEW_FRAMES_KEPT]
               : NULL;
}

panels_means panels_mean(const view_state *state)
{
    panels_means sums = {.ms = 0};
    float drawn_ms = 0;
    double rays = 0;
    size_t count = 0;
    const view_frame *frame = panels_frame(state, 0);
    for (; frame != NULL && (count == 0 || sums.ms + frame->ms <= MEAN_MS); frame = panels_frame(state, ++count)) {
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
    const view_frame *frame = panels_frame(state, 0);
    while (frame != NULL && frame->rays == 0) {
        frame = panels_frame(state, ++ago);
    }
    frame = frame != NULL ? frame : panels_frame(state, 0);
    (void)snprintf(made.text, sizeof made.text, "%s%.1f ms", state->is_idle ? "idle, " : "",
                   frame != NULL ? (double)frame->work_ms : 0.0);
    return made;
}

void panels_begin_box(ui *toolkit, const char *name, float box_width, float width, float height)
{
    const float room = width - 2 * UI_PADDING;
    const float columns = floorf(box_width < room ? box_width : room);
    const float top = floorf(height * 0.12F);
    ui_raise(toolkit);
    ui_panel_begin(toolkit, name, (ui_place){floorf((width - columns) / 2), top, columns, height - 2 * top});
}
