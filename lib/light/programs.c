/* SPDX-License-Identifier: MIT */
/* The programs of kernels/light: the files with their kernels. What these include comes with them. */
#include "light/programs.h"

#include "core/proof.h"

extern const svo_i_kernel_text svo_i_text_light_brick_light_cl, svo_i_text_light_bricks_cl,
    svo_i_text_light_exchange_cl, svo_i_text_light_faces_cl, svo_i_text_light_filter_cl, svo_i_text_light_gather_cl,
    svo_i_text_light_gather_rays_cl, svo_i_text_light_kept_photons_cl, svo_i_text_light_light_view_cl,
    svo_i_text_light_opacity_cl, svo_i_text_light_origins_cl, svo_i_text_light_photons_cl, svo_i_text_light_picture_cl,
    svo_i_text_light_renewed_cl, svo_i_text_light_screen_cl, svo_i_text_light_sent_photons_cl,
    svo_i_text_light_shade_cl, svo_i_text_light_voxel_photons_cl, svo_i_text_stages_scan_cl;

const svo_i_program svo_i_program_light = {.name = "light",
                                           .files = {&svo_i_text_stages_scan_cl, &svo_i_text_light_origins_cl,
                                                     &svo_i_text_light_opacity_cl, &svo_i_text_light_bricks_cl,
                                                     &svo_i_text_light_faces_cl, &svo_i_text_light_renewed_cl,
                                                     &svo_i_text_light_filter_cl, &svo_i_text_light_brick_light_cl},
                                           .prove = svo_i_prove_scanner};
const svo_i_program svo_i_program_photons = {.name = "photons",
                                             .files = {&svo_i_text_stages_scan_cl, &svo_i_text_light_light_view_cl,
                                                       &svo_i_text_light_photons_cl, &svo_i_text_light_exchange_cl,
                                                       &svo_i_text_shared_arithmetic_cl},
                                             .prove = svo_i_prove_scanner_and_arithmetic};
const svo_i_program svo_i_program_kept_photons = {.name = "kept_photons", .files = {&svo_i_text_light_kept_photons_cl}};
const svo_i_program svo_i_program_sent_photons = {.name = "sent_photons", .files = {&svo_i_text_light_sent_photons_cl}};
const svo_i_program svo_i_program_voxel_photons = {
    .name = "voxel_photons",
    .files = {&svo_i_text_light_voxel_photons_cl, &svo_i_text_shared_arithmetic_cl},
    .prove = svo_i_prove_arithmetic};
const svo_i_program svo_i_program_gather = {.name = "gather", .files = {&svo_i_text_light_gather_cl}};
const svo_i_program svo_i_program_gather_rays = {.name = "gather_rays", .files = {&svo_i_text_light_gather_rays_cl}};
const svo_i_program svo_i_program_screen = {.name = "screen", .files = {&svo_i_text_light_screen_cl}};
const svo_i_program svo_i_program_light_picture = {.name = "light_picture", .files = {&svo_i_text_light_picture_cl}};
const svo_i_program svo_i_program_light_shade = {.name = "light_shade", .files = {&svo_i_text_light_shade_cl}};
