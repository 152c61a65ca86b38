/* SPDX-License-Identifier: MIT */
/* What sees for sources in place of the tree's rays: svocl::gl, by rasterization. */
#ifndef SVO_LIB_LIGHT_VIEWER_H
#define SVO_LIB_LIGHT_VIEWER_H

#include "core/memory.h"
#include "shared/light_layout.h"
#include "svocl/light.h"

typedef struct svo_i_light_viewer {
    void *self;
    /* Makes the hits of view->count photons from view->first on, svo_hit each, in world units. weights: of these
       photons; those without flux meet nothing. The queue is idle, and must be on return. */
    svo_status (*draw)(void *self, const svo_light_view_params *view, const svo_photon_weight *weights,
                       cl_command_queue queue, cl_mem hits);
} svo_i_light_viewer;

SVO_I_SHARED_BEGIN

/* svo_light_set_sources with a viewer. The light's tree must have triangles that rays meet. */
svo_status svo_i_light_set_sources_by(const svo_i_light_viewer *viewer, svo_light *light, const svo_light_setup *setup,
                                      cl_command_queue queue);

SVO_I_SHARED_END

#endif
