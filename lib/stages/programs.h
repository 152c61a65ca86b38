/* SPDX-License-Identifier: MIT */
/*
 * The programs of kernels/stages. A program holds what depends on the same defines, so that a plan with other needs
 * compiles little anew.
 */
#ifndef SVO_LIB_STAGES_PROGRAMS_H
#define SVO_LIB_STAGES_PROGRAMS_H

#include "core/program.h"

extern const svo_i_program svo_i_program_subdivide;
extern const svo_i_program svo_i_program_sort;
extern const svo_i_program svo_i_program_pack;
SVO_I_SHARED_BEGIN
extern const svo_i_program svo_i_program_filter;
SVO_I_SHARED_END
extern const svo_i_program svo_i_program_voxelize;
extern const svo_i_program svo_i_program_decide;
extern const svo_i_program svo_i_program_drop;

/* Known answers of these programs, in proof_*.c; of the sort alone, for programs of other rooms. */
svo_i_prover svo_i_prove_subdivide, svo_i_prove_sorted_builder, svo_i_prove_sort, svo_i_prove_pack, svo_i_prove_filter,
    svo_i_prove_voxelize, svo_i_prove_decide, svo_i_prove_drop;

#endif
