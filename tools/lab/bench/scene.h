/* SPDX-License-Identifier: MIT */
/* svocl bench scene: instances of one tree in a lattice, beside one tree of all their voxels and beside Embree. */
#ifndef SVOCL_TOOLS_BENCH_SCENE_H
#define SVOCL_TOOLS_BENCH_SCENE_H

#include "measure/suite.h"

extern const suite_subject bench_scene;

#endif
