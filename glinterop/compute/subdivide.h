/* SPDX-License-Identifier: MIT */
/* The nodes of the tree. */
#ifndef SVO_GLINTEROP_COMPUTE_SUBDIVIDE_H
#define SVO_GLINTEROP_COMPUTE_SUBDIVIDE_H

#include "compute/stage.h"

/* Masks, first children and level counts; cursors end up at the leaves. *fits is false when the inner
   nodes did not fit the build's inner_capacity. */
svo_status svo_i_gl_subdivide(svo_i_gl_build *gl_build, bool *fits);

#endif
