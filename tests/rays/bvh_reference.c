/* SPDX-License-Identifier: MIT */
/*
 * The reference of bvh_make, quality SVO_BVH_BEST: the same splits, one after the other on the host. Where
 * kernels/bvh works by levels and in parallel, this recurses, and its nodes are in depth-first order.
 */
#include "bvh_reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bins along an axis. Sets of fewer items use half as many, since evaluating the bins would cost more than filling
   them. */
#define BINS      16
#define FEW_ITEMS 64
/* Least x, y, z, and the greatest ones negated, so that one minimum over all components joins two boxes. */
typedef struct box {
    float least[8];
} box;

typedef struct item {
    box bounds; /* the part inside the grid */
    uint32_t triangle;
} item;

/* Consecutive items that become one child. */
typedef struct range {
    float area; /* half of the bounds'; an estimate after a split by count */
    uint32_t first, count;
    uint32_t halvings; /* splits from the set of all items down to this one */
} range;

typedef struct maker {
    const bvh_source *source;
    bvh *out;
    item *items, *spare;
    uint32_t item_count;
} maker;

/* ---- boxes ---- */

static void box_clear(box *b)
{
    for (int i = 0; i < 8; ++i) {
        b->least[i] = 0x1p40f;
    }
}

static void box_grow(box *b, const box *other)
{
    for (int i = 0; i < 8; ++i) {
        b->least[i] = other->least[i] < b->least[i] ? other->least[i] : b->least[i];
    }
}

static float box_half_area(const box *b)
{
    const float x = -b->least[0] - b->least[4];
    const float y = -b->least[1] - b->least[5];
    const float z = -b->least[2] - b->least[6];
    return x * y + y * z + z * x;
}

/* Twice the center. */
static float box_center(const box *b, int axis)
{
    return b->least[axis] - b->least[4 + axis];
}

static void box_of_triangle(const bvh_source *source, uint32_t triangle, box *out)
{
    const float width = (float)(1u << source->snap_bits);
    box_clear(out);
    for (size_t corner = 0; corner < 3; ++corner) {
        const int32_t *vertex = source->vertices + (size_t)source->indices[(size_t)triangle * 3 + corner] * 3;
        for (int axis = 0; axis < 3; ++axis) {
            const float at = (float)vertex[axis];
            out->least[axis] = at < out->least[axis] ? at : out->least[axis];
            out->least[4 + axis] = -at < out->least[4 + axis] ? -at : out->least[4 + axis];
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        out->least[axis] = out->least[axis] > 0.0f ? out->least[axis] : 0.0f;
        out->least[4 + axis] = out->least[4 + axis] > -width ? out->least[4 + axis] : -width;
        /* In a damaged file a listed triangle may lie below the grid. */
        out->least[4 + axis] = out->least[4 + axis] > 0.0f ? 0.0f : out->least[4 + axis];
    }
}

/* ---- splits ---- */

typedef struct bin {
    box bounds;
    uint32_t count;
} bin;

/* The bins' places. An item's bin is (center - begin) * per_unit, rounded down. */
typedef struct binning {
    int bin_count; /* along each axis */
    float begin[3], per_unit[3];
} binning;

static int bin_of(const binning *by, const box *bounds, int axis)
{
    return (int)((box_center(bounds, axis) - by->begin[axis]) * by->per_unit[axis]);
}

/* About 1 / value, for 2^-60 < value < 2^60, by Newton's iteration as kernels/bvh/boxes.clh has it. */
static float reciprocal(float value)
{
    int exponent = 0;
    const float mantissa = frexpf(value, &exponent);
    float inverse = 2.9142136f - 2.0f * mantissa;
    for (int i = 0; i < 4; ++i) {
        inverse = inverse * (2.0f - mantissa * inverse);
    }
    return ldexpf(inverse, -exponent);
}

static void place_bins(const item *items, uint32_t count, binning *out)
{
    float least[3] = {0x1p40f, 0x1p40f, 0x1p40f};
    float greatest[3] = {-0x1p40f, -0x1p40f, -0x1p40f};
    for (uint32_t i = 0; i < count; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            const float center = box_center(&items[i].bounds, axis);
            least[axis] = center < least[axis] ? center : least[axis];
            greatest[axis] = center > greatest[axis] ? center : greatest[axis];
        }
    }
    out->bin_count = count < FEW_ITEMS ? BINS / 2 : BINS;
    for (int axis = 0; axis < 3; ++axis) {
        const float width = greatest[axis] - least[axis];
        out->begin[axis] = least[axis];
        out->per_unit[axis] = width > 0x1p-40f ? (float)out->bin_count * 0.9999f * reciprocal(width) : 0.0f;
    }
}

static void fill_bins(const item *items, uint32_t count, const binning *by, bin bins[3][BINS])
{
    for (int axis = 0; axis < 3; ++axis) {
        for (int k = 0; k < by->bin_count; ++k) {
            box_clear(&bins[axis][k].bounds);
            bins[axis][k].count = 0;
        }
    }
    for (uint32_t i = 0; i < count; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            bin *into = &bins[axis][bin_of(by, &items[i].bounds, axis)];
            box_grow(&into->bounds, &items[i].bounds);
            ++into->count;
        }
    }
}

/* A split of a set, and half the areas of the two parts. */
typedef struct cut {
    float cost;
    int axis; /* negative: none found */
    int at; /* the first bin of the second part */
    float areas[2];
} cut;

static void find_cut_along(const bin bins[BINS], int bin_count, int axis, cut *best)
{
    box after[BINS];
    uint32_t count_after[BINS] = {0};
    box sum;
    uint32_t count = 0;
    box_clear(&sum);
    for (int k = bin_count - 1; k > 0; --k) {
        box_grow(&sum, &bins[k].bounds);
        count += bins[k].count;
        after[k] = sum;
        count_after[k] = count;
    }
    box_clear(&sum);
    count = 0;
    for (int k = 1; k < bin_count; ++k) {
        box_grow(&sum, &bins[k - 1].bounds);
        count += bins[k - 1].count;
        if (count == 0 || count_after[k] == 0) {
            continue;
        }
        const float cost = box_half_area(&sum) * (float)count + box_half_area(&after[k]) * (float)count_after[k];
        if (best->axis < 0 || cost < best->cost) {
            *best =
                (cut){.cost = cost, .axis = axis, .at = k, .areas = {box_half_area(&sum), box_half_area(&after[k])}};
        }
    }
}

/* Moves the items of the first part to the front; all stay in order. Returns their number. */
static uint32_t part_items(item *items, item *spare, uint32_t count, const binning *by, const cut *where)
{
    uint32_t front = 0;
    uint32_t back = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (bin_of(by, &items[i].bounds, where->axis) < where->at) {
            items[front++] = items[i];
        } else {
            spare[back++] = items[i];
        }
    }
    memcpy(items + front, spare, back * sizeof *spare);
    return front;
}

static box bounds_of(const item *items, uint32_t count)
{
    box sum;
    box_clear(&sum);
    for (uint32_t i = 0; i < count; ++i) {
        box_grow(&sum, &items[i].bounds);
    }
    return sum;
}

/* How often a set must be halved by count until its parts fit leaves. */
static uint32_t halvings_by_count(uint32_t count)
{
    uint32_t halvings = 0;
    for (; count > SVO_RAY_LEAF_TRIANGLES; count -= count / 2) {
        ++halvings;
    }
    return halvings;
}

/* Splits a range that is too large for a leaf in two: by area, while enough levels remain to split the parts by count;
   otherwise by count. */
static void halve(maker *m, const range *whole, range *first, range *second)
{
    item *items = m->items + whole->first;
    cut where = {.axis = -1, .areas = {0.5f * whole->area, 0.5f * whole->area}};
    uint32_t front = whole->count / 2;
    if (whole->halvings + 1 + halvings_by_count(whole->count) <= SVO_BVH_DEPTH_MAX) {
        binning by;
        bin bins[3][BINS];
        place_bins(items, whole->count, &by);
        fill_bins(items, whole->count, &by, bins);
        for (int axis = 0; axis < 3; ++axis) {
            find_cut_along(bins[axis], by.bin_count, axis, &where);
        }
        front = where.axis < 0 ? front : part_items(items, m->spare, whole->count, &by, &where);
    }
    const uint32_t halvings = whole->halvings + 1;
    const range parts[2] = {
        {.area = where.areas[0], .first = whole->first, .count = front, .halvings = halvings},
        {.area = where.areas[1], .first = whole->first + front, .count = whole->count - front, .halvings = halvings}};
    *first = parts[0];
    *second = parts[1];
}

/* ---- records ---- */

/* Grows an array to at least needed elements. Returns false, with the array unchanged, when out of memory. */
static bool reserve(void **array, size_t *capacity, size_t needed, size_t element_bytes)
{
    if (needed <= *capacity) {
        return true;
    }
    size_t grown = *capacity < 1024 ? 1024 : *capacity;
    while (grown < needed) {
        grown += grown / 2;
    }
    void *moved = grown <= SIZE_MAX / element_bytes ? realloc(*array, grown * element_bytes) : NULL;
    if (moved == NULL) {
        return false;
    }
    *array = moved;
    *capacity = grown;
    return true;
}

/* Least and greatest snapped coordinates of whole triangles. */
static void find_leaf_bounds(const bvh_source *source, const item *items, uint32_t count, int32_t low[3],
                             int32_t high[3])
{
    for (size_t axis = 0; axis < 3; ++axis) {
        low[axis] = count > 0 ? INT32_MAX : 0;
        high[axis] = count > 0 ? INT32_MIN : 0;
    }
    for (uint32_t i = 0; i < count * 3; ++i) {
        const uint32_t vertex = source->indices[(size_t)items[i / 3].triangle * 3 + i % 3];
        for (size_t axis = 0; axis < 3; ++axis) {
            const int32_t at = source->vertices[(size_t)vertex * 3 + axis];
            low[axis] = at < low[axis] ? at : low[axis];
            high[axis] = at > high[axis] ? at : high[axis];
        }
    }
}

size_t bvh_reference_ids_begin(bool has_doubles, uint32_t count)
{
    const size_t words = 9 * (size_t)count;
    return has_doubles ? (words + 1) / 2 * 2 + 2 * words : words;
}

size_t bvh_reference_leaf_words(bool has_doubles, uint32_t count)
{
    return (SVO_RAY_LEAF_HEAD_WORDS + bvh_reference_ids_begin(has_doubles, count) + count + 3) / 4 * 4;
}

/* Writes what follows the head: nine rows, nine of doubles where there are any, and the positions in the mesh. */
static void write_triangles(const bvh_source *source, const item *items, uint32_t count, uint32_t *words)
{
    uint32_t *doubles = words + (9 * (size_t)count + 1) / 2 * 2;
    size_t entry = 0;
    for (size_t axis = 0; axis < 3; ++axis) {
        for (size_t corner = 0; corner < 3; ++corner) {
            for (uint32_t i = 0; i < count; ++i, ++entry) {
                const size_t at = (size_t)source->indices[(size_t)items[i].triangle * 3 + corner] * 3 + axis;
                memcpy(words + entry, &source->floats[at], sizeof *words);
                if (source->doubles != NULL) {
                    memcpy(doubles + 2 * entry, &source->doubles[at], sizeof(double));
                }
            }
        }
    }
    for (uint32_t i = 0; i < count; ++i) {
        words[bvh_reference_ids_begin(source->doubles != NULL, count) + i] = source->triangle_ids[items[i].triangle];
    }
}

/* Adds a leaf. *reference receives a node's reference to it. */
static bool add_leaf(maker *m, const item *items, uint32_t count, uint32_t *reference)
{
    bvh *out = m->out;
    int32_t low[3];
    int32_t high[3];
    const size_t words = bvh_reference_leaf_words(m->source->doubles != NULL, count);
    const size_t position = out->leaf_words / 4;
    if (position >= SVO_RAY_LEAF ||
        !reserve((void **)&out->leaves, &out->leaf_capacity, out->leaf_words + words + SVO_RAY_LEAF_PADDING_WORDS,
                 sizeof *out->leaves)) {
        return false;
    }
    uint32_t *record = out->leaves + out->leaf_words;
    memset(record, 0, (words + SVO_RAY_LEAF_PADDING_WORDS) * sizeof *record);
    find_leaf_bounds(m->source, items, count, low, high);
    for (int axis = 0; axis < 3; ++axis) {
        record[axis] = (uint32_t)low[axis];
        record[4 + axis] = (uint32_t)high[axis];
    }
    record[3] = count;
    write_triangles(m->source, items, count, record + SVO_RAY_LEAF_HEAD_WORDS);
    out->leaf_words += words;
    *reference = SVO_RAY_LEAF | (uint32_t)position;
    return true;
}

/* Adds a node without children: all references are to the empty leaf. */
static bool add_node(maker *m, uint32_t *index)
{
    bvh *out = m->out;
    if (out->node_count >= SVO_RAY_LEAF ||
        !reserve((void **)&out->nodes, &out->node_capacity, out->node_count + 1, sizeof *out->nodes)) {
        return false;
    }
    svo_ray_node *node = &out->nodes[out->node_count];
    for (int axis = 0; axis < 3; ++axis) {
        for (int word = 0; word < 4; ++word) {
            node->low[4 * axis + word] = UINT32_MAX;
            node->high[4 * axis + word] = 0;
        }
    }
    for (int child = 0; child < 8; ++child) {
        node->child[child] = SVO_RAY_LEAF;
    }
    *index = (uint32_t)out->node_count++;
    return true;
}

static void set_bound(uint32_t words[12], int axis, int child, uint32_t value)
{
    uint32_t *word = &words[4 * axis + child / 2];
    const uint32_t shift = 16u * (uint32_t)(child % 2);
    *word = (*word & ~(UINT32_C(0xffff) << shift)) | value << shift;
}

/* Both bounds are rounded down: a box ends where the step after its high bound begins. */
static void set_child(svo_ray_node *node, int child, const box *bounds, uint32_t box_log2, uint32_t reference)
{
    for (int axis = 0; axis < 3; ++axis) {
        const uint32_t low = (uint32_t)bounds->least[axis] >> box_log2;
        const uint32_t high = (uint32_t)-bounds->least[4 + axis] >> box_log2;
        set_bound(node->low, axis, child, low < UINT16_MAX ? low : UINT16_MAX);
        set_bound(node->high, axis, child, high < UINT16_MAX ? high : UINT16_MAX);
    }
    node->child[child] = reference;
}

/* The range with the largest area of those too large for a leaf; negative: none. */
static int largest_range(const range *ranges, int count)
{
    int best = -1;
    float most = 0.0f;
    for (int i = 0; i < count; ++i) {
        const float area = ranges[i].area;
        if (ranges[i].count > SVO_RAY_LEAF_TRIANGLES && (best < 0 || area > most)) {
            best = i;
            most = area;
        }
    }
    return best;
}

/* Adds a node for a range, and all nodes and leaves below it. *index receives the node's index. Recursion is at most
   SVO_BVH_DEPTH_MAX deep. */
static bool make_node(maker *m, const range *whole, uint32_t *index)
{
    range ranges[8] = {*whole};
    int count = whole->count > 0 ? 1 : 0;
    for (int best = largest_range(ranges, count); best >= 0 && count < 8; best = largest_range(ranges, count)) {
        const range whole_set = ranges[best];
        halve(m, &whole_set, &ranges[best], &ranges[count]);
        ++count;
    }
    if (!add_node(m, index)) {
        return false;
    }
    for (int i = 0; i < count; ++i) {
        uint32_t reference = 0;
        const bool made = ranges[i].count <= SVO_RAY_LEAF_TRIANGLES
                              ? add_leaf(m, m->items + ranges[i].first, ranges[i].count, &reference)
                              : make_node(m, &ranges[i], &reference);
        if (!made) {
            return false;
        }
        const box bounds = bounds_of(m->items + ranges[i].first, ranges[i].count);
        set_child(&m->out->nodes[*index], i, &bounds, m->source->snap_bits - SVO_RAY_BOX_BITS, reference);
    }
    return true;
}

/* ---- all of it ---- */

/* Collects the triangles to include, each once, in their order. */
static bool gather_items(maker *m)
{
    const bvh_source *source = m->source;
    const uint32_t count = source->triangle_count;
    uint8_t *listed = source->list != NULL ? calloc((size_t)count + 1, 1) : NULL;
    m->items = calloc((size_t)count + 1, sizeof *m->items);
    m->spare = calloc((size_t)count + 1, sizeof *m->spare);
    if (m->items == NULL || m->spare == NULL || (source->list != NULL && listed == NULL)) {
        free(listed);
        return false;
    }
    for (uint64_t i = 0; listed != NULL && i < source->list_count; ++i) {
        listed[source->list[i]] = 1;
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (listed == NULL || listed[i] != 0) {
            item *added = &m->items[m->item_count++];
            added->triangle = i;
            box_of_triangle(source, i, &added->bounds);
        }
    }
    free(listed);
    return true;
}

bool bvh_reference_make(const bvh_source *source, bvh *out)
{
    maker m = {.source = source, .out = out};
    uint32_t unread = 0;
    *out = (bvh){.nodes = NULL};
    bool made = gather_items(&m) && add_leaf(&m, NULL, 0, &unread);
    if (made) {
        const range all = {.area = 1.0f, .first = 0, .count = m.item_count};
        made = make_node(&m, &all, &unread);
    }
    out->leaf_words += made ? SVO_RAY_LEAF_PADDING_WORDS : 0;
    free(m.items);
    free(m.spare);
    return made;
}

void bvh_reference_free(bvh *made)
{
    free(made->nodes);
    free(made->leaves);
    *made = (bvh){.nodes = NULL};
}
