/* SPDX-License-Identifier: MIT */
/* The parameters that payload kernels share. */
#ifndef SVO_LIB_STAGES_PAYLOAD_PARAMS_H
#define SVO_LIB_STAGES_PAYLOAD_PARAMS_H

#include "stages/build_state.h"

SVO_I_SHARED_BEGIN

/* Parameters of a build, without those of a level or a chunk. */
svo_filter_params svo_i_payload_params(const svo_i_build *build);
/* Sets the parameters of a level. */
void svo_i_params_of_level(svo_filter_params *params, const svo_tree_info *info, uint32_t level);
/* Number of radix passes of SVO_DIGIT_BITS bits that sort triangle indices. It is even, so that the result is in the
   buffer that held the input. */
uint32_t svo_i_digit_passes(uint32_t triangle_count);

SVO_I_SHARED_END

#endif
