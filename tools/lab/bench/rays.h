/* SPDX-License-Identifier: MIT */
/* Subject "rays": rays against triangles, compared with Embree. */
#ifndef SVOCL_TOOLS_BENCH_RAYS_H
#define SVOCL_TOOLS_BENCH_RAYS_H

#include "measure/suite.h"

extern const suite_subject bench_rays;

/* `svocl bench rays`: one input by the build options, with a JSON document of its own. Returns the exit code. */
int bench_rays_alone(program *state);

#endif
