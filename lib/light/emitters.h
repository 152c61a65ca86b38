/* SPDX-License-Identifier: MIT */
/* The triangles of a tree that emit, for rays that aim at them: kernels/light/emitters.clh. */
#ifndef SVO_LIB_LIGHT_EMITTERS_H
#define SVO_LIB_LIGHT_EMITTERS_H

#include "light/handle.h"

/* Lists the triangles in leaves whose finish emits, as the light's emitters, if paths are to aim at them and they are
   not listed; waits. There are none without triangles or materials, and where so much of the surface emits that any ray
   finds some. submit: whose queue is used; NULL: the device's own. */
svo_status svo_i_light_list_emitters(svo_light *light, const char *function, const svo_gather_params *gather,
                                     const svo_submit *submit);
/* Forgets them: the light has other finishes, or is of another tree. */
void svo_i_light_drop_emitters(svo_light *light);

#endif
