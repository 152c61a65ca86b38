/* SPDX-License-Identifier: MIT */
/* What goes from the exchange to the filter: the leaves that have light. */
#ifndef SVO_LIB_LIGHT_LIT_LEAVES_H
#define SVO_LIB_LIGHT_LIT_LEAVES_H

#include <stdint.h>

#include <CL/cl.h>

typedef struct svo_i_lit_leaves {
    cl_mem leaves; /* lit_count u32: leaf numbers, 0 for the first leaf, ascending */
    /* u32 fixed point. SVO_LIGHT_FACES: lit_count * 18, direction * 3 + channel, premultiplied by opacity; other forms:
       lit_count * 3, not premultiplied. */
    cl_mem radiance;
    uint64_t lit_count;
    float unit; /* radiance is a value times unit, a power of two */
} svo_i_lit_leaves;

#endif
