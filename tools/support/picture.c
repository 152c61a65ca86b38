/* SPDX-License-Identifier: MIT */
/* Chooses payload, and writes PNG through stb. */
#include "support/picture.h"

#include <stb/stb_image_write.h>

#include "support/output.h"

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

static void write_bytes(void *user, void *bytes, int byte_count)
{
    output_write(user, bytes, (size_t)byte_count);
}

int picture_write_as(program *state, const char *path, uint32_t width, uint32_t height, const uint8_t *rgba)
{
    output_file file;
    const int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (stbi_write_png_to_func(write_bytes, &file, (int)width, (int)height, 4, rgba, (int)width * 4) == 0) {
        output_abandon(&file);
        return program_fail(state, PROGRAM_FAILED, "%s: out of memory for the picture", path);
    }
    return output_commit(state, &file);
}

int picture_write(program *state, const uint8_t *rgba)
{
    const options *given = &state->options;
    progress_step(state->progress, "writing the picture");
    return picture_write_as(state, given->output_path, given->width, given->height, rgba);
}
