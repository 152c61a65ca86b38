/* SPDX-License-Identifier: MIT */
/* Nodes of a sorted list. */
#ifndef SVO_LIB_MOVING_NODES_H
#define SVO_LIB_MOVING_NODES_H

#include "stages/build_state.h"

/* Makes the tree's nodes and the ranges of its leaves, in place of the stage bottom_up. The list is that of the build
   and sorted; program: of kernels/moving; counted: of the list. A build that does not wait has set the most nodes of
   each level in the tree's info; another sets the exact ones here. Leaves them in the state. */
svo_status svo_i_moving_nodes(svo_i_build *build, cl_program program, cl_mem counted);
/* Sets the tree's counts from the state. */
svo_status svo_i_moving_take_state(svo_device *device, const svo_build_state *state, svo_tree_info *info);

#endif
