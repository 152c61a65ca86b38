/* SPDX-License-Identifier: MIT */
/* The programs of kernels/sdf. */
#ifndef SVO_LIB_SDF_PROGRAMS_H
#define SVO_LIB_SDF_PROGRAMS_H

#include "core/program.h"

extern const svo_i_program svo_i_program_sdf;

#endif
