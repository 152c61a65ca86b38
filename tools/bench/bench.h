/* SPDX-License-Identifier: MIT */
/* What `svocl bench` measures: one function per subject, each returns the exit code. */
#ifndef SVOCL_BENCH_H
#define SVOCL_BENCH_H

#include "program.h"

/* Rays against triangles, ours beside Embree's. */
int bench_rays(program *state);

#endif
