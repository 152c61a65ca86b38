/* SPDX-License-Identifier: MIT */
/* A scene of which a share moves: the last triangles of a mesh are an object, the others the static mesh. */
#ifndef SVOCL_TOOLS_BENCH_MOVING_SCENE_H
#define SVOCL_TOOLS_BENCH_MOVING_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/svocl.h"

typedef struct moving_scene {
    svo_mesh fixed, object; /* views of the mesh */
    uint32_t *indices; /* owned; of the object */
    svo_moving_options options; /* need: the caller may set it between cut and open */
    svo_moving *moving; /* owned */
    double step; /* world units that the object moves: half a voxel */
} moving_scene;

/* Cuts a mesh, which has indices, by area. False when memory runs out; moving_scene_release either way. The others are
   false when the library fails. */
bool moving_scene_cut(const svo_mesh *mesh, double share, unsigned depth, moving_scene *scene);
bool moving_scene_open(svo_device *device, unsigned depth, cl_command_queue queue, moving_scene *scene);
/* Moves the object, there in odd rounds, back in even ones, and updates. report: NULL allowed. */
bool moving_scene_update(moving_scene *scene, size_t round, svo_moving_report *report);
/* A full build of the scene's mesh, with the update's grid, need and unit of weight. */
bool moving_scene_build(const moving_scene *scene, svo_device *device, svo_frontend *frontend, unsigned depth,
                        cl_command_queue queue, svo_tree **tree);
void moving_scene_release(moving_scene *scene);

#endif
