/* SPDX-License-Identifier: MIT */
/* Where the nodes of a level are, on the host, from the masks of the levels above. */
#ifndef SVO_LIB_LIGHT_CELLS_H
#define SVO_LIB_LIGHT_CELLS_H

#include "core/tree.h"
#include "core/work.h"
#include "light/light_view.h"

/* The Morton codes of a level's nodes; released by svo_i_free. */
svo_status svo_i_codes_of_level(svo_i_device_work *work, const svo_tree *tree, uint32_t level, uint64_t **codes);

/* Bounds of a tree's leaves: exact, or where that would take too many masks, of the nodes of a level above. There is a
   leaf. */
svo_status svo_i_lit_box_of_tree(svo_i_device_work *work, const svo_tree *tree, svo_i_lit_box *box);

#endif
