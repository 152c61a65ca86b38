/* SPDX-License-Identifier: MIT */
/* The signed distance field of INPUT, for the commands that write it or what follows from it. */
#ifndef SVOCL_TOOLS_SVOCL_DISTANCE_FIELD_H
#define SVOCL_TOOLS_SVOCL_DISTANCE_FIELD_H

#include "support/job.h"
#include "svocl/sdf.h"

typedef struct distance_field {
    job made; /* with its tree */
    svo_sdf *sdf; /* downloaded */
    svo_sdf_info info;
    svo_sdf_arrays arrays;
    double make_ms;
} distance_field;

/* What is inside, as --sign says: "none", or the name of the rule. */
const char *distance_field_sign(const program *state);

/* Fails where INPUT has no triangles, or options do not apply to distances. what: what the command makes. */
int distance_field_check(program *state, const char *what);

/*
 * Makes the tree: that of INPUT, or one with the svo_need bits of need. Its grid is that of --origin and --edge, or a
 * cube around the mesh and what is within offset of it, world units, with so many voxels of room on each side. Begins
 * the progress bar; further_steps: how many steps the caller adds. Returns the exit code; on failure nothing is left to
 * release.
 */
int distance_field_open(program *state, uint32_t need, double room, double offset, unsigned further_steps,
                        distance_field *out);

/* Makes the field, by --sign; band: as in svo_sdf_options. A step of the progress bar. */
int distance_field_make(program *state, float band, distance_field *field);

void distance_field_release(distance_field *field);

#endif
