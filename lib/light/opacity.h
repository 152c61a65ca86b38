/* SPDX-License-Identifier: MIT */
/* One opacity for each node, without direction. */
#ifndef SVO_LIB_LIGHT_OPACITY_H
#define SVO_LIB_LIGHT_OPACITY_H

#include "light/state.h"

/* The opacities of the leaves, u16 each, into a buffer from element first on. */
svo_status svo_i_light_leaves(svo_i_device_work *work, const svo_light *light, cl_mem opacities, cl_uint first);

/* SVO_LIGHT_VOXELS: the opacities of all nodes. */
svo_status svo_i_light_voxels(svo_i_device_work *work, svo_light *light);

#endif
