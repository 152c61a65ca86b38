/* SPDX-License-Identifier: MIT */
/* A scene as a JSON file: trees by path, placed instances, camera, lights. docs/scenes.md describes the format. */
#ifndef SVOCL_TOOLS_SUPPORT_SCENE_FILE_H
#define SVOCL_TOOLS_SUPPORT_SCENE_FILE_H

#include "support/program.h"
#include "svocl/svocl.h"

#define SCENE_FILE_PATH_BYTES 4096

/* One of the file's trees. */
typedef struct scene_file_tree {
    char name[64]; /* in the file */
    char path[SCENE_FILE_PATH_BYTES]; /* of a .svo file or a mesh, from where the program runs; or scene:... */
    unsigned depth; /* for a mesh; 0: not given */
} scene_file_tree;

typedef struct scene_file {
    scene_file_tree *trees;
    size_t tree_count;
    svo_instance *instances;
    size_t instance_count, instance_capacity;
    svo_camera camera;
    bool has_camera;
    svo_scene_light lights[SVO_SCENE_LIGHTS_MAX];
    size_t light_count;
    float occlusion_range; /* 0: not given */
} scene_file;

/* Whether INPUT is such a file, by its suffix. */
bool scene_file_is_input(const program *state);

/* Reads and checks the file. Returns the exit code; on failure nothing stays open. */
int scene_file_open(program *state, const char *path, scene_file *out);
void scene_file_close(scene_file *file);

#endif
