/* SPDX-License-Identifier: MIT */
/*
 * Links the fragments of each leaf into a list, by atomic exchange, by kernels/stages/link.cl. The filter runs it,
 * chunk by chunk.
 * Reads: build->cursors[chunk]. Writes: heads; the cursors become the links.
 */
#ifndef SVO_LIB_STAGES_LINK_H
#define SVO_LIB_STAGES_LINK_H

#include "stages/build_state.h"

svo_status svo_i_link(svo_i_build *build, cl_kernel kernel, uint32_t chunk, cl_mem heads, svo_filter_params params);

#endif
