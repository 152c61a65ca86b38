/* SPDX-License-Identifier: MIT */
/** \file
 * Records of trees and of their builds, as they lie in buffers and in kernels of the caller's own. One text for C, C++,
 * OpenCL C and GLSL; numbers at the front of comments are offsets in bytes.
 */
#ifndef SVOCL_TREE_TYPES_H
#define SVOCL_TREE_TYPES_H

#include "svocl/record.h"

#define SVO_NO_NODE 0xffffffffu /**< svo_node.index, svo_voxel_hit.node: none */

/** A node and its place: of the 2^level cells along each axis of the grid, the one that the node fills. 20 bytes. */
SVO_RECORD(svo_node)
{
    SVO_U32 index; /**< 0: into the tree's nodes, or SVO_NO_NODE */
    SVO_U32 level; /**< 4: 0 for the root; a leaf has the tree's depth */
    SVO_U32 cell[3]; /**< 8: x, y, z, each below 2^level */
};

#define SVO_DAMAGED_LIST 0xffffffffu /**< svo_build_state.overflow: a fragment outside the grid, or of no triangle */
#define SVO_SHORT_LIST   0xfffffffeu /**< svo_build_state.overflow: the list had too little room */

/** The outcome of an enqueued build on the device (SVO_TREE_BUILD_STATE). D is the depth of the tree. 96 bytes. */
SVO_RECORD(svo_build_state)
{
    /** 0: level l has the nodes level_begin[l] .. level_begin[l + 1] - 1. So there are level_begin[D] inner nodes,
     *  level_begin[D + 1] nodes and level_begin[D + 1] - level_begin[D] leaves, if overflow is 0. Entries after D + 1
     *  have no meaning. */
    SVO_U32 level_begin[18];
    /** 72: 0: the tree is complete. Otherwise its other buffers are undefined: the inner nodes of this level did not
     *  fit, or SVO_SHORT_LIST or SVO_DAMAGED_LIST. */
    SVO_U32 overflow;
    SVO_U32 fragments_low; /**< 76: the number of fragments, also when they did not fit: low word */
    SVO_U32 fragments_high; /**< 80: high word. Leaf lists have as many entries as there are fragments */
    SVO_U32 triangle_count; /**< 84: for the build alone: fragments are of triangles below it */
    SVO_U32 long_lists; /**< 88: for the build alone: leaf lists that a work-group sorts */
    SVO_U32 fragment_limit; /**< 92: for the build alone: no chunk has more fragments, whatever the host says */
};

/** \cond */
#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_node, 20);
SVO_ASSERT_BYTES(svo_build_state, 96);
#endif
/** \endcond */

#endif
