/* SPDX-License-Identifier: MIT */
/* 27 samples for each inner node. */
#ifndef SVO_LIB_LIGHT_BRICKS_H
#define SVO_LIB_LIGHT_BRICKS_H

#include "light/state.h"

/* SVO_LIGHT_BRICKS: makes SVO_LIGHT_OPACITY. */
svo_status svo_i_light_bricks(svo_i_device_work *work, svo_light *light);

/* Morton codes of the inner nodes, ulong each, by which kernels find the nodes around. */
svo_status svo_i_light_place(svo_i_device_work *work, const svo_light *light, cl_mem codes);

#endif
