/* SPDX-License-Identifier: MIT */
/* A tree of a scene, built or compact: what the scene copies of it. */
#ifndef SVO_LIB_SCENE_SOURCE_H
#define SVO_LIB_SCENE_SOURCE_H

#include "scene/state.h"

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
    bool one_color, one_normal;
    svo_i_source_array ray_nodes, ray_leaves; /* with SVO_NEED_RAYS */
    bool empty; /* without leaves */
    double origin[3], width; /* of the grid, world */
} svo_i_scene_source;

/* Checks and describes a tree of the options. With SVO_NEED_RAYS its BVH is made. */
svo_status svo_i_scene_source_of(svo_device *device, const char *function, const svo_scene_options *options,
                                 uint32_t index, svo_i_scene_source *out);

#endif
