/* SPDX-License-Identifier: MIT */
/* The hierarchy over the instances' boxes, built and refit on the device. */
#ifndef SVO_LIB_SCENE_HIERARCHY_H
#define SVO_LIB_SCENE_HIERARCHY_H

#include "scene/handle.h"

/* Adds the bytes of the hierarchy's and of the sort's buffers for so many instances. */
void svo_i_hierarchy_plan(const svo_device *device, uint32_t instance_count, uint64_t bytes[SVO_I_SCENE_BUFFERS]);

/* Builds the hierarchy from the instances on the device, whose boxes scene->boxes has too, and refits it. Waits. */
svo_status svo_i_hierarchy_build(svo_scene *scene, const char *function, cl_command_queue queue);
/* Finds the boxes of the nodes again. Waits. */
svo_status svo_i_hierarchy_refit(svo_scene *scene, const char *function, cl_command_queue queue);

#endif
