/* SPDX-License-Identifier: MIT */
/* Probes as spheres in the window. */
#ifndef SVOCL_TOOLS_VIEW_PROBE_SPHERES_H
#define SVOCL_TOOLS_VIEW_PROBE_SPHERES_H

#include "view/state.h"

typedef struct probe_sphere {
    uint32_t index; /* of the probe */
    float pixel[2]; /* of its center */
    float radius; /* pixels */
    float away; /* along the line of sight, world units */
} probe_sphere;

/* False where the probe is behind the eye. */
bool probe_sphere_project(const view_state *state, uint32_t index, probe_sphere *out);

/* The nearest sphere at a place of the window. False where none is, or none is shown. */
bool probe_sphere_at(const view_state *state, float x, float y, uint32_t *index);

#endif
