/* SPDX-License-Identifier: MIT */
/*
 * What the reader and the writer of .nvdb files share: the records of a file, and a grid of the file in memory.
 *
 * A file is a row of segments: a header, a record and a name for each of its grids, and the grids. A grid is a header,
 * a tree's header, a root with a table of tiles, and nodes of three levels: 32^3 and 16^3 children, and leaves of 8^3
 * voxels. NanoVDB's header for C, PNanoVDB.h, has the places of all fields in a grid; NanoVDB's util/IO.h and
 * util/GridChecksum.h describe the file and the checksum.
 */
#ifndef SVO_LIB_IO_VOXELS_NVDB_FILE_H
#define SVO_LIB_IO_VOXELS_NVDB_FILE_H

#include <stdint.h>
#include <string.h>

#define PNANOVDB_C
#include <nanovdb/PNanoVDB.h>

#define NVDB_MAGIC       "NanoVDB" /* and a digit */
#define NVDB_MAJOR       PNANOVDB_MAJOR_VERSION_NUMBER
#define NVDB_MAJOR_SHIFT 21 /* of a version; 11 bits of the minor one and 10 of the patch follow */
#define NVDB_NO_SUM      UINT32_MAX /* in place of a checksum that was not made */

/* The header of a segment. */
#define NVDB_HEADER_BYTES       16u
#define NVDB_HEADER_VERSION     8u
#define NVDB_HEADER_GRID_COUNT  12u
#define NVDB_HEADER_COMPRESSION 14u

/* The record of a grid. */
#define NVDB_RECORD_BYTES       176u
#define NVDB_RECORD_GRID_BYTES  0u
#define NVDB_RECORD_FILE_BYTES  8u
#define NVDB_RECORD_NAME_HASH   16u
#define NVDB_RECORD_VOXELS      24u
#define NVDB_RECORD_TYPE        32u
#define NVDB_RECORD_CLASS       36u
#define NVDB_RECORD_WORLD_BOX   40u
#define NVDB_RECORD_BOX         88u
#define NVDB_RECORD_VOXEL_SIZE  112u
#define NVDB_RECORD_NAME_BYTES  136u
#define NVDB_RECORD_NODE_COUNTS 140u
#define NVDB_RECORD_VERSION     172u

/* Levels of nodes, as PNanoVDB.h counts them. */
enum { NVDB_LEAF, NVDB_LOWER, NVDB_UPPER, NVDB_ROOT, NVDB_NODE_LEVELS = NVDB_ROOT };

/* Names of the grids that are written, and of those that are read for colors and materials. */
#define NVDB_DENSITY  "density"
#define NVDB_COLOR    "color"
#define NVDB_MATERIAL "material"
#define NVDB_SURFACE  "surface" /* a level set */

/* The log2 of the voxels along an edge of a node, and of the children along it. */
static inline uint32_t nvdb_voxels_log2(int level)
{
    return level == NVDB_LEAF ? 3 : level == NVDB_LOWER ? 7 : 12;
}

static inline uint32_t nvdb_children_log2(int level)
{
    return (uint32_t)level + 3;
}

/* Which child of a node, or which voxel of a leaf, holds a coordinate. */
static inline uint32_t nvdb_child_of(int level, const int32_t at[3])
{
    const uint32_t bits = nvdb_children_log2(level);
    const uint32_t shift = nvdb_voxels_log2(level) - bits;
    const uint32_t mask = (1u << bits) - 1;
    uint32_t child = 0;
    for (int axis = 0; axis < 3; ++axis) {
        child = child << bits | ((uint32_t)at[axis] >> shift & mask);
    }
    return child;
}

/* The key of a tile of the root: the upper 20 bits of each coordinate, x above y above z. */
static inline uint64_t nvdb_key_of(const int32_t at[3])
{
    return (uint64_t)((uint32_t)at[0] >> 12) << 42 | (uint64_t)((uint32_t)at[1] >> 12) << 21 | (uint32_t)at[2] >> 12;
}

/* Where in a node the child mask and the table of children and values begin, and the bytes of an entry. */
static inline uint32_t nvdb_child_mask(int level)
{
    return level == NVDB_LOWER ? PNANOVDB_LOWER_OFF_CHILD_MASK : PNANOVDB_UPPER_OFF_CHILD_MASK;
}

static inline uint32_t nvdb_table(const pnanovdb_grid_type_constants_t *places, int level)
{
    return level == NVDB_LOWER ? places->lower_off_table : places->upper_off_table;
}

static inline uint32_t nvdb_node_bytes(const pnanovdb_grid_type_constants_t *places, int level)
{
    return level == NVDB_LEAF ? places->leaf_size : level == NVDB_LOWER ? places->lower_size : places->upper_size;
}

/* The version of the format that is written and read. */
uint32_t svo_i_nvdb_version(void);

/* Where the parts of a grid begin, from its first byte on. */
typedef struct nvdb_parts {
    const pnanovdb_grid_type_constants_t *places; /* of the fields of nodes, by the grid's type */
    uint64_t root, root_end;
    uint64_t nodes[NVDB_NODE_LEVELS]; /* the first node of each level */
    uint32_t counts[NVDB_NODE_LEVELS]; /* nodes of each level */
} nvdb_parts;

/* The checksums of a grid: of its headers and its root, and of the checksums of its nodes, the upper ones first. */
void svo_i_nvdb_sums(const uint8_t *grid, const nvdb_parts *parts, uint32_t sums[2]);

#endif
