/* SPDX-License-Identifier: MIT */
/* Reads what a scene's file places. */
#include "support/scene_input.h"

#include <stdlib.h>

#include "support/voxel_faces.h"

static int read_voxels(program *state, placed_mesh *out)
{
    svo_tree *tree = NULL;
    int exit_code = input_load_tree(state, &tree);
    if (exit_code == PROGRAM_DONE) {
        exit_code = voxel_faces_make(state, state->options.input, tree, out);
    }
    svo_tree_destroy(&tree);
    return exit_code;
}

/* The tree's path stands in for INPUT. */
static int read_tree(program *state, const scene_file_tree *tree, input *source, placed_mesh *voxels)
{
    const char *before = state->options.input;
    state->options.input = tree->path;
    const int exit_code = input_is_tree(state) ? read_voxels(state, voxels) : input_open(state, source);
    state->options.input = before;
    return exit_code;
}

static int read_trees(program *state, const scene_file *file, scene_input *out)
{
    int exit_code = PROGRAM_DONE;
    out->sources = calloc(file->tree_count, sizeof *out->sources);
    out->voxels = calloc(file->tree_count, sizeof *out->voxels);
    if (out->sources == NULL || out->voxels == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu trees", file->tree_count);
    }
    out->count = file->tree_count;
    for (size_t i = 0; i < file->tree_count && exit_code == PROGRAM_DONE; ++i) {
        exit_code = read_tree(state, &file->trees[i], &out->sources[i], &out->voxels[i]);
    }
    return exit_code;
}

static int place(program *state, const scene_file *file, scene_input *out)
{
    const svo_mesh **parts = calloc(out->count, sizeof *parts);
    if (parts == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu trees", out->count);
    }
    for (size_t i = 0; i < out->count; ++i) {
        parts[i] = out->sources[i].mesh != NULL ? out->sources[i].mesh : &out->voxels[i].mesh;
    }
    const int exit_code = placed_mesh_make(state, file->source.path, parts, out->count, file->instances,
                                           file->instance_count, &out->placed);
    free(parts);
    return exit_code;
}

int scene_input_open(program *state, const scene_file *file, scene_input *out)
{
    *out = (scene_input){.count = 0};
    int exit_code = read_trees(state, file, out);
    if (exit_code == PROGRAM_DONE) {
        exit_code = place(state, file, out);
    }
    if (exit_code != PROGRAM_DONE) {
        scene_input_close(out);
    }
    return exit_code;
}

void scene_input_close(scene_input *opened)
{
    placed_mesh_free(&opened->placed);
    for (size_t i = 0; i < opened->count; ++i) {
        input_close(&opened->sources[i]);
        placed_mesh_free(&opened->voxels[i]);
    }
    free(opened->sources);
    free(opened->voxels);
    *opened = (scene_input){.count = 0};
}
