/* SPDX-License-Identifier: MIT */
/* shared/layout.h for scenes that move: constants and records of lists of pairs that are kept, and of their nodes. */
#ifndef SVO_KERNELS_SHARED_MOVING_LAYOUT_H
#define SVO_KERNELS_SHARED_MOVING_LAYOUT_H

#include "shared/layout.h"

/* Entries of two lists that a work-item merges. */
#define SVO_MERGE_STRIP 512
/* A pair that is kept, besides its code and triangle: its weight, its color (RGBA8), its normal (x, y) and, in the last
   word, the normal's z in the low half and its object in the high half. */
#define SVO_KEPT_WORDS        4
#define SVO_KEPT_OBJECT_SHIFT 16
/* What it shows, where projected areas are made: see kernels/moving/areas.clh. */
#define SVO_KEPT_AREA_WORDS 4
/* The most pairs of a leaf that a work-item sums up on GPUs; groups sum up the longer lists. */
#define SVO_KEPT_LONG 2048

/* Arguments of the kernels of scenes that move. 16 bytes. */
SVO_RECORD(svo_moving_params)
{
    SVO_U32 count; /* 0: pairs, of the first list where there are two; or words */
    SVO_U32 other_count; /* 4: pairs of the second list */
    SVO_U32 object; /* 8: of the pairs; or what is added to words; or marks that are left out */
    SVO_U32 first; /* 12: the first word to write */
};

/* Pairs of a sorted list that a work-item makes nodes from. */
#define SVO_NODE_STRIP 256
/* Levels at the largest depth, and their end: SVO_LEVELS_MAX of svocl/tree.h. */
#define SVO_NODE_LEVELS 18

/* Arguments of the kernels that make nodes of a sorted list. 16 bytes. */
SVO_RECORD(svo_node_params)
{
    SVO_U32 count; /* 0: pairs */
    SVO_U32 strips; /* 4: of SVO_NODE_STRIP pairs; the last may have fewer */
    SVO_U32 depth; /* 8 */
    SVO_U32 reserved; /* 12 */
};

#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_moving_params, 16);
SVO_ASSERT_BYTES(svo_node_params, 16);
#endif

#endif
