/* SPDX-License-Identifier: MIT */
/* The programs of kernels/scene: the files with their kernels. What these include comes with them. */
#include "scene/programs.h"

#include "core/proof.h"
#include "stages/programs.h"

extern const svo_i_kernel_text svo_i_text_scene_bounds_cl, svo_i_text_scene_codes_cl, svo_i_text_scene_link_cl,
    svo_i_text_scene_refit_cl, svo_i_text_scene_render_cl, svo_i_text_scene_see_cl, svo_i_text_scene_trace_cl,
    svo_i_text_scene_widen_cl, svo_i_text_stages_scan_cl, svo_i_text_stages_sort_cl;

const svo_i_program svo_i_program_scene_build = {.name = "scene_build",
                                                 .files = {&svo_i_text_stages_scan_cl, &svo_i_text_stages_sort_cl,
                                                           &svo_i_text_scene_codes_cl, &svo_i_text_scene_link_cl,
                                                           &svo_i_text_scene_refit_cl, &svo_i_text_scene_widen_cl},
                                                 .prove = svo_i_prove_sort};
const svo_i_program svo_i_program_scene_bounds = {.name = "scene_bounds", .files = {&svo_i_text_scene_bounds_cl}};
const svo_i_program svo_i_program_scene_trace = {
    .name = "scene_trace",
    .files = {&svo_i_text_scene_trace_cl, &svo_i_text_shared_arithmetic_cl},
    .prove = svo_i_prove_arithmetic};
const svo_i_program svo_i_program_scene_cast = {
    .name = "scene_cast",
    .files = {&svo_i_text_scene_render_cl, &svo_i_text_shared_arithmetic_cl},
    .prove = svo_i_prove_arithmetic};
const svo_i_program svo_i_program_scene_see = {.name = "scene_see",
                                               .files = {&svo_i_text_scene_see_cl, &svo_i_text_shared_arithmetic_cl},
                                               .prove = svo_i_prove_arithmetic};
