/* SPDX-License-Identifier: MIT */
/* A list of fragments and its tree, for the known answers of the kernels that make nodes and leaf lists. */
#ifndef SVO_LIB_STAGES_PROOF_TREE_H
#define SVO_LIB_STAGES_PROOF_TREE_H

#include "core/proof.h"
#include "shared/layout.h"

#define SVO_I_PROOF_FRAGMENTS 501
#define SVO_I_PROOF_DEPTH     9 /* three levels of blocks */

/* Codes in clusters at both ends of the grid, and a leaf of more fragments than a work-item sorts. The host makes the
   tree by sorting codes. */
typedef struct svo_i_proof_tree {
    uint32_t codes[SVO_I_PROOF_FRAGMENTS]; /* of 3 SVO_I_PROOF_DEPTH bits */
    uint32_t triangles[SVO_I_PROOF_FRAGMENTS];
    uint32_t words[SVO_I_PROOF_FRAGMENTS * SVO_FRAGMENT_WORDS_48]; /* as kernels read them */
    uint32_t word_count; /* of a fragment */
    uint32_t level_codes[SVO_I_PROOF_DEPTH + 1][SVO_I_PROOF_FRAGMENTS]; /* of the nodes of each level, ascending */
    uint32_t level_begin[SVO_I_PROOF_DEPTH + 2];
    uint8_t masks[SVO_I_PROOF_DEPTH * SVO_I_PROOF_FRAGMENTS]; /* of all inner nodes */
    uint32_t first_child[SVO_I_PROOF_DEPTH * SVO_I_PROOF_FRAGMENTS];
    uint32_t cursors[SVO_I_PROOF_FRAGMENTS]; /* the leaf of each fragment */
} svo_i_proof_tree;

/* tree: zeroed. */
void svo_i_proof_tree_fill(const svo_i_proof *proof, svo_i_proof_tree *tree);
/* A buffer with the words of the fragments. */
svo_status svo_i_proof_fragments(svo_i_proof *proof, const svo_i_proof_tree *tree, cl_mem *out);
/* The place of a code among those of its level. */
uint32_t svo_i_proof_place_of(const svo_i_proof_tree *tree, uint32_t level, uint32_t code);
/* For qsort. */
int svo_i_proof_compare_words(const void *a, const void *b);

static inline uint32_t svo_i_proof_level_count(const svo_i_proof_tree *tree, uint32_t level)
{
    return tree->level_begin[level + 1] - tree->level_begin[level];
}

#endif
