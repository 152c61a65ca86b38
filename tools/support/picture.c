/* SPDX-License-Identifier: MIT */
/* Chooses payload, checks what is asked of pictures, and draws their frames. */
#include "support/picture.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/info_of.h"
#include "support/viewpoint.h"

uint32_t picture_need(const input *source, uint32_t asked)
{
    const svo_mesh *mesh = source->mesh;
    if (mesh == NULL) {
        return asked;
    }
    const uint32_t color = mesh->colors != NULL || mesh->material_count > 0 ? (uint32_t)SVO_NEED_COLOR : 0;
    const uint32_t need =
        asked == SVO_NEED_DEFAULT ? (uint32_t)SVO_NEED_NORMAL | color : asked & ~((uint32_t)SVO_NEED_COLOR ^ color);
    return need == 0 ? (uint32_t)SVO_NEED_NONE : need;
}

/* ---- what is asked for ---- */

/* Views that linear pictures have as numbers. */
static bool has_numbers(const options *given)
{
    return given->view < OPTION_VIEW_LIGHT && given->view != (int)SVO_VIEW_SHADED;
}

static int check_numbers(program *state, const picture_format *format)
{
    const options *given = &state->options;
    if (given->view == (int)SVO_VIEW_NORMAL && !format->has_negative) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o %s: %s has no negative numbers; --view normal takes .exr",
                            given->output_path, format->suffix);
    }
    if (given->background == OPTION_BACKGROUND_COLOR) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "-o %s: this view is numbers, which --background R,G,B does not apply to",
                            given->output_path);
    }
    return given->view == (int)SVO_VIEW_TRIANGLES && given->pixel_samples > 1
               ? program_fail(state, PROGRAM_WRONG_USAGE, "-o %s: triangles are numbers, which --samples does not mix",
                              given->output_path)
               : PROGRAM_DONE;
}

static int check_film(program *state, const picture_format *format)
{
    const options *given = &state->options;
    const bool moves = given->turntable > 0 || given->animate != 0;
    if (given->turntable > 0 && given->animate != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--turntable and --animate exclude each other");
    }
    if (moves && !format->is_film && strcmp(given->output_path, "-") == 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--%s writes several files, not to standard output; --format y4m is one",
                            given->animate != 0 ? "animate" : "turntable");
    }
    return given->frame_rate == 0 || format->is_film
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--fps applies to .y4m alone");
}

int picture_check(program *state)
{
    const options *given = &state->options;
    const picture_format *format = picture_format_of(given);
    if (format == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o %s: pictures are %s; --format names one of them",
                            given->output_path, picture_format_suffixes());
    }
    if (given->background == OPTION_BACKGROUND_TRANSPARENT && !format->has_alpha) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o %s: %s has no alpha; --background transparent takes %s",
                            given->output_path, format->suffix, format->is_linear ? ".exr" : ".png or .exr");
    }
    int exit_code = picture_format_check(state, format, given->output_path);
    if (exit_code == PROGRAM_DONE && format->is_linear && has_numbers(given)) {
        exit_code = check_numbers(state, format);
    }
    return exit_code == PROGRAM_DONE ? check_film(state, format) : exit_code;
}

int picture_check_files(program *state, uint64_t frame_count)
{
    char path[PICTURE_PATH_BYTES];
    int exit_code = PROGRAM_DONE;
    const uint64_t file_count = picture_format_of(&state->options)->is_film ? 1 : frame_count;
    for (uint64_t frame = 0; frame < file_count && exit_code == PROGRAM_DONE; ++frame) {
        picture_frame_path(&state->options, frame, path);
        exit_code = output_check(state, path);
    }
    return exit_code;
}

unsigned picture_frames(const options *given)
{
    return given->turntable > 0 ? (unsigned)given->turntable : 1u;
}

svo_picture_output picture_output(const options *given)
{
    static const svo_background backgrounds[] = {SVO_BACKGROUND_OWN, SVO_BACKGROUND_COLOR, SVO_BACKGROUND_TRANSPARENT};
    svo_picture_output output = {.format = picture_format_of(given)->is_linear ? SVO_PIXELS_LINEAR : SVO_PIXELS_BYTES,
                                 .background = backgrounds[given->background],
                                 .samples = (uint32_t)given->pixel_samples};
    for (int channel = 0; channel < 3; ++channel) {
        output.background_color[channel] = (float)given->background_bytes[channel] / 255.0F;
    }
    return output;
}

/* ---- files ---- */

static int write_to(program *state, const char *path, const picture_format *format, const picture_pixels *pixels)
{
    output_file file;
    int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = format->write(state, &file, pixels);
    if (exit_code != PROGRAM_DONE) {
        output_abandon(&file);
        return exit_code;
    }
    return output_commit(state, &file);
}

int picture_write_as(program *state, const char *path, uint32_t width, uint32_t height, const uint8_t *rgba)
{
    const picture_pixels pixels = {.width = width, .height = height, .bytes = rgba};
    const options png = {.format = OPTION_FORMAT_PNG};
    return write_to(state, path, picture_format_of(&png), &pixels);
}

int picture_open(program *state, picture_stream *out)
{
    const options *given = &state->options;
    *out = (picture_stream){.state = state, .format = picture_format_of(given)};
    out->pixels = malloc((size_t)given->width * given->height * (out->format->is_linear ? 4 * sizeof(float) : 4));
    if (out->pixels == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %lux%lu pixels", (unsigned long)given->width,
                            (unsigned long)given->height);
    }
    const int exit_code = out->format->is_film ? output_open(state, given->output_path, &out->film) : (int)PROGRAM_DONE;
    if (exit_code != PROGRAM_DONE) {
        free(out->pixels);
        return exit_code;
    }
    if (out->format->is_film) {
        picture_film_begin(&out->film, given->width, given->height,
                           given->frame_rate > 0 ? (unsigned)given->frame_rate : OPTION_DEFAULT_FPS);
    }
    return PROGRAM_DONE;
}

int picture_add(picture_stream *shown, const char *path)
{
    const options *given = &shown->state->options;
    picture_pixels pixels = {.width = given->width, .height = given->height};
    pixels.has_alpha = given->background == OPTION_BACKGROUND_TRANSPARENT || has_numbers(given);
    pixels.bytes = shown->format->is_linear ? NULL : shown->pixels;
    pixels.floats = shown->format->is_linear ? (const float *)(const void *)shown->pixels : NULL;
    progress_step(shown->state->progress, "writing the picture");
    if (!shown->format->is_film) {
        return write_to(shown->state, path, shown->format, &pixels);
    }
    const int exit_code = shown->format->write(shown->state, &shown->film, &pixels);
    /* A reader that has gone is told of now, and not after all frames. */
    return exit_code != PROGRAM_DONE || output_flush(&shown->film)
               ? exit_code
               : program_fail(shown->state, PROGRAM_FAILED, "%s: %s", output_name(path), strerror(shown->film.error));
}

int picture_close(picture_stream *shown, int exit_code)
{
    if (shown->format->is_film && exit_code == PROGRAM_DONE) {
        exit_code = output_commit(shown->state, &shown->film);
    } else if (shown->format->is_film) {
        output_abandon(&shown->film);
    }
    free(shown->pixels);
    shown->pixels = NULL;
    return exit_code;
}

void picture_frame_path(const options *given, uint64_t frame, char path[PICTURE_PATH_BYTES])
{
    const char *whole = given->output_path;
    const char *name = strrchr(whole, '/');
    const char *dot = strrchr(name != NULL ? name : whole, '.');
    const int stem = (int)(dot != NULL ? (size_t)(dot - whole) : strlen(whole));
    const bool several = (given->animate != 0 || given->turntable > 0) && !picture_format_of(given)->is_film;
    if (!several) {
        (void)snprintf(path, PICTURE_PATH_BYTES, "%s", whole);
    } else if (given->animate != 0) {
        (void)snprintf(path, PICTURE_PATH_BYTES, "%.*s_%03llu%s", stem, whole, (unsigned long long)frame,
                       dot != NULL ? dot : "");
    } else {
        (void)snprintf(path, PICTURE_PATH_BYTES, "%.*s-%04llu%s", stem, whole, (unsigned long long)frame + 1,
                       dot != NULL ? dot : "");
    }
}

/* ---- drawing ---- */

int picture_draw(program *state, const char *step, const svo_camera *camera, picture_drawer draw, void *user,
                 double *draw_ms)
{
    const unsigned frame_count = picture_frames(&state->options);
    const svo_picture_output output = picture_output(&state->options);
    picture_stream shown;
    int exit_code = picture_open(state, &shown);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    *draw_ms = 0;
    progress_step(state->progress, step);
    for (unsigned frame = 0; frame < frame_count && exit_code == PROGRAM_DONE; ++frame) {
        char path[PICTURE_PATH_BYTES];
        svo_camera turned;
        viewpoint_turn(camera, frame, frame_count, &turned);
        const double started_ms = input_now_ms();
        exit_code = draw(user, &turned, &output, shown.pixels);
        *draw_ms += input_now_ms() - started_ms;
        if (exit_code == PROGRAM_DONE) {
            picture_frame_path(&state->options, frame, path);
            exit_code = picture_add(&shown, path);
        }
    }
    return picture_close(&shown, exit_code);
}

/* ---- reports ---- */

picture_words picture_describe(const options *given)
{
    picture_words words;
    const unsigned frames = picture_frames(given);
    char path[PICTURE_PATH_BYTES - 100];
    (void)snprintf(path, sizeof path, "%s", output_name(given->output_path));
    if (frames > 1) {
        (void)snprintf(words.text, sizeof words.text, "%s: %u frames of %lux%lu pixels", path, frames,
                       (unsigned long)given->width, (unsigned long)given->height);
    } else {
        (void)snprintf(words.text, sizeof words.text, "%s: %lux%lu pixels", path, (unsigned long)given->width,
                       (unsigned long)given->height);
    }
    return words;
}

cJSON *picture_document(const program *state)
{
    const options *given = &state->options;
    cJSON *document = json_document();
    json_add_text(document, "input", given->input);
    json_add_text(document, "file", given->output_path);
    json_add_count(document, "width", given->width);
    json_add_count(document, "height", given->height);
    if (given->turntable > 0) {
        json_add_count(document, "frames", given->turntable);
    }
    return document;
}

int picture_print_document(program *state, cJSON *document, double render_ms, const svo_device *device,
                           const svo_camera *camera)
{
    cJSON_AddNumberToObject(document, "render_ms", render_ms);
    json_add_text(document, "device", info_of_device(device).name);
    cJSON_AddItemToObject(document, "eye", cJSON_CreateFloatArray(camera->eye, 3));
    cJSON_AddItemToObject(document, "target", cJSON_CreateFloatArray(camera->target, 3));
    return json_print(state, document);
}
