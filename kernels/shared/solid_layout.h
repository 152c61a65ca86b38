/* SPDX-License-Identifier: MIT */
/* shared/layout.h for solids. */
#ifndef SVO_KERNELS_SHARED_SOLID_LAYOUT_H
#define SVO_KERNELS_SHARED_SOLID_LAYOUT_H

#include "shared/layout.h"

/* Counters of the solid kernels. */
#define SVO_SOLID_OUTSIDE    0 /* triangles that reach outside the grid */
#define SVO_SOLID_LONG_LISTS 1 /* leaves whose list a work-group reads */
#define SVO_SOLID_OPEN_X     2 /* columns whose crossings do not cancel, along x, y and z */
#define SVO_SOLID_TESTS      5 /* empty cells of the launch */
#define SVO_SOLID_INSIDE     6 /* of those, inside */
#define SVO_SOLID_AMBIGUOUS  7 /* of those, with axes that disagree */
#define SVO_SOLID_EDGES      8 /* four sums of the edges' hashes */
#define SVO_SOLID_REGIONS    12 /* regions of empty cells */
#define SVO_SOLID_COUNTERS   13

/* Which sums of crossings are inside: svo_solid_rule. */
#define SVO_SOLID_RULE_WINDING     0 /* other than 0 */
#define SVO_SOLID_RULE_PARITY      1 /* odd */
#define SVO_SOLID_RULE_GENERALIZED 2 /* above 0: above 1/2, where they are whole numbers */

/* What positions are. */
#define SVO_SOLID_SNAPPED 0
#define SVO_SOLID_FLOATS  1
#define SVO_SOLID_DOUBLES 2

/* Arguments of the solid kernels. 64 bytes. */
SVO_RECORD(svo_solid_params)
{
    SVO_U32 depth; /* 0 */
    SVO_U32 voxel_log2; /* 4: edge of a voxel in grid units */
    SVO_U32 leaf_begin; /* 8: first leaf */
    SVO_U32 leaf_count; /* 12 */
    SVO_U32 first; /* 16: first inner node of the launch */
    SVO_U32 count; /* 20: nodes, leaves or triangles of the launch */
    SVO_U32 level; /* 24: of those inner nodes */
    SVO_U32 rule; /* 28: which sums are inside, SVO_SOLID_RULE_* */
    SVO_U32 element_halves; /* 32: 16-bit words of a payload element */
    SVO_U32 repeats; /* 36: not 0: the tree's payload has one element for all nodes */
    SVO_U32 value[2]; /* 40: the element of interior leaves, its first half in the low half of the first word */
    SVO_U32 rounded_to_odd; /* 48: 1: odd coordinates of vertices may be off; 0: the snapped mesh is the true one */
    SVO_U32 positions; /* 52: what they are, SVO_SOLID_* */
    SVO_U32 region_max; /* 56: the most regions that are decided one by one */
    SVO_U32 axes; /* 60: bits of the axes along which leaves are crossed: 7, or of a closed mesh 1 */
};

#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_solid_params, 64);
#endif

#endif
