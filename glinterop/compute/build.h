/* SPDX-License-Identifier: MIT */
/* Builds a tree by compute shaders, from a fragment list that stays in OpenGL. */
#ifndef SVO_GLINTEROP_COMPUTE_BUILD_H
#define SVO_GLINTEROP_COMPUTE_BUILD_H

#include "compute/compute.h"
#include "stages/build_state.h"

/* Implements svo_frontend.make_tree for a list that stays in OpenGL. Expects the context current. */
svo_status svo_i_gl_make_tree(svo_i_compute *compute, svo_i_build *build);
/* Rejects, before anything is drawn, a plan whose arrays cannot fit the context's storage blocks. */
svo_status svo_i_gl_check_size(svo_i_compute *compute, const svo_plan *plan);

#endif
