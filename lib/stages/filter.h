/* SPDX-License-Identifier: MIT */
/*
 * Colors, normals and fills of all nodes, by kernels/stages/filter.cl.
 * Reads: the list, build->cursors (uses them up), build->surface. Writes: those of SVO_TREE_COLORS, _NORMALS and _FILLS
 * that are not constant.
 */
#ifndef SVO_LIB_STAGES_FILTER_H
#define SVO_LIB_STAGES_FILTER_H

#include "stages/build_state.h"

svo_status svo_i_filter(svo_i_build *build);

#endif
