/* SPDX-License-Identifier: MIT */
/*
 * Trees of .vdb files, for their reader: where nodes and their values lie in the file, and the values of a node, which
 * are unpacked when they are asked for. Every length is checked against the grid's end. Nodes take at most a quarter of
 * their bytes in the file as memory, and values that of one node of each level.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include <zlib.h>

#ifdef SVOCL_BLOSC
#include <blosc.h>
#endif

#include "io/voxels_files.h"
#include "io/voxels_vdb_file.h"

#define PLACE_BYTES 12u /* three coordinates */
#define KNOWN_FLAGS ((uint32_t)(VDB_ZIP | VDB_ACTIVE_MASK | VDB_BLOSC))
#define HALF_BYTES  2u
#define GROWTH      1024u /* no writer's packed values are longer than the values by more */

static const vdb_type types[] = {{"Tree_float_5_4_3", VDB_FLOAT, 1, 4},  {"Tree_double_5_4_3", VDB_DOUBLE, 1, 8},
                                 {"Tree_int32_5_4_3", VDB_INT32, 1, 4},  {"Tree_int64_5_4_3", VDB_INT64, 1, 8},
                                 {"Tree_bool_5_4_3", VDB_BOOL, 1, 1},    {"Tree_mask_5_4_3", VDB_MASK, 1, 1},
                                 {"Tree_vec3s_5_4_3", VDB_FLOAT, 3, 12}, {"Tree_vec3d_5_4_3", VDB_DOUBLE, 3, 24},
                                 {"Tree_vec3i_5_4_3", VDB_INT32, 3, 12}};

const vdb_type *svo_i_vdb_type(const char *name, size_t bytes)
{
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i) {
        if (strlen(types[i].name) == bytes && memcmp(types[i].name, name, bytes) == 0) {
            return &types[i];
        }
    }
    return NULL;
}

double svo_i_vdb_number(const vdb_type *type, const uint8_t *value, uint32_t component)
{
    const uint8_t *from = value + (size_t)component * (type->value_bytes / type->components);
    float number = 0.0F;
    double wide = 0.0;
    int32_t whole = 0;
    int64_t long_whole = 0;
    switch (type->kind) {
    case VDB_FLOAT:
        memcpy(&number, from, sizeof number);
        return (double)number;
    case VDB_DOUBLE:
        memcpy(&wide, from, sizeof wide);
        return wide;
    case VDB_INT32:
        memcpy(&whole, from, sizeof whole);
        return whole;
    case VDB_INT64:
        memcpy(&long_whole, from, sizeof long_whole);
        return (double)long_whole;
    default:
        return *from != 0 ? 1.0 : 0.0;
    }
}

/* ---- the place in the file ---- */

svo_status svo_i_vdb_damaged(const vdb_input *in, const char *what, size_t at)
{
    return in->grid == NULL ? svo_i_voxels_damaged(in->reader, "%s, at byte %zu", what, at)
                            : svo_i_voxels_damaged(in->reader, "grid \"%s\": %s, at byte %zu", in->grid, what, at);
}

svo_status svo_i_vdb_take(vdb_input *in, size_t bytes, const char *what, const uint8_t **out)
{
    if (bytes > in->end - in->at) {
        return in->grid == NULL
                   ? svo_i_voxels_damaged(in->reader, "%s cut off, at byte %zu", what, in->at)
                   : svo_i_voxels_damaged(in->reader, "grid \"%s\": %s cut off, at byte %zu", in->grid, what, in->at);
    }
    *out = in->reader->bytes + in->at;
    in->at += bytes;
    return SVO_OK;
}

static uint32_t get_u32(const uint8_t *bytes)
{
    uint32_t value = 0;
    memcpy(&value, bytes, sizeof value);
    return value;
}

static uint32_t count_bits(const uint8_t *mask, uint32_t slots)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < slots / 8; i += 8) {
        uint64_t word = 0;
        memcpy(&word, mask + i, sizeof word);
        for (; word != 0; word &= word - 1) {
            ++count;
        }
    }
    return count;
}

/* ---- values as they lie in the file ---- */

typedef struct packed_values {
    uint8_t code; /* how inactive ones are written */
    const uint8_t *inactive[2]; /* where the file has them; else NULL */
    const uint8_t *choice; /* a bit for each value: which of two; else NULL */
    uint32_t count; /* of those that are written */
    size_t element_bytes; /* of each */
    const uint8_t *data;
    size_t data_bytes;
    bool is_packed;
} packed_values;

static bool has_halves(const vdb_tree *tree)
{
    return tree->is_half && (tree->type->kind == VDB_FLOAT || tree->type->kind == VDB_DOUBLE);
}

/* The packed values' length, which is not there for no halves, and the values. */
static svo_status take_data(vdb_input *in, const vdb_tree *tree, packed_values *p)
{
    const size_t bytes = p->count * p->element_bytes;
    const size_t field = in->at;
    const uint8_t *length = NULL;
    int64_t packed = 0;
    p->data_bytes = bytes;
    if ((tree->compression & (VDB_ZIP | VDB_BLOSC)) != 0 && !(has_halves(tree) && bytes == 0)) {
        SVO_I_TRY(svo_i_vdb_take(in, sizeof packed, "a length of values is", &length));
        memcpy(&packed, length, sizeof packed);
        if (packed > 0 ? (uint64_t)packed > bytes + GROWTH : (uint64_t)0 - (uint64_t)packed != bytes) {
            return svo_i_vdb_damaged(in, "the length of values is not that of their number", field);
        }
        p->is_packed = packed > 0;
        p->data_bytes = p->is_packed ? (size_t)packed : bytes;
    }
    return svo_i_vdb_take(in, p->data_bytes, "values are", &p->data);
}

/* Goes over the values of a node. mask: of the active ones. */
static svo_status take_values(vdb_input *in, const vdb_tree *tree, const uint8_t *mask, uint32_t slots,
                              packed_values *p)
{
    const uint32_t value_bytes = tree->type->value_bytes;
    const uint8_t *code = NULL;
    *p = (packed_values){.count = slots,
                         .element_bytes = has_halves(tree) ? HALF_BYTES * (size_t)tree->type->components : value_bytes};
    SVO_I_TRY(svo_i_vdb_take(in, 1, "values are", &code));
    p->code = *code;
    if (p->code > VDB_EVERY_VALUE) {
        return svo_i_vdb_damaged(in, "inactive values are left out in an unknown way", in->at - 1);
    }
    if (p->code == VDB_ALL_ONE || p->code == VDB_ONE_AND_BACKGROUND || p->code == VDB_TWO_VALUES) {
        SVO_I_TRY(svo_i_vdb_take(in, value_bytes, "an inactive value is", &p->inactive[0]));
    }
    if (p->code == VDB_TWO_VALUES) {
        SVO_I_TRY(svo_i_vdb_take(in, value_bytes, "an inactive value is", &p->inactive[1]));
    }
    if (p->code == VDB_TWO_SIGNS || p->code == VDB_ONE_AND_BACKGROUND || p->code == VDB_TWO_VALUES) {
        SVO_I_TRY(svo_i_vdb_take(in, slots / 8, "the mask of inactive values is", &p->choice));
    }
    if ((tree->compression & VDB_ACTIVE_MASK) != 0 && p->code != VDB_EVERY_VALUE) {
        p->count = count_bits(mask, slots);
    }
    return take_data(in, tree, p);
}

/* ---- unpacking ---- */

struct vdb_unpacker {
    z_stream zip;
    bool has_zip;
    uint8_t bytes[]; /* the values of the largest node */
};

static voidpf allocate(voidpf user, uInt items, uInt bytes)
{
    return svo_i_alloc(user, (size_t)items * bytes);
}

static void release(voidpf user, voidpf block)
{
    (void)user;
    svo_i_free(block);
}

void svo_i_vdb_input_end(vdb_input *in)
{
    if (in->unpacker != NULL && in->unpacker->has_zip) {
        (void)inflateEnd(&in->unpacker->zip);
    }
    svo_i_free(in->unpacker);
    in->unpacker = NULL;
}

static svo_status fail_memory(const vdb_input *in)
{
    return svo_i_voxels_fail(in->reader, SVO_OUT_OF_HOST_MEMORY, "grid \"%s\": no memory for its values", in->grid);
}

static svo_status unzip(vdb_input *in, const packed_values *p)
{
    z_stream *zip = &in->unpacker->zip;
    if (!in->unpacker->has_zip) {
        zip->zalloc = allocate;
        zip->zfree = release;
        zip->opaque = &in->reader->memory;
        if (inflateInit(zip) != Z_OK) {
            return fail_memory(in);
        }
        in->unpacker->has_zip = true;
    }
    (void)inflateReset(zip);
    zip->next_in = (z_const Bytef *)p->data;
    zip->avail_in = (uInt)p->data_bytes;
    zip->next_out = in->unpacker->bytes;
    zip->avail_out = (uInt)(p->count * p->element_bytes);
    const int result = inflate(zip, Z_FINISH);
    if (result == Z_MEM_ERROR) {
        return fail_memory(in);
    }
    return result == Z_STREAM_END && zip->avail_in == 0 && zip->avail_out == 0
               ? SVO_OK
               : svo_i_vdb_damaged(in, "values packed by ZIP are wrong", (size_t)(p->data - in->reader->bytes));
}

#ifdef SVOCL_BLOSC
static svo_status unpack_blosc(vdb_input *in, const packed_values *p)
{
    const size_t expected = p->count * p->element_bytes;
    size_t bytes = 0;
    if (blosc_cbuffer_validate(p->data, p->data_bytes, &bytes) != 0 || bytes != expected ||
        blosc_decompress_ctx(p->data, in->unpacker->bytes, expected, 1) != (int)expected) {
        return svo_i_vdb_damaged(in, "values packed by BLOSC are wrong", (size_t)(p->data - in->reader->bytes));
    }
    return SVO_OK;
}
#else
static svo_status unpack_blosc(vdb_input *in, const packed_values *p)
{
    return svo_i_vdb_damaged(in, "values are packed by BLOSC", (size_t)(p->data - in->reader->bytes));
}
#endif

static svo_status unpack(vdb_input *in, const vdb_tree *tree, const packed_values *p, const uint8_t **elements)
{
    *elements = p->data;
    if (!p->is_packed) {
        return SVO_OK;
    }
    if (in->unpacker == NULL) {
        const size_t most = (size_t)VDB_UPPER_VALUES * tree->type->value_bytes;
        in->unpacker = svo_i_alloc(&in->reader->memory, sizeof *in->unpacker + most);
        if (in->unpacker == NULL) {
            return fail_memory(in);
        }
        memset(in->unpacker, 0, sizeof *in->unpacker);
    }
    *elements = in->unpacker->bytes;
    return (tree->compression & VDB_BLOSC) != 0 ? unpack_blosc(in, p) : unzip(in, p);
}

/* IEEE 754's binary16. */
static double half_value(const uint8_t *from)
{
    const int bits = from[0] | from[1] << 8;
    const int exponent = bits >> 10 & 31;
    const int fraction = bits & 1023;
    const double value = exponent == 31  ? (fraction != 0 ? (double)NAN : (double)INFINITY)
                         : exponent == 0 ? ldexp(fraction, -24)
                                         : ldexp(fraction | 1024, exponent - 25);
    return (bits >> 15) != 0 ? -value : value;
}

static void put_element(const vdb_tree *tree, const uint8_t *element, uint8_t *value)
{
    if (!has_halves(tree)) {
        memcpy(value, element, tree->type->value_bytes);
        return;
    }
    for (size_t i = 0; i < tree->type->components; ++i) {
        const double wide = half_value(element + HALF_BYTES * i);
        const float number = (float)wide;
        if (tree->type->kind == VDB_FLOAT) {
            memcpy(value + sizeof number * i, &number, sizeof number);
        } else {
            memcpy(value + sizeof wide * i, &wide, sizeof wide);
        }
    }
}

/* The negative of a value: of floats the other sign, of whole numbers the complement of two, of bits the other one. */
static void negate(const vdb_type *type, const uint8_t *value, uint8_t *out)
{
    const uint32_t bytes = type->value_bytes / type->components;
    memcpy(out, value, type->value_bytes);
    for (uint32_t i = 0; i < type->value_bytes; i += bytes) {
        uint64_t whole = 0;
        if (type->kind == VDB_FLOAT || type->kind == VDB_DOUBLE) {
            out[i + bytes - 1] ^= 0x80u;
        } else if (type->kind == VDB_INT32 || type->kind == VDB_INT64) {
            memcpy(&whole, out + i, bytes);
            whole = 0 - whole;
            memcpy(out + i, &whole, bytes);
        } else {
            out[i] = out[i] == 0;
        }
    }
}

svo_status svo_i_vdb_values(vdb_input *in, vdb_tree *tree, int level, const vdb_node *node, const uint8_t **values)
{
    const uint32_t slots = vdb_slots(level);
    const uint32_t value_bytes = tree->type->value_bytes;
    const uint8_t *mask = in->reader->bytes + node->masks + (level == VDB_LEAF ? 0 : slots / 8);
    const size_t at = in->at;
    uint8_t negative[VDB_VALUE_BYTES_MAX];
    const uint8_t *elements = NULL;
    packed_values p;
    if (tree->values[level] == NULL) {
        tree->values[level] = svo_i_alloc(&in->reader->memory, (size_t)slots * value_bytes);
        if (tree->values[level] == NULL) {
            return fail_memory(in);
        }
    }
    *values = tree->values[level];
    if (tree->held[level] == node) {
        return SVO_OK;
    }
    tree->held[level] = NULL;
    in->at = node->values;
    SVO_I_TRY(take_values(in, tree, mask, slots, &p));
    in->at = at;
    SVO_I_TRY(unpack(in, tree, &p, &elements));
    negate(tree->type, tree->background, negative);
    const uint8_t *const first = p.inactive[0] != NULL          ? p.inactive[0]
                                 : p.code == VDB_ALL_BACKGROUND ? tree->background
                                                                : negative;
    const uint8_t *const second = p.inactive[1] != NULL ? p.inactive[1] : tree->background;
    for (uint32_t i = 0; i < slots; ++i) {
        uint8_t *value = tree->values[level] + (size_t)i * value_bytes;
        if (p.count == slots || vdb_has_bit(mask, i)) {
            put_element(tree, elements, value);
            elements += p.element_bytes;
        } else {
            memcpy(value, p.choice != NULL && vdb_has_bit(p.choice, i) ? second : first, value_bytes);
        }
    }
    tree->held[level] = node;
    return SVO_OK;
}

/* ---- nodes ---- */

void svo_i_vdb_tree_end(vdb_tree *tree)
{
    for (int level = VDB_LEAF; level < VDB_NODE_LEVELS; ++level) {
        svo_i_free(tree->nodes[level]);
        svo_i_free(tree->values[level]);
    }
    *tree = (vdb_tree){.type = tree->type};
}

static svo_status add_node(const vdb_input *in, vdb_tree *tree, int level, vdb_node node)
{
    if (tree->counts[level] == tree->capacities[level]) {
        const uint64_t capacity = 2 * tree->capacities[level] + 16;
        vdb_node *grown = svo_i_grow(&in->reader->memory, tree->nodes[level], (size_t)capacity * sizeof *grown);
        if (grown == NULL) {
            return svo_i_voxels_fail(in->reader, SVO_OUT_OF_HOST_MEMORY, "grid \"%s\": no memory for %" PRIu64 " nodes",
                                     in->grid, capacity);
        }
        tree->nodes[level] = grown;
        tree->capacities[level] = capacity;
    }
    tree->nodes[level][tree->counts[level]++] = node;
    return SVO_OK;
}

/* Fails where so many things that take so many bytes at least cannot follow. */
static svo_status check_room(const vdb_input *in, uint64_t count, uint64_t bytes, const char *what)
{
    return count <= (in->end - in->at) / bytes ? SVO_OK : svo_i_vdb_damaged(in, what, in->at);
}

/* Reads the masks of a node, what values it has besides its children, and those. */
static svo_status read_node(vdb_input *in, vdb_tree *tree, int level, const int32_t at[3])
{
    const uint32_t slots = vdb_slots(level);
    const uint8_t *children = NULL;
    vdb_node node = {.at = {at[0], at[1], at[2]}, .masks = in->at};
    packed_values p;
    SVO_I_TRY(
        svo_i_vdb_take(in, (level == VDB_LEAF ? 1 : 2) * (size_t)slots / 8, "the masks of a node are", &children));
    node.values = in->at;
    SVO_I_TRY(add_node(in, tree, level, node));
    if (level == VDB_LEAF) {
        return SVO_OK;
    }
    for (uint32_t i = 0; i < slots / 8; ++i) {
        if ((children[i] & children[slots / 8 + i]) != 0) {
            return svo_i_vdb_damaged(in, "a child of a node is a value too", node.masks + i);
        }
    }
    SVO_I_TRY(take_values(in, tree, children + slots / 8, slots, &p));
    SVO_I_TRY(check_room(in, count_bits(children, slots), level == VDB_LOWER ? VDB_LEAF_BYTES : 1024,
                         "a node has more children than can follow"));
    for (uint32_t i = 0; i < slots; ++i) {
        if (vdb_has_bit(children, i)) {
            int32_t corner[3];
            vdb_corner_of(level, at, i, corner);
            SVO_I_TRY(read_node(in, tree, level - 1, corner));
        }
    }
    return SVO_OK;
}

/* The order of nodes and tiles: by those of the levels above, and in these by x, y, z. */
static int compare_places(int level, const int32_t a[3], const int32_t b[3])
{
    for (int above = VDB_UPPER; above >= level; --above) {
        const uint32_t shift = vdb_voxels_log2(above);
        for (int axis = 0; axis < 3; ++axis) {
            const int32_t one = a[axis] >> shift;
            const int32_t other = b[axis] >> shift;
            if (one != other) {
                return one < other ? -1 : 1;
            }
        }
    }
    return 0;
}

const vdb_node *svo_i_vdb_find(const vdb_tree *tree, int level, const int32_t at[3])
{
    uint64_t begin = 0;
    uint64_t end = tree->counts[level];
    while (begin < end) {
        const uint64_t middle = begin + (end - begin) / 2;
        const int order = compare_places(level, tree->nodes[level][middle].at, at);
        if (order == 0) {
            return &tree->nodes[level][middle];
        }
        if (order < 0) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    return NULL;
}

const uint8_t *svo_i_vdb_find_tile(const vdb_input *in, const vdb_tree *tree, const int32_t at[3])
{
    const size_t tile_bytes = PLACE_BYTES + (size_t)tree->type->value_bytes + 1;
    uint32_t begin = 0;
    uint32_t end = tree->tile_count;
    while (begin < end) {
        const uint32_t middle = begin + (end - begin) / 2;
        const uint8_t *tile = in->reader->bytes + tree->tiles + middle * tile_bytes;
        int32_t place[3];
        memcpy(place, tile, sizeof place);
        const int order = compare_places(VDB_UPPER, place, at);
        if (order == 0) {
            return tile;
        }
        if (order < 0) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    return NULL;
}

/* Reads the place of the next tile or child of the root: at planes between nodes, and in order. */
static svo_status take_place(vdb_input *in, bool is_first, int32_t place[3])
{
    const int32_t before[3] = {place[0], place[1], place[2]};
    const uint8_t *from = NULL;
    SVO_I_TRY(svo_i_vdb_take(in, PLACE_BYTES, "the root's table is", &from));
    memcpy(place, from, PLACE_BYTES);
    if (((place[0] | place[1] | place[2]) & ((1 << VDB_NODE_LOG2) - 1)) != 0) {
        return svo_i_vdb_damaged(in, "a place in the root's table is no multiple of 4096", in->at - PLACE_BYTES);
    }
    return is_first || compare_places(VDB_UPPER, before, place) < 0
               ? SVO_OK
               : svo_i_vdb_damaged(in, "the root's table is not in order", in->at - PLACE_BYTES);
}

static svo_status read_root(vdb_input *in, vdb_tree *tree)
{
    const uint8_t *from = NULL;
    int32_t place[3] = {0, 0, 0};
    const size_t value_bytes = tree->type->value_bytes;
    SVO_I_TRY(svo_i_vdb_take(in, value_bytes, "the root is", &from));
    memcpy(tree->background, from, value_bytes);
    SVO_I_TRY(svo_i_vdb_take(in, 8, "the root is", &from));
    const uint32_t tile_count = get_u32(from);
    const uint32_t child_count = get_u32(from + 4);
    SVO_I_TRY(check_room(in, tile_count, PLACE_BYTES + value_bytes + 1, "the root has more tiles than can follow"));
    tree->tiles = in->at;
    for (uint32_t i = 0; i < tile_count; ++i) {
        SVO_I_TRY(take_place(in, i == 0, place));
        SVO_I_TRY(svo_i_vdb_take(in, value_bytes + 1, "the root's table is", &from));
    }
    tree->tile_count = tile_count;
    SVO_I_TRY(
        check_room(in, child_count, PLACE_BYTES + 2 * VDB_UPPER_BYTES, "the root has more children than can follow"));
    for (uint32_t i = 0; i < child_count; ++i) {
        const size_t begin = in->at;
        SVO_I_TRY(take_place(in, i == 0, place));
        if (svo_i_vdb_find_tile(in, tree, place) != NULL) {
            return svo_i_vdb_damaged(in, "a child of the root is a tile too", begin);
        }
        SVO_I_TRY(read_node(in, tree, VDB_UPPER, place));
    }
    return SVO_OK;
}

svo_status svo_i_vdb_read_topology(vdb_input *in, vdb_tree *tree)
{
    const uint8_t *from = NULL;
    if ((tree->compression & ~KNOWN_FLAGS) != 0) {
        return svo_i_voxels_fail(in->reader, SVO_UNSUPPORTED, "grid \"%s\": compression %" PRIu32 " is not read",
                                 in->grid, tree->compression);
    }
#ifndef SVOCL_BLOSC
    if ((tree->compression & VDB_BLOSC) != 0) {
        return svo_i_voxels_fail(in->reader, SVO_UNSUPPORTED,
                                 "grid \"%s\" is compressed by BLOSC, which needs libblosc; svocl was built without it",
                                 in->grid);
    }
#endif
    SVO_I_TRY(svo_i_vdb_take(in, sizeof(uint32_t), "the tree is", &from));
    if (get_u32(from) != 1) {
        return svo_i_vdb_damaged(in, "the number of buffers is not 1", in->at - sizeof(uint32_t));
    }
    return read_root(in, tree);
}

/* Goes over what a leaf has of values. */
static svo_status read_leaf(vdb_input *in, const vdb_tree *tree, vdb_node *leaf)
{
    const uint8_t *from = NULL;
    packed_values p;
    SVO_I_TRY(svo_i_vdb_take(in, VDB_LEAF_BYTES, "the mask of a leaf is", &from));
    const uint8_t *mask = in->reader->bytes + leaf->masks;
    if (memcmp(from, mask, VDB_LEAF_BYTES) != 0) {
        return svo_i_vdb_damaged(in, "a leaf's two masks differ", in->at - VDB_LEAF_BYTES);
    }
    leaf->values = in->at;
    if (tree->type->kind != VDB_BOOL && tree->type->kind != VDB_MASK) {
        return take_values(in, tree, mask, VDB_LEAF_VALUES, &p);
    }
    SVO_I_TRY(svo_i_vdb_take(in, PLACE_BYTES, "the place of a leaf is", &from));
    if (memcmp(from, leaf->at, PLACE_BYTES) != 0) {
        return svo_i_vdb_damaged(in, "a leaf has another place than its parent says", leaf->values);
    }
    return tree->type->kind == VDB_BOOL ? svo_i_vdb_take(in, VDB_LEAF_BYTES, "values are", &from) : SVO_OK;
}

svo_status svo_i_vdb_read_buffers(vdb_input *in, vdb_tree *tree)
{
    for (uint64_t i = 0; i < tree->counts[VDB_LEAF]; ++i) {
        SVO_I_TRY(read_leaf(in, tree, &tree->nodes[VDB_LEAF][i]));
    }
    return SVO_OK;
}
