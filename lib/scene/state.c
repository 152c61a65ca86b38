/* SPDX-License-Identifier: MIT */
/* What every function of a scene begins with, and what every kernel of rays takes. */
#include "scene/state.h"

svo_status svo_i_scene_check(const svo_scene *scene, const char *function)
{
    return scene->lost ? svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                           "%s: an earlier change of the scene failed halfway", function)
                       : SVO_OK;
}

svo_status svo_i_scene_set_args(const svo_scene *scene, const char *function, cl_kernel kernel,
                                const svo_scene_params *params, const svo_i_argument *others, cl_uint other_count)
{
    svo_i_argument arguments[SVO_I_SCENE_ARGUMENT_BUFFERS + 1 + 8];
    cl_uint count = 0;
    for (; count < SVO_I_SCENE_ARGUMENT_BUFFERS; ++count) {
        arguments[count] = SVO_I_ARGUMENT(scene->buffers[count]);
    }
    arguments[count++] = (svo_i_argument){sizeof *params, params, false};
    for (cl_uint i = 0; i < other_count && count < sizeof arguments / sizeof arguments[0]; ++i) {
        arguments[count++] = others[i];
    }
    return svo_i_kernel_set(scene->device, function, kernel, arguments, count);
}
