/* SPDX-License-Identifier: MIT */
/* The vertices of a surface. */
#ifndef SVO_LIB_SURFACE_VERTICES_H
#define SVO_LIB_SURFACE_VERTICES_H

#include "surface/work.h"

/* Finds the cubes that the surface passes, brick by brick, and sets their vertices: positions, and normals if they are
   wanted. */
svo_status svo_i_surface_find_vertices(svo_i_surface_work *work);

#endif
