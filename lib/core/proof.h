/* SPDX-License-Identifier: MIT */
/*
 * Known answers. Drivers have compiled kernels wrongly without a word: one lost the larger of two keys, and trees came
 * out wrong. So before a handle uses a program whose results are stored, it runs the program's own kernels on small
 * inputs that are hard on a compiler: odd counts, ties, numbers beyond 32 bits, coordinates a last bit away from a
 * plane. The host computes what they must give, by the same text compiled as C or by a plain loop, and compares after
 * each kernel, so that the one that is wrong can be named.
 *
 * A room proves its programs in a file of its own, whose functions programs.h declares (svo_i_prover).
 */
#ifndef SVO_LIB_CORE_PROOF_H
#define SVO_LIB_CORE_PROOF_H

#include "core/work.h"

/* A proof that is running. */
typedef struct svo_i_proof {
    svo_i_device_work work; /* launches the program's kernels; its scratch buffers are the proof's */
    const char *defines; /* of the program */
    const char **wrong; /* receives the name of a kernel that gives wrong results */
} svo_i_proof;

/* What proves a program. memory: zeroed, for what the host computes. */
typedef svo_status svo_i_proof_steps(svo_i_proof *proof, void *memory);

/* Runs the steps with so many bytes: a prover, but for the last two. */
svo_status svo_i_proof_run(svo_device *device, const char *function, const svo_i_program_entry *made,
                           const char **wrong, size_t memory_bytes, svo_i_proof_steps *steps);

/* Whether the program was compiled with the define, as in "SVO_SORT". */
bool svo_i_proof_defines(const svo_i_proof *proof, const char *define);
/* A buffer with that content, for kernels to read and write; the work owns it. */
svo_status svo_i_proof_buffer(svo_i_proof *proof, const void *content, size_t bytes, cl_mem *out);
/* Reads the start of a buffer. SVO_DEVICE_UNRELIABLE, and the kernel's name, where it is not as expected. kernel: a
   static string. */
svo_status svo_i_proof_expect(svo_i_proof *proof, const char *kernel, cl_mem buffer, const void *expected,
                              size_t bytes);
/* Launches a kernel of which each work-item looks whether there is an element for it. On CPUs with more work-items than
   PoCL compiles a kernel for at first: one that was launched so before is not compiled again for a larger grid. */
svo_status svo_i_proof_launch(svo_i_proof *proof, const char *kernel, const svo_i_argument *arguments,
                              cl_uint argument_count, uint64_t elements);
/* Says that a kernel is wrong. */
svo_status svo_i_proof_fail(svo_i_proof *proof, const char *kernel);
/* Memory of the host for a case, zeroed; the caller frees it. */
svo_status svo_i_proof_alloc(svo_i_proof *proof, size_t bytes, void **out);

/* The next of a sequence of numbers that look random: the same ones on every host. */
uint64_t svo_i_proof_next(uint64_t *state);

/* Of a program with svo_k_scan_lists_*: exclusive prefix sums. */
svo_status svo_i_prove_scans(svo_i_proof *proof);

/* Of a program with svo_k_arithmetic: products that are rounded before they are added, and quotients; once for each
   device, whose programs are all compiled in one way. */
svo_status svo_i_prove_rounding(svo_i_proof *proof);

/* For programs of which no more is proven: the scans, the arithmetic, or both. */
svo_i_prover svo_i_prove_scanner, svo_i_prove_arithmetic, svo_i_prove_scanner_and_arithmetic;

/* The file with svo_k_arithmetic. */
extern const svo_i_kernel_text svo_i_text_shared_arithmetic_cl;

#endif
