/* SPDX-License-Identifier: MIT */
/*
 * Trees by hand for tests of compact trees, and an encoder on the host that follows the text of svocl/compact.h by
 * recursion, with nothing of the library's.
 */
#ifndef SVOCL_TESTS_COMPACT_REFERENCE_H
#define SVOCL_TESTS_COMPACT_REFERENCE_H

#include "svocl/svocl.h"

/* Child masks of a tree whose nodes are made by a function of level and Morton code, 0 .. 255; below the root not 0. */
typedef uint8_t mask_of_node(void *user, uint32_t level, uint64_t code);

/* A tree on the host alone. need: payload of random numbers from payload_level on. */
svo_tree *hand_tree(uint32_t depth, mask_of_node *masks, void *user, uint32_t need, uint32_t payload_level);

/* The words of SVO_FORM_DESCRIPTOR and what lies beside them. Released by reference_words_free. */
typedef struct reference_words {
    uint32_t *words;
    uint32_t *bases; /* as svo_compact_arrays has them if there are places */
    uint32_t *order; /* the tree's nodes in the order of their payload */
    uint64_t word_count, far_count, payload_count;
} reference_words;

/* tree: with host arrays. */
void reference_words_make(const svo_tree *tree, reference_words *out);
void reference_words_free(reference_words *made);

/* What a walk over the half words of SVO_FORM_MIRRORED finds, after the text of svocl/compact.h. */
typedef struct mirrored_walk {
    uint64_t visited; /* nodes that are as the tree has them */
    uint64_t long_references, reflected; /* references of two half words; with a mirror */
    uint32_t *places; /* of each node of the tree; SVO_NO_NODE where it has no payload */
} mirrored_walk;

/* Walks down a compact tree and the tree that it was made from, without merging, until they differ: visited is then
   below the tree's node_count. Released by mirrored_walk_free. Both have host arrays. */
void mirrored_walk_make(const svo_compact *compact, const svo_tree *tree, mirrored_walk *out);
void mirrored_walk_free(mirrored_walk *made);

#endif
