/* SPDX-License-Identifier: MIT */
/*
 * The scene's fields, for the files of this room.
 *
 * The room, each file after those that it uses:
 *   handle      this: the fields
 *   trees       the trees of a scene in common buffers, and the boxes of what they occupy
 *   hierarchy   the hierarchy over the instances' boxes
 *   scene       plan, creation, instances and their changes
 *   rays        rays through a scene, and pictures
 */
#ifndef SVO_LIB_SCENE_HANDLE_H
#define SVO_LIB_SCENE_HANDLE_H

#include "core/program.h"
#include "core/work.h"
#include "shared/scene_layout.h"
#include "svocl/scene.h"

/* The buffers. The first ones are the arguments that SVO_SCENE_PARAMETERS declares, in order; built trees have two
   arrays of nodes, compact ones three. */
typedef enum svo_i_scene_buffer {
    SVO_I_SCENE_NODES_0 = 0, /* as SVO_NODES_PARAMETERS of kernels/rays/read.clh */
    SVO_I_SCENE_NODES_1,
    SVO_I_SCENE_NODES_2,
    SVO_I_SCENE_RAY_NODES, /* of triangles; like the leaves, for SVO_NEED_RAYS */
    SVO_I_SCENE_RAY_LEAVES,
    SVO_I_SCENE_TREE_PARAMS,
    SVO_I_SCENE_TREES,
    SVO_I_SCENE_INSTANCES,
    SVO_I_SCENE_HIERARCHY, /* none for one instance */
    SVO_I_SCENE_ARGUMENT_BUFFERS,

    SVO_I_SCENE_COLORS = SVO_I_SCENE_ARGUMENT_BUFFERS,
    SVO_I_SCENE_NORMALS,
    SVO_I_SCENE_BOUNDS, /* of the trees */
    SVO_I_SCENE_PARENTS, /* of instances, in the hierarchy */
    SVO_I_SCENE_ARRIVALS, /* at its nodes, while they are refit */
    SVO_I_SCENE_WIDE, /* the hierarchy with eight children to a node, in place of the other for rays; for CPUs */
    SVO_I_SCENE_LIST, /* of Morton codes; like the rest, for the sort */
    SVO_I_SCENE_SPARE,
    SVO_I_SCENE_COUNTS,
    SVO_I_SCENE_BEFORE,
    SVO_I_SCENE_PARTIALS,
    SVO_I_SCENE_BUFFERS
} svo_i_scene_buffer;
#define SVO_I_SCENE_NODE_BUFFERS 3

/* What instances need of a tree on the host: the box of its occupied part, in its world. */
typedef struct svo_i_scene_box {
    double low[3], high[3];
    double leaf_edge; /* of the tree, in its world */
} svo_i_scene_box;

/* The box of an instance in the world. */
typedef struct svo_i_instance_box {
    float low[3], high[3];
    float leaf_edge; /* its longest edge of a leaf */
} svo_i_instance_box;

struct svo_scene {
    svo_device *device;
    const char *form; /* the options that select how nodes are read; static */
    bool is_clear; /* some tree shows in part */
    bool is_packed; /* some tree has packed colors or normals */
    cl_uint node_buffers; /* 2 or SVO_I_SCENE_NODE_BUFFERS: the arrays that the form has */
    svo_scene_info info; /* low and high are kept up to date */
    cl_mem buffers[SVO_I_SCENE_BUFFERS]; /* owned; NULL where the scene needs none */
    svo_i_scene_box *tree_boxes; /* tree_count */
    uint32_t *tree_of; /* instance_count */
    svo_i_instance_box *boxes; /* instance_count */
    svo_scene_params params; /* of the last refit */
    bool lost; /* a command failed halfway: nothing is defined any more */
};

/* Refuses a scene whose content is lost. */
static inline svo_status svo_i_scene_check(const svo_scene *scene, const char *function)
{
    return scene->lost ? svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                           "%s: an earlier change of the scene failed halfway", function)
                       : SVO_OK;
}

/* What rays of probes' texels see of the voxels of a scene that is_clear, by alpha (kernels/scene/see.cl): an
   svo_scene_hit for each. */
svo_status svo_i_scene_see(const svo_scene *scene, svo_i_device_work *work, cl_mem rays, cl_mem hits,
                           uint32_t ray_count);

#endif
