/* SPDX-License-Identifier: MIT */
/* The programs of kernels/solid. */
#ifndef SVO_LIB_SOLID_PROGRAMS_H
#define SVO_LIB_SOLID_PROGRAMS_H

#include "core/program.h"

extern const svo_i_program svo_i_program_solid;

#endif
