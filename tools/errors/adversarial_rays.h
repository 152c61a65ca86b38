/* SPDX-License-Identifier: MIT */
/* Rays aimed at where ray-triangle tests go wrong. The same numbers for the same mesh everywhere. */
#ifndef SVOCL_TOOLS_ERRORS_ADVERSARIAL_RAYS_H
#define SVOCL_TOOLS_ERRORS_ADVERSARIAL_RAYS_H

#include <stddef.h>

#include "svocl/ray_types.h"
#include "svocl/mesh.h"

typedef enum aim {
    AIM_ANYWHERE = 0, /* from the sphere around the mesh towards points of its box */
    AIM_VERTICES, /* from before a triangle at one of its corners */
    AIM_EDGES, /* at a point of one of its edges */
    AIM_GRAZING, /* nearly in its plane, through its inside */
    AIM_COUNT
} aim;
const char *aim_name(aim kind); /* static string */

typedef struct adversarial_set {
    aim kind;
    /* Not 0: the positions are multiples of it, origins are too, and rays that are aimed meet their targets exactly. 0:
       they pass them within the rounding of a float. */
    double unit;
    double reach; /* how far away the origins are, in widths of the mesh; 0: close by */
} adversarial_set;

/* mesh: with finite positions. */
void adversarial_rays(const svo_mesh *mesh, const adversarial_set *set, size_t count, svo_ray *rays);

#endif
