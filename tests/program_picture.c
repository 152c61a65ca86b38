/* SPDX-License-Identifier: MIT */
/* Reads PNG files by stb_image. */
#include "program_picture.h"

#include "run_program.h"

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wconversion"
#include <stb/stb_image.h>
#pragma GCC diagnostic error "-Wconversion"

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
