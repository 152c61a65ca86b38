/* SPDX-License-Identifier: MIT */
/* The programs of kernels/compact. */
#ifndef SVO_LIB_COMPACT_PROGRAMS_H
#define SVO_LIB_COMPACT_PROGRAMS_H

#include "core/program.h"

extern const svo_i_program svo_i_program_compact;
extern const svo_i_program svo_i_program_minimize;
extern const svo_i_program svo_i_program_expand;

#endif
