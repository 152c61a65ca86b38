/* SPDX-License-Identifier: MIT */
/* The parameters that the payload kernels have in common. */
#ifndef SVO_LIB_STAGES_PAYLOAD_PARAMS_H
#define SVO_LIB_STAGES_PAYLOAD_PARAMS_H

#include "stages/build_state.h"

SVO_I_SHARED_BEGIN

svo_filter_params svo_i_payload_params(const svo_i_build *build);
/* Those for the nodes of a level. */
void svo_i_params_of_level(svo_filter_params *params, const svo_tree_info *info, uint32_t level);
/* Radix passes of SVO_DIGIT_BITS that tell the triangles apart: an even number, so that the result ends where it
   began. */
uint32_t svo_i_digit_passes(uint32_t triangle_count);

SVO_I_SHARED_END

#endif
