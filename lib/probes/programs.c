/* SPDX-License-Identifier: MIT */
/* The programs of kernels/probes: the files with their kernels. What these include comes with them. */
#include "probes/programs.h"

#include "core/proof.h"

extern const svo_i_kernel_text svo_i_text_probes_clear_cl, svo_i_text_probes_field_cl, svo_i_text_probes_filter_cl,
    svo_i_text_probes_gather_cl, svo_i_text_probes_least_cl, svo_i_text_probes_texels_cl, svo_i_text_probes_trace_cl;

const svo_i_program svo_i_program_probes = {.name = "probes",
                                            .files = {&svo_i_text_probes_texels_cl, &svo_i_text_probes_least_cl,
                                                      &svo_i_text_probes_field_cl, &svo_i_text_shared_arithmetic_cl},
                                            .prove = svo_i_prove_arithmetic};
const svo_i_program svo_i_program_probe_clear = {
    .name = "probe_clear",
    .files = {&svo_i_text_probes_clear_cl, &svo_i_text_shared_arithmetic_cl},
    .prove = svo_i_prove_arithmetic};
const svo_i_program svo_i_program_probe_filter = {.name = "probe_filter", .files = {&svo_i_text_probes_filter_cl}};
const svo_i_program svo_i_program_probe_trace = {.name = "probe_trace", .files = {&svo_i_text_probes_trace_cl}};
const svo_i_program svo_i_program_probe_gather = {.name = "probe_gather", .files = {&svo_i_text_probes_gather_cl}};
