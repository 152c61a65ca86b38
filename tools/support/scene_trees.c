/* SPDX-License-Identifier: MIT */
/* Trees of scenes, built, loaded, or made compact. */
#include "support/scene_trees.h"

#include <stdlib.h>

#include "support/input.h"
#include "support/job.h"
#include "support/picture.h"
#include "support/tree_form.h"
#include "support/viewpoint.h"

/* ---- trees ---- */

static int load_tree(scene_trees *work, size_t index)
{
    const int exit_code = input_load_tree(work->running, &work->trees[index]);
    return exit_code == PROGRAM_DONE &&
                   svo_tree_upload(work->trees[index], work->opened.device, work->opened.queue) != SVO_OK
               ? program_fail_library(work->running, svo_device_message(work->opened.device))
               : exit_code;
}

/* A voxel file has its own depth, unless the scene's file names one, and takes no options of meshes. */
static int open_voxels(scene_trees *work, size_t index, input *source)
{
    program *running = work->running;
    *source = (input){.name = running->options.input};
    running->options.has_depth = work->file->trees[index].depth > 0;
    progress_step(running->progress, "reading the voxels");
    return voxel_input_open(running, &source->voxels);
}

/* The svo_need bits of a build. */
static uint32_t need_of(const scene_trees *work, const input *source)
{
    const uint32_t of_voxels = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_NONE;
    const uint32_t asked = work->running->options.need;
    return source->mesh != NULL ? picture_need(source, asked) : asked & of_voxels;
}

static int build_tree(scene_trees *work, size_t index)
{
    job one = {.opened = work->opened};
    int exit_code = voxel_input_is_given(work->running) ? open_voxels(work, index, &one.source)
                                                        : input_open(work->running, &one.source);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = job_build(work->running, need_of(work, &one.source), &one);
    work->opened = one.opened; /* the front end is chosen by the first build */
    work->trees[index] = one.result.tree;
    free(one.result.buffers);
    input_close(&one.source);
    return exit_code;
}

/* The input and the depth of each tree stand in for the command line's. */
static int make_tree(scene_trees *work, size_t index)
{
    const scene_file_tree *tree = &work->file->trees[index];
    options *given = &work->running->options;
    const options before = *given;
    given->input = tree->path;
    given->depth = tree->depth > 0 ? tree->depth : given->depth;
    given->voxel_size = tree->depth > 0 ? 0.0 : given->voxel_size;
    const int exit_code = input_is_tree(work->running) ? load_tree(work, index) : build_tree(work, index);
    *given = before;
    return exit_code;
}

/* ---- compact trees ---- */

/* The form of the file, or of --tree-form, which has taken its place there. */
static svo_compact_options compact_options(const scene_trees *work)
{
    options given = work->running->options;
    given.tree_form = 1 + work->file->form;
    return tree_form_options(&given);
}

/* A file of the scene's form is used as it is: it may be minimized, a solid, or packed. For another one nothing is
   loaded. */
static int load_compact(scene_trees *work, size_t index)
{
    svo_compact **out = &work->compacts[index];
    const svo_compact_options asked = compact_options(work);
    const int exit_code = compact_input_load(work->running, svo_from_path(work->file->trees[index].path), out);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (!tree_form_fits(*out, &asked)) {
        svo_compact_destroy(out);
        return PROGRAM_DONE;
    }
    return svo_compact_upload(*out, work->opened.device, work->opened.queue) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(work->running, svo_device_message(work->opened.device));
}

static int make_compact(scene_trees *work, size_t index)
{
    const svo_compact_options asked = compact_options(work);
    int exit_code = compact_input_is_name(work->file->trees[index].path) ? load_compact(work, index) : PROGRAM_DONE;
    if (exit_code != PROGRAM_DONE || work->compacts[index] != NULL) {
        return exit_code;
    }
    exit_code = make_tree(work, index);
    if (exit_code == PROGRAM_DONE && svo_compact_create(work->opened.device, work->trees[index], &asked,
                                                        work->opened.queue, &work->compacts[index]) != SVO_OK) {
        exit_code = program_fail_library(work->running, svo_device_message(work->opened.device));
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
static int check_places(const scene_trees *work, size_t index)
{
    const scene_file *file = work->file;
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

/* ---- all of them ---- */

static int make_trees(scene_trees *work)
{
    const size_t count = work->file->tree_count;
    const bool built = work->file->form == SCENE_FILE_BUILT;
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; i < count && exit_code == PROGRAM_DONE; ++i) {
        exit_code = built ? make_tree(work, i) : make_compact(work, i);
        if (exit_code == PROGRAM_DONE && !built) {
            exit_code = check_places(work, i);
        }
    }
    return exit_code;
}

int scene_trees_open(program *state, const scene_file *file, scene_trees *out)
{
    const size_t count = file->tree_count;
    *out = (scene_trees){.running = state, .file = file};
    out->trees = calloc(count, sizeof(svo_tree *));
    out->compacts = calloc(count, sizeof(svo_compact *));
    if (out->trees == NULL || out->compacts == NULL) {
        scene_trees_close(out);
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu trees", count);
    }
    int exit_code = session_open(state, &out->opened);
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_trees(out);
    }
    if (exit_code != PROGRAM_DONE) {
        scene_trees_close(out);
    }
    return exit_code;
}

void scene_trees_close(scene_trees *which)
{
    for (size_t i = 0; which->trees != NULL && i < which->file->tree_count; ++i) {
        svo_tree_destroy(&which->trees[i]);
    }
    for (size_t i = 0; which->compacts != NULL && i < which->file->tree_count; ++i) {
        svo_compact_destroy(&which->compacts[i]);
    }
    free(which->trees);
    free(which->compacts);
    session_close(&which->opened);
    *which = (scene_trees){.trees = NULL};
}

svo_scene_options scene_trees_place(const scene_trees *which, const svo_instance *instances, size_t instance_count)
{
    const bool built = which->file->form == SCENE_FILE_BUILT;
    return (svo_scene_options){.struct_size = sizeof(svo_scene_options),
                               .trees = built ? which->trees : NULL,
                               .compacts = built ? NULL : which->compacts,
                               .instances = instances,
                               .tree_count = (uint32_t)which->file->tree_count,
                               .instance_count = (uint32_t)instance_count};
}

/* ---- the scene ---- */

static int place_trees(program *state, device_scene *which)
{
    const svo_scene_options asked = scene_trees_place(&which->trees, which->file.instances, which->file.instance_count);
    progress_step(state->progress, "placing the trees");
    return svo_scene_create(which->trees.opened.device, &asked, which->trees.opened.queue, &which->scene) == SVO_OK
               ? PROGRAM_DONE
               : scene_file_fail_library(&which->file, svo_device_message(which->trees.opened.device));
}

int device_scene_open(program *state, unsigned further_steps, device_scene *out)
{
    *out = (device_scene){.scene = NULL};
    int exit_code = scene_file_open(state, state->options.input, &out->file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    program_begin_progress(state, SCENE_TREES_STEPS * (unsigned)out->file.tree_count + 1 + further_steps);
    exit_code = scene_trees_open(state, &out->file, &out->trees);
    if (exit_code == PROGRAM_DONE) {
        exit_code = place_trees(state, out);
    }
    if (exit_code != PROGRAM_DONE) {
        device_scene_close(out);
    }
    return exit_code;
}

void device_scene_close(device_scene *which)
{
    svo_scene_destroy(&which->scene);
    scene_trees_close(&which->trees);
    scene_file_close(&which->file);
}

int device_scene_camera(program *state, const device_scene *which, svo_camera *camera)
{
    const viewpoint_subject shown = {.camera = which->file.has_camera ? &which->file.camera : NULL,
                                     .target = svo_scene_target(which->scene),
                                     .aspect = viewpoint_aspect(state)};
    return viewpoint_place(state, &shown, camera);
}
