/* SPDX-License-Identifier: MIT */
#include "light/viewer.h"

#include "light/state.h"

svo_status svo_i_light_set_sources_by(const svo_i_light_viewer *viewer, svo_light *light, const svo_light_setup *setup,
                                      cl_command_queue queue)
{
    light->viewer = viewer;
    const svo_status status = svo_light_set_sources(light, setup, queue);
    light->viewer = NULL;
    return status;
}
