/* SPDX-License-Identifier: MIT */
/* Reads PNG and HDR files by stb_image, and EXR files by OpenEXR. */
#include "program_picture.h"

#include "run_program.h"

#include <stdlib.h>
#include <string.h>

#ifdef SVOCL_EXR
#include <openexr.h>
#endif

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_ONLY_HDR
#pragma GCC diagnostic ignored "-Wunused-function" /* which are found at the end of the file */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized" /* gcc 14 */
#endif
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

program_picture read_picture(const char *path)
{
    program_picture picture = {.rgba = NULL};
    int channels = 0;
    picture.rgba = stbi_load(path, &picture.width, &picture.height, &channels, 4);
    if (picture.rgba == NULL) {
        fail_msg("%s: %s", path, stbi_failure_reason());
    }
    return picture;
}

#ifdef SVOCL_EXR

#define SUCCEED(call) assert_int_equal(call, EXR_ERR_SUCCESS)

static void read_chunk(exr_context_t exr, int32_t row, int32_t width, float *out, exr_decode_pipeline_t *decoder)
{
    exr_chunk_info_t chunk;
    SUCCEED(exr_read_scanline_chunk_info(exr, 0, row, &chunk));
    SUCCEED(row == 0 ? exr_decoding_initialize(exr, 0, &chunk, decoder) : exr_decoding_update(exr, 0, &chunk, decoder));
    for (int k = 0; k < decoder->channel_count; ++k) {
        exr_coding_channel_info_t *to = &decoder->channels[k];
        to->user_bytes_per_element = sizeof(float);
        to->user_data_type = EXR_PIXEL_FLOAT;
        to->user_pixel_stride = 4 * (int32_t)sizeof(float);
        to->user_line_stride = width * to->user_pixel_stride;
        to->decode_to_ptr =
            (uint8_t *)(out + 4 * (size_t)width * (size_t)row + (strchr("RGBA", to->channel_name[0]) - "RGBA"));
    }
    if (row == 0) {
        SUCCEED(exr_decoding_choose_default_routines(exr, 0, decoder));
    }
    SUCCEED(exr_decoding_run(exr, 0, decoder));
}

static float *read_exr(const char *path, int *width, int *height)
{
    exr_context_t exr = NULL;
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_decode_pipeline_t decoder = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_attr_box2i_t window;
    int32_t rows = 0;
    SUCCEED(exr_start_read(&exr, path, &how));
    SUCCEED(exr_get_data_window(exr, 0, &window));
    SUCCEED(exr_get_scanlines_per_chunk(exr, 0, &rows));
    *width = window.max.x + 1;
    *height = window.max.y + 1;
    const size_t count = 4 * (size_t)*width * (size_t)*height;
    float *out = malloc(count * sizeof *out);
    assert_non_null(out);
    for (size_t i = 0; i < count; ++i) {
        out[i] = 1;
    }
    for (int32_t row = 0; row < *height; row += rows) {
        read_chunk(exr, row, *width, out, &decoder);
    }
    SUCCEED(exr_decoding_destroy(exr, &decoder));
    SUCCEED(exr_finish(&exr));
    return out;
}

#endif

float *read_light(const char *path, int *width, int *height)
{
    int channels = 0;
#ifdef SVOCL_EXR
    if (strstr(path, ".exr") != NULL) {
        return read_exr(path, width, height);
    }
#endif
    float *out = stbi_loadf(path, width, height, &channels, 4);
    if (out == NULL) {
        fail_msg("%s: %s", path, stbi_failure_reason());
    }
    return out;
}

void free_picture(program_picture *picture)
{
    stbi_image_free(picture->rgba);
    picture->rgba = NULL;
}

const uint8_t *pixel_of(const program_picture *picture, int x, int y)
{
    return picture->rgba + 4 * ((size_t)y * (size_t)picture->width + (size_t)x);
}

double mean_of(const program_picture *picture)
{
    const size_t count = (size_t)picture->width * (size_t)picture->height;
    double sum = 0;
    for (size_t i = 0; i < count; ++i) {
        const uint8_t *pixel = picture->rgba + 4 * i;
        sum += pixel[0] + pixel[1] + pixel[2];
    }
    return sum / (3 * (double)count);
}

double take_brightness(const char *path)
{
    program_picture picture = read_picture(path);
    const double mean = mean_of(&picture);
    free_picture(&picture);
    assert_int_equal(remove(path), 0);
    return mean;
}
