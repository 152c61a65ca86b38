/* SPDX-License-Identifier: MIT */
/* Creates the nodes of the tree. */
#ifndef SVO_GLINTEROP_COMPUTE_SUBDIVIDE_H
#define SVO_GLINTEROP_COMPUTE_SUBDIVIDE_H

#include "compute/stage.h"

/* Creates masks, first children and level counts, and moves the cursors to the leaves. *fits is false when the inner
   nodes exceed the build's inner_capacity. */
svo_status svo_i_gl_subdivide(svo_i_gl_build *gl_build, bool *fits);

#endif
