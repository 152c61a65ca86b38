/* SPDX-License-Identifier: MIT */
/* Colors of what rays through probes find. */
#ifndef SVOCL_TOOLS_SUPPORT_PROBE_COLORS_H
#define SVOCL_TOOLS_SUPPORT_PROBE_COLORS_H

#include <stdbool.h>

#include "svocl/probes.h"
#include "svocl/trace.h"

/* What distances and radiances are shown by. */
typedef struct probe_colors {
    svo_render_view view; /* shaded, normal, depth or steps */
    double nearest, farthest; /* depth: distances shown as white and as nearly black */
    double exposure; /* shaded: radiance is multiplied by it */
    bool is_linear; /* radiance, or numbers, in place of what a screen shows */
} probe_colors;

/* What a ray shows: shares of white, or light and numbers where they are linear. Misses are green and unknown rays red,
   except for SVO_VIEW_STEPS, which shows what any ray took. */
void probe_colors_see(const probe_colors *shown, const svo_probe_hit *hit, double seen[3]);

/* Bytes of such shares. */
void probe_colors_encode(const probe_colors *shown, const double seen[3], uint8_t rgb[3]);

/* Both, of an opaque pixel. */
void probe_colors_pixel(const probe_colors *shown, const svo_probe_hit *hit, uint8_t rgba[4]);

#endif
