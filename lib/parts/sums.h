/* SPDX-License-Identifier: MIT */
/* The host's twin of kernels/stages/sums.clh and material.cl, for the levels above the parts. */
#ifndef SVO_LIB_PARTS_SUMS_H
#define SVO_LIB_PARTS_SUMS_H

#include "core/tree.h"

/* The sums of a node, and its materials with their weights, ascending. */
typedef struct svo_i_part_root {
    svo_i_node_sums sums;
    uint64_t *runs; /* owned */
    uint32_t run_count;
} svo_i_part_root;

/* The payload of a node, as it lies in the arrays of trees. */
typedef struct svo_i_part_payload {
    uint8_t color[4];
    int16_t normal[3];
    uint16_t material;
    uint16_t fill;
} svo_i_part_payload;

/* Adds a child's sums to its parent's. Returns false when out of memory. */
bool svo_i_part_join(svo_i_part_root *to, const svo_i_part_root *from);
/* Rounds the sums of a node once; all zero for a node without weight. face_log2: the weight of its face, as a power of
   two. */
svo_i_part_payload svo_i_part_round(const svo_i_part_root *root, uint32_t face_log2);

#endif
