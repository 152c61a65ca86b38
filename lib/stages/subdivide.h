/* SPDX-License-Identifier: MIT */
/*
 * Nodes from the root down, by kernels/stages/subdivide.cl and scan.cl.
 * Reads: the fragment list. Writes: SVO_TREE_CHILD_MASK, SVO_TREE_FIRST_CHILD, the tree's counts, build->state, and
 * build->cursors, which end at the leaves.
 */
#ifndef SVO_LIB_STAGES_SUBDIVIDE_H
#define SVO_LIB_STAGES_SUBDIVIDE_H

#include "stages/build_state.h"

svo_status svo_i_subdivide(svo_i_build *build);

#endif
