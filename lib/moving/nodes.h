/* SPDX-License-Identifier: MIT */
/* Nodes of a sorted list. */
#ifndef SVO_LIB_MOVING_NODES_H
#define SVO_LIB_MOVING_NODES_H

#include "stages/build_state.h"

/* Makes the tree's nodes and the ranges of its leaves, in place of the stage bottom_up. The list is that of the build
   and sorted; program: of kernels/moving. Waits for the counts. */
svo_status svo_i_moving_nodes(svo_i_build *build, cl_program program);

#endif
