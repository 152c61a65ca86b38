/* SPDX-License-Identifier: MIT */
/*
 * What the host, the OpenCL kernels and the GLSL shaders must agree on: constants, and the records that travel in
 * buffers and kernel arguments. One text for C, C++, OpenCL C and GLSL. Records hold 32-bit integers and floats only,
 * every field at a multiple of four bytes, without padding. Offsets are in bytes. Solids, BVHs, scenes, scenes that
 * move, light and probes have files of their own: solid_layout.h and so on. The records that callers of the library see
 * are in svocl/ray_types.h and its neighbors.
 */
#ifndef SVO_KERNELS_SHARED_LAYOUT_H
#define SVO_KERNELS_SHARED_LAYOUT_H

#include "svocl/ray_types.h"
#include "svocl/scene_types.h"
#include "svocl/tree_types.h"

/* Vectors may be wider than the registers of a device. All functions are called from their own file alone, so how they
   are passed is of no interest, but PoCL would print the number of such warnings. */
#if defined(__OPENCL_C_VERSION__) && defined(__clang__)
#pragma clang diagnostic ignored "-Wpsabi"
#endif

/* Work-items of a work-group. Kernels are compiled for exactly this size, but for those whose work-items have much to
   do: there each is a group of its own. */
#define SVO_GROUP_ITEMS 64
/* Words that kernels/shared/arithmetic.cl writes for four factors. */
#define SVO_ARITHMETIC_WORDS 6
/* Nodes or leaves that a work-item gathers on CPUs, where it evaluates their pairs together. */
#define SVO_GATHER_NODES 32
/* One group filters this level and those above, which have few nodes. */
#define SVO_TOP_LEVEL 3
/* The most groups of a scan's reduce and add passes. Each has one partial sum; one group scans them all, so this is a
   multiple of SVO_GROUP_ITEMS. */
#define SVO_SCAN_GROUPS 256
/* Elements that a group scans at once: 16 per work-item. */
#define SVO_SCAN_TILE (SVO_GROUP_ITEMS * 16)
/* The largest grid depth at which a fragment's Morton code fits 30 bits. */
#define SVO_CODE30_DEPTH_MAX 10
/* Words of a fragment: code, triangle; or code low, code high, triangle. */
#define SVO_FRAGMENT_WORDS_30 2
#define SVO_FRAGMENT_WORDS_48 3
/* Leaf lists up to this length are sorted by one work-item, longer ones by a work-group. */
#define SVO_SHORT_LIST_MAX 256
/* The most triangles of a leaf that one work-item sorts or sums up where drivers stop long launches: on GPUs. */
#define SVO_LONG_LEAF 4096
/* Long lists are sorted by digits of this many bits. */
#define SVO_DIGIT_BITS 4
#define SVO_DIGITS     (1 << SVO_DIGIT_BITS)

/* The most columns of voxels that one work-item of the OpenCL front end visits. Larger triangles are cut into tiles of
   SVO_TILE_EDGE x SVO_TILE_EDGE columns. */
#define SVO_TILE_EDGE    8
#define SVO_TILE_COLUMNS (SVO_TILE_EDGE * SVO_TILE_EDGE)
/* Words of local memory of a group of it: on CPUs, where one work-item stages its group's fragments, and elsewhere,
   where each notes its own columns, in 16 bits each. */
#define SVO_VOXELIZE_STAGE_WORDS (SVO_GROUP_ITEMS * (SVO_TILE_COLUMNS + 1))
#define SVO_VOXELIZE_NOTE_WORDS  (SVO_GROUP_ITEMS * (SVO_TILE_COLUMNS / 2 + 1))

/* Draw items of a class are sorted by size, within blocks of SVO_SCAN_TILE triangles of the mesh, and so are tiles: so
   work-items that run together visit about as many columns. The size is the number of columns, below SVO_SIZE_COUNT,
   or SVO_SIZE_LARGE where there are more than those of a tile. A work-item of the plan's kernels counts one size. */
#define SVO_SIZE_COUNT SVO_GROUP_ITEMS
#define SVO_SIZE_LARGE 0u
/* Local memory counts the triangles of each size and work-item in 16 bits: SVO_SIZE_COUNT rows of so many, padded so
   that work-items that go through rows meet different banks. */
#define SVO_SIZE_PITCH (SVO_GROUP_ITEMS + 2)

/* The classes of triangles inside the grid by what the overlap test's integers must hold (overlap.clh): the widest
   bounding box of SVO_NARROW, in voxels and in units, which are coarser than the grid's where they must be, and the
   largest grid, as a power of two of its units, for which 64 bits do. */
#define SVO_NARROW_VOXELS 128
#define SVO_NARROW_UNITS  (1 << 14)
#define SVO_REGULAR_BITS  20u

/* svo_draw_item.flags. */
#define SVO_DRAW_AXIS_MASK 3u /* 0, 1, 2: the axis of projection */
#define SVO_DRAW_BOUNDS    4u /* draw the triangle's bounds: needles, degenerate triangles, parts outside the grid */

#define SVO_DRAW_NOTHING 8u /* alone: a place for an item that is not used */

/* One triangle to draw; the front end reads an array of them. 8 bytes. */
SVO_RECORD(svo_draw_item)
{
    SVO_U32 triangle; /* 0: into the index buffer, and the fragment's triangle */
    SVO_U32 flags; /* 4: SVO_DRAW_* */
};

/* A tile of a large triangle: SVO_TILE_EDGE x SVO_TILE_EDGE columns of voxels, clipped to the triangle's bounds and the
   draw. 8 bytes. */
SVO_RECORD(svo_tile_item)
{
    SVO_U32 item; /* 0: into the items */
    SVO_U32 corner; /* 4: the first column in voxels of the grid, u in the low half, v in the high half */
};

/* A triangle of more than SVO_TILE_COLUMNS columns, for the host that finds its tiles. 48 bytes. */
SVO_RECORD(svo_large_item)
{
    SVO_U32 item; /* 0: into the items */
    SVO_U32 axis; /* 4: of its projection */
    SVO_F32 fragments; /* 8: expected ones */
    SVO_I32 corners[9]; /* 12: grid units */
};

/* Arguments of the plan's kernels. Doubles are two words, the low one first. 80 bytes. */
SVO_RECORD(svo_plan_params)
{
    SVO_U32 vertex_count; /* 0 */
    SVO_U32 triangle_count; /* 4: of the mesh; for attributes, of the kept ones */
    SVO_U32 flags; /* 8: SVO_PLAN_* */
    SVO_U32 snap_bits; /* 12 */
    SVO_U32 voxel_log2; /* 16: edge of a voxel in grid units */
    SVO_U32 material_count; /* 20 */
    SVO_U32 origin[6]; /* 24: of the grid, three doubles */
    SVO_U32 scale[2]; /* 48: grid units per world unit, a double */
    SVO_U32 edge[2]; /* 56: of the grid, a double */
    SVO_U32 class_begin[4]; /* 64: the first item of each class */
};

#define SVO_PLAN_INDEXED  1u /* the mesh has indices */
#define SVO_PLAN_DOUBLES  2u /* its positions are doubles */
#define SVO_PLAN_CLOSED   4u /* voxels contain their far faces */
#define SVO_PLAN_THIN     8u /* coverage is thin */
#define SVO_PLAN_SOME     16u /* not all triangles are kept */
#define SVO_PLAN_TEXTURED 32u /* textures may be sampled */

/* What becomes of a triangle: its class (svo_i_class in lib/plan/plan_data.h) or one of these, in the low bits of 16;
   above them its draw flags, then its size. */
#define SVO_FATE_REFUSED   4u /* index out of range, not finite */
#define SVO_FATE_OUTSIDE   5u
#define SVO_FATE_FAR       6u /* refused, since the overlap test cannot represent it */
#define SVO_FATE_MASK      7u
#define SVO_FATE_DRAW_LOG2 3
#define SVO_FATE_SIZE_LOG2 6

/* The columns of 64 bits that classification sums: triangles by fate, the sums of the estimate, large triangles. */
#define SVO_PLAN_SUM_WIDTHS     7
#define SVO_PLAN_SUM_AREAS_LOW  8
#define SVO_PLAN_SUM_AREAS_HIGH 9
#define SVO_PLAN_SUM_LARGE      10
#define SVO_PLAN_SUMS           11
/* Columns of svo_k_plan_records, at most those. */
#define SVO_PLAN_FINDINGS 9

/* Arguments of the reduction over the columns of all groups. 16 bytes. */
SVO_RECORD(svo_plan_total_params)
{
    SVO_U32 groups; /* 0 */
    SVO_U32 columns; /* 4 */
    SVO_U32 largest; /* 8: not 0: the largest number of each column instead of the sum */
    SVO_U32 first_total; /* 12: the first of the totals that are written */
};

/* An array in a caller's buffer. 64-bit numbers are two words, the low one first. 28 bytes. */
SVO_RECORD(svo_plan_view)
{
    SVO_U32 offset[2]; /* 0: bytes to the first element */
    SVO_U32 stride[2]; /* 8: bytes between the starts of elements */
    SVO_U32 count[2]; /* 16: elements */
    SVO_U32 element_bytes; /* 24 */
};

/* What a triangle brings to the payload besides its vertices. 16 bytes. */
SVO_RECORD(svo_triangle_record)
{
    SVO_U32 material; /* 0: into the material records */
    SVO_U32 normal_xy; /* 4: the triangle's own unit normal, int16 x in the low half, y in the high half; 32767 = 1 */
    SVO_U32 normal_z_flags; /* 8: int16 z in the low half, SVO_TRIANGLE_* in the high half */
    SVO_U32 stretch; /* 12: ratio of its area to that of its projection along its axis, 2^30 = 1; below 2^31 */
};
/* The attributes are constant over the triangle. */
#define SVO_TRIANGLE_FLAT 0x10000u
/* Two bits from this bit on: 0, 1, 2, the axis along which its projection is largest; ties go to the first. */
#define SVO_TRIANGLE_AXIS_SHIFT 17
#define SVO_TRIANGLE_AXIS_MASK  3u

/* Arguments of the OpenCL front end: one draw. 64 bytes. */
SVO_RECORD(svo_voxelize_params)
{
    SVO_U32 depth; /* 0 */
    SVO_U32 voxel_log2; /* 4: edge of a voxel in grid units */
    SVO_U32 open; /* 8: 1: a voxel's far faces belong to its neighbors; 0: coverage is closed */
    SVO_U32 one_voxel; /* 12: not 0: every triangle lies inside one voxel */
    SVO_U32 first_item; /* 16 */
    SVO_U32 item_count; /* 20: one work-item each */
    SVO_U32 first_tile_id; /* 24: the work-item of the first tile */
    SVO_U32 first_tile; /* 28: into the tiles */
    SVO_U32 tile_count; /* 32: one work-item each */
    SVO_U32 left; /* 36: the draw's columns of voxels: least u */
    SVO_U32 bottom; /* 40: least v */
    SVO_U32 width; /* 44 */
    SVO_U32 height; /* 48 */
    SVO_U32 capacity; /* 52: fragments that the chunk can hold */
    SVO_U32 counter; /* 56: the chunk, whose counters have SVO_COUNTER_WORDS words */
    SVO_U32 most_columns; /* 60: of a window; at most SVO_TILE_COLUMNS */
};

/* Words of a chunk's counters, of 64 bits each: its fragments, and of these at first those that are decided; and the
   undecided ones. */
#define SVO_COUNTER_WORDS 4u

/* Arguments of the kernels that decide fragments. Doubles are two words, the low one first. 72 bytes. */
SVO_RECORD(svo_decide_params)
{
    SVO_U32 capacity; /* 0: fragments that the chunk can hold */
    SVO_U32 counter; /* 4: the chunk */
    SVO_U32 coverage; /* 8: svo_coverage */
    SVO_U32 is_double; /* 12: not 0: positions are doubles */
    SVO_U32 depth; /* 16: of the whole tree, also for a part */
    SVO_U32 corner[3]; /* 20: the first voxel of the part; 0 for a whole tree */
    SVO_U32 origin[6]; /* 32: of the whole grid, three doubles */
    SVO_U32 edge[2]; /* 56: of the whole grid, a double */
    SVO_U32 reserved[2]; /* 64 */
};

/* Arguments of the kernels that drop pairs by their alpha. 32 bytes. */
SVO_RECORD(svo_drop_params)
{
    SVO_U32 capacity; /* 0: fragments of the chunk, or where it has counters the room for them */
    SVO_U32 counter; /* 4: the chunk */
    SVO_U32 least_alpha; /* 8: 1 .. 255; pairs of less are dropped */
    SVO_U32 triangle_count; /* 12: a fragment's triangle is below it */
    SVO_U32 depth; /* 16 */
    SVO_U32 voxel_log2; /* 20: edge of a voxel in grid units */
    SVO_U32 weight_log2; /* 24: a voxel's face weighs 2^weight_log2 */
    SVO_U32 reserved; /* 28 */
};

/* Arguments of the subdivision kernels. Levels are counted from pad levels above the root. 56 bytes. */
SVO_RECORD(svo_blocks_params)
{
    SVO_U32 depth; /* 0 */
    SVO_U32 pad; /* 4: depth + pad is a multiple of 3 */
    SVO_U32 level; /* 8: of the blocks that the launch works on, a multiple of 3 */
    SVO_U32 fragment_count; /* 12: in this chunk, or the room for them */
    SVO_U32 inner_capacity; /* 16: nodes that child_mask and first_child have room for */
    SVO_U32 scan_groups; /* 20: groups of the scan of this level */
    SVO_U32 rank_blocks; /* 24: blocks, from the first, that there are ranks for */
    SVO_U32 level_capacity[3]; /* 28: inner nodes that the three levels below have room for */
    SVO_U32 block_begin; /* 40: the first block of the level */
    SVO_U32 next_begin; /* 44: the first block three levels below; unused where those are the leaves */
    SVO_U32 dense; /* 48: the last level that has all blocks, also empty ones */
    SVO_U32 dense_begin; /* 52: its first block */
};

/* Arguments of the subdivision shaders. 32 bytes. */
SVO_RECORD(svo_subdivide_params)
{
    SVO_U32 depth; /* 0 */
    SVO_U32 level; /* 4: the level whose nodes get their children */
    SVO_U32 inner_capacity; /* 8: nodes that child_mask and first_child have room for */
    SVO_U32 fragment_count; /* 12: in this chunk, or the room for them */
    SVO_U32 level_capacity; /* 16: inner nodes that the next level has room for */
    SVO_U32 scan_groups; /* 20: groups of the scan of this level */
    SVO_U32 reserved[2]; /* 24 */
};

/* The radix sort of the builder "sorted": bits of a digit, and groups, each of which owns a block of the list. */
#define SVO_SORT_BITS   6
#define SVO_SORT_DIGITS (1 << SVO_SORT_BITS)
#define SVO_SORT_BLOCKS 64
/* The same of long lists on CPUs, where fewer passes are worth more counts. */
#define SVO_SORT_WIDE_BITS   9
#define SVO_SORT_WIDE_DIGITS (1 << SVO_SORT_WIDE_BITS)
#define SVO_SORT_LONG_LIST   (1 << 17)
/* Local memory of the sort kernels: on CPUs a count for each digit; on GPUs a place and a bit for each work-item, for
   each digit. */
#define SVO_SORT_ITEM_WORDS   (SVO_GROUP_ITEMS / 32)
#define SVO_SORT_SERIAL_BYTES (4 * SVO_SORT_WIDE_DIGITS)
#define SVO_SORT_TILE_BYTES   (4 * SVO_SORT_DIGITS * (1 + SVO_SORT_ITEM_WORDS))

/* Arguments of the sort kernels. 16 bytes. */
SVO_RECORD(svo_sort_params)
{
    SVO_U32 fragment_count; /* 0 */
    SVO_U32 shift; /* 4: of the digit, in bits */
    SVO_U32 by_triangle; /* 8: not 0: a digit of the triangle, else of the code */
    SVO_U32 bits; /* 12: of the digit */
};

/* Arguments of the kernels that make nodes from sorted codes. 32 bytes. */
SVO_RECORD(svo_bottom_up_params)
{
    SVO_U32 depth; /* 0 */
    SVO_U32 count; /* 4: codes to read */
    SVO_U32 of_fragments; /* 8: not 0: they are fragments, else the codes of a level's nodes */
    SVO_U32 shift; /* 12: from those codes to the codes of the nodes to make: 0 for leaves, else 3 */
    SVO_U32 node_begin; /* 16: first node of the level to make */
    SVO_U32 child_begin; /* 20: first node of the level below it */
    SVO_U32 triangle_count; /* 24: a fragment's triangle is below it */
    SVO_U32 reserved; /* 28 */
};

/* Arguments of the link, pack and filter kernels. 72 bytes. */
SVO_RECORD(svo_filter_params)
{
    SVO_U32 depth; /* 0 */
    SVO_U32 level; /* 4: the level whose nodes sum up their children */
    SVO_U32 level_begin; /* 8: its first node */
    SVO_U32 level_count; /* 12: its nodes */
    SVO_U32 child_begin; /* 16: first node of the next level */
    SVO_U32 fragment_count; /* 20: in this chunk */
    SVO_U32 leaf_begin; /* 24: first leaf */
    SVO_U32 leaf_count; /* 28 */
    SVO_U32 voxel_log2; /* 32: edge of a voxel in grid units */
    SVO_U32 first_chunk; /* 36: not 0: sums are written, not added to */
    SVO_U32 digit_passes; /* 40: radix passes of four bits over a triangle index, an even number */
    SVO_U32 weight_log2; /* 44: a voxel's face weighs 2^weight_log2 */
    SVO_U32 fill_shift; /* 48: shift in bits from weights of the next level's nodes to fills; from 63 on fills are 0 */
    SVO_U32 payload_level; /* 52: the first level whose nodes have payload */
    SVO_U32 payload_begin; /* 56: its first node, whose payload is the first in the arrays */
    SVO_U32 first_index; /* 60: first of the launch's nodes or leaves, where a filter is launched in parts */
    SVO_U32 both_sides; /* 64: not 0: triangles count for projected areas from both sides */
    SVO_U32 grouped; /* 68: not 0: fragments are gathered in the order of their leaves */
};

/* Arguments of the kernels that make compact trees and expand them. 32 bytes. */
SVO_RECORD(svo_compact_params)
{
    SVO_U32 first_node; /* 0: of the launch's nodes */
    SVO_U32 node_count; /* 4 */
    SVO_U32 child_begin; /* 8: the first node of the next level */
    SVO_U32 payload_parents; /* 12: the first inner node whose children have payload */
    SVO_U32 payload_begin; /* 16: what first_payload has for the first node that has payload */
    SVO_U32 root_payload; /* 20: 1: the root has payload, else 0 */
    SVO_U32 element_halves; /* 24: of a payload array, in units of two bytes */
    SVO_U32 keep_below; /* 28: not 0: the next level is visited too */
};

/* Bytes of the least and the greatest payload below a node (kernels/compact/minimize.cl). */
#define SVO_MINIMIZE_BOUNDS_BYTES 32

/* Arguments of the kernels that merge full leaves. 48 bytes. */
SVO_RECORD(svo_minimize_params)
{
    SVO_U32 first_node; /* 0: of the launch's inner nodes */
    SVO_U32 node_count; /* 4: or elements */
    SVO_U32 child_first; /* 8: the first inner node of the level below */
    SVO_U32 merge; /* 12: 0: nodes of this level do not merge */
    SVO_U32 payload_begin; /* 16: what first_payload has for the first node that has payload */
    SVO_U32 new_payload_begin; /* 20: the same of the new first_payload */
    SVO_U32 color_tolerance; /* 24: red in the low byte, green, blue, alpha */
    SVO_U32 normal_tolerance; /* 28 */
    SVO_U32 fill_tolerance; /* 32 */
    SVO_U32 reserved[3]; /* 36 */
};

/* Of an entry of kernels/stages/material.cl: its material begins at this bit. */
#define SVO_ENTRY_SHIFT 48

/* One material. 32 bytes. */
SVO_RECORD(svo_material_record)
{
    SVO_U32 rgba; /* 0: base color, red in the low byte */
    SVO_U32 texel_offset; /* 4: of its texture in the texel buffer, in texels */
    SVO_U32 width; /* 8: texels; 0: no texture */
    SVO_U32 height; /* 12: texels */
    SVO_U32 wrap_u; /* 16: svo_wrap */
    SVO_U32 wrap_v; /* 20 */
    SVO_U32 least_alpha; /* 24: no point has less, vertex colors aside; of plans that drop pairs by alpha, else 0 */
    SVO_U32 reserved; /* 28 */
};

/* Arguments of the ray caster. Positions and lengths in voxels, from the grid's minimum corner; directions in the
   grid's axes. 128 bytes. */
SVO_RECORD(svo_cast_params)
{
    SVO_F32 eye[3]; /* 0 */
    SVO_F32 footprint; /* 12: width of a pixel at distance 1 */
    SVO_F32 corner[3]; /* 16: from the eye to the picture's upper left corner, at any distance */
    SVO_U32 width; /* 28: pixels */
    SVO_F32 across[3]; /* 32: from a pixel to its right neighbor, at that distance */
    SVO_U32 height; /* 44: pixels */
    SVO_F32 down[3]; /* 48: from a pixel to the one below, at that distance */
    SVO_U32 depth; /* 60 */
    SVO_F32 sun[3]; /* 64: unit, towards the light */
    SVO_U32 samples; /* 76: camera rays of a pixel */
    SVO_F32 up[3]; /* 80: unit, towards the sky */
    SVO_F32 occlusion_range; /* 92: range of the ambient occlusion */
    SVO_F32 background[3]; /* 96: what is behind everything, with SVO_PIXEL_COLOR */
    SVO_U32 pixel_flags; /* 108: SVO_PIXEL_* */
    SVO_F32 clip[4]; /* 112: a plane; what is below it is not there (kernels/rays/part.clh). Zeros: none */
};

/* Camera rays of a pixel: where shaded pictures are not asked for another number, those of a group that share light,
   and at most. */
#define SVO_CAST_SAMPLES      4u
#define SVO_PIXEL_SAMPLES_MAX 4096u

/* What is written of a pixel: svo_picture_output of trace.h. */
#define SVO_PIXEL_LINEAR      1u /* four floats, else four bytes */
#define SVO_PIXEL_COLOR       2u /* a color behind everything */
#define SVO_PIXEL_TRANSPARENT 4u /* nothing behind everything */

/* What kernels/rays/view.cl shows: svo_render_view of trace.h. */
#define SVO_VIEW_KIND_NORMAL    1u
#define SVO_VIEW_KIND_DEPTH     2u
#define SVO_VIEW_KIND_STEPS     3u
#define SVO_VIEW_KIND_LEVEL     4u
#define SVO_VIEW_KIND_TRIANGLES 5u

/* What the ray kernels know of a tree besides its arrays. World coordinates are sums of three floats each, which hold a
   double exactly. 68 bytes. */
SVO_RECORD(svo_ray_params)
{
    SVO_F32 origin[9]; /* 0: of the grid: x, y, z of the first parts, then of the second and third ones */
    SVO_F32 scale[3]; /* 36: grid units per world unit, in three parts */
    SVO_U32 depth; /* 48 */
    SVO_U32 snap_bits; /* 52: the grid is 2^snap_bits units wide */
    SVO_U32 inner_count; /* 56: nodes above the leaves */
    SVO_F32 reach; /* 60: no vertex has a coordinate beyond this, in grid units */
    SVO_U32 flags; /* 64: SVO_RAY_FLAG_* */
};
#define SVO_RAY_FLAG_WORLD 1u /* the leaves' rows are in world units */
#define SVO_RAY_FLAG_CLIP  2u /* triangles may reach outside the grid; hits there are none */

#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_draw_item, 8);
SVO_ASSERT_BYTES(svo_tile_item, 8);
SVO_ASSERT_BYTES(svo_large_item, 48);
SVO_ASSERT_BYTES(svo_plan_params, 80);
SVO_ASSERT_BYTES(svo_plan_total_params, 16);
SVO_ASSERT_BYTES(svo_plan_view, 28);
SVO_ASSERT_BYTES(svo_triangle_record, 16);
SVO_ASSERT_BYTES(svo_voxelize_params, 64);
SVO_ASSERT_BYTES(svo_decide_params, 72);
SVO_ASSERT_BYTES(svo_drop_params, 32);
SVO_ASSERT_BYTES(svo_blocks_params, 56);
SVO_ASSERT_BYTES(svo_subdivide_params, 32);
SVO_ASSERT_BYTES(svo_sort_params, 16);
SVO_ASSERT_BYTES(svo_bottom_up_params, 32);
SVO_ASSERT_BYTES(svo_filter_params, 72);
SVO_ASSERT_BYTES(svo_compact_params, 32);
SVO_ASSERT_BYTES(svo_minimize_params, 48);
SVO_ASSERT_BYTES(svo_material_record, 32);
SVO_ASSERT_BYTES(svo_cast_params, 128);
SVO_ASSERT_BYTES(svo_ray_params, 68);
#endif

#endif
