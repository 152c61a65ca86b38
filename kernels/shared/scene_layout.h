/* SPDX-License-Identifier: MIT */
/* shared/layout.h for scenes of instances: trees, instances, their hierarchy and pictures of them. */
#ifndef SVO_KERNELS_SHARED_SCENE_LAYOUT_H
#define SVO_KERNELS_SHARED_SCENE_LAYOUT_H

#include "shared/layout.h"

/* Bits of a coordinate in the Morton code of a box's center. */
#define SVO_SCENE_CODE_BITS 16
/* Of a child in the hierarchy: an instance; the other bits are its index. */
#define SVO_SCENE_LEAF 0x80000000u
/* Numbers of a box: low x, y, z, high x, y, z. */
#define SVO_SCENE_BOUNDS 6u
/* The most nodes from the root to a leaf: a bit of the code or of the index decides at each. */
#define SVO_SCENE_DEPTH_MAX (3 * SVO_SCENE_CODE_BITS + 24)

/* Where a tree lies in the scene's buffers. 32 bytes. */
SVO_RECORD(svo_scene_tree)
{
    SVO_U32 begin[3]; /* 0: its first elements in the arrays of nodes, which count from its own root */
    SVO_U32 color_begin; /* 12: its first color, in colors */
    SVO_U32 normal_begin; /* 16: its first normal, in normals */
    SVO_U32 flags; /* 20: SVO_SCENE_TREE_* */
    SVO_U32 node_begin; /* 24: the root of its BVH */
    SVO_U32 leaf_begin; /* 28: its BVH's first leaf, in units of 16 bytes */
};
#define SVO_SCENE_TREE_COLORS     1u
#define SVO_SCENE_TREE_ONE_COLOR  2u /* for all nodes */
#define SVO_SCENE_TREE_NORMALS    4u
#define SVO_SCENE_TREE_ONE_NORMAL 8u
#define SVO_SCENE_TREE_CLEAR      16u /* it has colors, and some node shows in part */
/* With -DSVO_PACKED: the array is packed (packed.clh), and its words begin there. */
#define SVO_SCENE_TREE_PACKED_COLORS  32u
#define SVO_SCENE_TREE_PACKED_NORMALS 64u

/* An instance: M is the linear part of its matrix. 152 bytes. */
SVO_RECORD(svo_scene_instance)
{
    SVO_F32 low[3]; /* 0: its box in the world, rounded outwards */
    SVO_F32 high[3]; /* 12 */
    SVO_F32 translation[3]; /* 24: the last column of the matrix */
    SVO_F32 inverse[9]; /* 36: M^-1, row by row, rounded to float */
    SVO_F32 inverse_rest[9]; /* 72: what that lacks */
    SVO_F32 normals[9]; /* 108: unit normals of the high faces on the tree's axes, in the world */
    SVO_F32 widest; /* 144: the length of M's longest column */
    SVO_U32 tree; /* 148 */
};

/* A node of the hierarchy. 64 bytes. */
SVO_RECORD(svo_scene_node)
{
    SVO_F32 box[12]; /* 0: the boxes of the two children, low and high corner each */
    SVO_U32 child[2]; /* 48: nodes, or SVO_SCENE_LEAF and an instance */
    SVO_U32 parent; /* 56: 2 * the parent, plus 1 for its second child; SVO_NO_NODE: the root */
    SVO_U32 reserved; /* 60 */
};

/* A node of the wide hierarchy, for CPUs: up to eight nodes or instances that are met together. 224 bytes. */
SVO_RECORD(svo_scene_wide)
{
    SVO_F32 low[24]; /* 0: low x of the children, y, z; where there is no child, beyond all numbers */
    SVO_F32 high[24]; /* 96 */
    SVO_U32 child[8]; /* 192: nodes, SVO_SCENE_LEAF and an instance, or SVO_NO_NODE */
};
#define SVO_SCENE_WIDTH 8u /* children of a node */

/* Arguments of the scene's kernels. 40 bytes. */
SVO_RECORD(svo_scene_params)
{
    SVO_U32 instance_count; /* 0 */
    SVO_U32 root; /* 4: as svo_scene_node.child */
    SVO_F32 reach; /* 8: no box has a coordinate beyond this */
    SVO_F32 footprint; /* 12: of the rays */
    SVO_U32 flags; /* 16: svo_scene_flags */
    SVO_F32 code_low[3]; /* 20: the least center of a box */
    SVO_F32 code_scale; /* 32: cells of the Morton codes per world unit */
    SVO_U32 reserved; /* 36 */
};

/* A picture of a scene. World coordinates. 128 bytes. */
SVO_RECORD(svo_scene_picture)
{
    SVO_F32 eye[3]; /* 0 */
    SVO_F32 footprint; /* 12: width of a pixel at distance 1 */
    SVO_F32 corner[3]; /* 16: from the eye to the picture's upper left corner, at any distance */
    SVO_U32 width; /* 28: pixels */
    SVO_F32 across[3]; /* 32: from a pixel to its right neighbor, at that distance */
    SVO_U32 height; /* 44: pixels */
    SVO_F32 down[3]; /* 48: from a pixel to the one below, at that distance */
    SVO_U32 samples; /* 60: rays of a pixel */
    SVO_F32 up[3]; /* 64: unit, towards the sky */
    SVO_F32 occlusion_range; /* 76: range of the ambient occlusion */
    SVO_U32 light_count; /* 80 */
    SVO_U32 pixel_flags; /* 84: SVO_PIXEL_* */
    SVO_F32 background[3]; /* 88: what is behind everything, with SVO_PIXEL_COLOR */
    SVO_U32 reserved[3]; /* 100 */
    SVO_F32 clip[4]; /* 112: a plane; what is below it is not there (kernels/rays/part.clh). Zeros: none */
};

#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_scene_tree, 32);
SVO_ASSERT_BYTES(svo_scene_instance, 152);
SVO_ASSERT_BYTES(svo_scene_node, 64);
SVO_ASSERT_BYTES(svo_scene_wide, 224);
SVO_ASSERT_BYTES(svo_scene_params, 40);
SVO_ASSERT_BYTES(svo_scene_picture, 128);
#endif

#endif
