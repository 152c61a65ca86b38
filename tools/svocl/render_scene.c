/* SPDX-License-Identifier: MIT */
/* Renders a scene of many placed trees, which it holds as they were built or in a compact form. */
#include "svocl/render_scene.h"

#include <stdlib.h>

#include "support/input.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/scene_file.h"
#include "support/scene_trees.h"
#include "support/table.h"
#include "support/viewpoint.h"

typedef struct scene_render {
    program *state;
    const char *path; /* of the scene's file */
    scene_file file;
    scene_trees trees;
    svo_scene *scene;
    svo_scene_info info;
    svo_camera camera;
    double render_ms;
} scene_render;

/* ---- the picture ---- */

static int place_trees(scene_render *work)
{
    const svo_scene_options asked = scene_trees_place(&work->trees, work->file.instances, work->file.instance_count);
    progress_step(work->state->progress, "placing the trees");
    if (svo_scene_create(work->trees.opened.device, &asked, work->trees.opened.queue, &work->scene) != SVO_OK) {
        return scene_file_fail_library(&work->file, svo_device_message(work->trees.opened.device));
    }
    work->info = (svo_scene_info)SVO_SCENE_INFO_INIT;
    (void)svo_scene_get_info(work->scene, &work->info);
    return PROGRAM_DONE;
}

static int draw(scene_render *work)
{
    const options *given = &work->state->options;
    svo_scene_render_options asked = {.struct_size = sizeof asked,
                                      .width = given->width,
                                      .height = given->height,
                                      .camera = work->file.camera,
                                      .lights = work->file.lights,
                                      .light_count = (uint32_t)work->file.light_count,
                                      .occlusion_range = work->file.occlusion_range};
    if (!work->file.has_camera) {
        svo_scene_camera_frame(work->scene, (float)given->width / (float)given->height, &asked.camera);
    }
    int exit_code = viewpoint_apply(work->state, !work->file.has_camera, &asked.camera);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    work->camera = asked.camera;
    uint8_t *rgba = malloc((size_t)given->width * given->height * 4);
    if (rgba == NULL) {
        return program_fail(work->state, PROGRAM_FAILED, "out of memory for %ux%u pixels", given->width, given->height);
    }
    progress_step(work->state->progress, "casting rays");
    const double started_ms = input_now_ms();
    if (svo_scene_render(work->scene, &asked, work->trees.opened.queue, rgba) != SVO_OK) {
        exit_code = scene_file_fail_library(&work->file, svo_device_message(work->trees.opened.device));
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
    if (given->json) {
        cJSON *document = json_document();
        json_add_text(document, "input", work->path);
        json_add_text(document, "file", given->output_path);
        json_add_count(document, "width", given->width);
        json_add_count(document, "height", given->height);
        json_add_text(document, "form", scene_file_form_name(&work->file));
        json_add_count(document, "trees", work->info.tree_count);
        json_add_count(document, "instances", work->info.instance_count);
        json_add_count(document, "device_bytes", work->info.total_bytes);
        cJSON_AddNumberToObject(document, "render_ms", work->render_ms);
        json_add_text(document, "device", svo_device_name(work->trees.opened.device));
        cJSON_AddItemToObject(document, "eye", cJSON_CreateFloatArray(work->camera.eye, 3));
        cJSON_AddItemToObject(document, "target", cJSON_CreateFloatArray(work->camera.target, 3));
        return json_print(work->state, document);
    }
    if (!given->quiet) {
        progress_hide(work->state->progress);
        table_line("%s: %ux%u pixels of %u instances of %u trees in %s", output_name(given->output_path), given->width,
                   given->height, work->info.instance_count, work->info.tree_count, figure_ms(work->render_ms).text);
    }
    return PROGRAM_DONE;
}

static void release(scene_render *work)
{
    svo_scene_destroy(&work->scene);
    scene_trees_close(&work->trees);
    scene_file_close(&work->file);
}

int render_scene(program *state)
{
    scene_render work = {.state = state, .path = state->options.input};
    if (state->options.view != (int)SVO_VIEW_SHADED) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --view does not apply to a scene");
    }
    int exit_code = scene_file_open(state, work.path, &work.file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    program_begin_progress(state, SCENE_TREES_STEPS * (unsigned)work.file.tree_count + 3);
    exit_code = scene_trees_open(state, &work.file, &work.trees);
    if (exit_code == PROGRAM_DONE) {
        exit_code = place_trees(&work);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = draw(&work);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(&work);
    }
    release(&work);
    return exit_code;
}
