/* SPDX-License-Identifier: MIT */
/* The programs of kernels/plan: the files with their kernels. What these include comes with them. */
#include "plan/programs.h"

extern const svo_i_kernel_text svo_i_text_plan_attributes_cl, svo_i_text_plan_classify_cl, svo_i_text_plan_closed_cl,
    svo_i_text_plan_keep_cl, svo_i_text_plan_snap_cl, svo_i_text_plan_tiles_cl, svo_i_text_plan_views_cl;

const svo_i_program svo_i_program_plan = {.name = "plan",
                                          .files = {&svo_i_text_plan_views_cl, &svo_i_text_plan_snap_cl,
                                                    &svo_i_text_plan_classify_cl, &svo_i_text_plan_keep_cl,
                                                    &svo_i_text_plan_attributes_cl, &svo_i_text_plan_closed_cl,
                                                    &svo_i_text_plan_tiles_cl},
                                          .prove = svo_i_prove_plan};
