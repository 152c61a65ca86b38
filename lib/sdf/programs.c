/* SPDX-License-Identifier: MIT */
/* The programs of kernels/sdf: the files with their kernels. What these include comes with them. */
#include "sdf/programs.h"

#include "core/proof.h"

extern const svo_i_kernel_text svo_i_text_sdf_distance_cl, svo_i_text_sdf_refine_cl, svo_i_text_stages_scan_cl;

const svo_i_program svo_i_program_sdf = {
    .name = "sdf",
    .files = {&svo_i_text_stages_scan_cl, &svo_i_text_sdf_refine_cl, &svo_i_text_sdf_distance_cl},
    .prove = svo_i_prove_scanner};
