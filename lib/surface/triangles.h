/* SPDX-License-Identifier: MIT */
/* The triangles of a surface. */
#ifndef SVO_LIB_SURFACE_TRIANGLES_H
#define SVO_LIB_SURFACE_TRIANGLES_H

#include "surface/work.h"

/* Joins the vertices around each edge that the surface crosses. Sets the count of triangles at the field's end. */
svo_status svo_i_surface_find_triangles(svo_i_surface_work *work);

#endif
