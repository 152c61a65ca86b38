/* SPDX-License-Identifier: MIT */
/* The programs of kernels/solid: the files with their kernels. What these include comes with them. */
#include "solid/programs.h"

extern const svo_i_kernel_text svo_i_text_solid_carry_cl, svo_i_text_solid_centers_cl, svo_i_text_solid_chain_cl,
    svo_i_text_solid_closed_cl, svo_i_text_solid_cross_cl, svo_i_text_solid_fill_cl, svo_i_text_solid_masks_cl,
    svo_i_text_solid_payload_cl, svo_i_text_solid_place_cl, svo_i_text_solid_regions_cl;

const svo_i_program svo_i_program_solid = {.name = "solid",
                                           .files = {&svo_i_text_solid_closed_cl, &svo_i_text_solid_regions_cl,
                                                     &svo_i_text_solid_place_cl, &svo_i_text_solid_cross_cl,
                                                     &svo_i_text_solid_carry_cl, &svo_i_text_solid_chain_cl,
                                                     &svo_i_text_solid_fill_cl, &svo_i_text_solid_centers_cl,
                                                     &svo_i_text_solid_masks_cl, &svo_i_text_solid_payload_cl}};
