/* SPDX-License-Identifier: MIT */
/* Trees made by hand, with every array and without a device, for tests of files. */
#ifndef SVO_TESTS_SMALL_TREE_H
#define SVO_TESTS_SMALL_TREE_H

#include "core/tree.h"

#define SMALL_TREE_DEPTH 3

/* The tree of ascending Morton codes at depth 3; no code gives the empty tree. Payload differs from element to element.
   Released by svo_tree_destroy. */
svo_tree *small_tree_make(const uint32_t *codes, size_t count, uint32_t need);
/* Five leaves. */
svo_tree *small_tree(uint32_t need);

/* Asserts the same properties, arrays and hash. */
void assert_same_tree(const svo_tree *a, const svo_tree *b);

#endif
