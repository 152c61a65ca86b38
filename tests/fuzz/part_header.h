/* SPDX-License-Identifier: MIT */
/* The tree that the part files of fuzz_part belong to. */
#ifndef SVOCL_TESTS_FUZZ_PART_HEADER_H
#define SVOCL_TESTS_FUZZ_PART_HEADER_H

#include "svocl/plan.h"

static inline svo_part_header part_header(void)
{
    svo_part_header header = SVO_PART_HEADER_INIT;
    header.depth = 3;
    header.snap_bits = 20;
    header.need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL;
    header.weight_log2 = 20;
    header.edge = 1.0;
    header.scale = 1048575.0;
    header.triangles = 10;
    header.kept_triangles = 10;
    return header;
}

#endif
