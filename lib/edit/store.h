/* SPDX-License-Identifier: MIT */
/*
 * The nodes of an edit: written once, one after the other, and never changed, so that versions share what they have in
 * common (Driscoll et al., "Making Data Structures Persistent", 1989; for voxels Careil et al., "Interactively
 * Modifying Compressed Sparse Voxel Representations", 2020).
 *
 * A node is a cube of 2^level voxels along each axis:
 *
 *     empty     SVO_I_EDIT_EMPTY, no node
 *     uniform   full, with one color and material and no normals; a node for any level
 *     inner     up to eight children of level - 1, and how many voxels they have
 *     block     on level 2: 64 places, the color and material of each voxel, or one for all, and the normal of each, or
 *               none for all
 *
 * Nodes lie in segments, in units of 8 bytes. Children come before their parents. So nodes that are still needed can be
 * moved down in one pass in the order of their places, without a second copy of anything (Lisp 2's compaction, with the
 * bit map of Abuaid et al., "An Efficient Parallel Heap Compaction Algorithm", 2004). Each segment has room for what
 * that takes: a bit for each unit and a number for each 64.
 */
#ifndef SVO_LIB_EDIT_STORE_H
#define SVO_LIB_EDIT_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/memory.h"

#define SVO_I_EDIT_EMPTY       0u /* in place of a node: no voxels */
#define SVO_I_EDIT_BLOCK_LEVEL 2u
#define SVO_I_EDIT_ROOT_LEVEL  21u /* SVO_EDIT_EXTENT is 2^21 */
#define SVO_I_EDIT_CELLS       64u /* of a block, by Morton code */

/* How many bits are set. */
static inline uint32_t svo_i_edit_count(uint64_t bits)
{
    bits -= bits >> 1 & UINT64_C(0x5555555555555555);
    bits = (bits & UINT64_C(0x3333333333333333)) + (bits >> 2 & UINT64_C(0x3333333333333333));
    bits = (bits + (bits >> 4)) & UINT64_C(0x0f0f0f0f0f0f0f0f);
    return (uint32_t)(bits * UINT64_C(0x0101010101010101) >> 56);
}

/* The place of the lowest bit that is set; not of 0. */
static inline uint32_t svo_i_edit_lowest(uint64_t bits)
{
    return svo_i_edit_count(~bits & (bits - 1));
}

/* Where a node is: its first unit. */
typedef uint32_t svo_i_edit_ref;

typedef enum svo_i_edit_kind {
    SVO_I_EDIT_UNIFORM = 1,
    SVO_I_EDIT_INNER = 2,
    SVO_I_EDIT_BLOCK = 4, /* and, as bits: */
    SVO_I_EDIT_COLORS = 8, /* each voxel has a color of its own */
    SVO_I_EDIT_MATERIALS = 16, /* each voxel has a material of its own */
    SVO_I_EDIT_NORMALS = 32 /* each voxel has a normal of its own */
} svo_i_edit_kind;

/* What a voxel has, but for its normal. */
typedef struct svo_i_edit_payload {
    uint32_t color; /* the bytes of RGBA8 */
    uint16_t material;
} svo_i_edit_payload;

/* The first unit of every node. */
typedef struct svo_i_edit_node {
    uint8_t kind; /* svo_i_edit_kind */
    uint8_t mask; /* inner: which children are there */
    uint16_t material; /* of all voxels, where the kind has one */
    uint32_t color; /* the same; elsewhere about the mean, for pictures (kernels/rays/read_edit.clh) */
} svo_i_edit_node;

/* An inner node. children has as many as the mask has bits. */
typedef struct svo_i_edit_inner {
    svo_i_edit_node node;
    uint64_t voxel_count;
    svo_i_edit_ref children[8];
} svo_i_edit_inner;

/* The 64 places of a block, unpacked. */
typedef struct svo_i_edit_cells {
    uint64_t mask; /* bit i: there is a voxel at Morton code i */
    uint32_t color[SVO_I_EDIT_CELLS];
    uint16_t material[SVO_I_EDIT_CELLS];
    uint64_t normal[SVO_I_EDIT_CELLS]; /* x, y, z in 16 bits each, from the lowest on; 0: none */
} svo_i_edit_cells;

static inline uint64_t svo_i_edit_pack_normal(const int16_t normal[3])
{
    return (uint64_t)(uint16_t)normal[0] | (uint64_t)(uint16_t)normal[1] << 16 | (uint64_t)(uint16_t)normal[2] << 32;
}

static inline void svo_i_edit_unpack_normal(uint64_t packed, int16_t normal[3])
{
    for (uint32_t axis = 0; axis < 3; ++axis) {
        normal[axis] = (int16_t)(packed >> 16u * axis & 0xffffu);
    }
}

struct svo_i_edit_segment;

/* All zero but memory, max_bytes and has_normals: no nodes. */
typedef struct svo_i_edit_store {
    svo_i_memory memory;
    bool has_normals; /* false: those of cells are dropped */
    uint64_t max_bytes; /* of all segments */
    struct svo_i_edit_segment **segments; /* owned, as they themselves are */
    uint32_t segment_count;
    uint32_t segment_room; /* elements of segments */
    uint32_t top; /* the first unit that is free */
    svo_i_edit_ref last_uniform; /* or SVO_I_EDIT_EMPTY: neighbors often are the same */
    svo_status failure; /* why the last allocation failed: SVO_OUT_OF_HOST_MEMORY or, by max_bytes,
                           SVO_CAPACITY_EXCEEDED */
} svo_i_edit_store;

/* The bytes of a segment, with what a collection needs. */
extern const size_t svo_i_edit_segment_bytes;

void svo_i_edit_store_release(svo_i_edit_store *store);

/* What the store holds, and what of it has nodes, bytes. */
uint64_t svo_i_edit_store_held(const svo_i_edit_store *store);
uint64_t svo_i_edit_store_used(const svo_i_edit_store *store);

/* The units below top in a segment, from the first one on; segments have 2^17 units of 8 bytes. */
#define SVO_I_EDIT_SEGMENT_LOG2 17u
const void *svo_i_edit_store_units(const svo_i_edit_store *store, uint32_t segment_index);

/* Sums over voxels, of weights below 2^46 in all. */
typedef struct svo_i_edit_sums {
    uint64_t weight;
    uint64_t color[4]; /* of red, green and blue times alpha, and of alpha */
    int64_t normal[3];
} svo_i_edit_sums;

void svo_i_edit_add_color(svo_i_edit_sums *to, uint32_t color, uint64_t weight);
/* The mean, opaque if all is; 0 of no voxels. */
uint32_t svo_i_edit_mean_color(const svo_i_edit_sums *of);

/* The bytes of the nodes between two tops. */
uint64_t svo_i_edit_bytes_between(uint32_t begin, uint32_t end);

/* Takes back all nodes from top on, and releases the segments that then are empty. */
void svo_i_edit_store_rewind(svo_i_edit_store *store, uint32_t top);

/* Keeps the nodes of the roots alone, moved together, and puts their new places in roots. It cannot fail. */
void svo_i_edit_store_collect(svo_i_edit_store *store, svo_i_edit_ref *roots, size_t root_count);

/* The kind of a node that is not empty, without the bits of blocks. */
svo_i_edit_kind svo_i_edit_kind_of(const svo_i_edit_store *store, svo_i_edit_ref ref);
/* The payload that the voxels of a node have in common. Where their colors differ, it has about the mean, which is
   opaque if all are. */
svo_i_edit_payload svo_i_edit_payload_of(const svo_i_edit_store *store, svo_i_edit_ref ref);
/* Of a block: what its voxels have of their own, SVO_I_EDIT_COLORS, _MATERIALS and _NORMALS; 0 of other nodes. */
uint32_t svo_i_edit_variety_of(const svo_i_edit_store *store, svo_i_edit_ref ref);
/* The places of a block that have voxels, by Morton code. */
uint64_t svo_i_edit_mask_of(const svo_i_edit_store *store, svo_i_edit_ref ref);
/* The voxels below a node. */
uint64_t svo_i_edit_voxels_of(const svo_i_edit_store *store, svo_i_edit_ref ref, uint32_t level);
/* The children of a node above level 2 that may be empty; all eight of a uniform node are itself. */
void svo_i_edit_children_of(const svo_i_edit_store *store, svo_i_edit_ref ref, svo_i_edit_ref children[8]);
/* The places of a node of level 2, which may be empty. */
void svo_i_edit_unpack(const svo_i_edit_store *store, svo_i_edit_ref ref, svo_i_edit_cells *cells);
/* The node of level 2 with these places; uniform or empty where they are. false: no memory, see failure. */
bool svo_i_edit_pack(svo_i_edit_store *store, const svo_i_edit_cells *cells, svo_i_edit_ref *out);
/* The node with these children, of level - 1 each; uniform or empty where they are. */
bool svo_i_edit_join(svo_i_edit_store *store, const svo_i_edit_ref children[8], uint32_t level, svo_i_edit_ref *out);
/* A uniform node. */
bool svo_i_edit_fill(svo_i_edit_store *store, svo_i_edit_payload payload, svo_i_edit_ref *out);

#endif
