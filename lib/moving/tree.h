/* SPDX-License-Identifier: MIT */
/* The tree of a list of kept pairs. */
#ifndef SVO_LIB_MOVING_TREE_H
#define SVO_LIB_MOVING_TREE_H

#include "moving/state.h"

/* Makes a new tree of the scene's objects and their pairs. Waits. report: receives times, NULL: waits only at the
   end. */
svo_status svo_i_moving_tree(svo_moving *moving, cl_command_queue queue, const svo_i_kept_list *list,
                             svo_moving_report *report, svo_tree **out);

#endif
