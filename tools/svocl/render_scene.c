/* SPDX-License-Identifier: MIT */
/* Renders a scene of many placed trees, which it holds as they were built or in a compact form. */
#include "svocl/render_scene.h"

#include <stdlib.h>

#include "support/input.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/table.h"
#include "svocl/placed_scene.h"

typedef struct scene_render {
    program *state;
    placed_scene placed;
    svo_camera camera;
    double render_ms;
} scene_render;

/* ---- the picture ---- */

static int draw(scene_render *work)
{
    const options *given = &work->state->options;
    const scene_file *file = &work->placed.file;
    const session *opened = &work->placed.trees.opened;
    const svo_scene_render_options asked = {.struct_size = sizeof asked,
                                            .width = given->width,
                                            .height = given->height,
                                            .camera = work->camera,
                                            .lights = file->lights,
                                            .light_count = (uint32_t)file->light_count,
                                            .occlusion_range = file->occlusion_range};
    int exit_code = PROGRAM_DONE;
    uint8_t *rgba = malloc((size_t)given->width * given->height * 4);
    if (rgba == NULL) {
        return program_fail(work->state, PROGRAM_FAILED, "out of memory for %ux%u pixels", given->width, given->height);
    }
    progress_step(work->state->progress, "casting rays");
    const double started_ms = input_now_ms();
    if (svo_scene_render(work->placed.scene, &asked, opened->queue, rgba) != SVO_OK) {
        exit_code = scene_file_fail_library(file, svo_device_message(opened->device));
    }
    work->render_ms = input_now_ms() - started_ms;
    if (exit_code == PROGRAM_DONE) {
        exit_code = picture_write(work->state, rgba);
    }
    free(rgba);
    return exit_code;
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
        table_line("%s: %ux%u pixels of %u instances of %u trees in %s", output_name(given->output_path), given->width,
                   given->height, info.instance_count, info.tree_count, figure_ms(work->render_ms).text);
    }
    return PROGRAM_DONE;
}

int render_scene(program *state)
{
    scene_render work = {.state = state};
    if (state->options.view != (int)SVO_VIEW_SHADED) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --view does not apply to a scene");
    }
    int exit_code = placed_scene_open(state, 2, &work.placed);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = placed_scene_camera(state, &work.placed, &work.camera);
    if (exit_code == PROGRAM_DONE) {
        exit_code = draw(&work);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(&work);
    }
    placed_scene_close(&work.placed);
    return exit_code;
}
