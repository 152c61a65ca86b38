/* SPDX-License-Identifier: MIT */
/* Solids beside the reference: what the words of the descriptor form say, and what each cell should be. */
#include "oracle_solid.h"

#include <string.h>

typedef struct cell {
    uint32_t corner[3]; /* in voxels */
    unsigned level;
} cell;

static cell child_of(const cell *parent, unsigned octant, unsigned depth)
{
    cell child = *parent;

    child.level++;
    for (unsigned axis = 0; axis < 3; axis++)
        child.corner[axis] |= (octant >> axis & 1) << (depth - child.level);
    return child;
}

/* ---- words ---- */

typedef struct decoder {
    const uint32_t *words;
    size_t word_count;
    unsigned depth;
    uint8_t *levels;
} decoder;

static bool set_levels(const decoder *d, const cell *leaf)
{
    uint32_t edge = UINT32_C(1) << (d->depth - leaf->level);

    for (uint32_t z = 0; z < edge; z++)
        for (uint32_t y = 0; y < edge; y++) {
            uint64_t row = leaf->corner[1] + y + ((uint64_t)(leaf->corner[2] + z) << d->depth);
            uint8_t *first = d->levels + ((row << d->depth) + leaf->corner[0]);

            for (uint32_t x = 0; x < edge; x++) {
                if (first[x] != ORACLE_NO_LEAF)
                    return false;
                first[x] = (uint8_t)leaf->level;
            }
        }
    return true;
}

static bool decode(const decoder *d, size_t at, const cell *node)
{
    uint32_t word, distance;

    if (at >= d->word_count || node->level >= d->depth)
        return false;
    word = d->words[at];
    distance = word >> 17;
    if (word >> 16 & 1) {
        if (at + distance >= d->word_count)
            return false;
        distance = d->words[at + distance];
    }
    for (unsigned octant = 0, inner = 0; octant < 8; octant++) {
        cell child = child_of(node, octant, d->depth);
        bool valid = word >> octant & 1, leaf = word >> (8 + octant) & 1;

        if (leaf && (!valid || !set_levels(d, &child)))
            return false;
        if (valid && !leaf && !decode(d, at + distance + inner++, &child))
            return false;
    }
    return true;
}

bool oracle_descriptor_levels(const uint32_t *words, size_t word_count, unsigned depth, uint8_t *levels)
{
    decoder d = {words, word_count, depth, levels};
    cell root = {{0, 0, 0}, 0};

    memset(levels, ORACLE_NO_LEAF, (size_t)1 << 3 * depth);
    return decode(&d, 0, &root);
}

/* ---- cells ---- */

typedef struct comparison {
    const oracle_solid *reference;
    const uint8_t *child_mask;
    const uint32_t *first_child;
    const uint8_t *levels;
    oracle_solid_difference *out;
} comparison;

/* Voxels of a cell that do not have the level, and of an empty cell those on the other side than said. */
static void check_cell(const comparison *c, const cell *of, uint8_t level, bool empty, bool inside)
{
    unsigned depth = c->reference->depth;
    uint32_t edge = UINT32_C(1) << (depth - of->level);

    for (uint32_t z = 0; z < edge; z++)
        for (uint32_t y = 0; y < edge; y++)
            for (uint32_t x = 0; x < edge; x++) {
                uint32_t at[3] = {of->corner[0] + x, of->corner[1] + y, of->corner[2] + z};
                uint64_t index = at[0] + ((at[1] + ((uint64_t)at[2] << depth)) << depth);

                c->out->wrong_voxels += c->levels[index] != level;
                if (empty)
                    c->out->split_voxels += (oracle_solid_votes(c->reference, at[0], at[1], at[2]) >= 2) != inside;
            }
}

static void compare_empty(const comparison *c, const cell *empty)
{
    uint32_t middle = UINT32_C(1) << (c->reference->depth - empty->level) >> 1;
    uint64_t voxels = (uint64_t)1 << 3 * (c->reference->depth - empty->level);
    unsigned votes = oracle_solid_votes(c->reference, empty->corner[0] + middle, empty->corner[1] + middle,
                                        empty->corner[2] + middle);
    bool inside = votes >= 2;

    c->out->inside_leaves += inside ? 1 : 0;
    c->out->inside_voxels += inside ? voxels : 0;
    c->out->ambiguous_cells += votes == 1 || votes == 2;
    c->out->ambiguous_voxels += votes == 1 || votes == 2 ? voxels : 0;
    check_cell(c, empty, inside ? (uint8_t)empty->level : ORACLE_NO_LEAF, true, inside);
}

static void compare_node(const comparison *c, uint32_t node, const cell *of)
{
    uint32_t child_node = c->first_child[node];

    for (unsigned octant = 0; octant < 8; octant++) {
        cell child = child_of(of, octant, c->reference->depth);

        if (!(c->child_mask[node] >> octant & 1)) {
            compare_empty(c, &child);
        } else if (child.level == c->reference->depth) {
            c->out->surface_voxels++;
            check_cell(c, &child, (uint8_t)child.level, false, false);
        } else {
            compare_node(c, child_node++, &child);
        }
    }
}

void oracle_solid_compare(const oracle_solid *reference, const uint8_t *child_mask, const uint32_t *first_child,
                          const uint8_t *levels, oracle_solid_difference *out)
{
    comparison c = {reference, child_mask, first_child, levels, out};
    cell root = {{0, 0, 0}, 0};

    *out = (oracle_solid_difference){0};
    compare_node(&c, 0, &root);
}
