/* SPDX-License-Identifier: MIT */
/*
 * The BVH that rays traverse: nodes of up to eight children, leaves of up to eight triangles, each triangle in one
 * leaf. It is built when a tree's rays are first used; kernels/rays/rays.clh reads it.
 *
 * The surface area heuristic decides where a set of triangles is split, estimated with bins along the three axes (Wald,
 * "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007). A node splits the set with the largest area
 * until it has eight sets, or all fit leaves (Wald, Benthin and Boulos, "Getting Rid of Packets", 2008). Bounds are
 * whole grid units, exact in floats; nodes store them rounded outwards to 16 bits (after Mahovsky and Wyvill,
 * "Memory-Conserving Bounding Volume Hierarchies with Coherent Raytracing", 2006). Floats are only added, multiplied
 * and compared, so the same geometry gives the same BVH everywhere.
 */
#include "rays/bvh.h"

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
    box bounds;
    uint32_t first, count;
    uint32_t halvings; /* splits from the set of all items down to this one */
} range;

typedef struct maker {
    const svo_i_memory *memory;
    const svo_i_bvh_source *source;
    svo_i_bvh *out;
    item *items;
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

static void box_of_triangle(const svo_i_bvh_source *source, uint32_t triangle, box *out)
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
        out->per_unit[axis] = width > 0.0f ? (float)out->bin_count * 0.9999f / width : 0.0f;
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

/* A split of a set, and the bounds of the two parts. */
typedef struct cut {
    float cost;
    int axis; /* negative: none found */
    int at; /* the first bin of the second part */
    box parts[2];
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
            *best = (cut){.cost = cost, .axis = axis, .at = k, .parts = {sum, after[k]}};
        }
    }
}

/* Moves the items of the first part to the front. Returns their number. */
static uint32_t part_items(item *items, uint32_t count, const binning *by, const cut *where)
{
    uint32_t front = 0;
    uint32_t back = count;
    while (front < back) {
        if (bin_of(by, &items[front].bounds, where->axis) < where->at) {
            ++front;
        } else {
            const item moved = items[front];
            items[front] = items[--back];
            items[back] = moved;
        }
    }
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
static void halve(item *all, const range *whole, range *first, range *second)
{
    item *items = all + whole->first;
    cut where = {.axis = -1};
    uint32_t front = whole->count / 2;
    if (whole->halvings + 1 + halvings_by_count(whole->count) <= SVO_BVH_DEPTH_MAX) {
        binning by;
        bin bins[3][BINS];
        place_bins(items, whole->count, &by);
        fill_bins(items, whole->count, &by, bins);
        for (int axis = 0; axis < 3; ++axis) {
            find_cut_along(bins[axis], by.bin_count, axis, &where);
        }
        front = where.axis < 0 ? front : part_items(items, whole->count, &by, &where);
    }
    if (where.axis < 0) {
        where.parts[0] = bounds_of(items, front);
        where.parts[1] = bounds_of(items + front, whole->count - front);
    }
    const uint32_t halvings = whole->halvings + 1;
    const range parts[2] = {
        {.bounds = where.parts[0], .first = whole->first, .count = front, .halvings = halvings},
        {.bounds = where.parts[1], .first = whole->first + front, .count = whole->count - front, .halvings = halvings}};
    *first = parts[0];
    *second = parts[1];
}

/* ---- records ---- */

/* Grows an array to at least needed elements. Returns false, with the array unchanged, when out of memory. */
static bool reserve(const svo_i_memory *memory, void **array, size_t *capacity, size_t needed, size_t element_bytes)
{
    if (needed <= *capacity) {
        return true;
    }
    size_t grown = *capacity < 1024 ? 1024 : *capacity;
    while (grown < needed) {
        grown += grown / 2;
    }
    void *moved = grown <= SIZE_MAX / element_bytes ? svo_i_grow(memory, *array, grown * element_bytes) : NULL;
    if (moved == NULL) {
        return false;
    }
    *array = moved;
    *capacity = grown;
    return true;
}

/* Least and greatest snapped coordinates of whole triangles. */
static void find_leaf_bounds(const svo_i_bvh_source *source, const item *items, uint32_t count, int32_t low[3],
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

/* A coordinate of a vertex, world units. at: of the coordinate in its array. */
static double world_coordinate(const svo_i_bvh_source *source, size_t at)
{
    if (source->positions != NULL) {
        return (double)source->positions[at];
    }
    return source->positions_double != NULL ? source->positions_double[at]
                                            : source->origin[at % 3] + (double)source->vertices[at] / source->scale;
}

/* The coordinate as floats have it. */
static float row_coordinate(const svo_i_bvh_source *source, size_t at)
{
    return source->rows == SVO_I_ROWS_WORLD
               ? source->positions[at]
               : (float)((world_coordinate(source, at) - source->origin[at % 3]) * source->scale);
}

/* Where the rows of doubles begin, in words after the head, and where the positions in the mesh do. */
static size_t doubles_begin(uint32_t count)
{
    return (9 * (size_t)count + 1) & ~(size_t)1;
}

static size_t ids_begin(svo_i_leaf_rows rows, uint32_t count)
{
    return rows == SVO_I_ROWS_DOUBLE ? doubles_begin(count) + 18 * (size_t)count : 9 * (size_t)count;
}

/* Writes what follows the head: nine rows, nine of doubles where there are any, and the positions in the mesh. */
static void write_triangles(const svo_i_bvh_source *source, const item *items, uint32_t count, uint32_t *words)
{
    float *floats = (float *)words;
    double *doubles = (double *)(words + doubles_begin(count));
    size_t entry = 0;
    for (size_t axis = 0; axis < 3; ++axis) {
        for (size_t corner = 0; corner < 3; ++corner) {
            for (uint32_t i = 0; i < count; ++i, ++entry) {
                const size_t at = (size_t)source->indices[(size_t)items[i].triangle * 3 + corner] * 3 + axis;
                floats[entry] = row_coordinate(source, at);
                if (source->rows == SVO_I_ROWS_DOUBLE) {
                    doubles[entry] = world_coordinate(source, at);
                }
            }
        }
    }
    for (uint32_t i = 0; i < count; ++i) {
        words[ids_begin(source->rows, count) + i] = source->triangle_ids[items[i].triangle];
    }
}

/* Adds a leaf. *reference receives a node's reference to it. */
static bool add_leaf(maker *m, const item *items, uint32_t count, uint32_t *reference)
{
    svo_i_bvh *out = m->out;
    int32_t low[3];
    int32_t high[3];
    const size_t words = (SVO_RAY_LEAF_HEAD_WORDS + ids_begin(m->source->rows, count) + count + 3) / 4 * 4;
    const size_t position = out->leaf_words / 4;
    if (position >= SVO_RAY_LEAF ||
        !reserve(m->memory, (void **)&out->leaves, &out->leaf_capacity,
                 out->leaf_words + words + SVO_RAY_LEAF_PADDING_WORDS, sizeof *out->leaves)) {
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
    svo_i_bvh *out = m->out;
    if (out->node_count >= SVO_RAY_LEAF ||
        !reserve(m->memory, (void **)&out->nodes, &out->node_capacity, out->node_count + 1, sizeof *out->nodes)) {
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
        const float area = box_half_area(&ranges[i].bounds);
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
        halve(m->items, &whole_set, &ranges[best], &ranges[count]);
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
        set_child(&m->out->nodes[*index], i, &ranges[i].bounds, m->source->snap_bits - SVO_RAY_BOX_BITS, reference);
    }
    return true;
}

/* ---- all of it ---- */

/* Collects the triangles to include, each once, in their order. */
static bool gather_items(maker *m)
{
    const svo_i_bvh_source *source = m->source;
    const uint32_t count = source->triangle_count;
    uint8_t *listed = source->list != NULL ? svo_i_alloc_zeroed(m->memory, (size_t)count + 1, 1) : NULL;
    m->items = svo_i_alloc_zeroed(m->memory, (size_t)count + 1, sizeof *m->items);
    if (m->items == NULL || (source->list != NULL && listed == NULL)) {
        svo_i_free(listed);
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
    svo_i_free(listed);
    return true;
}

bool svo_i_bvh_make(const svo_i_memory *memory, const svo_i_bvh_source *source, svo_i_bvh *out)
{
    maker m = {.memory = memory, .source = source, .out = out};
    uint32_t unread = 0;
    *out = (svo_i_bvh){.nodes = NULL};
    bool made = gather_items(&m) && add_leaf(&m, NULL, 0, &unread);
    if (made) {
        const range all = {.bounds = bounds_of(m.items, m.item_count), .first = 0, .count = m.item_count};
        made = make_node(&m, &all, &unread);
    }
    out->leaf_words += made ? SVO_RAY_LEAF_PADDING_WORDS : 0;
    svo_i_free(m.items);
    return made;
}

void svo_i_bvh_free(svo_i_bvh *bvh)
{
    svo_i_free(bvh->nodes);
    svo_i_free(bvh->leaves);
    *bvh = (svo_i_bvh){.nodes = NULL};
}
