/* SPDX-License-Identifier: MIT */
/* Version and checksums of .nvdb files. */
#include "io/voxels_nvdb_file.h"

#include "io/voxels_files.h"

uint32_t svo_i_nvdb_version(void)
{
    return (uint32_t)PNANOVDB_MAJOR_VERSION_NUMBER << NVDB_MAJOR_SHIFT | (uint32_t)PNANOVDB_MINOR_VERSION_NUMBER << 10 |
           (uint32_t)PNANOVDB_PATCH_VERSION_NUMBER;
}

/* CRC-32, as zlib has it. */
static uint32_t add_to_sum(const uint32_t byte_sums[256], uint32_t sum, const uint8_t *bytes, uint64_t count)
{
    for (uint64_t i = 0; i < count; ++i) {
        sum = byte_sums[(sum ^ bytes[i]) & 0xffu] ^ sum >> 8;
    }
    return sum;
}

void svo_i_nvdb_sums(const uint8_t *grid, const nvdb_parts *parts, uint32_t sums[2])
{
    uint32_t byte_sums[256];
    uint32_t of_nodes = UINT32_MAX;
    svo_i_voxels_byte_sums(byte_sums);
    sums[0] = ~add_to_sum(byte_sums, UINT32_MAX, grid + PNANOVDB_GRID_OFF_VERSION,
                          parts->root_end - PNANOVDB_GRID_OFF_VERSION);
    for (int level = VDB_UPPER; level >= VDB_LEAF; --level) {
        const uint32_t bytes = nvdb_node_bytes(parts->places, level);
        for (uint32_t i = 0; i < parts->counts[level]; ++i) {
            const uint8_t *node = grid + parts->nodes[level] + (uint64_t)i * bytes;
            const uint64_t sum = ~add_to_sum(byte_sums, UINT32_MAX, node, bytes) & UINT32_MAX; /* 64 bits, as there */
            of_nodes = add_to_sum(byte_sums, of_nodes, (const uint8_t *)&sum, sizeof sum);
        }
    }
    sums[1] = parts->counts[VDB_UPPER] > 0 ? ~of_nodes : NVDB_NO_SUM;
}
