/* SPDX-License-Identifier: MIT */
/* Walks two trees at once, so that nodes in one place meet whatever their indices are. */
#include "svocl/tree_diff.h"

#include <string.h>

#include "svocl/plan.h"

#define COMPONENTS_MAX 6

typedef struct field_row {
    const char *name;
    uint32_t need;
    uint32_t components; /* of a node; 0: as many as the list has */
    bool of_leaves, is_label;
} field_row;

static const field_row fields[DIFF_FIELD_COUNT] = {
    [DIFF_COLOR] = {"color", SVO_NEED_COLOR, 4, false, false},
    [DIFF_NORMAL] = {"normal", SVO_NEED_NORMAL, 3, false, false},
    [DIFF_MATERIAL] = {"material", SVO_NEED_MATERIAL, 1, false, true},
    [DIFF_FILL] = {"fill", SVO_NEED_FILL, 1, false, false},
    [DIFF_AREA] = {"projected-area", SVO_NEED_PROJECTED_AREA, COMPONENTS_MAX, true, false},
    [DIFF_LIST] = {"list", SVO_NEED_RAYS, 0, true, false},
};

static const char *const option_names[DIFF_OPTION_COUNT] = {"depth",  "coverage", "voxels_of",
                                                            "origin", "edge",     "payload_level"};

const char *diff_option_name(diff_option option)
{
    return option_names[option];
}

const char *diff_field_name(diff_field field)
{
    return fields[field].name;
}

bool diff_field_is_label(diff_field field)
{
    return fields[field].is_label;
}

/* ---- values ---- */

/* Whether the hash covers bytes of the field: payload of no node leaves nothing, areas of no leaf a length. */
static bool holds(const diff_side *side, diff_field field)
{
    const svo_tree_info *info = &side->info;
    const bool has_nodes = fields[field].of_leaves || info->level_begin[info->payload_level] < info->node_count;
    return (info->need & fields[field].need) != 0 && has_nodes;
}

static bool has_values(const diff_side *side, diff_field field, uint32_t level)
{
    return holds(side, field) && level >= (fields[field].of_leaves ? side->info.depth : side->info.payload_level);
}

static uint32_t list_of(const diff_side *side, uint32_t node, const uint32_t **entries)
{
    const uint32_t leaf = node - side->info.level_begin[side->info.depth];
    const uint32_t *begin = side->arrays.list_begin + leaf;
    *entries = side->arrays.list + begin[0];
    return begin[1] - begin[0];
}

static int64_t component(const diff_side *side, diff_field field, size_t place)
{
    const svo_tree_arrays *arrays = &side->arrays;
    switch (field) {
    case DIFF_COLOR:
        return arrays->colors[place];
    case DIFF_NORMAL:
        return arrays->normals[place];
    case DIFF_MATERIAL:
        return arrays->materials[place];
    case DIFF_FILL:
        return arrays->fills[place];
    default:
        return arrays->areas[place];
    }
}

uint32_t diff_values(const diff_side *side, diff_field field, uint32_t level, uint32_t node, uint32_t out_count,
                     int64_t *out)
{
    if (node == SVO_NO_NODE || !has_values(side, field, level)) {
        return 0;
    }
    const field_row *row = &fields[field];
    const uint32_t *entries = NULL;
    const uint32_t count = field == DIFF_LIST ? list_of(side, node, &entries) : row->components;
    const size_t first = side->info.level_begin[row->of_leaves ? side->info.depth : side->info.payload_level];
    for (uint32_t i = 0; i < count && i < out_count; ++i) {
        out[i] = entries != NULL ? (int64_t)entries[i] : component(side, field, (node - first) * count + i);
    }
    return count;
}

/* ---- the walk ---- */

typedef struct walk {
    const diff_side *sides;
    tree_diff found;
    bool first_is_voxel;
    diff_visitor *visit;
    void *user;
} walk;

static uint32_t distance(int64_t a, int64_t b)
{
    return (uint32_t)(a > b ? a - b : b - a);
}

/* Compares the field in a node of both trees; *largest grows to the difference. */
static bool differs(const walk *work, diff_field field, const diff_place *at, uint32_t *largest)
{
    const diff_side *a = &work->sides[0], *b = &work->sides[1];
    if (!has_values(a, field, at->level) || !has_values(b, field, at->level)) {
        return false;
    }
    uint32_t most = 0;
    bool is_other = false;
    if (field == DIFF_LIST) {
        const uint32_t *of_a = NULL, *of_b = NULL;
        const uint32_t count_a = list_of(a, at->node[0], &of_a), count_b = list_of(b, at->node[1], &of_b);
        most = count_a > count_b ? count_a - count_b : count_b - count_a;
        is_other = most > 0 || (count_a > 0 && memcmp(of_a, of_b, count_a * sizeof *of_a) != 0);
    } else {
        int64_t of_a[COMPONENTS_MAX] = {0}, of_b[COMPONENTS_MAX] = {0};
        const uint32_t count = diff_values(a, field, at->level, at->node[0], COMPONENTS_MAX, of_a);
        (void)diff_values(b, field, at->level, at->node[1], COMPONENTS_MAX, of_b);
        for (uint32_t i = 0; i < count; ++i) {
            most = distance(of_a[i], of_b[i]) > most ? distance(of_a[i], of_b[i]) : most;
        }
        is_other = most > 0;
    }
    *largest = most > *largest ? most : *largest;
    return is_other;
}

static bool compare_payload(walk *work, const diff_place *at)
{
    bool any = false;
    const bool is_voxel = at->level == work->found.level;
    for (diff_field field = 0; field < DIFF_FIELD_COUNT; ++field) {
        diff_counts *counts = &work->found.fields[field];
        if (differs(work, field, at, &counts->largest)) {
            *(is_voxel ? &counts->voxels : &counts->nodes) += 1;
            any = true;
        }
    }
    return any;
}

static void note_first(walk *work, const diff_place *at)
{
    const bool is_voxel = at->level == work->found.level;
    if (!work->found.has_first || (is_voxel && !work->first_is_voxel)) {
        work->found.has_first = true;
        work->first_is_voxel = is_voxel;
        work->found.first = *at;
    }
}

static void visit_voxel(walk *work, const diff_place *at, bool is_changed)
{
    tree_diff *found = &work->found;
    const diff_kind kind = at->node[1] == SVO_NO_NODE   ? DIFF_ONLY_A
                           : at->node[0] == SVO_NO_NODE ? DIFF_ONLY_B
                           : is_changed                 ? DIFF_CHANGED
                                                        : DIFF_SAME;
    found->only[0] += kind == DIFF_ONLY_A;
    found->only[1] += kind == DIFF_ONLY_B;
    found->both += kind == DIFF_SAME || kind == DIFF_CHANGED;
    found->changed += kind == DIFF_CHANGED;
    if (kind != DIFF_SAME) {
        note_first(work, at);
    }
    if (work->visit != NULL) {
        work->visit(work->user, at->cell, kind);
    }
}

static unsigned count_bits(unsigned mask)
{
    unsigned count = 0;
    for (; mask != 0; mask &= mask - 1) {
        ++count;
    }
    return count;
}

static uint32_t child_of(const diff_side *side, uint32_t node, unsigned octant)
{
    const unsigned mask = node != SVO_NO_NODE ? side->arrays.child_mask[node] : 0;
    return (mask >> octant & 1u) != 0 ? side->arrays.first_child[node] + count_bits(mask & ((1u << octant) - 1))
                                      : SVO_NO_NODE;
}

/* As deep as the trees are: SVO_DEPTH_MAX calls at most. */
static void walk_node(walk *work, const diff_place *at)
{
    const bool in_both = at->node[0] != SVO_NO_NODE && at->node[1] != SVO_NO_NODE;
    const bool is_changed = in_both && compare_payload(work, at);
    if (at->level == work->found.level) {
        visit_voxel(work, at, is_changed);
        return;
    }
    if (is_changed) {
        note_first(work, at);
    }
    for (unsigned octant = 0; octant < 8; ++octant) {
        diff_place child = {.level = at->level + 1};
        for (unsigned axis = 0; axis < 3; ++axis) {
            child.cell[axis] = 2 * at->cell[axis] + (octant >> axis & 1u);
        }
        child.node[0] = child_of(&work->sides[0], at->node[0], octant);
        child.node[1] = child_of(&work->sides[1], at->node[1], octant);
        if (child.node[0] != SVO_NO_NODE || child.node[1] != SVO_NO_NODE) {
            walk_node(work, &child);
        }
    }
}

/* As the hash does, which knows 0 from -0. */
static bool are_same(const double *a, const double *b, size_t count)
{
    bool same = true;
    for (size_t i = 0; i < count; ++i) {
        uint64_t bits_a = 0, bits_b = 0;
        memcpy(&bits_a, &a[i], sizeof bits_a);
        memcpy(&bits_b, &b[i], sizeof bits_b);
        same = same && bits_a == bits_b;
    }
    return same;
}

static unsigned compare_options(const diff_side sides[2], const diff_counts counts[DIFF_FIELD_COUNT])
{
    const svo_tree_info *a = &sides[0].info, *b = &sides[1].info;
    bool have_payload = false;
    for (diff_field field = 0; field < DIFF_AREA; ++field) {
        have_payload = have_payload || (counts[field].is_held[0] && counts[field].is_held[1]);
    }
    const bool differ[DIFF_OPTION_COUNT] = {
        [DIFF_DEPTH] = a->depth != b->depth,
        [DIFF_COVERAGE] = a->coverage != b->coverage,
        [DIFF_VOXELS_OF] = (a->is_exact != 0 ? 0 : a->snap_bits) != (b->is_exact != 0 ? 0 : b->snap_bits),
        [DIFF_ORIGIN] = !are_same(a->origin, b->origin, 3),
        [DIFF_EDGE] = !are_same(&a->edge, &b->edge, 1),
        [DIFF_PAYLOAD_LEVEL] = have_payload && a->payload_level != b->payload_level,
    };
    unsigned bits = 0;
    for (unsigned i = 0; i < DIFF_OPTION_COUNT; ++i) {
        bits |= (unsigned)differ[i] << i;
    }
    return bits;
}

tree_diff tree_diff_find(const diff_side sides[2], diff_visitor *visit, void *user)
{
    walk work = {.sides = sides, .visit = visit, .user = user};
    tree_diff *found = &work.found;
    for (diff_field field = 0; field < DIFF_FIELD_COUNT; ++field) {
        found->fields[field].is_held[0] = holds(&sides[0], field);
        found->fields[field].is_held[1] = holds(&sides[1], field);
    }
    found->options = compare_options(sides, found->fields);
    found->level = sides[0].info.depth < sides[1].info.depth ? sides[0].info.depth : sides[1].info.depth;
    walk_node(&work, &(diff_place){0});
    found->is_equal = strcmp(sides[0].hash, sides[1].hash) == 0;
    return *found;
}
