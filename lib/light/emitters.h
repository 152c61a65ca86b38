/* SPDX-License-Identifier: MIT */
/* The triangles of a tree that emit, for rays that aim at them: kernels/light/emitters.clh. */
#ifndef SVO_LIB_LIGHT_EMITTERS_H
#define SVO_LIB_LIGHT_EMITTERS_H

#include "light/handle.h"

/* Lists the triangles in leaves whose finish emits, as the light's emitters. There are none without triangles or
   materials, and where so much of the surface emits that any ray finds some. */
svo_status svo_i_light_list_emitters(svo_i_device_work *work, svo_light *light, const svo_light_setup *setup);
/* Forgets them. */
void svo_i_light_drop_emitters(svo_light *light);

#endif
