/* SPDX-License-Identifier: MIT */
/* Pictures through probes, and the colors of what probes hold. */
#ifndef SVOCL_TOOLS_SUPPORT_PROBE_PICTURE_H
#define SVOCL_TOOLS_SUPPORT_PROBE_PICTURE_H

#include <stdbool.h>

#include "support/program.h"
#include "svocl/probes.h"
#include "svocl/trace.h"

/* ---- colors ---- */

/* What distances and radiances are shown by. */
typedef struct probe_colors {
    svo_render_view view; /* shaded, normal, depth or steps */
    double nearest, farthest; /* depth: distances shown as white and as nearly black */
    double exposure; /* shaded: radiance is multiplied by it */
    bool is_linear; /* radiance, or numbers, in place of what a screen shows */
} probe_colors;

/* Both, of an opaque pixel. */
void probe_colors_pixel(const probe_colors *shown, const svo_probe_hit *hit, uint8_t rgba[4]);

/* ---- pictures ---- */

/* Whether rays through probes have such a view: shaded, normal, depth and steps. */
bool probe_picture_has_view(int view);

typedef struct probe_picture {
    svo_camera camera;
    uint32_t width, height;
    svo_render_view view;
    double exposure; /* shaded: radiance is multiplied by it */
    svo_picture_output output; /* one ray a pixel where samples is 0 */
} probe_picture;

/* What the rays of a picture found. */
typedef struct probe_found {
    size_t rays[SVO_PROBE_UNKNOWN + 1]; /* by their outcome: SVO_PROBE_MISS, ... */
    double trace_ms;
} probe_found;

/* Percent of the rays that had an outcome; 0 without rays. */
double probe_found_percent(const probe_found *found, unsigned outcome);

/* Draws rows from top to bottom, of bytes or floats as the output says. Misses are the background that is asked for, or
   else green, and unknown rays are red. Returns the exit code. */
int probe_picture_draw(program *state, const probe_picture *asked, svo_probes *probes, svo_device *device,
                       cl_command_queue queue, uint8_t *pixels, probe_found *found);

#endif
