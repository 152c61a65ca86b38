/* SPDX-License-Identifier: MIT */
/*
 * The voxelizer of OpenCL alone: triangles -> fragments, by kernels/stages/voxelize.cl; the front end "cl".
 * Reads: the plan's snapped mesh and draws. Writes: the fragment list.
 */
#ifndef SVO_LIB_STAGES_VOXELIZE_H
#define SVO_LIB_STAGES_VOXELIZE_H

#include "stages/build_state.h"

/* svo_frontend.voxelize; self is not used. */
svo_status svo_i_voxelize(void *self, svo_i_commands *commands, const svo_i_chunking *chunking,
                          svo_i_fragment_list *list);

#endif
