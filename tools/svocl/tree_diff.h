/* SPDX-License-Identifier: MIT */
/* Where two trees differ, in what svo_tree_hash covers: the grid, the nodes, their payload and the leaf lists. */
#ifndef SVOCL_TOOLS_SVOCL_TREE_DIFF_H
#define SVOCL_TOOLS_SVOCL_TREE_DIFF_H

#include <stdbool.h>
#include <stdint.h>

#include "svocl/tree.h"

/* What describes a tree besides its arrays: the places of bits in tree_diff.options. */
typedef enum diff_option {
    DIFF_DEPTH = 0,
    DIFF_COVERAGE,
    DIFF_VOXELS_OF, /* of the mesh as given, or of one rounded to so many bits */
    DIFF_ORIGIN,
    DIFF_EDGE,
    DIFF_PAYLOAD_LEVEL,
    DIFF_OPTION_COUNT
} diff_option;

/* What nodes carry. */
typedef enum diff_field {
    DIFF_COLOR = 0,
    DIFF_NORMAL,
    DIFF_MATERIAL,
    DIFF_FILL,
    DIFF_AREA, /* of leaves alone, as the lists */
    DIFF_LIST,
    DIFF_FIELD_COUNT
} diff_field;

const char *diff_option_name(diff_option option); /* "depth" */
const char *diff_field_name(diff_field field); /* "color" */
/* Whether the values are labels, between which there is no distance. */
bool diff_field_is_label(diff_field field);

/* A tree, on the host. */
typedef struct diff_side {
    svo_tree_info info;
    svo_tree_arrays arrays;
    char hash[SVO_HASH_TEXT_BYTES];
} diff_side;

typedef struct diff_counts {
    bool is_held[2]; /* by A, by B */
    uint64_t voxels; /* those of both trees that differ in it */
    uint64_t nodes; /* the same above the voxels */
    uint32_t largest; /* greatest difference of a component; of a list's length */
} diff_counts;

/* A node that differs, or is in one tree alone. */
typedef struct diff_place {
    uint32_t level;
    uint32_t cell[3];
    uint32_t node[2]; /* in A, in B; SVO_NO_NODE: it is not there */
} diff_place;

/* The trees have voxels of one size on the level of the lesser depth, by which they are compared. */
typedef struct tree_diff {
    bool is_equal; /* as the hashes are */
    unsigned options; /* bits: those that differ */
    uint32_t level;
    uint64_t only[2]; /* voxels of A alone, of B alone */
    uint64_t both, changed; /* voxels of both; those of them with other payload or another list */
    diff_counts fields[DIFF_FIELD_COUNT];
    bool has_first;
    diff_place first; /* the first voxel in Morton order that differs; without one the first node above */
} tree_diff;

typedef enum diff_kind { DIFF_SAME, DIFF_ONLY_A, DIFF_ONLY_B, DIFF_CHANGED } diff_kind;

/* Is told of each voxel of either tree, in Morton order. */
typedef void diff_visitor(void *user, const uint32_t cell[3], diff_kind kind);

/* visit: NULL: nobody. */
tree_diff tree_diff_find(const diff_side sides[2], diff_visitor *visit, void *user);

/* The values of a field in a node of that level. Returns how many they are, of which out receives those that fit; 0
   where the tree does not hold the field there. */
uint32_t diff_values(const diff_side *side, diff_field field, uint32_t level, uint32_t node, uint32_t out_count,
                     int64_t *out);

#endif
