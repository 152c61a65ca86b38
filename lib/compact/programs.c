/* SPDX-License-Identifier: MIT */
/* The programs of kernels/compact: the files with their kernels. What these include comes with them. */
#include "compact/programs.h"

#include "core/proof.h"

extern const svo_i_kernel_text svo_i_text_compact_expand_cl, svo_i_text_compact_gather_cl,
    svo_i_text_compact_implied_cl, svo_i_text_compact_levels_cl, svo_i_text_compact_minimize_cl,
    svo_i_text_compact_payload_cl, svo_i_text_compact_places_cl, svo_i_text_compact_sizes_cl,
    svo_i_text_compact_unpack_cl, svo_i_text_compact_words_cl, svo_i_text_stages_scan_cl;

const svo_i_program svo_i_program_compact = {.name = "compact",
                                             .files = {&svo_i_text_stages_scan_cl, &svo_i_text_compact_sizes_cl,
                                                       &svo_i_text_compact_places_cl, &svo_i_text_compact_words_cl,
                                                       &svo_i_text_compact_implied_cl, &svo_i_text_compact_payload_cl,
                                                       &svo_i_text_compact_gather_cl},
                                             .prove = svo_i_prove_scanner};
const svo_i_program svo_i_program_minimize = {.name = "minimize",
                                              .files = {&svo_i_text_stages_scan_cl, &svo_i_text_compact_minimize_cl,
                                                        &svo_i_text_compact_levels_cl, &svo_i_text_compact_gather_cl},
                                              .prove = svo_i_prove_scanner};
const svo_i_program svo_i_program_expand = {
    .name = "expand",
    .files = {&svo_i_text_stages_scan_cl, &svo_i_text_compact_expand_cl, &svo_i_text_compact_unpack_cl},
    .prove = svo_i_prove_scanner};
