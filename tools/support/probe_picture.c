/* SPDX-License-Identifier: MIT */
/* Colors of probes; pictures through them. */
#include "support/probe_picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/input.h"
#include "support/query_table.h"
#include "support/view_colors.h"

/* ---- colors, by the curves of svocl's other pictures: kernels/rays/view.cl, kernels/light/picture.cl ---- */

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

/* What a ray shows: shares of white, or light and numbers where they are linear. Misses are green and unknown rays red,
   except for SVO_VIEW_STEPS, which shows what any ray took. */
static void probe_colors_see(const probe_colors *shown, const svo_probe_hit *hit, double seen[3])
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

/* Bytes of such shares. */
static void probe_colors_encode(const probe_colors *shown, const double seen[3], uint8_t rgb[3])
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

/* ---- pictures ---- */

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
                          .is_linear = asked->output.format == SVO_PIXELS_LINEAR,
                          .nearest = fmax(away - REACH * diagonal, 0),
                          .farthest = away + REACH * diagonal};
}

/* What the rays of a pixel have shown so far. */
typedef struct pixel_sum {
    double seen[3];
    uint32_t met; /* rays that did not miss */
} pixel_sum;

typedef struct drawing {
    program *state;
    const probe_picture *asked;
    svo_probes *probes;
    svo_device *device;
    cl_command_queue queue;
    probe_colors colors;
    uint32_t samples;
    size_t pixel_count;
    pixel_sum *sums; /* owned */
    svo_probe_hit *hits; /* owned; of one ray a pixel */
    probe_found *found;
} drawing;

/* Where a ray is in its pixel, as kernels/rays/pixel.clh places it. */
static void place_sample(uint32_t sample, uint32_t samples, double place[2])
{
    const uint32_t rows = (uint32_t)(sqrt((double)samples) + 0.001);
    const uint32_t cells = samples / rows;
    const uint32_t longer = samples % rows * (cells + 1);
    const uint32_t inside = sample < longer ? sample : sample - longer;
    const uint32_t here = sample < longer ? cells + 1 : cells;
    const uint32_t before = (sample < longer ? 0 : longer) + inside / here * here;
    place[0] = ((double)(inside % here) + 0.5) / here;
    place[1] = ((double)before + 0.5 * here) / samples;
}

/* ---- pixels ---- */

static bool has_numbers(const drawing *work)
{
    return work->colors.is_linear && work->asked->view != SVO_VIEW_SHADED;
}

/* The linear value of the background's color. */
static double background_of(const drawing *work, int channel)
{
    const double coded = (double)work->asked->output.background_color[channel];
    if (work->asked->output.background == SVO_BACKGROUND_TRANSPARENT) {
        return 0;
    }
    return work->asked->view != SVO_VIEW_SHADED ? coded
           : coded <= 0.04045                   ? coded / 12.92
                                                : pow((coded + 0.055) / 1.055, 2.4);
}

static void add_hit(const drawing *work, const svo_probe_hit *hit, pixel_sum *sum)
{
    double seen[3] = {0, 0, 0};
    const bool numbers = has_numbers(work);
    const bool met = hit->state == SVO_PROBE_HIT || (hit->state == SVO_PROBE_UNKNOWN && !numbers) ||
                     work->asked->view == SVO_VIEW_STEPS;
    const bool behind = !met && (numbers || work->asked->output.background != SVO_BACKGROUND_OWN);
    if (!behind) {
        probe_colors_see(&work->colors, hit, seen);
    }
    for (int channel = 0; channel < 3; ++channel) {
        sum->seen[channel] += !behind ? seen[channel] : numbers ? 0 : background_of(work, channel);
    }
    sum->met += met ? 1 : 0;
    ++work->found->rays[hit->state];
}

/* Means as kernels/rays/pixel.clh makes them. */
static void store_pixel(const drawing *work, size_t pixel, uint8_t *pixels)
{
    const pixel_sum *sum = &work->sums[pixel];
    const bool transparent = work->asked->output.background == SVO_BACKGROUND_TRANSPARENT || has_numbers(work);
    const bool straight = transparent && (!work->colors.is_linear || has_numbers(work));
    const double share = transparent ? (double)sum->met / work->samples : 1;
    const double count = straight ? fmax(sum->met, 1) : work->samples;
    const double mean[3] = {sum->seen[0] / count, sum->seen[1] / count, sum->seen[2] / count};
    if (work->colors.is_linear) {
        const float floats[4] = {(float)mean[0], (float)mean[1], (float)mean[2], (float)share};
        memcpy(pixels + sizeof floats * pixel, floats, sizeof floats);
    } else {
        probe_colors_encode(&work->colors, mean, pixels + 4 * pixel);
        pixels[4 * pixel + 3] = (uint8_t)(255 * share + 0.5);
    }
}

/* ---- rays ---- */

static int trace_sample(const drawing *work, uint32_t sample)
{
    double place[2];
    ray_table rays;
    place_sample(sample, work->samples, place);
    int exit_code =
        ray_table_from_camera(work->state, &work->asked->camera, work->asked->width, work->asked->height, place, &rays);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const double started_ms = input_now_ms();
    if (svo_probes_trace(work->probes, svo_in_host(rays.rays), svo_in_host(work->hits), rays.count, NULL,
                         &(svo_submit){.queue = work->queue}) != SVO_OK) {
        exit_code = program_fail_library(work->state, svo_device_message(work->device));
    }
    work->found->trace_ms += input_now_ms() - started_ms;
    for (size_t i = 0; i < rays.count && exit_code == PROGRAM_DONE; ++i) {
        add_hit(work, &work->hits[i], &work->sums[i]);
    }
    ray_table_free(&rays);
    return exit_code;
}

static int draw(drawing *work, uint8_t *pixels)
{
    svo_probe_info info = SVO_PROBE_INFO_INIT;
    int exit_code = svo_probes_get_info(work->probes, &info) == SVO_OK
                        ? PROGRAM_DONE
                        : program_fail_library(work->state, svo_device_message(work->device));
    work->colors = colors_of(work->asked, &info);
    for (uint32_t sample = 0; sample < work->samples && exit_code == PROGRAM_DONE; ++sample) {
        exit_code = trace_sample(work, sample);
    }
    for (size_t i = 0; i < work->pixel_count && exit_code == PROGRAM_DONE; ++i) {
        store_pixel(work, i, pixels);
    }
    return exit_code;
}

int probe_picture_draw(program *state, const probe_picture *asked, svo_probes *probes, svo_device *device,
                       cl_command_queue queue, uint8_t *pixels, probe_found *found)
{
    drawing work = {.state = state,
                    .asked = asked,
                    .probes = probes,
                    .device = device,
                    .queue = queue,
                    .samples = asked->output.samples > 0 ? asked->output.samples : 1,
                    .pixel_count = (size_t)asked->width * asked->height,
                    .found = found};
    *found = (probe_found){.trace_ms = 0};
    work.sums = calloc(work.pixel_count, sizeof *work.sums);
    work.hits = malloc(work.pixel_count * sizeof *work.hits);
    const int exit_code = work.sums != NULL && work.hits != NULL
                              ? draw(&work, pixels)
                              : program_fail(state, PROGRAM_FAILED, "out of memory for %zu rays", work.pixel_count);
    free(work.hits);
    free(work.sums);
    return exit_code;
}
