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

#include "io/voxels_vdb_file.h"

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

/* The key of a tile of the root: the upper 20 bits of each coordinate, x above y above z. */
static inline uint64_t nvdb_key_of(const int32_t at[3])
{
    return (uint64_t)((uint32_t)at[0] >> 12) << 42 | (uint64_t)((uint32_t)at[1] >> 12) << 21 | (uint32_t)at[2] >> 12;
}

/* Where in a node the child mask and the table of children and values begin, and the bytes of an entry. */
static inline uint32_t nvdb_child_mask(int level)
{
    return level == VDB_LOWER ? PNANOVDB_LOWER_OFF_CHILD_MASK : PNANOVDB_UPPER_OFF_CHILD_MASK;
}

static inline uint32_t nvdb_table(const pnanovdb_grid_type_constants_t *places, int level)
{
    return level == VDB_LOWER ? places->lower_off_table : places->upper_off_table;
}

static inline uint32_t nvdb_node_bytes(const pnanovdb_grid_type_constants_t *places, int level)
{
    return level == VDB_LEAF ? places->leaf_size : level == VDB_LOWER ? places->lower_size : places->upper_size;
}

/* The version of the format that is written and read. */
uint32_t svo_i_nvdb_version(void);

/* Where the parts of a grid begin, from its first byte on. */
typedef struct nvdb_parts {
    const pnanovdb_grid_type_constants_t *places; /* of the fields of nodes, by the grid's type */
    uint64_t root, root_end;
    uint64_t nodes[VDB_NODE_LEVELS]; /* the first node of each level */
    uint32_t counts[VDB_NODE_LEVELS]; /* nodes of each level */
} nvdb_parts;

/* The checksums of a grid: of its headers and its root, and of the checksums of its nodes, the upper ones first. */
void svo_i_nvdb_sums(const uint8_t *grid, const nvdb_parts *parts, uint32_t sums[2]);

#endif
