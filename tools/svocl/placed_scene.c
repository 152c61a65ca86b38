/* SPDX-License-Identifier: MIT */
/* Placed trees and their camera. */
#include "svocl/placed_scene.h"

#include "support/viewpoint.h"

static int place_trees(program *state, placed_scene *which)
{
    const svo_scene_options asked = scene_trees_place(&which->trees, which->file.instances, which->file.instance_count);
    progress_step(state->progress, "placing the trees");
    return svo_scene_create(which->trees.opened.device, &asked, which->trees.opened.queue, &which->scene) == SVO_OK
               ? PROGRAM_DONE
               : scene_file_fail_library(&which->file, svo_device_message(which->trees.opened.device));
}

int placed_scene_open(program *state, unsigned further_steps, placed_scene *out)
{
    *out = (placed_scene){.scene = NULL};
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
        placed_scene_close(out);
    }
    return exit_code;
}

void placed_scene_close(placed_scene *which)
{
    svo_scene_destroy(&which->scene);
    scene_trees_close(&which->trees);
    scene_file_close(&which->file);
}

int placed_scene_camera(program *state, const placed_scene *which, svo_camera *camera)
{
    const viewpoint_subject shown = {.camera = which->file.has_camera ? &which->file.camera : NULL,
                                     .scene = which->scene,
                                     .aspect = viewpoint_aspect(state)};
    return viewpoint_place(state, &shown, camera);
}
