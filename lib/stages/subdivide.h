/* SPDX-License-Identifier: MIT */
/*
 * Makes the nodes from the root down, three levels at a time. Kernels: kernels/stages/subdivide.cl.
 *
 * Reads: the fragment list.
 * Writes: SVO_TREE_CHILD_MASK, SVO_TREE_FIRST_CHILD, the tree's counts, build->state, build->partials, and where a
 * stage reads them build->cursors, the leaf of each fragment.
 * Needs: a complete fragment list.
 */
#ifndef SVO_LIB_STAGES_SUBDIVIDE_H
#define SVO_LIB_STAGES_SUBDIVIDE_H

#include "stages/build_state.h"

svo_status svo_i_subdivide(svo_i_build *build);

#endif
