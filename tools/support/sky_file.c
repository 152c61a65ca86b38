/* SPDX-License-Identifier: MIT */
/* Skies of files of lights. Gradients and pictures become maps, which the library takes (svo_light_setup.sky_map). */
#include "support/sky_file.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "support/exr_file.h"
#include "support/hdr_file.h"
#include "svocl/light.h"

#define PI 3.14159265358979323846
/* Rows of a gradient's map. */
#define GRADIENT_ROWS 1024u
#define PATH_BYTES    4096
#define TURN_MAX      36000.0
#define CHANNELS      3

/* ---- values ---- */

static const cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

int sky_file_color(const json_source *source, const cJSON *object, const char *what, const char *name, float out[3])
{
    const cJSON *value = member(object, name);
    if (value == NULL) {
        return json_source_fail(source, object, "%s has no '%s'", what, name);
    }
    const int exit_code = json_source_floats(source, value, name, 3, out);
    const cJSON *number = value->child;
    for (int channel = 0; channel < 3 && exit_code == PROGRAM_DONE; ++channel, number = number->next) {
        if (out[channel] < 0.0F) {
            return json_source_fail(source, number, "number %d of '%s' is %g, below 0", channel + 1, name,
                                    (double)out[channel]);
        }
    }
    return exit_code;
}

/* A member that is a number within low .. high; absent: it stays as it is. */
static int read_number(const json_source *source, const cJSON *object, const char *name, double low, double high,
                       double *out)
{
    const cJSON *value = member(object, name);
    if (value == NULL) {
        return PROGRAM_DONE;
    }
    if (!cJSON_IsNumber(value) || !(value->valuedouble >= low) || !(value->valuedouble <= high)) {
        return json_source_fail(source, value, "'%s' is not a number within %g .. %g", name, low, high);
    }
    *out = value->valuedouble;
    return PROGRAM_DONE;
}

static int allocate(const json_source *source, uint32_t width, uint32_t height, sky_file *out)
{
    out->texels = calloc((size_t)width * height, CHANNELS * sizeof *out->texels);
    if (out->texels == NULL) {
        return program_fail(source->state, PROGRAM_FAILED, "out of memory for a sky of %u x %u texels", width, height);
    }
    out->width = width;
    out->height = height;
    return PROGRAM_DONE;
}

/* ---- gradients ---- */

/* From the horizon linear in the height of the direction, up to the zenith and down to the ground. */
static int read_gradient(const json_source *source, const cJSON *object, sky_file *out)
{
    static const char *const keys[] = {"zenith", "horizon", "ground", NULL};
    int exit_code = json_source_check_keys(source, object, "a gradient of the sky", keys);
    for (int i = 0; i < 3 && exit_code == PROGRAM_DONE; ++i) {
        exit_code = sky_file_color(source, object, "a gradient of the sky", keys[i], out->gradient[i]);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = allocate(source, 1, GRADIENT_ROWS, out);
    }
    for (uint32_t row = 0; row < GRADIENT_ROWS && exit_code == PROGRAM_DONE; ++row) {
        const double height = cos(PI * (row + 0.5) / GRADIENT_ROWS);
        const float *end = height > 0 ? out->gradient[0] : out->gradient[2];
        for (int channel = 0; channel < CHANNELS; ++channel) {
            const double horizon = (double)out->gradient[1][channel];
            out->texels[CHANNELS * row + (uint32_t)channel] =
                (float)(horizon + fabs(height) * ((double)end[channel] - horizon));
        }
    }
    return exit_code;
}

/* ---- pictures ---- */

typedef struct sky_picture {
    const json_source *source;
    const cJSON *file, *scale_value; /* for messages */
    char path[PATH_BYTES];
    double scale, turn; /* turn: degrees to the right */
} sky_picture;

/* Paths are relative to the folder of the file of lights. */
static int find_path(const json_source *source, const cJSON *value, char path[PATH_BYTES])
{
    if (!cJSON_IsString(value) || value->valuestring[0] == '\0') {
        return json_source_fail(source, value, "'file' is not a text");
    }
    const char *name = value->valuestring;
    const char *slash = strrchr(source->path, '/');
    const bool is_own = name[0] == '/' || slash == NULL;
    const int length =
        snprintf(path, PATH_BYTES, "%.*s%s", is_own ? 0 : (int)(slash + 1 - source->path), source->path, name);
    return length >= 0 && length < PATH_BYTES
               ? PROGRAM_DONE
               : json_source_fail(source, value, "'file' is longer than %d bytes", PATH_BYTES - 1);
}

static int fail_file(const sky_picture *picture, const char *words)
{
    return json_source_fail(picture->source, picture->file, "'file' %s: %s", picture->path, words);
}

/* A row, turned and scaled: linear between its texels. */
static void turn_row(const sky_picture *picture, const float *from, uint32_t width, float *to)
{
    const double shift = picture->turn / 360 * width;
    for (uint32_t column = 0; column < width; ++column) {
        const double at = column - shift;
        const double low = floor(at);
        const double left = fmod(low, width);
        const uint32_t first = (uint32_t)(left < 0 ? left + width : left);
        const uint32_t second = first + 1 < width ? first + 1 : 0;
        for (uint32_t channel = 0; channel < CHANNELS; ++channel) {
            const double a = (double)from[CHANNELS * first + channel];
            const double b = (double)from[CHANNELS * second + channel];
            to[CHANNELS * column + channel] = (float)(picture->scale * (a + (at - low) * (b - a)));
        }
    }
}

static int take_texels(const sky_picture *picture, const float *pixels, sky_file *out)
{
    const size_t row_floats = (size_t)CHANNELS * out->width;
    for (uint32_t row = 0; row < out->height; ++row) {
        turn_row(picture, pixels + row * row_floats, out->width, out->texels + row * row_floats);
    }
    for (size_t i = 0; i < row_floats * out->height; ++i) {
        if (!isfinite(out->texels[i])) {
            return json_source_fail(
                picture->source, picture->scale_value != NULL ? picture->scale_value : picture->file,
                "'file' %s: %g times 'scale' %g, at column %zu and row %zu, is no float", picture->path,
                (double)pixels[i], picture->scale, i / CHANNELS % out->width, i / CHANNELS / out->width);
        }
    }
    return PROGRAM_DONE;
}

static int load_picture(const sky_picture *picture, FILE *stream, sky_file *out)
{
    hdr_picture read;
    const size_t length = strlen(picture->path);
    const bool is_exr = length > 4 && strcasecmp(picture->path + length - 4, ".exr") == 0;
    if (!(is_exr ? exr_file_read(picture->path, SVO_SKY_WIDTH_MAX, SVO_SKY_HEIGHT_MAX, &read)
                 : hdr_file_read(stream, SVO_SKY_WIDTH_MAX, SVO_SKY_HEIGHT_MAX, &read))) {
        return fail_file(picture, read.words);
    }
    int exit_code = allocate(picture->source, read.width, read.height, out);
    if (exit_code == PROGRAM_DONE) {
        exit_code = take_texels(picture, read.texels, out);
    }
    hdr_file_free(&read);
    out->path = strdup(picture->path);
    out->scale = picture->scale;
    out->turn = picture->turn;
    return exit_code == PROGRAM_DONE && out->path == NULL
               ? program_fail(picture->source->state, PROGRAM_FAILED, "out of memory for a path of a sky")
               : exit_code;
}

static int read_picture(const json_source *source, const cJSON *object, sky_file *out)
{
    static const char *const keys[] = {"file", "scale", "turn", NULL};
    sky_picture picture = {
        .source = source, .file = member(object, "file"), .scale_value = member(object, "scale"), .scale = 1};
    int exit_code = json_source_check_keys(source, object, "a picture of the sky", keys);
    if (exit_code == PROGRAM_DONE) {
        exit_code = find_path(source, picture.file, picture.path);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_number(source, object, "scale", 0, 1e30, &picture.scale);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_number(source, object, "turn", -TURN_MAX, TURN_MAX, &picture.turn);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    FILE *stream = fopen(picture.path, "rb");
    if (stream == NULL) {
        return fail_file(&picture, strerror(errno));
    }
    exit_code = load_picture(&picture, stream, out);
    fclose(stream);
    return exit_code;
}

/* ---- all of it ---- */

int sky_file_read(const json_source *source, const cJSON *value, sky_file *out)
{
    *out = (sky_file){.texels = NULL};
    if (cJSON_IsArray(value)) {
        return sky_file_color(source, source->root, "the file", "sky", out->radiance);
    }
    if (!cJSON_IsObject(value)) {
        return json_source_fail(source, value, "'sky' is neither an array of 3 numbers, a gradient nor a picture");
    }
    return member(value, "file") != NULL ? read_picture(source, value, out) : read_gradient(source, value, out);
}

void sky_file_close(sky_file *sky)
{
    free(sky->texels);
    free(sky->path);
    *sky = (sky_file){.texels = NULL};
}
