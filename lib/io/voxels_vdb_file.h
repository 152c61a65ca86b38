/* SPDX-License-Identifier: MIT */
/*
 * The tree of OpenVDB's and NanoVDB's grids, and what the reader and the writer of .vdb files share.
 *
 * Below a root, a table of nodes and tiles, are nodes of 32^3 and of 16^3 children and leaves of 8^3 voxels: K. Museth,
 * "VDB: High-Resolution Sparse Volumes with Dynamic Topology", ACM Transactions on Graphics 32 (3), 2013. OpenVDB's
 * io/Archive.cc, io/GridDescriptor.cc and io/Compression.h and the functions writeTopology and writeBuffers of its
 * nodes describe files: a header, metadata, and for each grid a descriptor, metadata, a transform, the masks and tiles
 * of all nodes, depth first, and then the values of all leaves in that order.
 */
#ifndef SVO_LIB_IO_VOXELS_VDB_FILE_H
#define SVO_LIB_IO_VOXELS_VDB_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/status.h"

/* ---- the tree ---- */

/* Levels of nodes. */
enum { VDB_LEAF, VDB_LOWER, VDB_UPPER, VDB_ROOT, VDB_NODE_LEVELS = VDB_ROOT };

#define VDB_NODE_LOG2    12 /* voxels along the edge of a node below the root */
#define VDB_LEAF_VALUES  512u
#define VDB_UPPER_VALUES 32768u /* the most of a node */
#define VDB_LEAF_BYTES   (VDB_LEAF_VALUES / 8) /* of its mask */
#define VDB_UPPER_BYTES  (VDB_UPPER_VALUES / 8)

/* Names of the grids that are written, and of those that are read for colors and materials. */
#define VDB_DENSITY  "density"
#define VDB_COLOR    "color"
#define VDB_MATERIAL "material"
#define VDB_SURFACE  "surface" /* a level set */

/* The log2 of the voxels along an edge of a node, and of the children along it. */
static inline uint32_t vdb_voxels_log2(int level)
{
    return level == VDB_LEAF ? 3 : level == VDB_LOWER ? 7 : VDB_NODE_LOG2;
}

static inline uint32_t vdb_children_log2(int level)
{
    return (uint32_t)level + 3;
}

/* Children of a node, or voxels of a leaf. */
static inline uint32_t vdb_slots(int level)
{
    return 1u << 3 * vdb_children_log2(level);
}

/* Which child of a node, or which voxel of a leaf, holds a coordinate. */
static inline uint32_t vdb_child_of(int level, const int32_t at[3])
{
    const uint32_t bits = vdb_children_log2(level);
    const uint32_t shift = vdb_voxels_log2(level) - bits;
    const uint32_t mask = (1u << bits) - 1;
    uint32_t child = 0;
    for (int axis = 0; axis < 3; ++axis) {
        child = child << bits | ((uint32_t)at[axis] >> shift & mask);
    }
    return child;
}

/* The least corner of a child. at: that of the node. */
static inline void vdb_corner_of(int level, const int32_t at[3], uint32_t child, int32_t corner[3])
{
    const uint32_t bits = vdb_children_log2(level);
    const uint32_t shift = vdb_voxels_log2(level) - bits;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        corner[axis] = at[axis] + (int32_t)((child >> (2 - axis) * bits & ((1u << bits) - 1)) << shift);
    }
}

static inline bool vdb_has_bit(const uint8_t *mask, uint32_t bit)
{
    return (mask[bit >> 3] >> (bit & 7u) & 1u) != 0;
}

/* ---- the file ---- */

#define VDB_MAGIC_BYTES   8u
#define VDB_MAGIC         " BDV" /* and four bytes of 0 */
#define VDB_VERSION       224u /* that is written */
#define VDB_VERSION_LEAST 222u /* from here on the way values are compressed stands in each grid */
#define VDB_VERSION_MOST  225u
#define VDB_UUID_BYTES    36u
#define VDB_HALF_SUFFIX   "_HalfFloat"
#define VDB_SEPARATOR     '\x1e' /* between a grid's name and a number that makes it unique */

/* How values are compressed. */
enum { VDB_ZIP = 1, VDB_ACTIVE_MASK = 2, VDB_BLOSC = 4 };

/* What stands for the inactive values of a node, its first byte. */
enum {
    VDB_ALL_BACKGROUND,
    VDB_ALL_NEGATIVE, /* the negative background */
    VDB_ALL_ONE, /* one other value */
    VDB_TWO_SIGNS, /* a mask chooses the background, else its negative */
    VDB_ONE_AND_BACKGROUND, /* a mask chooses the background, else one other value */
    VDB_TWO_VALUES, /* a mask chooses the second of two */
    VDB_EVERY_VALUE /* all values are there, inactive ones too */
};

/* ---- the reader's trees (voxels_vdb_tree.c) ---- */

struct voxel_reader;

typedef enum vdb_kind { VDB_FLOAT, VDB_DOUBLE, VDB_INT32, VDB_INT64, VDB_BOOL, VDB_MASK } vdb_kind;

/* A type of trees that is read. */
typedef struct vdb_type {
    const char *name;
    vdb_kind kind;
    uint32_t components;
    uint32_t value_bytes; /* in memory and, unless they are halves, in the file */
} vdb_type;

#define VDB_VALUE_BYTES_MAX 24u

/* The type of that name; NULL: it is not read. */
const vdb_type *svo_i_vdb_type(const char *name, size_t bytes);

/* A place in the file, with what messages say of it. */
typedef struct vdb_input {
    struct voxel_reader *reader;
    const char *grid; /* its name; NULL: none */
    size_t at, end;
    struct vdb_unpacker *unpacker; /* made when it is needed */
} vdb_input;

/* Releases what reading took. */
void svo_i_vdb_input_end(vdb_input *in);

/* Fails: the file, the grid, and "WHAT, at byte N". */
svo_status svo_i_vdb_damaged(const vdb_input *in, const char *what, size_t at);
/* Takes the next bytes. what: which they are, for the message that they are cut off. */
svo_status svo_i_vdb_take(vdb_input *in, size_t bytes, const char *what, const uint8_t **out);

/* A node. */
typedef struct vdb_node {
    int32_t at[3];
    size_t masks; /* in the file: of children, and behind it of active values; of a leaf the latter alone */
    size_t values; /* in the file: the byte that begins them */
} vdb_node;

/* A tree of the file. Nodes of a level stand in the order of the file, which is that of svo_i_vdb_find. */
typedef struct vdb_tree {
    const vdb_type *type;
    bool is_half; /* values are halves in the file */
    uint32_t compression;
    uint8_t background[VDB_VALUE_BYTES_MAX];
    size_t tiles; /* of the root, in the file: a place, a value, and a byte that is not 0 where it is active */
    uint32_t tile_count;
    vdb_node *nodes[VDB_NODE_LEVELS]; /* owned, as values */
    uint64_t counts[VDB_NODE_LEVELS], capacities[VDB_NODE_LEVELS];
    uint8_t *values[VDB_NODE_LEVELS]; /* of one node */
    const vdb_node *held[VDB_NODE_LEVELS]; /* that node; NULL: none */
} vdb_tree;

void svo_i_vdb_tree_end(vdb_tree *tree);

/* Reads what stands before the leaves' values, then those. Each checks that it ends where the grid says. */
svo_status svo_i_vdb_read_topology(vdb_input *in, vdb_tree *tree);
svo_status svo_i_vdb_read_buffers(vdb_input *in, vdb_tree *tree);

/* The values of a node, until another one of its level is asked for. Not of leaves of VDB_BOOL or VDB_MASK. */
svo_status svo_i_vdb_values(vdb_input *in, vdb_tree *tree, int level, const vdb_node *node, const uint8_t **values);

/* The node of a level that holds a voxel; NULL: there is none. */
const vdb_node *svo_i_vdb_find(const vdb_tree *tree, int level, const int32_t at[3]);
/* The root's tile that holds a voxel; NULL: there is none. */
const uint8_t *svo_i_vdb_find_tile(const vdb_input *in, const vdb_tree *tree, const int32_t at[3]);

/* A component of a value as a number. */
double svo_i_vdb_number(const vdb_type *type, const uint8_t *value, uint32_t component);

#endif
