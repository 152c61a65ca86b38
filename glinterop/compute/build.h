/* SPDX-License-Identifier: MIT */
/* Builds a tree by compute shaders, from a fragment list that stays in OpenGL. */
#ifndef SVO_GLINTEROP_COMPUTE_BUILD_H
#define SVO_GLINTEROP_COMPUTE_BUILD_H

#include "compute/compute.h"
#include "stages/build_state.h"

/* The tree of a list that is in OpenGL, for svo_frontend.make_tree. Expects the context current. */
svo_status svo_i_gl_make_tree(svo_i_compute *compute, svo_i_build *build);
/* Refuses what is sure not to fit the context's storage blocks, before anything is drawn. */
svo_status svo_i_gl_check_size(svo_i_compute *compute, const svo_plan *plan);

#endif
