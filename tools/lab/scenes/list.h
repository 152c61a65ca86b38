/* SPDX-License-Identifier: MIT */
/* The scenes, one per file of this folder. */
#ifndef SVOCL_TOOLS_SCENES_LIST_H
#define SVOCL_TOOLS_SCENES_LIST_H

#include "builder.h"

/* The scenes, one file each. */
void scene_atrium(scene_builder *builder, const scene_request *request);
void scene_statue(scene_builder *builder, const scene_request *request);
void scene_knot(scene_builder *builder, const scene_request *request);
void scene_terrain(scene_builder *builder, const scene_request *request);
void scene_needles(scene_builder *builder, const scene_request *request);
void scene_dust(scene_builder *builder, const scene_request *request);
void scene_cornell(scene_builder *builder, const scene_request *request);
void scene_cube(scene_builder *builder, const scene_request *request);

#endif
