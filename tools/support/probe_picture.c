/* SPDX-License-Identifier: MIT */
/* Rays of a camera through probes, to colors. */
#include "support/probe_picture.h"

#include <math.h>
#include <stdlib.h>

#include "support/input.h"
#include "support/probe_colors.h"
#include "support/ray_table.h"

/* Of a box's diagonal: the radius of a sphere around it, as for other pictures of depth: 0.87 / sqrt(3). */
#define REACH 0.502294734194974

bool probe_picture_has_view(int view)
{
    return view == (int)SVO_VIEW_SHADED || view == (int)SVO_VIEW_NORMAL || view == (int)SVO_VIEW_DEPTH ||
           view == (int)SVO_VIEW_STEPS;
}

double probe_found_percent(const probe_found *found, unsigned outcome)
{
    size_t all = 0;
    for (unsigned i = 0; i <= SVO_PROBE_UNKNOWN; ++i) {
        all += found->rays[i];
    }
    return all > 0 ? 100.0 * (double)found->rays[outcome] / (double)all : 0;
}

/* The sphere around what probes see has white in front and nearly black at its back. */
static probe_colors colors_of(const probe_picture *asked, const svo_probe_info *info)
{
    double away = 0;
    double diagonal = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = (double)info->low[axis];
        const double high = (double)info->high[axis];
        away = hypot(away, (double)asked->camera.eye[axis] - 0.5 * (low + high));
        diagonal = hypot(diagonal, high - low);
    }
    return (probe_colors){.view = asked->view,
                          .exposure = asked->exposure,
                          .nearest = fmax(away - REACH * diagonal, 0),
                          .farthest = away + REACH * diagonal};
}

static void color(const probe_colors *colors, const svo_probe_hit *hits, size_t count, uint8_t *rgba,
                  probe_found *found)
{
    for (size_t i = 0; i < count; ++i) {
        probe_colors_pixel(colors, &hits[i], rgba + 4 * i);
        ++found->rays[hits[i].state];
    }
}

int probe_picture_draw(program *state, const probe_picture *asked, svo_probes *probes, svo_device *device,
                       cl_command_queue queue, uint8_t *rgba, probe_found *found)
{
    const svo_probe_trace_options how = {.struct_size = sizeof how, .choice = asked->choice};
    svo_probe_info info = SVO_PROBE_INFO_INIT;
    ray_table rays;
    *found = (probe_found){.trace_ms = 0};
    int exit_code = ray_table_from_camera(state, &asked->camera, asked->width, asked->height, &rays);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    svo_probe_hit *hits = malloc(rays.count * sizeof *hits);
    const double started_ms = input_now_ms();
    if (hits == NULL) {
        exit_code = program_fail(state, PROGRAM_FAILED, "out of memory for %zu rays", rays.count);
    } else if (svo_probes_get_info(probes, &info) != SVO_OK ||
               svo_probes_trace(probes, rays.rays, hits, rays.count, &how, queue) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(device));
    } else {
        const probe_colors colors = colors_of(asked, &info);
        found->trace_ms = input_now_ms() - started_ms;
        color(&colors, hits, rays.count, rgba, found);
    }
    free(hits);
    ray_table_free(&rays);
    return exit_code;
}
