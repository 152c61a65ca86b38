/* SPDX-License-Identifier: MIT */
/* shared/layout.h for BVHs: what rays traverse, and the records that their making keeps. */
#ifndef SVO_KERNELS_SHARED_BVH_LAYOUT_H
#define SVO_KERNELS_SHARED_BVH_LAYOUT_H

#include "shared/layout.h"

/* The BVH that rays traverse. */
#define SVO_RAY_LEAF           0x80000000u /* of a child: a leaf; the other bits are its offset, in units of 16 bytes */
#define SVO_RAY_LEAF_TRIANGLES 8
#define SVO_RAY_BOX_BITS       16 /* a box's bounds are in units of 2^-16 of the grid's width */
#define SVO_BVH_DEPTH_MAX      40 /* most nodes from the root to a leaf */

/* A node: the boxes of eight children, axis by axis. A word holds two bounds, that of the even child in the low half.
   The low bound is rounded down; the high bound is the last step that the box reaches into. A missing child has its low
   bound above the high one, and refers to the empty leaf, which is the first. 128 bytes. */
SVO_RECORD(svo_ray_node)
{
    SVO_U32 low[12]; /* 0 */
    SVO_U32 high[12]; /* 48 */
    SVO_U32 child[8]; /* 96: a node, or SVO_RAY_LEAF and a leaf */
};

/* A leaf: a head, the corners, and the triangles' positions in the mesh; the next leaf begins at the next multiple of
   16 bytes. The head has the least x, y and z of the snapped corners as integers in grid units, the number n of
   triangles, the greatest x, y and z, and 0. The corners are the mesh's own, not the snapped ones: nine rows of n
   floats, x of the first corner, x of the second, x of the third, y of the first and so on.
   With SVO_RAY_FLAG_WORLD they are the mesh's floats, in world units. Else they are in grid units, rounded to float,
   and on devices with cl_khr_fp64 the same nine rows follow as doubles in world units, from the next even word on.
   The positions in the mesh are n words after the last row. After the last leaf come SVO_RAY_LEAF_PADDING_WORDS, since
   kernels read eight floats where a row has fewer. */
#define SVO_RAY_LEAF_HEAD_WORDS    8
#define SVO_RAY_LEAF_PADDING_WORDS 8

/* The making of BVHs: bins of a split. */
#define SVO_BVH_BINS     16 /* along an axis */
#define SVO_BVH_CELLS    48 /* along all three */
#define SVO_BVH_BY_COUNT 3u /* in place of an axis: split in halves of the items */
#define SVO_BVH_NO_RANGE 0xffffffffu
/* The most items of a job of SVO_BVH_FAST, on every device, since the BVH depends on it. */
#define SVO_BVH_SWEEP_ITEMS 512
#define SVO_BVH_IN_B        0x80000000u /* of a job's halvings: its items are in the second of two buffers */
#define SVO_BVH_ROOM_BYTES  2720 /* local memory for a split with bins: svo_bvh_room */
#define SVO_BVH_SWEEP_BYTES 7584 /* and for a sweep: svo_bvh_sweep_room */

/* A range of items to split, as a level of the binary tree lists them. 64 bytes. */
SVO_RECORD(svo_bvh_range)
{
    SVO_U32 first; /* 0: item */
    SVO_U32 count; /* 4: items */
    SVO_U32 halvings; /* 8: splits from all items down to this range */
    SVO_U32 link; /* 12: twice the branch that it is a part of, and which part */
    SVO_U32 chunk_begin; /* 16: the first of its chunks */
    SVO_U32 axis; /* 20: of its split; SVO_BVH_BY_COUNT */
    SVO_U32 at; /* 24: the first bin of the second part */
    SVO_U32 front; /* 28: items of the first part */
    SVO_U32 part[2]; /* 32: its parts among the ranges of the next level; SVO_BVH_NO_RANGE */
    SVO_U32 center_low[3]; /* 40: the least of twice the items' centers, as bits of floats */
    SVO_U32 center_high[3]; /* 52: the greatest ones */
};

/* A range of items that a group splits down to leaves. 16 bytes. */
SVO_RECORD(svo_bvh_job)
{
    SVO_U32 first; /* 0 */
    SVO_U32 count; /* 4 */
    SVO_U32 halvings; /* 8: and SVO_BVH_IN_B */
    SVO_U32 link; /* 12 */
};

/* A branch of the binary tree over the items. Its index is the first item of its second part, so 0 is none; branch 0
   has the root as its first part. 16 bytes. */
SVO_RECORD(svo_bvh_branch)
{
    SVO_U32 part[2]; /* 0: the branches of its parts; 0: a leaf */
    SVO_F32 area[2]; /* 8: half the areas of the parts' boxes */
};

/* The children of a node, before leaves have their places. 96 bytes. */
SVO_RECORD(svo_bvh_children)
{
    SVO_U32 first[8]; /* 0: item */
    SVO_U32 count[8]; /* 32: items; 0: no child */
    SVO_U32 node[8]; /* 64: a branch, then a node; 0: a leaf */
};

/* What the making of a BVH counts on the device: ranges and their chunks by levels of the binary tree, and the first
   node of each level of nodes. 512 bytes. */
SVO_RECORD(svo_bvh_state)
{
    SVO_U32 reach; /* 0: the largest absolute coordinate of a vertex */
    SVO_U32 outside; /* 4: whether a vertex lies outside the grid */
    SVO_U32 fuses; /* 8: not 0: the device fuses multiplications and additions that must not be */
    SVO_U32 job_count; /* 12 */
    SVO_U32 range_count[SVO_BVH_DEPTH_MAX + 1]; /* 16 */
    SVO_U32 chunk_count[SVO_BVH_DEPTH_MAX + 1]; /* 180 */
    SVO_U32 node_begin[SVO_BVH_DEPTH_MAX + 2]; /* 344 */
};

/* Arguments of the kernels that make a BVH. 32 bytes. */
SVO_RECORD(svo_bvh_params)
{
    SVO_U32 triangle_count; /* 0 */
    SVO_U32 item_count; /* 4 */
    SVO_U32 snap_bits; /* 8 */
    SVO_U32 chunk_items; /* 12: items of a chunk */
    SVO_U32 subtree_items; /* 16: the most items of a job, SVO_BVH_FEW_ITEMS or more */
    SVO_U32 use_list; /* 20: not 0: the tree's lists say which triangles there are */
    SVO_U32 level; /* 24: of the binary tree. Items of every other level are in the second buffer */
    SVO_U32 halvings; /* 28: splits above the root, of a BVH below other nodes */
};

/* A BVH among those that kernels fit to their triangles together, in buffers that they share. 24 bytes. */
SVO_RECORD(svo_bvh_member)
{
    SVO_U32 first_triangle; /* 0: of the mesh */
    SVO_U32 item_count; /* 4 */
    SVO_U32 item_begin; /* 8: its first item among those of the others */
    SVO_U32 child_begin; /* 12: the children of its first node among those of the others */
    SVO_U32 node_begin; /* 16: its first node among those that rays read */
    SVO_U32 leaf_begin; /* 20: units of 16 bytes of leaves before its own */
};

/* Nodes or items of a member, for a group. 12 bytes. */
SVO_RECORD(svo_bvh_tile)
{
    SVO_U32 member; /* 0 */
    SVO_U32 begin; /* 4 */
    SVO_U32 end; /* 8: at most SVO_GROUP_ITEMS after begin */
};

/* What is known of a BVH that was fit: its root's box in grid units, and what rays through it cost. 32 bytes. */
SVO_RECORD(svo_bvh_extent)
{
    SVO_F32 low[3]; /* 0 */
    SVO_F32 area; /* 12: half those of all nodes and leaves; over half the root's, how many a random ray visits */
    SVO_F32 high[3]; /* 16: negated */
    SVO_U32 outside; /* 28: whether a triangle reaches outside the grid; the BVH is of no use then */
};

#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_ray_node, 128);
SVO_ASSERT_BYTES(svo_bvh_range, 64);
SVO_ASSERT_BYTES(svo_bvh_job, 16);
SVO_ASSERT_BYTES(svo_bvh_branch, 16);
SVO_ASSERT_BYTES(svo_bvh_children, 96);
SVO_ASSERT_BYTES(svo_bvh_state, 512);
SVO_ASSERT_BYTES(svo_bvh_params, 32);
SVO_ASSERT_BYTES(svo_bvh_member, 24);
SVO_ASSERT_BYTES(svo_bvh_tile, 12);
SVO_ASSERT_BYTES(svo_bvh_extent, 32);
#endif

#endif
