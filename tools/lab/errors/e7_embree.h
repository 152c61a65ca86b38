/* SPDX-License-Identifier: MIT */
/* Table "e7-embree": the rays of light at points, svocl's beside Embree's on the same directions. */
#ifndef SVOCL_TOOLS_ERRORS_E7_EMBREE_H
#define SVOCL_TOOLS_ERRORS_E7_EMBREE_H

#include "errors/cones.h"
#include "measure/embree.h"

/* Adds the table with its columns. */
void e7_embree_begin(const error_run *run);

/* Adds the rows of a scene. peer: NULL adds none. False on failure, with the reason in the device's message or for lack
   of memory. */
bool e7_embree_measure(const error_run *run, const cone_truth *truth, const embree *peer);

#endif
