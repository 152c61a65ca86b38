/* SPDX-License-Identifier: MIT */
/* What two trees have in common where one has what is kept of the other. */
#ifndef SVO_LIB_LIGHT_KEPT_TREE_H
#define SVO_LIB_LIGHT_KEPT_TREE_H

#include "core/tree.h"
#include "core/work.h"
#include "svocl/nodes.h"

typedef struct svo_i_kept_tree {
    svo_grid grid;
    uint32_t need, constant, weights; /* of svo_tree_info */
    uint64_t constants[3]; /* of colors, normals and materials, where all nodes have the same; else 0 */
} svo_i_kept_tree;

svo_status svo_i_kept_tree_read(svo_i_device_work *work, const svo_tree *tree, svo_i_kept_tree *out);
bool svo_i_kept_tree_is_same(const svo_i_kept_tree *a, const svo_i_kept_tree *b);

/* Bytes of a buffer that is kept; NULL has none. */
uint64_t svo_i_kept_buffer_bytes(cl_mem buffer);

#endif
