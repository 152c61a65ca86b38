/* SPDX-License-Identifier: MIT */
/*
 * Computes the colors, normals and fills of all nodes, and the projected areas of the leaves. Kernels:
 * kernels/stages/filter.cl, and link.cl or pairs.cl.
 *
 * Reads: the fragment list, build->cursors, build->order, build->state, build->surface, SVO_TREE_CHILD_MASK,
 * SVO_TREE_FIRST_CHILD.
 * Writes: SVO_TREE_COLORS, _NORMALS and _FILLS, as far as they are not constant, and SVO_TREE_AREAS. Overwrites the
 * cursors, and releases the order.
 * Needs: subdivide or bottom_up, surface. Runs after all other stages that read the cursors.
 */
#ifndef SVO_LIB_STAGES_FILTER_H
#define SVO_LIB_STAGES_FILTER_H

#include "stages/build_state.h"

svo_status svo_i_filter(svo_i_build *build);

#endif
