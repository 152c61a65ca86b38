/* SPDX-License-Identifier: MIT */
/* The programs of kernels/stages: the files with their kernels. What these include comes with them. */
#include "stages/programs.h"

extern const svo_i_kernel_text svo_i_text_stages_bottom_up_cl, svo_i_text_stages_decide_cl, svo_i_text_stages_drop_cl,
    svo_i_text_stages_filter_cl, svo_i_text_stages_link_cl, svo_i_text_stages_material_cl, svo_i_text_stages_pack_cl,
    svo_i_text_stages_pairs_cl, svo_i_text_stages_scan_cl, svo_i_text_stages_sort_cl, svo_i_text_stages_subdivide_cl,
    svo_i_text_stages_voxelize_cl;

const svo_i_program svo_i_program_drop = {
    .name = "drop", .files = {&svo_i_text_stages_drop_cl}, .prove = svo_i_prove_drop};
const svo_i_program svo_i_program_subdivide = {
    .name = "subdivide", .files = {&svo_i_text_stages_subdivide_cl}, .prove = svo_i_prove_subdivide};
const svo_i_program svo_i_program_sort = {
    .name = "sort",
    .files = {&svo_i_text_stages_scan_cl, &svo_i_text_stages_sort_cl, &svo_i_text_stages_bottom_up_cl},
    .prove = svo_i_prove_sorted_builder};
const svo_i_program svo_i_program_pack = {
    .name = "pack", .files = {&svo_i_text_stages_scan_cl, &svo_i_text_stages_pack_cl}, .prove = svo_i_prove_pack};
const svo_i_program svo_i_program_filter = {.name = "filter",
                                            .files = {&svo_i_text_stages_link_cl, &svo_i_text_stages_material_cl,
                                                      &svo_i_text_stages_filter_cl, &svo_i_text_stages_pairs_cl},
                                            .prove = svo_i_prove_filter};
const svo_i_program svo_i_program_voxelize = {
    .name = "voxelize", .files = {&svo_i_text_stages_voxelize_cl}, .prove = svo_i_prove_voxelize};
const svo_i_program svo_i_program_decide = {
    .name = "decide", .files = {&svo_i_text_stages_decide_cl}, .prove = svo_i_prove_decide};
