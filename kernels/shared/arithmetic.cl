/* SPDX-License-Identifier: MIT */
/*
 * What programs expect of the arithmetic that they are compiled to: a product is rounded before anything is added to
 * it, though drivers may fuse the two where FP_CONTRACT does not forbid it; quotients and roots of floats are rounded
 * correctly where the host asks for it (lib/core/program.c). The host tests it with this kernel (lib/core/proof.c).
 *
 * Launch: one work-item per four factors, rounded up to whole groups. Writes SVO_ARITHMETIC_WORDS words for each: of
 * floats a sum and a difference of products, a quotient and a root; of doubles a difference of products, the low word
 * first, or zeros. No local memory, no atomics.
 */
#include "shared/layout.h"

#pragma OPENCL FP_CONTRACT OFF
#ifdef cl_khr_fp64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_arithmetic(__global const float *factors, __global uint *words, uint count)
{
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    const float4 f = vload4(i, factors);
    ulong difference = 0;
#ifdef cl_khr_fp64
    const double a = f.x, b = f.y, c = f.z, d = f.w;
    difference = as_ulong((a * a) * (b * b) - (c * c) * (d * d));
#endif
    __global uint *to = words + (size_t)i * SVO_ARITHMETIC_WORDS;
    to[0] = as_uint(f.x * f.y + f.z);
    to[1] = as_uint(f.x * f.y - f.z * f.w);
    to[2] = as_uint(f.x / f.y);
    to[3] = as_uint(sqrt(f.x));
    to[4] = (uint)difference;
    to[5] = (uint)(difference >> 32);
}
