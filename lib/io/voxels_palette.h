/* SPDX-License-Identifier: MIT */
/* A palette of at most 255 colors for a list of voxels. */
#ifndef SVO_LIB_IO_VOXELS_PALETTE_H
#define SVO_LIB_IO_VOXELS_PALETTE_H

#include "io/voxels_writer.h"

#define PALETTE_ENTRIES 256 /* entry 0 means no voxel */

/* A pair of a color and a material, with its palette entry. */
typedef struct palette_pair {
    uint64_t key; /* material << 32 | red << 24 | green << 16 | blue << 8 | alpha */
    uint64_t count; /* voxels that have it */
    uint32_t entry; /* 1 .. 255 */
} palette_pair;

typedef struct voxel_palette {
    uint8_t rgba[PALETTE_ENTRIES][4];
    uint32_t material[PALETTE_ENTRIES]; /* whose properties the entry has */
    bool by_material; /* entry i is material i, for voxels and properties alike */
    palette_pair *pairs; /* pair_count, by key; owned */
    size_t pair_count;
    uint32_t error; /* largest difference of a component */
} voxel_palette;

/* Makes the palette of the writer's voxels; svo_i_palette_free afterwards, on failure too. */
svo_status svo_i_palette_make(const voxel_writer *writer, voxel_palette *palette);
void svo_i_palette_free(voxel_palette *palette);

/* The entry of a voxel, 1 .. 255. */
uint8_t svo_i_palette_entry(const voxel_palette *palette, const svo_voxel *voxel);

#endif
