/* SPDX-License-Identifier: MIT */
/* The programs of kernels/bvh and kernels/rays: the files with their kernels. What these include comes with them. */
#include "rays/programs.h"

#include "core/proof.h"
#include "stages/programs.h"

extern const svo_i_kernel_text svo_i_text_bvh_collapse_cl, svo_i_text_bvh_corners_cl, svo_i_text_bvh_items_cl,
    svo_i_text_bvh_leaves_cl, svo_i_text_bvh_morton_cl, svo_i_text_bvh_refit_cl, svo_i_text_bvh_split_cl,
    svo_i_text_bvh_subtree_cl, svo_i_text_rays_nearest_cl, svo_i_text_rays_render_cl, svo_i_text_rays_trace_cl,
    svo_i_text_rays_trace_voxels_cl, svo_i_text_rays_view_cl, svo_i_text_stages_scan_cl, svo_i_text_stages_sort_cl;

const svo_i_program svo_i_program_bvh = {.name = "bvh",
                                         .files = {&svo_i_text_stages_scan_cl, &svo_i_text_stages_sort_cl,
                                                   &svo_i_text_bvh_items_cl, &svo_i_text_bvh_morton_cl,
                                                   &svo_i_text_bvh_split_cl, &svo_i_text_bvh_subtree_cl,
                                                   &svo_i_text_bvh_collapse_cl, &svo_i_text_bvh_corners_cl,
                                                   &svo_i_text_bvh_leaves_cl, &svo_i_text_bvh_refit_cl},
                                         .prove = svo_i_prove_sort};
const svo_i_program svo_i_program_trace = {
    .name = "trace",
    .files = {&svo_i_text_rays_trace_cl, &svo_i_text_rays_nearest_cl, &svo_i_text_shared_arithmetic_cl},
    .prove = svo_i_prove_arithmetic};
const svo_i_program svo_i_program_trace_voxels = {
    .name = "trace_voxels",
    .files = {&svo_i_text_rays_trace_voxels_cl, &svo_i_text_shared_arithmetic_cl},
    .prove = svo_i_prove_arithmetic};
const svo_i_program svo_i_program_cast = {.name = "cast",
                                          .files = {&svo_i_text_rays_render_cl, &svo_i_text_shared_arithmetic_cl},
                                          .prove = svo_i_prove_arithmetic};
const svo_i_program svo_i_program_view = {.name = "view",
                                          .files = {&svo_i_text_rays_view_cl, &svo_i_text_shared_arithmetic_cl},
                                          .prove = svo_i_prove_arithmetic};
