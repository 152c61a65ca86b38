/* SPDX-License-Identifier: MIT */
/*
 * The fields of a surface. Files of the room, each after those that it uses: cases, field, work, vertices, triangles,
 * leaves, surface.
 */
#ifndef SVO_LIB_SURFACE_HANDLE_H
#define SVO_LIB_SURFACE_HANDLE_H

#include "core/memory.h"
#include "svocl/surface.h"

struct svo_surface {
    svo_surface_info info;
    svo_i_memory memory; /* of the surface and its arrays */
    float *positions; /* owned, as all arrays; NULL: not asked for, or nothing in it */
    uint32_t *indices;
    float *normals;
    uint8_t *colors;
    svo_mesh mesh; /* of these arrays */
};

#endif
