/* SPDX-License-Identifier: MIT */
/* The curves of svocl's other pictures (kernels/rays/view.cl, kernels/light/picture.cl), on the host. */
#include "support/probe_colors.h"

#include <math.h>

#define STEPS_HOT 64.0 /* the number of texels that the last color stands for */

static uint8_t byte_of(double share)
{
    return (uint8_t)(255.0 * fmin(fmax(share, 0.0), 1.0) + 0.5);
}

/* Linear light as the share of white that a screen shows, coded by the sRGB curve (IEC 61966-2-1). */
static double shown_of(double light)
{
    const double share = light > 0.5 ? 1.0 - 0.5 * exp(1.0 - 2.0 * light) : fmax(light, 0.0);
    return share <= 0.0031308 ? 12.92 * share : 1.055 * pow(share, 1.0 / 2.4) - 0.055;
}

/* From dark blue over green and yellow to red. */
static void set_heat(double heat, uint8_t rgba[4])
{
    static const double peaks[3] = {0.90, 0.55, 0.15};
    static const double widths[3] = {0.55, 0.45, 0.35};
    static const double least[3] = {0.05, 0.03, 0.20};
    for (int channel = 0; channel < 3; ++channel) {
        const double away = (fmin(heat, 1.0) - peaks[channel]) / widths[channel];
        rgba[channel] = byte_of(fmax(1.0 - away * away, least[channel]));
    }
}

static void set_hit(const probe_colors *shown, const svo_probe_hit *hit, uint8_t rgba[4])
{
    float normal[3];
    svo_probe_normal(hit->normal, normal);
    const double far = ((double)hit->t - shown->nearest) / (shown->farthest - shown->nearest);
    for (int channel = 0; channel < 3; ++channel) {
        const double value = shown->view == SVO_VIEW_NORMAL ? 0.5 + 0.5 * (double)normal[channel]
                             : shown->view == SVO_VIEW_DEPTH
                                 ? 1.0 - 0.9 * far
                                 : shown_of(shown->exposure * (double)hit->radiance[channel]);
        rgba[channel] = byte_of(value);
    }
}

void probe_colors_pixel(const probe_colors *shown, const svo_probe_hit *hit, uint8_t rgba[4])
{
    rgba[0] = hit->state == SVO_PROBE_UNKNOWN ? 255 : 0;
    rgba[1] = hit->state == SVO_PROBE_MISS ? 255 : 0;
    rgba[2] = 0;
    rgba[3] = 255;
    if (shown->view == SVO_VIEW_STEPS) {
        set_heat((double)hit->visited / STEPS_HOT, rgba);
    } else if (hit->state == SVO_PROBE_HIT) {
        set_hit(shown, hit, rgba);
    }
}
