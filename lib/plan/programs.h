/* SPDX-License-Identifier: MIT */
/* The programs of kernels/plan. */
#ifndef SVO_LIB_PLAN_PROGRAMS_H
#define SVO_LIB_PLAN_PROGRAMS_H

#include "core/program.h"

extern const svo_i_program svo_i_program_plan;

/* Known answers of the program: proof.c. */
svo_i_prover svo_i_prove_plan;

#endif
