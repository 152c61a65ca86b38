/* SPDX-License-Identifier: MIT */
/* Adversarial rays: aimed where ray-triangle tests fail. The same bits for the same mesh on every machine. */
#ifndef SVOCL_TOOLS_ERRORS_ADVERSARIAL_RAYS_H
#define SVOCL_TOOLS_ERRORS_ADVERSARIAL_RAYS_H

#include <stddef.h>

#include "svocl/mesh.h"
#include "svocl/ray_types.h"

typedef enum ray_target {
    TARGET_RANDOM = 0, /* from a sphere around the mesh to random points of its bounding box */
    TARGET_VERTICES, /* a vertex, from the front of its triangle */
    TARGET_EDGES, /* a point on an edge */
    TARGET_GRAZING, /* the interior of a triangle, nearly parallel to its plane */
    TARGET_COUNT
} ray_target;
const char *ray_target_name(ray_target target); /* static string */

typedef struct adversarial_set {
    ray_target target;
    /* Positions and origins are multiples of it, and rays pass through their targets exactly. 0: within the rounding of
       a float. */
    double unit;
    double reach; /* distance of the origins, in widths of the mesh; 0: close to it */
} adversarial_set;

/* mesh: with finite positions. */
void adversarial_rays(const svo_mesh *mesh, const adversarial_set *set, size_t count, svo_ray *rays);

#endif
