/* SPDX-License-Identifier: MIT */
/*
 * A slow reference of rays through one probe, in long double: every plane through the probe that bounds a column or a
 * row of texels is crossed by the ray on its own, so that there is no walk to go wrong. The rules of a texel are those
 * of kernels/probes/walk.clh.
 */
#ifndef SVOCL_TESTS_PROBE_REFERENCE_H
#define SVOCL_TESTS_PROBE_REFERENCE_H

#include <stdbool.h>

#include "svocl/probes.h"

/* A probe with copies of its texels. */
typedef struct probe_map {
    svo_probe_info info;
    float position[3];
    const uint32_t *texels; /* two words each, of this probe */
} probe_map;

typedef struct probe_answer {
    uint32_t state; /* SVO_PROBE_* */
    double t; /* of a ray of unit direction, world units; as svo_probe_hit has it */
    uint32_t texel; /* of a hit, in the probe's map */
    bool close; /* a comparison on the way was nearly even */
} probe_answer;

/* ray: unit direction, inside the field's box, up to a finite t_max there. */
probe_answer probe_reference_trace(const probe_map *map, const svo_ray *ray);

#endif
