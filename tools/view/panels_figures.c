/* SPDX-License-Identifier: MIT */
/* Means over the ring of frames. */
#include "view/panels_figures.h"

#include <stdio.h>
#include <string.h>

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

void panels_fit(const ui *toolkit, const char *text, float width, char *out, size_t out_bytes)
{
    (void)snprintf(out, out_bytes, "%s", text);
    size_t length = strlen(out);
    while (length > 0 && ui_text_width(toolkit, out) > width) {
        do {
            --length;
        } while (length > 0 && ((unsigned char)out[length] & 0xC0U) == 0x80);
        out[length] = '\0';
    }
}
