/* SPDX-License-Identifier: MIT */
/* The programs of kernels/probes. */
#ifndef SVO_LIB_PROBES_PROGRAMS_H
#define SVO_LIB_PROBES_PROGRAMS_H

#include "core/program.h"

extern const svo_i_program svo_i_program_probes;
extern const svo_i_program svo_i_program_probe_clear;
extern const svo_i_program svo_i_program_probe_filter;
extern const svo_i_program svo_i_program_probe_trace;
extern const svo_i_program svo_i_program_probe_gather;

#endif
