/* SPDX-License-Identifier: MIT */
/*
 * Links the fragments of each leaf into a list, by atomic exchange. Kernels: kernels/stages/link.cl.
 *
 * Reads: build->cursors of a chunk, build->state.
 * Writes: heads, the first fragment of each leaf; the cursors, which become the links.
 * Needs: subdivide or bottom_up. filter calls it, chunk by chunk.
 */
#ifndef SVO_LIB_STAGES_LINK_H
#define SVO_LIB_STAGES_LINK_H

#include "stages/build_state.h"

svo_status svo_i_link(svo_i_build *build, cl_kernel kernel, uint32_t chunk, cl_mem heads, svo_filter_params params);

#endif
