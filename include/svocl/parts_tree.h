/* SPDX-License-Identifier: MIT */
/** \file
 * A folder of parts as a tree, part of svocl::io. Its nodes are numbered in 64 bits over all parts and in 32 bits
 * within each, so it may have more nodes than a .svo file, whose limit is 2^32 - 2. Nothing is stitched: what is asked
 * for is read from the parts where they lie.
 *
 *     svo_parts_tree_open       folder of svo_parts_create, all parts built -> svo_parts_tree
 *     svo_parts_tree_get_info   what it holds
 *     svo_parts_tree_hash       the hash of the stitched tree
 *     svo_parts_tree_check      some parts, or all, byte by byte
 *     svo_parts_tree_load       a region -> svo_tree
 *     svo_parts_tree_save       a region -> a .svo file
 *     svo_paged_open            pictures of a region, see paged.h
 *
 * A region is what lies under one node, down to a level: a tree of its own, whose grid is the node. The region of the
 * root with all levels is the whole tree: svo_parts_tree_save then writes the file of svo_parts_finish, byte for byte,
 * and the region of the root down to a level is what svo_tree_load gives for svo_load_options.last_level. Regions that
 * leave out anything have nodes and payload alone, no lists and no geometry. A region has at most 2^32 - 2 nodes and
 * SVO_DEPTH_MAX levels below its root, and any tree has regions that small.
 *
 * Parts are known by the plan's identity, and each by the checksum of its head when the tree was opened: a part that is
 * missing, damaged, of another plan, or another file than it was, is refused by its name. An array of a part is
 * compared with its checksum before the first byte of it is used. Memory holds about 400 bytes and 8 bytes a level for
 * each part and for each node above the parts, however large the tree is.
 *
 * Thread-safety: one thread at a time may use a svo_parts_tree.
 */
#ifndef SVOCL_PARTS_TREE_H
#define SVOCL_PARTS_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/export.h"
#include "svocl/files.h"
#include "svocl/part_types.h"
#include "svocl/status.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/** An open folder of parts. */
typedef struct svo_parts_tree svo_parts_tree;

/** What a tree of parts holds. */
typedef struct svo_parts_tree_info {
    size_t struct_size; /**< sizeof(svo_parts_tree_info) */
    /** As of the stitched tree, but for counts of nodes and lists, which are 0 here: they may need 64 bits, and are
     *  below. */
    svo_tree_info tree;
    uint64_t part_count; /**< parts with nodes */
    uint64_t file_bytes; /**< of their files */
    uint64_t node_count; /**< inner_count + leaf_count */
    uint64_t inner_count; /**< nodes above the deepest level */
    uint64_t leaf_count; /**< nodes of the deepest level */
    uint64_t list_count; /**< entries of all leaf lists; 0 without SVO_NEED_RAYS */
    uint64_t level_nodes[SVO_PARTS_LEVELS_MAX]; /**< nodes of each level */
    /** The deepest level that a region of the whole tree can have: SVO_DEPTH_MAX at most, and down to it at most
     *  2^32 - 2 nodes. The depth, where all of it can be stitched. */
    uint32_t last_level;
    uint32_t reserved; /**< 0 */
} svo_parts_tree_info;

/** An empty output. */
#define SVO_PARTS_TREE_INFO_INIT SVO_STRUCT_INIT(svo_parts_tree_info)

/** A region of a tree of parts. */
typedef struct svo_parts_region {
    size_t struct_size; /**< sizeof(svo_parts_region) */
    uint32_t level; /**< of the node that is the region's root, below last_level; 0: the whole grid */
    uint32_t last_level; /**< of the whole tree: the region's leaves; 0: the deepest */
    uint64_t code; /**< the node's Morton code, below 8^level */
    uint64_t voxels_max; /**< most nodes that svo_parts_tree_load loads; 0: by the memory that is there */
} svo_parts_region;

/** The whole tree. */
#define SVO_PARTS_REGION_INIT SVO_STRUCT_INIT(svo_parts_region)

/** Opens a folder whose parts are all built. Reads the heads of the parts and makes the nodes above them.
 *
 * \param folder of svo_parts_create, or the path of the file "plan" in it
 * \param out receives the tree
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR (no folder of parts, or a part is missing; the message names it), SVO_FILE_DAMAGED (the plan,
 *          or a part is damaged or of another plan), SVO_UNAVAILABLE (the folder was planned anew meanwhile),
 *          SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_parts_tree_open(const char *folder, svo_parts_tree **out, svo_message *message);

/** Closes a tree; its files stay.
 *
 * \param tree set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_parts_tree_close(svo_parts_tree **tree);

/** What the tree holds.
 *
 * \param tree not NULL
 * \param info receives it
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_parts_tree_get_info(const svo_parts_tree *tree, svo_parts_tree_info *info, svo_message *message);

/** The hash of the tree, by one reading of its parts, level after level: that of svo_tree_hash of the stitched tree. A
 *  tree that cannot be stitched has the hash that its arrays would have, with first nodes and places in lists of 64
 *  bits in place of 32.
 *
 * \param tree not NULL
 * \param scope what is hashed
 * \param text receives 32 hexadecimal digits
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR, SVO_FILE_DAMAGED, SVO_UNAVAILABLE, SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on
 *          failure. */
SVO_API svo_status svo_parts_tree_hash(svo_parts_tree *tree, svo_hash_scope scope, char text[SVO_HASH_TEXT_BYTES],
                                       svo_message *message);

/** Checks parts: every byte of each, and that child masks and levels agree. Parts are spread evenly over the tree.
 *
 * \param tree not NULL
 * \param count how many; 0, or more than there are: all
 * \param seed which ones: the first is the seed modulo the distance between two
 * \param checked receives how many were checked; NULL allowed
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR, SVO_FILE_DAMAGED, SVO_UNAVAILABLE, SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on
 *          failure. */
SVO_API svo_status svo_parts_tree_check(svo_parts_tree *tree, uint64_t count, uint64_t seed, uint64_t *checked,
                                        svo_message *message);

/** Loads a region.
 *
 * \param tree not NULL
 * \param region NULL means the whole tree
 * \param out receives a tree with host arrays, on no device
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_CAPACITY_EXCEEDED (more than SVO_DEPTH_MAX levels, or 2^32 - 2 nodes or list entries; the message has
 *          the deepest level that is possible), SVO_INVALID_ARGUMENT (levels or code out of range, or no node is
 *          there), and what svo_tree_load and svo_parts_tree_open return. */
SVO_API svo_status svo_parts_tree_load(svo_parts_tree *tree, const svo_parts_region *region, svo_tree **out,
                                       svo_message *message);

/** Writes a region as a .svo file, in blocks of a few MB, so that memory does not grow with it.
 *
 * \param tree not NULL
 * \param region NULL means the whole tree
 * \param sink the file
 * \param info receives what the file holds; its struct_size is set by the caller. NULL allowed
 * \param message receives the reason for a failure; NULL allowed
 * \returns what svo_parts_tree_load and svo_tree_save return. */
SVO_API svo_status svo_parts_tree_save(svo_parts_tree *tree, const svo_parts_region *region, svo_sink sink,
                                       svo_tree_info *info, svo_message *message);

#ifdef __cplusplus
}
#endif

#endif
