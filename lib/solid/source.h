/* SPDX-License-Identifier: MIT */
/* A tree with interior leaves, as encoders of compact trees read it. */
#ifndef SVO_LIB_SOLID_SOURCE_H
#define SVO_LIB_SOLID_SOURCE_H

#include "compact/source.h"
#include "core/tree.h"
#include "solid/classify.h"

/* Adds the interior leaves to a tree. The tree and the work own its arrays, which must outlive the work. options: read
   and complete. */
svo_status svo_i_solid_source(svo_i_device_work *work, const svo_tree *tree, const svo_i_inside *inside,
                              const svo_solid_options *options, svo_i_compact_source *out);

#endif
