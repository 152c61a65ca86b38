/* SPDX-License-Identifier: MIT */
/* What every function of a scene begins with, and what every kernel of rays takes. */
#include "scene/state.h"

svo_status svo_i_scene_check(const svo_scene *scene, const char *function)
{
    return scene->lost ? svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                           "%s: an earlier change of the scene failed halfway", function)
                       : SVO_OK;
}

double svo_i_scene_leaf_edge(const svo_scene *scene)
{
    double least = (double)scene->boxes[0].leaf_edge;
    for (uint32_t i = 1; i < scene->info.instance_count; ++i) {
        const double edge = (double)scene->boxes[i].leaf_edge;
        least = edge < least ? edge : least;
    }
    return least;
}

cl_uint svo_i_scene_arguments(const svo_scene *scene)
{
    return scene->node_buffers + (SVO_I_SCENE_ARGUMENT_BUFFERS - SVO_I_SCENE_NODE_BUFFERS) + 1;
}

svo_status svo_i_scene_set_args(const svo_scene *scene, const char *function, cl_kernel kernel, cl_uint first_index,
                                const svo_scene_params *params)
{
    svo_i_argument arguments[SVO_I_SCENE_ARGUMENT_BUFFERS + 1];
    cl_uint count = 0;
    for (cl_uint i = 0; i < SVO_I_SCENE_ARGUMENT_BUFFERS; ++i) {
        if (i < scene->node_buffers || i >= SVO_I_SCENE_NODE_BUFFERS) {
            arguments[count++] = SVO_I_ARGUMENT(scene->buffers[i]);
        }
    }
    arguments[count++] = (svo_i_argument){sizeof *params, params, false};
    return svo_i_kernel_set_from(scene->device, function, kernel, first_index, arguments, count);
}
