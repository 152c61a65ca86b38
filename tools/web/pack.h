/* SPDX-License-Identifier: MIT */
/* The data of a page: a compact tree of the implied form, cut at a level, as one stream of bytes, level by level,
   compressed. */
#ifndef SVOCL_TOOLS_WEB_PACK_H
#define SVOCL_TOOLS_WEB_PACK_H

#include <stdbool.h>
#include <stddef.h>

#include "svocl/compact.h"
#include "svocl/plan.h"

/* The directory of the implied form that pages read has an entry for each 16 nodes. */
#define WEB_DIRECTORY_STEP_LOG2 4u

/* Texels of light for each node: +x, -x, +y, -y, +z, -z. */
#define WEB_LIGHT_FACES 6u

/* Colors, normals or light. The element of a node is at (node - first) * stride; nodes before first have none. */
typedef struct web_payload {
    uint64_t count; /* 0: there is none */
    uint32_t first;
    uint32_t stride; /* 0: all nodes have the same, else 1 */
} web_payload;

/* Irradiance from six directions, for the nodes of the upper levels: red, green and blue, and an exponent that they
   share (Ward, "Real Pixels", 1991): value / 255 * 2^(exponent - 128). Exponent 0: nothing in the node faces there. */
typedef struct web_light {
    uint32_t level; /* the last that has it */
    uint64_t node_count;
    unsigned char (*texels)[WEB_LIGHT_FACES][4]; /* by malloc */
} web_light;

/*
 * What a page holds of a tree: nodes down to a level, the nodes of which are leaves there. Breadth-first, a cut is the
 * front part of each array. The stream has what each level adds to the cut above it, from level 1 on, in this order and
 * little-endian:
 *
 *     masks      a byte for each node above the level, up to a multiple of 16 bytes
 *     directory  for each 16 masks the u32 index of the first node's first child
 *     colors     4 bytes each: red, green, blue, alpha
 *     normals    2 bytes each, by web_pack_normal
 *     light      24 bytes each
 */
typedef struct web_cut {
    uint32_t level;
    uint64_t node_count; /* with those of the level */
    uint64_t leaf_count; /* nodes of the level, and leaves above it */
    uint64_t mask_count, directory_count;
    web_payload colors, normals, light;
    uint64_t byte_count; /* of the stream */
} web_cut;

/* A compact tree on the host. */
typedef struct web_tree {
    svo_compact_info info;
    svo_compact_arrays arrays;
    const web_light *light; /* NULL: none */
} web_tree;

/* compact: of the implied form with step WEB_DIRECTORY_STEP_LOG2 and host arrays; must outlive the tree. */
web_tree web_tree_of(const svo_compact *compact);

/* The width of a cell of a level, in world units. */
double web_tree_edge(const web_tree *tree, uint32_t level);

/* level: 0 .. info.depth. */
web_cut web_cut_at(const web_tree *tree, uint32_t level);

/* The Morton codes of the nodes down to a level, breadth-first, each on its node's level. By malloc; NULL when out of
   memory. */
uint64_t *web_tree_codes(const web_tree *tree, uint32_t level);

/* The box of the occupied cells of level 6, or of the tree's depth if it is less, in voxels of the tree. False when out
   of memory. */
bool web_tree_bounds(const web_tree *tree, uint32_t low[3], uint32_t high[3]);

/* A normal in octahedral coordinates (Meyer et al., "On Floating-Point Normal Vectors", 2010): each 128 + round(127 p).
   0, 0: shorter than a fifth, so that the face's is used. */
void web_pack_normal(const int16_t normal[3], unsigned char out[2]);

/* Red, green, blue, not negative, and the exponent that they share, never 0: as texels of web_light. */
void web_pack_light(const float light[3], unsigned char out[4]);

typedef enum web_pack_status { WEB_PACK_DONE, WEB_PACK_TOO_LARGE, WEB_PACK_NO_MEMORY } web_pack_status;

/* The stream, compressed. What is in front of an end unpacks to whole levels: pages show a tree while the rest of them
   arrives. Levels of few bytes share one. */
typedef struct web_packed {
    unsigned char *bytes; /* by malloc */
    size_t count;
    size_t ends[SVO_DEPTH_MAX]; /* ascending; the last is count */
    unsigned end_count;
} web_packed;

/* Compresses the stream as gzip (RFC 1952) into at most limit bytes. */
web_pack_status web_pack(const web_tree *tree, const web_cut *cut, size_t limit, web_packed *out);

#endif
