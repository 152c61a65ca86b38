/* SPDX-License-Identifier: MIT */
/** \file
 * Trees in parts, part of svocl::io: a tree that is larger than memory, or that several machines build, is made from
 * parts that lie under nodes of the whole grid, and the parts together are the whole tree, byte for byte.
 *
 *     svo_plan_get_part_header  plan of the whole mesh -> what all parts share      plan.h
 *     svo_plan_create, svo_build  with options.part_header: one part -> its tree    plan.h, build.h
 *     svo_part_save             the part's tree -> a part file
 *     svo_parts_stitch          part files, in any order -> a .svo file
 *
 * A part file is a head, a table of segments and the segments: of each level of the part the child masks and the
 * payload, of the leaves also areas and lists, in Morton order. The head has the sums of the part's root, unrounded: the
 * levels above the parts are rounded once, from sums, by the same integer arithmetic as all others. Numbers are
 * little-endian.
 *
 *     0    u8[8] 89 53 56 50 0d 0a 1a 0a
 *     8    u32 version, 1; u32 number of segments
 *     16   u64 length of the file; u64 XXH3 of bytes 32 .. the end of the table
 *     32   u64 XXH3 of the header's values; u64 code; u32 level; u32 1 for a mesh file, 0 for a part
 *     56   u64 fragments; u64 weight, u64 color[4], i64 normal[3]: the root's sums
 *     128  u32 level_begin[18]: of the part's own levels, as in svo_tree_info
 *     200  segments: u32 kind, u32 level, u64 offset, u64 length, u64 XXH3 of the segment
 *
 * A kind is a svo_tree_buffer; 14 are the root's materials and weights, a u64 each: material << 48 | weight. list_begin
 * has an entry per leaf, and lists have positions among the kept triangles of the whole mesh.
 *
 * Thread-safety: functions may be called at the same time for different files.
 */
#ifndef SVOCL_PARTS_H
#define SVOCL_PARTS_H

#include "svocl/plan.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What a part file holds. */
typedef struct svo_part_info {
    size_t struct_size; /**< sizeof(svo_part_info) */
    uint32_t level; /**< of the node that the part lies under */
    uint64_t code; /**< its Morton code */
    uint64_t node_count; /**< 0: no triangle touches the part */
    uint64_t leaf_count; /**< of those, on the deepest level */
    uint64_t fragments; /**< (voxel, triangle) pairs */
    uint64_t file_bytes; /**< length of the file */
} svo_part_info;

/** An empty output. */
#define SVO_PART_INFO_INIT SVO_STRUCT_INIT(svo_part_info)

/** Saves the tree of a part. The file appears whole or not at all.
 *
 * \param tree built from a plan with part_header, with host arrays (svo_tree_download)
 * \param path the file
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (not a part, no host arrays), SVO_FILE_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_part_save(const svo_tree *tree, const char *path, svo_message *message);

/** Saves what rays meet of the whole mesh: snapped vertices, indices, names of triangles and the mesh's own positions.
 *  svo_parts_stitch needs it for trees with SVO_NEED_RAYS.
 *
 * \param plan of the whole mesh, with SVO_NEED_RAYS; arrays that a device has are copied to the host
 * \param path the file, which appears whole or not at all
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT, SVO_FILE_ERROR, SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_part_save_mesh(svo_plan *plan, const char *path, svo_message *message);

/** Reads a part file whole and checks every byte.
 *
 * \param header of the tree that the part must belong to
 * \param path the file
 * \param info receives what it holds; NULL allowed
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR (cannot be read), SVO_FILE_DAMAGED (truncated, changed, of another tree),
 *          SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_part_check(const svo_part_header *header, const char *path, svo_part_info *info,
                                  svo_message *message);

/** Puts parts together: writes the .svo file that svo_tree_save writes of the tree in one piece, byte for byte.
 *
 * Memory holds one level of one part at a time, and about 200 bytes per part and per node above the parts.
 *
 * \param header of the tree
 * \param paths part_count part files, in any order; parts may have different levels but not overlap. Where no part is,
 *        the tree is empty: parts that no triangle touches need no file
 * \param part_count 0 is allowed
 * \param mesh_path file of svo_part_save_mesh; NULL without SVO_NEED_RAYS
 * \param path the .svo file, which appears whole or not at all; no pipe or terminal, since its head is written last
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_DAMAGED (a part is damaged, of another tree, or overlaps another), SVO_CAPACITY_EXCEEDED (more than
 *          2^32 - 2 nodes or list entries; the message has the number), SVO_FILE_ERROR, SVO_INVALID_ARGUMENT or
 *          SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_parts_stitch(const svo_part_header *header, const char *const *paths, size_t part_count,
                                    const char *mesh_path, const char *path, svo_message *message);

#ifdef __cplusplus
}
#endif

#endif
