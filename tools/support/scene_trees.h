/* SPDX-License-Identifier: MIT */
/* The trees of a scene's file on a device, as they were built or in the compact form that the file asks for. */
#ifndef SVOCL_TOOLS_SUPPORT_SCENE_TREES_H
#define SVOCL_TOOLS_SUPPORT_SCENE_TREES_H

#include "support/scene_file.h"
#include "support/session.h"

#define SCENE_TREES_STEPS 3u /* of the progress bar, for each tree */

typedef struct scene_trees {
    program *running;
    const scene_file *file; /* the caller's */
    session opened;
    svo_tree **trees; /* file->tree_count, like compacts, and NULL where the other is there */
    svo_compact **compacts;
} scene_trees;

/* Opens the session and builds or loads the trees; SCENE_TREES_STEPS steps of the progress bar for each, at most. file:
   must outlive them. Returns the exit code; on failure nothing stays open. */
int scene_trees_open(program *state, const scene_file *file, scene_trees *out);
void scene_trees_close(scene_trees *which);

/* What places the trees by instances, which stay the caller's. */
svo_scene_options scene_trees_place(const scene_trees *which, const svo_instance *instances, size_t instance_count);

/* The scene of a file on the device, for commands that draw it. */
typedef struct device_scene {
    scene_file file;
    scene_trees trees;
    svo_scene *scene;
} device_scene;

/* Builds or loads the trees of INPUT and places them; begins the progress bar. Returns the exit code; on failure
   nothing stays open. */
int device_scene_open(program *state, unsigned further_steps, device_scene *out);
void device_scene_close(device_scene *which);

/* Where a picture of --size is taken from: the file's camera, or one that frames the scene, moved by the options.
   Returns the exit code. */
int device_scene_camera(program *state, const device_scene *which, svo_camera *camera);

#endif
