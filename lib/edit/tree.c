/* SPDX-License-Identifier: MIT */
/*
 * Two walks from the root down: the first one counts the nodes of each level and finds what payload is constant, the
 * second one writes. Payload goes up as it does in a build (kernels/stages/sums.clh, material.cl), where voxels weigh
 * the same: sums of colors times alpha and of normals, and how many voxels have each material. So the bytes are those
 * of a build.
 */
#include "edit/tree.h"

#include <string.h>

#include "svocl/plan.h"

#define TOLD_LEVEL 6u /* progress is told behind cubes of 2^6 and larger ones */

/* ---- bounds ---- */

typedef struct bounds {
    const svo_i_edit_store *store;
    uint32_t least_level; /* cubes of it count as full */
    uint32_t *low, *high;
} bounds;

static void widen(bounds *b, const uint32_t cell[3], uint32_t edge)
{
    for (int axis = 0; axis < 3; ++axis) {
        b->low[axis] = cell[axis] < b->low[axis] ? cell[axis] : b->low[axis];
        b->high[axis] = cell[axis] + edge > b->high[axis] ? cell[axis] + edge : b->high[axis];
    }
}

static bool is_within(const bounds *b, const uint32_t cell[3], uint32_t level)
{
    bool within = true;
    for (int axis = 0; axis < 3; ++axis) {
        within = within && cell[axis] >= b->low[axis] && cell[axis] + (1u << level) <= b->high[axis];
    }
    return within;
}

static void bound_block(bounds *b, svo_i_edit_ref ref, const uint32_t cell[3])
{
    for (uint64_t left = svo_i_edit_mask_of(b->store, ref); left != 0; left &= left - 1) {
        const uint32_t code = svo_i_edit_lowest(left);
        uint32_t place[3];
        for (uint32_t axis = 0; axis < 3; ++axis) {
            place[axis] = cell[axis] + (code >> axis & 1u) + 2u * (code >> (3u + axis) & 1u);
        }
        widen(b, place, 1);
    }
}

/* Cubes within the bounds so far are not looked into. */
static void bound(bounds *b, svo_i_edit_ref ref, uint32_t level, const uint32_t cell[3])
{
    if (ref == SVO_I_EDIT_EMPTY || is_within(b, cell, level)) {
        return;
    }
    if (level == b->least_level || svo_i_edit_kind_of(b->store, ref) == SVO_I_EDIT_UNIFORM) {
        widen(b, cell, 1u << level);
    } else if (level == SVO_I_EDIT_BLOCK_LEVEL) {
        bound_block(b, ref, cell);
    } else {
        svo_i_edit_ref children[8];
        svo_i_edit_children_of(b->store, ref, children);
        for (uint32_t i = 0; i < 8; ++i) {
            const uint32_t octant = i % 2 == 0 ? i / 2 : 7 - i / 2; /* opposite corners first: they bound most */
            const uint32_t half = 1u << (level - 1u);
            const uint32_t below[3] = {cell[0] + (octant & 1u) * half, cell[1] + (octant >> 1 & 1u) * half,
                                       cell[2] + (octant >> 2 & 1u) * half};
            bound(b, children[octant], level - 1, below);
        }
    }
}

void svo_i_edit_bounds(const svo_i_edit_store *store, svo_i_edit_ref root, uint32_t least_level, uint32_t low[3],
                       uint32_t high[3])
{
    const uint32_t cell[3] = {0, 0, 0};
    bounds b = {.store = store, .least_level = least_level, .low = low, .high = high};
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = UINT32_MAX;
        high[axis] = 0;
    }
    bound(&b, root, SVO_I_EDIT_ROOT_LEVEL, cell);
}

/* ---- cubes ---- */

bool svo_i_edit_is_aligned(const uint32_t low[3], uint32_t level)
{
    return ((low[0] | low[1] | low[2]) & ((1u << level) - 1u)) == 0;
}

svo_i_edit_ref svo_i_edit_find_cube(const svo_i_edit_store *store, svo_i_edit_ref root, const uint32_t low[3],
                                    uint32_t level)
{
    svo_i_edit_ref ref = root;
    for (uint32_t at = SVO_I_EDIT_ROOT_LEVEL; at > level; --at) {
        svo_i_edit_ref children[8];
        svo_i_edit_children_of(store, ref, children);
        ref = children[(low[0] >> (at - 1) & 1u) | (low[1] >> (at - 1) & 1u) << 1 | (low[2] >> (at - 1) & 1u) << 2];
    }
    return ref;
}

/* ---- the walks ---- */

/* How many voxels have a material. */
typedef struct run {
    uint64_t weight;
    uint16_t material;
} run;

typedef struct writer {
    const svo_i_edit_store *store;
    svo_tree *tree;
    uint32_t depth;
    svo_i_edit_told told;
    void *user;
    uint64_t voxel_count, done_count;
    bool is_canceled;
    /* of the first walk */
    uint64_t counts[SVO_LEVELS_MAX];
    svo_i_edit_payload first;
    uint64_t first_normal;
    bool has_first, colors_vary, materials_vary, normals_vary;
    /* of the second one */
    uint32_t next[SVO_LEVELS_MAX]; /* the next node of each level */
    uint32_t payload_begin; /* the first node with payload */
    bool depth_first; /* the order of payload */
    uint32_t next_place; /* of payload, where it is depth-first */
    uint8_t *masks;
    uint32_t *first_child;
    uint32_t *colors; /* NULL: constant, or not asked for */
    uint16_t *materials; /* the same */
    int16_t *normals; /* the same */
    run *runs; /* materials of nodes whose parent is not written yet, each node's ascending */
    size_t run_count, run_room;
} writer;

/* Behind a node that is written; large uniform ones have none below. */
static bool tell(writer *w, uint32_t level, bool is_inner, uint64_t voxel_count)
{
    if (w->told == NULL || level < TOLD_LEVEL || (level > TOLD_LEVEL && is_inner)) {
        return true;
    }
    w->done_count += voxel_count;
    w->is_canceled = !w->told(w->user, (double)w->done_count / (double)w->voxel_count);
    return !w->is_canceled;
}

/* ---- counting ---- */

/* is_first: no node was noted before. */
static void note_normals(writer *w, svo_i_edit_ref ref, uint32_t variety, bool is_first)
{
    if (!w->store->has_normals || w->normals_vary) {
        return;
    }
    svo_i_edit_cells cells = {.mask = 1};
    if ((variety & SVO_I_EDIT_NORMALS) != 0) {
        svo_i_edit_unpack(w->store, ref, &cells);
    }
    w->first_normal = is_first ? cells.normal[svo_i_edit_lowest(cells.mask)] : w->first_normal;
    for (uint64_t left = cells.mask; left != 0; left &= left - 1) {
        w->normals_vary = w->normals_vary || cells.normal[svo_i_edit_lowest(left)] != w->first_normal;
    }
}

static void note(writer *w, svo_i_edit_ref ref)
{
    const svo_i_edit_payload payload = svo_i_edit_payload_of(w->store, ref);
    const uint32_t variety = svo_i_edit_variety_of(w->store, ref);
    note_normals(w, ref, variety, !w->has_first);
    w->first = w->has_first ? w->first : payload;
    w->has_first = true;
    w->colors_vary = w->colors_vary || payload.color != w->first.color || (variety & SVO_I_EDIT_COLORS) != 0;
    w->materials_vary =
        w->materials_vary || payload.material != w->first.material || (variety & SVO_I_EDIT_MATERIALS) != 0;
}

/* The octants of a block that have voxels. */
static uint32_t octants_of(uint64_t mask)
{
    uint32_t octants = 0;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        octants |= (mask >> 8u * octant & 0xffu) != 0 ? 1u << octant : 0u;
    }
    return octants;
}

static void count(writer *w, svo_i_edit_ref ref, uint32_t level)
{
    const uint32_t at = w->depth - level;
    if (ref == SVO_I_EDIT_EMPTY) {
        return;
    }
    switch (svo_i_edit_kind_of(w->store, ref)) {
    case SVO_I_EDIT_UNIFORM:
        note(w, ref);
        for (uint32_t below = 0; below <= level; ++below) {
            w->counts[at + below] += (uint64_t)1 << 3u * below;
        }
        break;
    case SVO_I_EDIT_INNER: {
        svo_i_edit_ref children[8];
        svo_i_edit_children_of(w->store, ref, children);
        ++w->counts[at];
        for (uint32_t octant = 0; octant < 8; ++octant) {
            count(w, children[octant], level - 1);
        }
        break;
    }
    default:
        note(w, ref);
        ++w->counts[at];
        w->counts[at + 1] += svo_i_edit_count(octants_of(svo_i_edit_mask_of(w->store, ref)));
        w->counts[at + 2] += svo_i_edit_count(svo_i_edit_mask_of(w->store, ref));
    }
}

/* ---- materials ---- */

static bool push_run(writer *w, run one)
{
    if (w->run_count == w->run_room) {
        const size_t room = w->run_room == 0 ? 1024 : 2 * w->run_room;
        run *larger = svo_i_grow(&w->tree->memory, w->runs, room * sizeof *larger);
        if (larger == NULL) {
            return false;
        }
        w->runs = larger;
        w->run_room = room;
    }
    w->runs[w->run_count++] = one;
    return true;
}

/* Merges the ascending runs begin .. middle - 1 and middle .. run_count - 1. They are merged behind both. */
static bool merge_runs(writer *w, size_t begin, size_t middle)
{
    const size_t end = w->run_count;
    size_t a = begin;
    size_t b = middle;
    if (a == b || b == end) {
        return true;
    }
    if (b - a == 1 && end - b == 1 && w->runs[a].material == w->runs[b].material) { /* of most nodes */
        w->runs[a].weight += w->runs[b].weight;
        w->run_count = b;
        return true;
    }
    while (a < middle || b < end) {
        const bool takes_b = a == middle || (b < end && w->runs[b].material < w->runs[a].material);
        run one = takes_b ? w->runs[b++] : w->runs[a++];
        if (!takes_b && b < end && w->runs[b].material == one.material) {
            one.weight += w->runs[b++].weight;
        }
        if (!push_run(w, one)) {
            return false;
        }
    }
    const size_t merged = w->run_count - end;
    memmove(w->runs + begin, w->runs + end, merged * sizeof *w->runs);
    w->run_count = begin + merged;
    return true;
}

/* ---- payload ---- */

/* What shows of a voxel's color. */
static uint32_t shown_color(uint32_t color)
{
    return color >> 24 != 0 ? color : 0;
}

static void add_sums(svo_i_edit_sums *to, const svo_i_edit_sums *from)
{
    to->weight += from->weight;
    for (uint32_t i = 0; i < 4; ++i) {
        to->color[i] += from->color[i];
    }
    for (uint32_t axis = 0; axis < 3; ++axis) {
        to->normal[axis] += from->normal[axis];
    }
}

/* As svo_mean_normal of kernels: rounded half up, with an offset that makes the dividend positive. */
static void put_mean_normal(const svo_i_edit_sums *s, int16_t out[3])
{
    for (uint32_t axis = 0; axis < 3; ++axis) {
        const uint64_t shifted = (uint64_t)(2 * s->normal[axis] + (int64_t)(s->weight << 16)) + s->weight;
        out[axis] = (int16_t)((int64_t)(shifted / (2 * s->weight)) - 32768);
    }
}

#define NO_PLACE UINT32_MAX

/* Where the payload of the node that is met now goes, or NO_PLACE. */
static uint32_t take_place(writer *w, uint32_t node)
{
    return node < w->payload_begin ? NO_PLACE : w->depth_first ? w->next_place++ : node - w->payload_begin;
}

/* Writes what a node above the voxels has. run_begin: its first run. */
static void put_payload(writer *w, uint32_t place, const svo_i_edit_sums *s, size_t run_begin)
{
    if (place == NO_PLACE) {
        return;
    }
    if (w->colors != NULL) {
        w->colors[place] = svo_i_edit_mean_color(s);
    }
    if (w->normals != NULL) {
        put_mean_normal(s, w->normals + 3 * (size_t)place);
    }
    if (w->materials != NULL) {
        run most = w->runs[run_begin];
        for (size_t i = run_begin + 1; i < w->run_count; ++i) {
            most = w->runs[i].weight > most.weight ? w->runs[i] : most;
        }
        w->materials[place] = most.material;
    }
}

/* ---- writing ---- */

static void put_masks(writer *w, uint32_t node, uint32_t level, uint32_t mask)
{
    w->masks[node] = (uint8_t)mask;
    w->first_child[node] = w->next[level + 1];
}

/* Writes one payload so many times from a place on. */
static void put_same(writer *w, uint32_t place, uint32_t node_count, svo_i_edit_payload payload)
{
    for (uint32_t i = 0; i < node_count && w->colors != NULL; ++i) {
        w->colors[place + i] = shown_color(payload.color);
    }
    for (uint32_t i = 0; i < node_count && w->materials != NULL; ++i) {
        w->materials[place + i] = payload.material;
    }
    if (w->normals != NULL) {
        memset(w->normals + 3 * (size_t)place, 0, 3 * sizeof *w->normals * node_count);
    }
}

/* Full levels below a node, and that node itself. They have one payload, so depth-first they lie side by side. */
static bool write_uniform(writer *w, svo_i_edit_ref ref, uint32_t level, svo_i_edit_sums *out)
{
    const svo_i_edit_payload payload = svo_i_edit_payload_of(w->store, ref);
    const uint64_t voxel_count = (uint64_t)1 << 3u * level;
    for (uint32_t below = 0; below <= level; ++below) {
        const uint32_t at = w->depth - level + below;
        const uint32_t node_count = 1u << 3u * below;
        const uint32_t begin = w->next[at];
        if (at < w->depth) {
            memset(w->masks + begin, 0xff, node_count);
            for (uint32_t i = 0; i < node_count; ++i) {
                w->first_child[begin + i] = w->next[at + 1] + 8 * i;
            }
        }
        const uint32_t place = take_place(w, begin);
        if (place != NO_PLACE) {
            put_same(w, place, node_count, payload);
            w->next_place += w->depth_first ? node_count - 1 : 0;
        }
        w->next[at] += node_count;
    }
    svo_i_edit_add_color(out, payload.color, voxel_count);
    return w->materials == NULL || push_run(w, (run){voxel_count, payload.material});
}

/* run_begin: the first run of the octant. */
static bool write_leaf(writer *w, const svo_i_edit_cells *cells, uint32_t cell, size_t run_begin, svo_i_edit_sums *out)
{
    const uint32_t place = take_place(w, w->next[w->depth]++);
    const uint32_t color = cells->color[cell];
    svo_i_edit_add_color(out, color, 1);
    if (w->colors != NULL) {
        w->colors[place] = shown_color(color);
    }
    if (w->normals != NULL) {
        int16_t *normal = w->normals + 3 * (size_t)place;
        svo_i_edit_unpack_normal(cells->normal[cell], normal);
        for (uint32_t axis = 0; axis < 3; ++axis) {
            out->normal[axis] += normal[axis];
        }
    }
    if (w->materials == NULL) {
        return true;
    }
    const uint16_t material = cells->material[cell];
    run *last = w->run_count > run_begin ? &w->runs[w->run_count - 1] : NULL;
    w->materials[place] = material;
    if (last != NULL && last->material == material) { /* of most voxels */
        ++last->weight;
        return true;
    }
    const size_t middle = w->run_count;
    return push_run(w, (run){1, material}) && merge_runs(w, run_begin, middle);
}

/* The eight voxels of a block's octant. */
static bool write_octant(writer *w, const svo_i_edit_cells *cells, uint32_t octant, svo_i_edit_sums *out)
{
    const uint32_t level = w->depth - 1;
    const uint32_t mask = (uint32_t)(cells->mask >> 8u * octant & 0xffu);
    const uint32_t node = w->next[level]++;
    const uint32_t place = take_place(w, node);
    const size_t begin = w->run_count;
    svo_i_edit_sums own = {.weight = 0};
    put_masks(w, node, level, mask);
    for (uint32_t left = mask; left != 0; left &= left - 1) {
        if (!write_leaf(w, cells, 8u * octant + svo_i_edit_lowest(left), begin, &own)) {
            return false;
        }
    }
    put_payload(w, place, &own, begin);
    add_sums(out, &own);
    return true;
}

static bool write_block(writer *w, svo_i_edit_ref ref, svo_i_edit_sums *out)
{
    svo_i_edit_cells cells;
    const uint32_t level = w->depth - SVO_I_EDIT_BLOCK_LEVEL;
    const uint32_t node = w->next[level]++;
    const uint32_t place = take_place(w, node);
    const size_t begin = w->run_count;
    svo_i_edit_sums own = {.weight = 0};
    svo_i_edit_unpack(w->store, ref, &cells);
    const uint32_t octants = octants_of(cells.mask);
    put_masks(w, node, level, octants);
    for (uint32_t left = octants; left != 0; left &= left - 1) {
        const size_t middle = w->run_count;
        if (!write_octant(w, &cells, svo_i_edit_lowest(left), &own) || !merge_runs(w, begin, middle)) {
            return false;
        }
    }
    put_payload(w, place, &own, begin);
    add_sums(out, &own);
    return true;
}

static bool write_node(writer *w, svo_i_edit_ref ref, uint32_t level, svo_i_edit_sums *out);

static bool write_inner(writer *w, svo_i_edit_ref ref, uint32_t level, svo_i_edit_sums *out)
{
    svo_i_edit_ref children[8];
    const uint32_t at = w->depth - level;
    const uint32_t node = w->next[at]++;
    const uint32_t place = take_place(w, node);
    const size_t begin = w->run_count;
    svo_i_edit_sums own = {.weight = 0};
    uint32_t mask = 0;
    svo_i_edit_children_of(w->store, ref, children);
    for (uint32_t octant = 0; octant < 8; ++octant) {
        mask |= children[octant] != SVO_I_EDIT_EMPTY ? 1u << octant : 0u;
    }
    put_masks(w, node, at, mask);
    for (uint32_t left = mask; left != 0; left &= left - 1) {
        const size_t middle = w->run_count;
        if (!write_node(w, children[svo_i_edit_lowest(left)], level - 1, &own) || !merge_runs(w, begin, middle)) {
            return false;
        }
    }
    put_payload(w, place, &own, begin);
    add_sums(out, &own);
    return true;
}

/* Of a node that is not empty; adds its sums. */
static bool write_node(writer *w, svo_i_edit_ref ref, uint32_t level, svo_i_edit_sums *out)
{
    const svo_i_edit_kind kind = svo_i_edit_kind_of(w->store, ref);
    const bool done = kind == SVO_I_EDIT_UNIFORM ? write_uniform(w, ref, level, out)
                      : kind == SVO_I_EDIT_INNER ? write_inner(w, ref, level, out)
                                                 : write_block(w, ref, out);
    return done && tell(w, level, kind == SVO_I_EDIT_INNER, svo_i_edit_voxels_of(w->store, ref, level));
}

/* ---- the tree ---- */

static svo_status take_counts(writer *w)
{
    svo_tree_info *info = &w->tree->info;
    uint64_t node_count = 0;
    for (uint32_t level = 0; level <= w->depth; ++level) {
        info->level_begin[level] = (uint32_t)node_count;
        w->next[level] = (uint32_t)node_count;
        node_count += w->counts[level];
        if (node_count >= UINT32_MAX) {
            return SVO_CAPACITY_EXCEEDED;
        }
    }
    info->level_begin[w->depth + 1] = (uint32_t)node_count;
    info->inner_count = info->level_begin[w->depth];
    info->node_count = node_count;
    info->leaf_count = node_count - info->inner_count;
    info->fragments = info->leaf_count;
    info->constant = (w->colors_vary ? 0u : info->need & (uint32_t)SVO_NEED_COLOR) |
                     (w->materials_vary ? 0u : info->need & (uint32_t)SVO_NEED_MATERIAL) |
                     (w->normals_vary ? 0u : info->need & (uint32_t)SVO_NEED_NORMAL);
    w->payload_begin = info->level_begin[info->payload_level];
    return SVO_OK;
}

static bool allocate(writer *w)
{
    static const svo_tree_buffer arrays[] = {SVO_TREE_CHILD_MASK, SVO_TREE_FIRST_CHILD, SVO_TREE_COLORS,
                                             SVO_TREE_NORMALS, SVO_TREE_MATERIALS};
    svo_tree *tree = w->tree;
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; ++i) {
        if (svo_i_tree_holds(&tree->info, arrays[i])) {
            tree->host[arrays[i]] =
                svo_i_alloc(&tree->memory, (size_t)svo_i_tree_element_count(&tree->info, arrays[i]) *
                                               svo_i_tree_element_bytes(arrays[i]));
            if (tree->host[arrays[i]] == NULL) {
                return false;
            }
        }
    }
    w->masks = tree->host[SVO_TREE_CHILD_MASK];
    w->first_child = tree->host[SVO_TREE_FIRST_CHILD];
    w->colors = tree->host[SVO_TREE_COLORS];
    w->materials = tree->host[SVO_TREE_MATERIALS];
    w->normals = tree->host[SVO_TREE_NORMALS];
    return true;
}

/* Payload that is constant is its one element; the walk leaves it out. */
static void put_constants(writer *w)
{
    if (w->colors != NULL && !w->colors_vary) {
        w->colors[0] = shown_color(w->first.color);
        w->colors = NULL;
    }
    if (w->materials != NULL && !w->materials_vary) {
        w->materials[0] = w->first.material;
        w->materials = NULL;
    }
    if (w->normals != NULL && !w->normals_vary) {
        svo_i_edit_unpack_normal(w->first_normal, w->normals);
        w->normals = NULL;
    }
}

svo_status svo_i_edit_write_tree(const svo_i_edit_store *store, svo_i_edit_ref node, bool depth_first, svo_tree *tree,
                                 svo_i_edit_told told_by, void *user)
{
    const uint32_t depth = tree->info.depth;
    writer w = {.store = store,
                .tree = tree,
                .depth = depth,
                .depth_first = depth_first,
                .told = told_by,
                .user = user,
                .voxel_count = svo_i_edit_voxels_of(store, node, depth)};
    svo_i_edit_sums all = {.weight = 0};
    count(&w, node, depth);
    SVO_I_TRY(take_counts(&w));
    if (!allocate(&w)) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    put_constants(&w);
    const bool done = write_node(&w, node, depth, &all);
    svo_i_free(w.runs);
    return done ? SVO_OK : w.is_canceled ? SVO_CANCELED : SVO_OUT_OF_HOST_MEMORY;
}
