/* SPDX-License-Identifier: MIT */
/* Nodes in segments: made, read, and moved together. */
#include "edit/store.h"

#include <string.h>

#define SEGMENT_LOG2  SVO_I_EDIT_SEGMENT_LOG2
#define SEGMENT_UNITS (1u << SEGMENT_LOG2)
#define UNIT_BYTES    8u
#define WORD_LOG2     6u /* units that one word of the bit map describes */
#define SEGMENT_WORDS (SEGMENT_UNITS >> WORD_LOG2)
#define SEGMENTS_MAX  (1u << (32u - SEGMENT_LOG2))
#define FIRST_UNIT    1u /* 0 is SVO_I_EDIT_EMPTY */
#define STACK_MAX     (8u * 22u) /* children left to visit on the way down from a root */

typedef struct svo_i_edit_segment {
    uint64_t units[SEGMENT_UNITS];
    uint64_t live[SEGMENT_WORDS]; /* bit i of a word: the unit is of a node that is kept */
    uint32_t moved[SEGMENT_WORDS]; /* where a word's first unit would go, if all before it in the word were kept */
} segment;

const size_t svo_i_edit_segment_bytes = sizeof(segment);

static void *at(const svo_i_edit_store *store, svo_i_edit_ref ref)
{
    return &store->segments[ref >> SEGMENT_LOG2]->units[ref & (SEGMENT_UNITS - 1u)];
}

static uint32_t segments_of(uint32_t top)
{
    return (uint32_t)(((uint64_t)top + SEGMENT_UNITS - 1u) >> SEGMENT_LOG2);
}

/* ---- segments ---- */

void svo_i_edit_store_release(svo_i_edit_store *store)
{
    for (uint32_t i = 0; i < store->segment_count; ++i) {
        svo_i_free(store->segments[i]);
    }
    svo_i_free((void *)store->segments);
    store->segments = NULL;
    store->segment_count = 0;
    store->segment_room = 0;
    store->top = 0;
}

uint64_t svo_i_edit_store_held(const svo_i_edit_store *store)
{
    return (uint64_t)store->segment_count * sizeof(segment);
}

uint64_t svo_i_edit_store_used(const svo_i_edit_store *store)
{
    return (uint64_t)segments_of(store->top) * sizeof(segment);
}

uint64_t svo_i_edit_bytes_between(uint32_t begin, uint32_t end)
{
    return (uint64_t)(end - begin) * UNIT_BYTES;
}

void svo_i_edit_store_rewind(svo_i_edit_store *store, uint32_t top)
{
    store->top = top;
    store->last_uniform = store->last_uniform < top ? store->last_uniform : SVO_I_EDIT_EMPTY;
    while (store->segment_count > segments_of(top)) {
        svo_i_free(store->segments[--store->segment_count]);
    }
}

static bool fail(svo_i_edit_store *store, svo_status why)
{
    store->failure = why;
    return false;
}

static bool add_segment(svo_i_edit_store *store)
{
    if (store->segment_count >= SEGMENTS_MAX || svo_i_edit_store_held(store) + sizeof(segment) > store->max_bytes) {
        return fail(store, SVO_CAPACITY_EXCEEDED);
    }
    if (store->segment_count == store->segment_room) {
        const uint32_t room = store->segment_room == 0 ? 16 : 2 * store->segment_room;
        segment **larger = svo_i_grow(&store->memory, (void *)store->segments, room * sizeof(segment *));
        if (larger == NULL) {
            return fail(store, SVO_OUT_OF_HOST_MEMORY);
        }
        store->segments = larger;
        store->segment_room = room;
    }
    segment *made = svo_i_alloc(&store->memory, sizeof *made);
    if (made == NULL) {
        return fail(store, SVO_OUT_OF_HOST_MEMORY);
    }
    store->segments[store->segment_count++] = made;
    return true;
}

/* Room for a node, which lies within a segment. NULL: no memory. */
static void *reserve(svo_i_edit_store *store, uint32_t units, svo_i_edit_ref *out)
{
    uint64_t begin = store->top < FIRST_UNIT ? FIRST_UNIT : store->top;
    if ((begin & (SEGMENT_UNITS - 1u)) + units > SEGMENT_UNITS) {
        begin = (begin | (SEGMENT_UNITS - 1u)) + 1u;
    }
    if (begin >> SEGMENT_LOG2 >= store->segment_count && !add_segment(store)) {
        return NULL;
    }
    /* The last unit of the last segment stays free, so that top is below 2^32. */
    if (begin + units > UINT32_MAX) {
        store->failure = SVO_CAPACITY_EXCEEDED;
        return NULL;
    }
    *out = (svo_i_edit_ref)begin;
    store->top = (uint32_t)(begin + units);
    return at(store, *out);
}

const void *svo_i_edit_store_units(const svo_i_edit_store *store, uint32_t segment_index)
{
    return store->segments[segment_index]->units;
}

/* ---- means ---- */

void svo_i_edit_add_color(svo_i_edit_sums *to, uint32_t color, uint64_t weight)
{
    const uint64_t share = weight * (color >> 24);
    to->weight += weight;
    for (uint32_t i = 0; i < 3; ++i) {
        to->color[i] += share * (color >> 8u * i & 255u);
    }
    to->color[3] += share;
}

static uint64_t rounded_quotient(uint64_t sum, uint64_t by)
{
    return (2 * sum + by) / (2 * by);
}

/* As svo_mean_color of kernels. */
uint32_t svo_i_edit_mean_color(const svo_i_edit_sums *of)
{
    const uint64_t shown = of->color[3];
    uint64_t alpha = rounded_quotient(shown, of->weight > 0 ? of->weight : 1);
    uint32_t color = 0;
    for (uint32_t i = 0; i < 3; ++i) {
        color |= (uint32_t)rounded_quotient(of->color[i], shown > 0 ? shown : 1) << 8u * i;
    }
    alpha = alpha == 0 && shown > 0 ? 1 : alpha;
    alpha = alpha == 255 && shown < 255 * of->weight ? 254 : alpha;
    return color | (uint32_t)alpha << 24;
}

/* ---- nodes ---- */

/* The occupied places of a block, which follow its first unit. */
static uint64_t mask_of(const svo_i_edit_node *block)
{
    return *(const uint64_t *)(const void *)(block + 1);
}

static uint32_t block_units(uint32_t kind, uint64_t mask)
{
    const uint32_t bytes = svo_i_edit_count(mask) * (((kind & SVO_I_EDIT_COLORS) != 0 ? 4u : 0u) +
                                                     ((kind & SVO_I_EDIT_MATERIALS) != 0 ? 2u : 0u) +
                                                     ((kind & SVO_I_EDIT_NORMALS) != 0 ? 6u : 0u));
    return 2u + (bytes + UNIT_BYTES - 1u) / UNIT_BYTES;
}

static uint32_t units_of(const svo_i_edit_node *node)
{
    if (node->kind == SVO_I_EDIT_INNER) {
        return 2u + (svo_i_edit_count(node->mask) + 1u) / 2u;
    }
    return node->kind == SVO_I_EDIT_UNIFORM ? 1u : block_units(node->kind, mask_of(node));
}

svo_i_edit_kind svo_i_edit_kind_of(const svo_i_edit_store *store, svo_i_edit_ref ref)
{
    const svo_i_edit_node *node = at(store, ref);
    return (svo_i_edit_kind)(node->kind & (SVO_I_EDIT_UNIFORM | SVO_I_EDIT_INNER | SVO_I_EDIT_BLOCK));
}

svo_i_edit_payload svo_i_edit_payload_of(const svo_i_edit_store *store, svo_i_edit_ref ref)
{
    const svo_i_edit_node *node = at(store, ref);
    return (svo_i_edit_payload){.color = node->color, .material = node->material};
}

uint32_t svo_i_edit_variety_of(const svo_i_edit_store *store, svo_i_edit_ref ref)
{
    const svo_i_edit_node *node = at(store, ref);
    return node->kind & (uint32_t)(SVO_I_EDIT_COLORS | SVO_I_EDIT_MATERIALS | SVO_I_EDIT_NORMALS);
}

uint64_t svo_i_edit_mask_of(const svo_i_edit_store *store, svo_i_edit_ref ref)
{
    return mask_of(at(store, ref));
}

uint64_t svo_i_edit_voxels_of(const svo_i_edit_store *store, svo_i_edit_ref ref, uint32_t level)
{
    if (ref == SVO_I_EDIT_EMPTY) {
        return 0;
    }
    const svo_i_edit_node *node = at(store, ref);
    if (node->kind == SVO_I_EDIT_UNIFORM) {
        return (uint64_t)1 << 3u * level;
    }
    return node->kind == SVO_I_EDIT_INNER ? ((const svo_i_edit_inner *)(const void *)node)->voxel_count
                                          : svo_i_edit_count(mask_of(node));
}

void svo_i_edit_children_of(const svo_i_edit_store *store, svo_i_edit_ref ref, svo_i_edit_ref children[8])
{
    const svo_i_edit_inner *inner = ref != SVO_I_EDIT_EMPTY ? at(store, ref) : NULL;
    const bool is_uniform = inner != NULL && inner->node.kind == SVO_I_EDIT_UNIFORM;
    const uint32_t mask = inner != NULL && !is_uniform ? inner->node.mask : 0;
    const svo_i_edit_ref *next = inner != NULL ? inner->children : NULL;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        children[octant] = is_uniform ? ref : (mask >> octant & 1u) != 0 ? *next++ : SVO_I_EDIT_EMPTY;
    }
}

bool svo_i_edit_fill(svo_i_edit_store *store, svo_i_edit_payload payload, svo_i_edit_ref *out)
{
    if (store->last_uniform != SVO_I_EDIT_EMPTY) {
        const svo_i_edit_payload last = svo_i_edit_payload_of(store, store->last_uniform);
        if (last.color == payload.color && last.material == payload.material) {
            *out = store->last_uniform;
            return true;
        }
    }
    svo_i_edit_node *node = reserve(store, 1, out);
    if (node == NULL) {
        return false;
    }
    *node = (svo_i_edit_node){.kind = SVO_I_EDIT_UNIFORM, .material = payload.material, .color = payload.color};
    store->last_uniform = *out;
    return true;
}

/* Whether all children are uniform with one payload. */
static bool are_one(const svo_i_edit_store *store, const svo_i_edit_ref children[8])
{
    if (children[0] == SVO_I_EDIT_EMPTY) {
        return false;
    }
    const svo_i_edit_node *first = at(store, children[0]);
    bool one = first->kind == SVO_I_EDIT_UNIFORM;
    for (uint32_t i = 1; i < 8 && one; ++i) {
        const svo_i_edit_node *other = children[i] != SVO_I_EDIT_EMPTY ? at(store, children[i]) : NULL;
        one = other != NULL && other->kind == first->kind && other->color == first->color &&
              other->material == first->material;
    }
    return one;
}

bool svo_i_edit_join(svo_i_edit_store *store, const svo_i_edit_ref children[8], uint32_t level, svo_i_edit_ref *out)
{
    const uint32_t scale = 3u * (level - 1u) > 40u ? 3u * (level - 1u) - 40u : 0u; /* weights below 2^43 */
    svo_i_edit_sums colors = {.weight = 0};
    uint32_t mask = 0;
    uint64_t voxel_count = 0;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if (children[octant] != SVO_I_EDIT_EMPTY) {
            const uint64_t below = svo_i_edit_voxels_of(store, children[octant], level - 1);
            mask |= 1u << octant;
            voxel_count += below;
            svo_i_edit_add_color(&colors, svo_i_edit_payload_of(store, children[octant]).color,
                                 (below >> scale) + (scale > 0 ? 1u : 0u));
        }
    }
    if (mask == 0 || are_one(store, children)) {
        *out = children[0];
        return true;
    }
    svo_i_edit_inner *inner = reserve(store, 2u + (svo_i_edit_count(mask) + 1u) / 2u, out);
    if (inner == NULL) {
        return false;
    }
    inner->node =
        (svo_i_edit_node){.kind = SVO_I_EDIT_INNER, .mask = (uint8_t)mask, .color = svo_i_edit_mean_color(&colors)};
    inner->voxel_count = voxel_count;
    svo_i_edit_ref *next = inner->children;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if (children[octant] != SVO_I_EDIT_EMPTY) {
            *next++ = children[octant];
        }
    }
    return true;
}

/* ---- blocks ---- */

void svo_i_edit_unpack(const svo_i_edit_store *store, svo_i_edit_ref ref, svo_i_edit_cells *cells)
{
    const svo_i_edit_node *node = ref != SVO_I_EDIT_EMPTY ? at(store, ref) : NULL;
    if (node == NULL) {
        cells->mask = 0;
        return;
    }
    const bool is_block = node->kind != SVO_I_EDIT_UNIFORM;
    const uint32_t *colors = (const uint32_t *)(const void *)(node + 2);
    const bool has_colors = (node->kind & SVO_I_EDIT_COLORS) != 0;
    const bool has_materials = (node->kind & SVO_I_EDIT_MATERIALS) != 0;
    cells->mask = is_block ? mask_of(node) : UINT64_MAX;
    const bool has_normals = (node->kind & SVO_I_EDIT_NORMALS) != 0;
    const uint32_t count = svo_i_edit_count(cells->mask);
    const uint16_t *materials = (const uint16_t *)(const void *)(colors + (has_colors ? count : 0));
    const int16_t *normals = (const int16_t *)(const void *)(materials + (has_materials ? count : 0));
    for (uint64_t left = cells->mask; left != 0; left &= left - 1) {
        const uint32_t cell = svo_i_edit_lowest(left);
        cells->color[cell] = has_colors ? *colors++ : node->color;
        cells->material[cell] = has_materials ? *materials++ : node->material;
        cells->normal[cell] = has_normals ? svo_i_edit_pack_normal(normals) : 0;
        normals += has_normals ? 3 : 0;
    }
}

/* The payload bits of a block: what its voxels have of their own. */
static uint32_t variety_of(const svo_i_edit_store *store, const svo_i_edit_cells *cells)
{
    const uint32_t first = svo_i_edit_lowest(cells->mask);
    uint32_t kind = store->has_normals && cells->normal[first] != 0 ? (uint32_t)SVO_I_EDIT_NORMALS : 0u;
    for (uint64_t left = cells->mask & (cells->mask - 1); left != 0; left &= left - 1) {
        const uint32_t cell = svo_i_edit_lowest(left);
        kind |= cells->color[cell] != cells->color[first] ? (uint32_t)SVO_I_EDIT_COLORS : 0u;
        kind |= cells->material[cell] != cells->material[first] ? (uint32_t)SVO_I_EDIT_MATERIALS : 0u;
        kind |= store->has_normals && cells->normal[cell] != 0 ? (uint32_t)SVO_I_EDIT_NORMALS : 0u;
    }
    return kind;
}

static void write_payload(const svo_i_edit_cells *cells, svo_i_edit_node *node)
{
    uint32_t *colors = (uint32_t *)(void *)(node + 2);
    const bool has_colors = (node->kind & SVO_I_EDIT_COLORS) != 0;
    const bool has_materials = (node->kind & SVO_I_EDIT_MATERIALS) != 0;
    const bool has_normals = (node->kind & SVO_I_EDIT_NORMALS) != 0;
    const uint32_t count = svo_i_edit_count(cells->mask);
    uint16_t *materials = (uint16_t *)(void *)(colors + (has_colors ? count : 0));
    int16_t *normals = (int16_t *)(void *)(materials + (has_materials ? count : 0));
    for (uint64_t left = cells->mask; left != 0 && (has_colors || has_materials || has_normals); left &= left - 1) {
        const uint32_t cell = svo_i_edit_lowest(left);
        if (has_colors) {
            *colors++ = cells->color[cell];
        }
        if (has_materials) {
            *materials++ = cells->material[cell];
        }
        if (has_normals) {
            svo_i_edit_unpack_normal(cells->normal[cell], normals);
            normals += 3;
        }
    }
}

static uint32_t mean_of(const svo_i_edit_cells *cells)
{
    svo_i_edit_sums colors = {.weight = 0};
    for (uint64_t left = cells->mask; left != 0; left &= left - 1) {
        svo_i_edit_add_color(&colors, cells->color[svo_i_edit_lowest(left)], 1);
    }
    return svo_i_edit_mean_color(&colors);
}

bool svo_i_edit_pack(svo_i_edit_store *store, const svo_i_edit_cells *cells, svo_i_edit_ref *out)
{
    if (cells->mask == 0) {
        *out = SVO_I_EDIT_EMPTY;
        return true;
    }
    const uint32_t first = svo_i_edit_lowest(cells->mask);
    const svo_i_edit_payload payload = {.color = cells->color[first], .material = cells->material[first]};
    const uint32_t kind = (uint32_t)SVO_I_EDIT_BLOCK | variety_of(store, cells);
    if (cells->mask == UINT64_MAX && kind == SVO_I_EDIT_BLOCK) {
        return svo_i_edit_fill(store, payload, out);
    }
    svo_i_edit_node *node = reserve(store, block_units(kind, cells->mask), out);
    if (node == NULL) {
        return false;
    }
    *node = (svo_i_edit_node){.kind = (uint8_t)kind, .material = payload.material, .color = payload.color};
    if ((kind & (uint32_t)SVO_I_EDIT_COLORS) != 0) {
        node->color = mean_of(cells);
    }
    *(uint64_t *)(void *)(node + 1) = cells->mask;
    write_payload(cells, node);
    return true;
}

/*
 * ---- collection ----
 *
 * Marks the units of all nodes that the roots reach, finds where each goes, and moves them down. The nodes that begin
 * in one word's units stay together, so a word's number and its bits tell where each of them goes. They are never moved
 * up: a segment's nodes fit in a segment.
 */

static bool is_live(const svo_i_edit_store *store, svo_i_edit_ref ref)
{
    const uint32_t unit = ref & (SEGMENT_UNITS - 1u);
    return (store->segments[ref >> SEGMENT_LOG2]->live[unit >> WORD_LOG2] >> (unit & 63u) & 1u) != 0;
}

static void set_live(svo_i_edit_store *store, svo_i_edit_ref ref, uint32_t units)
{
    segment *one = store->segments[ref >> SEGMENT_LOG2];
    uint32_t unit = ref & (SEGMENT_UNITS - 1u);
    while (units > 0) {
        const uint32_t bit = unit & 63u;
        const uint32_t here = units < 64u - bit ? units : 64u - bit;
        one->live[unit >> WORD_LOG2] |= (here == 64u ? UINT64_MAX : ((uint64_t)1 << here) - 1u) << bit;
        unit += here;
        units -= here;
    }
}

static void mark(svo_i_edit_store *store, svo_i_edit_ref root)
{
    svo_i_edit_ref stack[STACK_MAX];
    uint32_t count = 0;
    stack[count++] = root;
    while (count > 0) {
        const svo_i_edit_ref ref = stack[--count];
        if (ref == SVO_I_EDIT_EMPTY || is_live(store, ref)) {
            continue;
        }
        const svo_i_edit_node *node = at(store, ref);
        set_live(store, ref, units_of(node));
        if (node->kind != SVO_I_EDIT_INNER) {
            continue;
        }
        const svo_i_edit_inner *inner = (const svo_i_edit_inner *)(const void *)node;
        for (uint32_t i = 0; i < svo_i_edit_count(node->mask); ++i) {
            stack[count++] = inner->children[i];
        }
    }
}

/* The units of a word from bit first on that are of kept nodes which begin there; *next: the first unit behind them. */
static uint32_t measure_word(const svo_i_edit_store *store, uint32_t word, uint64_t *next, uint32_t *first)
{
    const uint64_t begin = (uint64_t)word << WORD_LOG2;
    const uint64_t live = store->segments[word / SEGMENT_WORDS]->live[word % SEGMENT_WORDS];
    uint32_t sum = 0;
    *first = 64u;
    for (;;) {
        const uint64_t from = *next > begin ? *next - begin : 0;
        const uint64_t left = from < 64u ? live >> from << from : 0;
        if (left == 0) {
            return sum;
        }
        const uint32_t bit = svo_i_edit_lowest(left);
        const uint32_t units = units_of(at(store, (svo_i_edit_ref)(begin + bit)));
        *first = *first == 64u ? bit : *first;
        *next = begin + bit + units;
        sum += units;
    }
}

/* Where each word's nodes go. Returns the first unit behind them. */
static uint32_t place(svo_i_edit_store *store)
{
    uint64_t to = FIRST_UNIT;
    uint64_t next = 0;
    for (uint32_t word = 0; word < segments_of(store->top) * SEGMENT_WORDS; ++word) {
        uint32_t first = 0;
        segment *one = store->segments[word / SEGMENT_WORDS];
        const uint32_t units = measure_word(store, word, &next, &first);
        if (units == 0) {
            continue;
        }
        if ((to & (SEGMENT_UNITS - 1u)) + units > SEGMENT_UNITS) {
            to = (to | (SEGMENT_UNITS - 1u)) + 1u;
        }
        const uint64_t before = one->live[word % SEGMENT_WORDS] & (((uint64_t)1 << first) - 1u);
        one->moved[word % SEGMENT_WORDS] = (uint32_t)to - svo_i_edit_count(before);
        to += units;
    }
    return (uint32_t)to;
}

static svo_i_edit_ref moved(const svo_i_edit_store *store, svo_i_edit_ref ref)
{
    if (ref == SVO_I_EDIT_EMPTY) {
        return ref;
    }
    const segment *one = store->segments[ref >> SEGMENT_LOG2];
    const uint32_t word = (ref & (SEGMENT_UNITS - 1u)) >> WORD_LOG2;
    return one->moved[word] + svo_i_edit_count(one->live[word] & (((uint64_t)1 << (ref & 63u)) - 1u));
}

/* Moves the nodes that begin in a word's units. */
static void move_word(svo_i_edit_store *store, uint32_t word, uint64_t *next)
{
    const uint64_t begin = (uint64_t)word << WORD_LOG2;
    const uint64_t live = store->segments[word / SEGMENT_WORDS]->live[word % SEGMENT_WORDS];
    for (;;) {
        const uint64_t from = *next > begin ? *next - begin : 0;
        const uint64_t left = from < 64u ? live >> from << from : 0;
        if (left == 0) {
            return;
        }
        const svo_i_edit_ref ref = (svo_i_edit_ref)(begin + svo_i_edit_lowest(left));
        svo_i_edit_node *node = at(store, ref);
        const uint32_t units = units_of(node);
        if (node->kind == SVO_I_EDIT_INNER) {
            svo_i_edit_inner *inner = (svo_i_edit_inner *)(void *)node;
            for (uint32_t i = 0; i < svo_i_edit_count(node->mask); ++i) {
                inner->children[i] = moved(store, inner->children[i]);
            }
        }
        memmove(at(store, moved(store, ref)), node, (size_t)units * UNIT_BYTES);
        *next = (uint64_t)ref + units;
    }
}

void svo_i_edit_store_collect(svo_i_edit_store *store, svo_i_edit_ref *roots, size_t root_count)
{
    const uint32_t segment_count = segments_of(store->top);
    uint64_t next = 0;
    for (uint32_t i = 0; i < segment_count; ++i) {
        memset(store->segments[i]->live, 0, sizeof store->segments[i]->live);
    }
    for (size_t i = 0; i < root_count; ++i) {
        mark(store, roots[i]);
    }
    const uint32_t top = place(store);
    for (uint32_t word = 0; word < segment_count * SEGMENT_WORDS; ++word) {
        move_word(store, word, &next);
    }
    for (size_t i = 0; i < root_count; ++i) {
        roots[i] = moved(store, roots[i]);
    }
    store->last_uniform = SVO_I_EDIT_EMPTY;
    svo_i_edit_store_rewind(store, top);
}
