/* SPDX-License-Identifier: MIT */
/* The trees of a scene in its buffers, one after the other. */
#ifndef SVO_LIB_SCENE_ARENA_H
#define SVO_LIB_SCENE_ARENA_H

#include "scene/state.h"

/* Where the trees go, and how much they take. */
typedef struct svo_i_arena {
    svo_tree *const *trees;
    uint32_t tree_count;
    uint32_t need; /* svo_need bits that are copied */
    svo_scene_tree *places; /* owned */
    svo_ray_params *params; /* owned */
    uint64_t bytes[SVO_I_SCENE_BUFFERS]; /* of the trees' buffers; 0 elsewhere */
} svo_i_arena;

/* Checks the trees and lays them out. With SVO_NEED_RAYS it makes their BVHs. The caller frees *out in either case. */
svo_status svo_i_arena_plan(svo_device *device, const char *function, const svo_scene_options *options,
                            svo_i_arena *out);
void svo_i_arena_free(svo_i_arena *arena);

/* Copies the trees into the scene's buffers, and finds the boxes of their occupied parts. Waits. */
svo_status svo_i_arena_fill(const svo_i_arena *arena, svo_scene *scene, const char *function, cl_command_queue queue);

#endif
