/* SPDX-License-Identifier: MIT */
/*
 * Automatic exposure by small pictures of linear light. One exposure shows their log average as middle gray
 * (E. Reinhard and others, "Photographic Tone Reproduction for Digital Images", 2002, section 3.1), another one what is
 * bright in them as nearly white. What is used lies between the two, in stops twice as near to the latter: white walls
 * stay white, and sun on a floor does not make the room around it black.
 *
 * Both are of what is in view and has light. Light beyond certain shares of the pixels counts as the light there, so
 * that neither a lamp in view nor a black corner decides.
 */
#include "support/exposure.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "support/picture.h"
#include "support/table.h"
#include "support/viewpoint.h"

/* The longer side of a small picture, pixels. */
#define SIDE 96u
/* Small pictures of a turn. */
#define PICTURES_MAX 4u
/* Shares of white: of the log average, and of what is bright before highlights roll off. */
#define KEY   0.18
#define WHITE 1.0
/* Shares of the pixels: light beyond counts as the light there. */
#define DARK_SHARE   0.05
#define BRIGHT_SHARE 0.9
/* The darkest light that counts, as a share of the brightest. */
#define DARKEST (1.0F / 256)
/* Beyond, a number is not light but its rounding. */
#define EXPOSURE_MAX 1e12

typedef struct metering {
    float pixels[SIDE * SIDE * 4];
    float light[PICTURES_MAX * SIDE * SIDE]; /* luminance of pixels that met something */
    size_t count;
    size_t met;
} metering;

/* ---- one picture ---- */

/* The luminance of linear light by Rec. 709. */
static float luminance(const float *pixel)
{
    return 0.2126F * pixel[0] + 0.7152F * pixel[1] + 0.0722F * pixel[2];
}

static void take_pixels(metering *work, size_t pixel_count)
{
    for (size_t i = 0; i < pixel_count; ++i) {
        const float *pixel = &work->pixels[4 * i];
        const float light = luminance(pixel);
        const bool has_met = pixel[3] > 0;
        work->met += has_met ? 1 : 0;
        if (has_met && light > 0 && isfinite(light)) {
            work->light[work->count++] = light;
        }
    }
}

/* Draws a small picture as a camera sees it. */
static bool measure(svo_target lit, const svo_render_options *asked, const svo_camera *camera, cl_command_queue queue,
                    metering *work)
{
    svo_render_options small = *asked;
    viewpoint_shrink(SIDE, &small.width, &small.height);
    small.camera = *camera;
    small.exposure = 1;
    small.first_row = small.row_count = 0;
    small.output =
        (svo_picture_output){.format = SVO_PIXELS_LINEAR, .background = SVO_BACKGROUND_TRANSPARENT, .samples = 1};
    if (svo_render(lit, &small, svo_in_host(work->pixels), &(svo_submit){.queue = queue}) != SVO_OK) {
        return false;
    }
    take_pixels(work, (size_t)small.width * small.height);
    return true;
}

/* ---- the exposure ---- */

static int compare(const void *a, const void *b)
{
    const float left = *(const float *)a;
    const float right = *(const float *)b;
    return left < right ? -1 : left > right ? 1 : 0;
}

static float exposure_of(metering *work)
{
    double sum = 0;
    qsort(work->light, work->count, sizeof *work->light, compare);
    const float bright = work->light[(size_t)(BRIGHT_SHARE * (double)(work->count - 1))];
    const float dark = fmaxf(work->light[(size_t)(DARK_SHARE * (double)(work->count - 1))], DARKEST * bright);
    for (size_t i = 0; i < work->count; ++i) {
        sum += log((double)fminf(fmaxf(work->light[i], dark), bright));
    }
    const double of_mean = log(KEY) - sum / (double)work->count;
    const double of_bright = log(WHITE / (double)bright);
    const double between = exp((of_mean + 2 * of_bright) / 3);
    return (float)figure_rounded(fmin(fmax(between, 1 / EXPOSURE_MAX), EXPOSURE_MAX));
}

int exposure_measure(program *state, svo_target lit, const svo_render_options *asked, const session *opened,
                     exposure *out)
{
    const unsigned frame_count = picture_frames(&state->options);
    const unsigned picture_count = frame_count < PICTURES_MAX ? frame_count : PICTURES_MAX;
    metering *work = malloc(sizeof *work);
    bool is_measured = true;
    if (work == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the exposure");
    }
    work->count = work->met = 0;
    for (unsigned i = 0; i < picture_count && is_measured; ++i) {
        svo_camera turned;
        viewpoint_turn(&asked->camera, i, picture_count, &turned);
        is_measured = measure(lit, asked, &turned, opened->queue, work);
    }
    *out = (exposure){.value = work->count > 0 ? exposure_of(work) : 1,
                      .is_automatic = true,
                      .is_dark = work->count == 0 && work->met > 0};
    free(work);
    return is_measured ? PROGRAM_DONE : program_fail_library(state, svo_device_message(opened->device));
}

int exposure_choose(program *state, svo_target lit, const svo_render_options *asked, const session *opened,
                    exposure *out)
{
    const bool is_fixed =
        state->options.exposure > 0 || asked->view == SVO_VIEW_AO || asked->output.format == SVO_PIXELS_LINEAR;
    *out = (exposure){.value = state->options.exposure > 0 ? (float)state->options.exposure : 1};
    return is_fixed ? PROGRAM_DONE : exposure_measure(state, lit, asked, opened, out);
}

/* ---- reports ---- */

exposure_words exposure_describe(const exposure *chosen)
{
    exposure_words words;
    (void)snprintf(words.text, sizeof words.text, "; exposure %.6g%s", (double)chosen->value,
                   chosen->is_automatic ? " (automatic)" : "");
    return words;
}

void exposure_report_dark(const exposure *chosen)
{
    if (chosen->is_dark) {
        table_line("The picture is black: what is in view has no light of this kind.");
    }
}

void exposure_report_json(cJSON *document, const exposure *chosen)
{
    cJSON_AddNumberToObject(document, "exposure", (double)chosen->value);
    cJSON_AddBoolToObject(document, "exposure_is_automatic", chosen->is_automatic);
}
