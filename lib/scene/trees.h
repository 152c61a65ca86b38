/* SPDX-License-Identifier: MIT */
/* The trees of a scene, built or compact: what the scene copies of them into its buffers, one after the other. */
#ifndef SVO_LIB_SCENE_TREES_H
#define SVO_LIB_SCENE_TREES_H

#include "scene/handle.h"

/* An array that is copied. */
typedef struct svo_i_source_array {
    cl_mem buffer; /* NULL: none */
    uint64_t bytes;
} svo_i_source_array;

typedef struct svo_i_scene_source {
    svo_ray_params params;
    const char *form; /* the options that select the reader of its nodes; "" for a built tree */
    svo_i_source_array nodes[3]; /* what SVO_NODES_PARAMETERS declares */
    svo_i_source_array colors, normals; /* as far as the scene takes them: of all nodes, or one for all */
    bool one_color, one_normal, packed_colors, packed_normals;
    svo_i_source_array ray_nodes, ray_leaves; /* with SVO_NEED_RAYS */
    bool empty; /* without leaves */
    double origin[3], width; /* of the grid, world */
} svo_i_scene_source;

/* Where the trees go, and how much they take. */
typedef struct svo_i_arena {
    uint32_t tree_count;
    svo_i_scene_source *sources; /* owned, like the next two; tree_count each */
    svo_scene_tree *places;
    svo_ray_params *params;
    uint64_t bytes[SVO_I_SCENE_BUFFERS]; /* of the trees' buffers; 0 elsewhere */
    bool is_packed; /* some tree has packed payload */
} svo_i_arena;

/* Checks the trees and lays them out. The caller frees *out in either case. */
svo_status svo_i_arena_plan(svo_device *device, const char *function, const svo_scene_options *options,
                            svo_i_arena *out);
void svo_i_arena_free(svo_i_arena *arena);

/* Copies the trees into the scene's buffers, and finds the boxes of their occupied parts. Waits. */
svo_status svo_i_arena_fill(const svo_i_arena *arena, svo_scene *scene, const char *function, cl_command_queue queue);

#endif
