/* SPDX-License-Identifier: MIT */
/* A scene as a JSON file: trees by path, placed instances, camera, lights. docs/scenes.md describes the format. */
#ifndef SVOCL_TOOLS_SUPPORT_SCENE_FILE_H
#define SVOCL_TOOLS_SUPPORT_SCENE_FILE_H

#include "support/json_source.h"
#include "support/program.h"
#include "support/scene_motion.h"
#include "svocl/svocl.h"

#define SCENE_FILE_PATH_BYTES 4096

/* One of the file's trees. */
typedef struct scene_file_tree {
    char name[64]; /* in the file */
    char path[SCENE_FILE_PATH_BYTES]; /* of a tree, voxels or a mesh, from where the program runs; or scene:... */
    unsigned depth; /* for a mesh or voxels; 0: not given */
    int form; /* that of the scene, unless it names its own */
    const cJSON *value; /* for messages */
} scene_file_tree;

/* Instances that one entry of the file places. */
typedef struct scene_file_entry {
    size_t begin; /* the first instance */
    const cJSON *value; /* for messages: the matrix, else the entry */
} scene_file_entry;

#define SCENE_FILE_BUILT (-1)

typedef struct scene_file {
    json_source source; /* open as long as the scene */
    int form; /* svo_form that all trees are held in; SCENE_FILE_BUILT: as built */
    scene_file_tree *trees;
    size_t tree_count;
    scene_file_entry *entries; /* by ascending begin */
    size_t entry_count;
    svo_instance *instances;
    size_t instance_count, instance_capacity;
    scene_motion *motions; /* of instances that move, by ascending instance */
    size_t motion_count;
    svo_camera camera;
    bool has_camera;
    svo_scene_light lights[SVO_SCENE_LIGHTS_MAX];
    size_t light_count;
    float occlusion_range; /* 0: not given */
} scene_file;

/* Whether INPUT is such a file, by its suffix. */
bool scene_file_is_input(const program *state);

/* Reads and checks the file. path stays the caller's. Returns the exit code; on failure nothing stays open. */
int scene_file_open(program *state, const char *path, scene_file *out);
void scene_file_close(scene_file *file);

/* "built" or the name of the form. */
const char *scene_file_form_name(const scene_file *file);

/* program_fail with what the library says about the scene: "PATH:LINE: words" if it names an instance, else
   "PATH: words". */
int scene_file_fail_library(const scene_file *file, const char *message);

#endif
