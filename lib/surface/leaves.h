/* SPDX-License-Identifier: MIT */
/* What vertices have from the leaves of a tree. */
#ifndef SVO_LIB_SURFACE_LEAVES_H
#define SVO_LIB_SURFACE_LEAVES_H

#include "surface/work.h"

/* Refuses a tree that has not what the parts take from it. */
svo_status svo_i_surface_check_tree(const svo_surface_options *options, svo_message *message);

/* Sets colors, and normals of leaves. */
svo_status svo_i_surface_take_leaves(svo_i_surface_work *work, const svo_surface_options *options);

#endif
