/* SPDX-License-Identifier: MIT */
/* The programs of kernels/probes. */
#include "probes/programs.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_probes[];
extern const char svo_i_source_probe_filter[];
extern const char svo_i_source_probe_trace[];
extern const char svo_i_source_probe_gather[];

const svo_i_program svo_i_program_probes = {.name = "probes", .source = svo_i_source_probes};
const svo_i_program svo_i_program_probe_filter = {.name = "probe_filter", .source = svo_i_source_probe_filter};
const svo_i_program svo_i_program_probe_trace = {.name = "probe_trace", .source = svo_i_source_probe_trace};
const svo_i_program svo_i_program_probe_gather = {.name = "probe_gather", .source = svo_i_source_probe_gather};
