/* SPDX-License-Identifier: MIT */
/* Which empty children of a tree's inner nodes are inside the mesh. */
#ifndef SVO_LIB_SOLID_INSIDE_H
#define SVO_LIB_SOLID_INSIDE_H

#include "core/tree.h"
#include "core/work.h"
#include "svocl/solid.h"

/* What the device found. */
typedef struct svo_i_inside {
    cl_mem mask; /* scratch of the work: a byte per inner node, bit o for an empty child in octant o that is inside */
    uint64_t count; /* of those children */
    uint64_t level_count[SVO_LEVELS_MAX]; /* the same by their level */
} svo_i_inside;

/* Decides all empty children and waits for the counts. info: receives all fields but struct_size. */
svo_status svo_i_inside_find(svo_i_device_work *work, const svo_tree *tree, svo_solid_rule rule, svo_i_inside *out,
                             svo_solid_info *info);

#endif
