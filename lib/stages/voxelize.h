/* SPDX-License-Identifier: MIT */
/*
 * Makes the fragment list with OpenCL alone: the front end "cl". Kernels: kernels/stages/voxelize.cl.
 *
 * Reads: the plan's snapped mesh, the draws and chunks of a chunking.
 * Writes: the fragment list, and its counts.
 * Needs: a program per overlap test that the plan uses, which svo_frontend.prepare compiles.
 */
#ifndef SVO_LIB_STAGES_VOXELIZE_H
#define SVO_LIB_STAGES_VOXELIZE_H

#include "stages/build_state.h"

SVO_I_SHARED_BEGIN

/* Implements svo_frontend.voxelize; self is unused. */
svo_status svo_i_voxelize(void *self, svo_i_commands *commands, const svo_i_chunking *chunking,
                          svo_i_fragment_list *list);
/* Implements svo_frontend.prepare; self is unused. */
svo_status svo_i_voxelize_prepare(void *self, svo_plan *plan, svo_i_warm_up *warm_up);

/* Adds the fragments of the chunking's triangles, of at most most_columns, to chunks that hold `needed` fragments of
   its other triangles. In SVO_I_MODE_RUN. */
svo_status svo_i_voxelize_more(svo_i_commands *commands, const svo_i_chunking *chunking, svo_i_fragment_list *list);

SVO_I_SHARED_END

#endif
