/* SPDX-License-Identifier: MIT */
/* The programs of kernels/moving. */
#ifndef SVO_LIB_MOVING_PROGRAMS_H
#define SVO_LIB_MOVING_PROGRAMS_H

#include "core/program.h"

extern const svo_i_program svo_i_program_moving;

#endif
