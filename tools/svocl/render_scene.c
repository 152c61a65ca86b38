/* SPDX-License-Identifier: MIT */
/* Renders a scene of many placed trees, which it holds as they were built or in a compact form. */
#include "svocl/render.h"

#include "support/picture.h"
#include "support/scene_trees.h"
#include "support/table.h"

typedef struct scene_render {
    program *state;
    device_scene placed;
    svo_camera camera;
    double render_ms;
} scene_render;

/* ---- the picture ---- */

static int draw(void *user, const svo_camera *camera, const svo_picture_output *output, uint8_t *pixels)
{
    const scene_render *work = user;
    const options *given = &work->state->options;
    const scene_file *file = &work->placed.file;
    const session *opened = &work->placed.trees.opened;
    const svo_render_options asked = {.struct_size = sizeof asked,
                                      .width = given->width,
                                      .height = given->height,
                                      .camera = *camera,
                                      .lights = file->lights,
                                      .light_count = (uint32_t)file->light_count,
                                      .occlusion_range = file->occlusion_range,
                                      .output = *output};
    return svo_render(svo_scene_target(work->placed.scene), &asked, svo_in_host(pixels),
                      &(svo_submit){.queue = opened->queue}) == SVO_OK
               ? PROGRAM_DONE
               : scene_file_fail_library(file, svo_device_message(opened->device));
}

static int report(const scene_render *work)
{
    const options *given = &work->state->options;
    svo_scene_info info = SVO_SCENE_INFO_INIT;
    (void)svo_scene_get_info(work->placed.scene, &info);
    if (given->json) {
        cJSON *document = picture_document(work->state);
        json_add_text(document, "form", scene_file_form_name(&work->placed.file));
        json_add_count(document, "trees", info.tree_count);
        json_add_count(document, "instances", info.instance_count);
        json_add_count(document, "device_bytes", info.total_bytes);
        return picture_print_document(work->state, document, work->render_ms, work->placed.trees.opened.device,
                                      &work->camera);
    }
    if (!given->quiet) {
        progress_hide(work->state->progress);
        table_line("%s of %u instances of %u trees in %s", picture_describe(given).text, info.instance_count,
                   info.tree_count, figure_ms(work->render_ms).text);
    }
    return PROGRAM_DONE;
}

int render_scene(program *state)
{
    scene_render work = {.state = state};
    if (state->options.view != (int)SVO_VIEW_SHADED) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --view does not apply to a scene");
    }
    int exit_code = device_scene_open(state, 1 + picture_frames(&state->options), &work.placed);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = device_scene_camera(state, &work.placed, &work.camera);
    if (exit_code == PROGRAM_DONE) {
        exit_code = picture_draw(state, "casting rays", &work.camera, draw, &work, &work.render_ms);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(&work);
    }
    device_scene_close(&work.placed);
    return exit_code;
}
