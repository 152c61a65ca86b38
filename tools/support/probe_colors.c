/* SPDX-License-Identifier: MIT */
/* The curves of svocl's other pictures (kernels/rays/view.cl, kernels/light/picture.cl), on the host. */
#include "support/probe_colors.h"

#include <math.h>

#include "support/view_colors.h"

static uint8_t byte_of(double share)
{
    return (uint8_t)(255.0 * fmin(fmax(share, 0.0), 1.0) + 0.5);
}

/* Linear light as the share of white that a screen shows. */
static double tone(double light)
{
    return light > 0.5 ? 1.0 - 0.5 * exp(1.0 - 2.0 * light) : fmax(light, 0.0);
}

/* Of the texels that a ray visited. */
static void set_steps(uint32_t visited, double seen[3])
{
    float rgb[3];
    view_colors_steps(fminf((float)visited / VIEW_COLORS_STEPS_HOT, 1.0F), rgb);
    for (int channel = 0; channel < 3; ++channel) {
        seen[channel] = (double)rgb[channel];
    }
}

static void set_hit(const probe_colors *shown, const svo_probe_hit *hit, double seen[3])
{
    float normal[3];
    svo_probe_normal(hit->normal, normal);
    const double far = ((double)hit->t - shown->nearest) / (shown->farthest - shown->nearest);
    for (int channel = 0; channel < 3; ++channel) {
        const double light = shown->exposure * (double)hit->radiance[channel];
        const double axis = (double)normal[channel];
        seen[channel] = shown->view == SVO_VIEW_NORMAL  ? (shown->is_linear ? axis : 0.5 + 0.5 * axis)
                        : shown->view == SVO_VIEW_DEPTH ? (shown->is_linear ? (double)hit->t : 1.0 - 0.9 * far)
                        : shown->is_linear              ? light
                                                        : tone(light);
    }
}

void probe_colors_see(const probe_colors *shown, const svo_probe_hit *hit, double seen[3])
{
    seen[0] = hit->state == SVO_PROBE_UNKNOWN ? 1 : 0;
    seen[1] = hit->state == SVO_PROBE_MISS ? 1 : 0;
    seen[2] = 0;
    if (shown->view == SVO_VIEW_STEPS && shown->is_linear) {
        seen[0] = seen[1] = seen[2] = (double)hit->visited;
    } else if (shown->view == SVO_VIEW_STEPS) {
        set_steps(hit->visited, seen);
    } else if (hit->state == SVO_PROBE_HIT) {
        set_hit(shown, hit, seen);
    }
}

void probe_colors_encode(const probe_colors *shown, const double seen[3], uint8_t rgb[3])
{
    for (int channel = 0; channel < 3; ++channel) {
        const double share = seen[channel];
        /* The sRGB curve, IEC 61966-2-1. */
        rgb[channel] = byte_of(shown->view != SVO_VIEW_SHADED ? share
                               : share <= 0.0031308           ? 12.92 * share
                                                              : 1.055 * pow(share, 1.0 / 2.4) - 0.055);
    }
}

void probe_colors_pixel(const probe_colors *shown, const svo_probe_hit *hit, uint8_t rgba[4])
{
    double seen[3];
    probe_colors_see(shown, hit, seen);
    probe_colors_encode(shown, seen, rgba);
    rgba[3] = 255;
}
