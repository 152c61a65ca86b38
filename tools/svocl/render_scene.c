/* SPDX-License-Identifier: MIT */
/* Renders a scene of many placed trees, which it holds as they were built or in a compact form. */
#include "svocl/render_scene.h"

#include <stdlib.h>

#include "support/compact_input.h"
#include "support/job.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/scene_file.h"
#include "support/table.h"
#include "support/viewpoint.h"

/* The directory of compact trees in SVO_FORM_IMPLIED, which must be the same in all of a scene. */
#define DIRECTORY_STEP_LOG2 5u

typedef struct scene_render {
    program *state;
    const char *path; /* of the scene's file */
    scene_file file;
    session opened;
    svo_tree **trees; /* file.tree_count, like compacts, and NULL where the other is there */
    svo_compact **compacts;
    svo_scene *scene;
    svo_scene_info info;
    svo_camera camera;
    double render_ms;
} scene_render;

/* ---- trees ---- */

static int load_tree(scene_render *work, size_t index)
{
    const int exit_code = input_load_tree(work->state, &work->trees[index]);
    return exit_code == PROGRAM_DONE &&
                   svo_tree_upload(work->trees[index], work->opened.device, work->opened.queue) != SVO_OK
               ? program_fail_library(work->state, svo_device_message(work->opened.device))
               : exit_code;
}

static int build_tree(scene_render *work, size_t index)
{
    job one = {.opened = work->opened};
    int exit_code = input_open(work->state, &one.source);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = job_build(work->state, picture_need(&one.source, work->state->options.need), &one);
    work->opened = one.opened; /* the front end is chosen by the first build */
    work->trees[index] = one.result.tree;
    free(one.result.buffers);
    input_close(&one.source);
    return exit_code;
}

/* The input and the depth of each tree stand in for the command line's. */
static int make_tree(scene_render *work, size_t index)
{
    const scene_file_tree *tree = &work->file.trees[index];
    options *given = &work->state->options;
    const options before = *given;
    given->input = tree->path;
    given->depth = tree->depth > 0 ? tree->depth : given->depth;
    const int exit_code = input_is_tree(work->state) ? load_tree(work, index) : build_tree(work, index);
    *given = before;
    return exit_code;
}

/* ---- compact trees ---- */

static bool has_form(const scene_render *work, const svo_compact *compact)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    return svo_compact_get_info(compact, &info) == SVO_OK && (int)info.form == work->file.form &&
           (info.form != SVO_FORM_IMPLIED || info.directory_step_log2 == DIRECTORY_STEP_LOG2);
}

/* A file of the scene's form is used as it is: it may be minimized, or a solid. For another one nothing is loaded. */
static int load_compact(scene_render *work, size_t index)
{
    svo_message message = {""};
    svo_compact **out = &work->compacts[index];
    if (svo_compact_load(work->file.trees[index].path, NULL, out, &message) != SVO_OK) {
        return program_fail_library(work->state, message.text);
    }
    if (!has_form(work, *out)) {
        svo_compact_destroy(out);
        return PROGRAM_DONE;
    }
    return svo_compact_upload(*out, work->opened.device, work->opened.queue) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(work->state, svo_device_message(work->opened.device));
}

static int make_compact(scene_render *work, size_t index)
{
    const svo_compact_options asked = {
        .struct_size = sizeof asked, .form = (svo_form)work->file.form, .directory_step_log2 = DIRECTORY_STEP_LOG2};
    int exit_code = compact_input_is_name(work->file.trees[index].path) ? load_compact(work, index) : PROGRAM_DONE;
    if (exit_code != PROGRAM_DONE || work->compacts[index] != NULL) {
        return exit_code;
    }
    exit_code = make_tree(work, index);
    if (exit_code == PROGRAM_DONE && svo_compact_create(work->opened.device, work->trees[index], &asked,
                                                        work->opened.queue, &work->compacts[index]) != SVO_OK) {
        exit_code = program_fail_library(work->state, svo_device_message(work->opened.device));
    }
    svo_tree_destroy(&work->trees[index]);
    return exit_code;
}

/* Whether nodes of a compact tree differ in payload, so that it has places of it. */
static bool has_places(const svo_compact *compact)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    (void)svo_compact_get_info(compact, &info);
    return (info.need & ~info.constant) != 0;
}

/* Compact trees of a scene have all places of payload, or none has. */
static int check_places(const scene_render *work, size_t index)
{
    const scene_file *file = &work->file;
    const bool places = has_places(work->compacts[index]);
    if (places == has_places(work->compacts[0])) {
        return PROGRAM_DONE;
    }
    return json_source_fail(&file->source, file->trees[index].value,
                            "the nodes of tree '%s' are alike in color, normal, material and fill, and those of '%s' "
                            "are not; form '%s' cannot hold both",
                            file->trees[places ? 0 : index].name, file->trees[places ? index : 0].name,
                            scene_file_form_name(file));
}

static int make_trees(scene_render *work)
{
    const size_t count = work->file.tree_count;
    const bool built = work->file.form == SCENE_FILE_BUILT;
    work->trees = calloc(count, sizeof(svo_tree *));
    work->compacts = calloc(count, sizeof(svo_compact *));
    if (work->trees == NULL || work->compacts == NULL) {
        return program_fail(work->state, PROGRAM_FAILED, "out of memory for %zu trees", count);
    }
    int exit_code = session_open(work->state, &work->opened);
    for (size_t i = 0; i < count && exit_code == PROGRAM_DONE; ++i) {
        exit_code = built ? make_tree(work, i) : make_compact(work, i);
        if (exit_code == PROGRAM_DONE && !built) {
            exit_code = check_places(work, i);
        }
    }
    return exit_code;
}

/* ---- the picture ---- */

static int place_trees(scene_render *work)
{
    const bool built = work->file.form == SCENE_FILE_BUILT;
    const svo_scene_options asked = {.struct_size = sizeof asked,
                                     .trees = built ? work->trees : NULL,
                                     .compacts = built ? NULL : work->compacts,
                                     .instances = work->file.instances,
                                     .tree_count = (uint32_t)work->file.tree_count,
                                     .instance_count = (uint32_t)work->file.instance_count};
    progress_step(work->state->progress, "placing the trees");
    if (svo_scene_create(work->opened.device, &asked, work->opened.queue, &work->scene) != SVO_OK) {
        return scene_file_fail_library(&work->file, svo_device_message(work->opened.device));
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
    if (svo_scene_render(work->scene, &asked, work->opened.queue, rgba) != SVO_OK) {
        exit_code = scene_file_fail_library(&work->file, svo_device_message(work->opened.device));
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
        json_add_text(document, "device", svo_device_name(work->opened.device));
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
    for (size_t i = 0; i < work->file.tree_count && work->trees != NULL; ++i) {
        svo_tree_destroy(&work->trees[i]);
    }
    for (size_t i = 0; i < work->file.tree_count && work->compacts != NULL; ++i) {
        svo_compact_destroy(&work->compacts[i]);
    }
    free(work->trees);
    free(work->compacts);
    session_close(&work->opened);
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
    program_begin_progress(state, 3 * (unsigned)work.file.tree_count + 3);
    exit_code = make_trees(&work);
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
