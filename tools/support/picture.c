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

cJSON *picture_document(const program *state)
{
    const options *given = &state->options;
    cJSON *document = json_document();
    json_add_text(document, "input", given->input);
    json_add_text(document, "file", given->output_path);
    json_add_count(document, "width", given->width);
    json_add_count(document, "height", given->height);
    return document;
}

int picture_print_document(program *state, cJSON *document, double render_ms, const svo_device *device,
                           const svo_camera *camera)
{
    cJSON_AddNumberToObject(document, "render_ms", render_ms);
    json_add_text(document, "device", svo_device_name(device));
    cJSON_AddItemToObject(document, "eye", cJSON_CreateFloatArray(camera->eye, 3));
    cJSON_AddItemToObject(document, "target", cJSON_CreateFloatArray(camera->target, 3));
    return json_print(state, document);
}
