/* SPDX-License-Identifier: MIT */
/* Subjects "sizes" and "memory": bytes from no triangle to a million, and bytes per leaf. */
#ifndef SVOCL_TOOLS_BENCH_SIZES_H
#define SVOCL_TOOLS_BENCH_SIZES_H

#include "measure/suite.h"

extern const suite_subject bench_scene_sizes, bench_memory;

/* Of a full octree with 4 bytes for each node. */
double bench_full_octree_bytes(unsigned depth);

#endif
