/* SPDX-License-Identifier: MIT */
/* The programs of kernels/moving: the files with their kernels. What these include comes with them. */
#include "moving/programs.h"

#include "core/proof.h"

extern const svo_i_kernel_text svo_i_text_moving_count_cl, svo_i_text_moving_gather_cl, svo_i_text_moving_merge_cl,
    svo_i_text_moving_nodes_cl, svo_i_text_moving_shift_cl, svo_i_text_moving_weigh_cl, svo_i_text_stages_scan_cl;

const svo_i_program svo_i_program_moving = {.name = "moving",
                                            .files = {&svo_i_text_stages_scan_cl, &svo_i_text_moving_weigh_cl,
                                                      &svo_i_text_moving_merge_cl, &svo_i_text_moving_nodes_cl,
                                                      &svo_i_text_moving_gather_cl, &svo_i_text_moving_shift_cl,
                                                      &svo_i_text_moving_count_cl},
                                            .prove = svo_i_prove_scanner};
