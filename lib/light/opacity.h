/* SPDX-License-Identifier: MIT */
/* The opacity of all nodes of a tree, in the light's form. */
#ifndef SVO_LIB_LIGHT_OPACITY_H
#define SVO_LIB_LIGHT_OPACITY_H

#include "light/handle.h"

/* Makes SVO_LIGHT_OPACITY and, for SVO_LIGHT_FACES, SVO_LIGHT_COVER. Where light->before keeps nodes, what stays is
   copied from there: makes light->nodes and light->before->origins. */
svo_status svo_i_light_opacity(svo_i_device_work *work, svo_light *light);

/* Morton codes of the inner nodes, ulong each, by which kernels find the nodes around. */
svo_status svo_i_light_place(svo_i_device_work *work, const svo_light *light, cl_mem codes);

#endif
