/* SPDX-License-Identifier: MIT */
/* Bounds of what has changed in a tree, for kernels/light/changed.clh. */
#ifndef SVO_LIB_LIGHT_CHANGES_H
#define SVO_LIB_LIGHT_CHANGES_H

#include "light/state.h"

/* The cells of the leaves that each box may have changed: low x, y, z, high x, y, z, int each. The buffer belongs to
   the work. */
svo_status svo_i_changes_upload(svo_i_device_work *work, const svo_tree *tree, const svo_i_light_changes *changes,
                                cl_mem *cells);

#endif
