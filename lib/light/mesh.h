/* SPDX-License-Identifier: MIT */
/* The mesh of a light: kernels/light/mesh.clh. */
#ifndef SVO_LIB_LIGHT_MESH_H
#define SVO_LIB_LIGHT_MESH_H

#include "light/handle.h"

void svo_i_light_drop_mesh(svo_light *light);

#endif
