/* SPDX-License-Identifier: MIT */
/*
 * The .nvdb writer: a grid "density", a fog volume of 4 bits a voxel that is 1 where a voxel is, and, where there are
 * any, grids "color" (RGBA8) and "material" of the same voxels. Distances are a grid "surface", a level set of floats:
 * what is not in the band has the greatest distance of it, negative inside. A grid is made in memory: its headers need
 * what comes last. All bytes between fields are 0, so that equal voxels make equal files.
 */
#include <inttypes.h>

#include "io/voxels_files.h"
#include "io/voxels_formats.h"
#include "io/voxels_nvdb_file.h"

#define GRIDS_MAX  3
#define EXTENT_MAX (SVO_VOXELS_EXTENT_MAX - (1 << VDB_NODE_LOG2))
#define BOX_FLAG   2u /* of a node: its box of voxels is there */

/* What a grid holds. */
typedef struct grid_kind {
    const char *name;
    uint32_t type, class;
} grid_kind;

static const grid_kind density = {VDB_DENSITY, PNANOVDB_GRID_TYPE_FP4, PNANOVDB_GRID_CLASS_FOG_VOLUME};
static const grid_kind color = {VDB_COLOR, PNANOVDB_GRID_TYPE_RGBA8, PNANOVDB_GRID_CLASS_VOXEL_VOLUME};
static const grid_kind material = {VDB_MATERIAL, PNANOVDB_GRID_TYPE_UINT32, PNANOVDB_GRID_CLASS_VOXEL_VOLUME};

static const grid_kind surface = {VDB_SURFACE, PNANOVDB_GRID_TYPE_FLOAT, PNANOVDB_GRID_CLASS_LEVEL_SET};

/* The voxels of all grids, node by node. */
typedef struct shape {
    const voxel_writer *writer;
    svo_voxel *voxels; /* in Morton order from a corner of a node below the root; owned */
    uint64_t voxel_count;
    uint32_t counts[VDB_NODE_LEVELS]; /* nodes of each level */
} shape;

/* A grid that is being made. */
typedef struct grid {
    const shape *of;
    const grid_kind *kind;
    nvdb_parts parts;
    uint8_t *bytes; /* owned */
    uint64_t byte_count;
    uint64_t at[VDB_NODE_LEVELS]; /* where the node begins that is being filled */
    int32_t boxes[VDB_ROOT + 1][2][3]; /* least and greatest coordinates in it, and of all voxels */
} grid;

/* ---- fields ---- */

static void put(grid *g, uint64_t at, const void *value, size_t bytes)
{
    memcpy(g->bytes + at, value, bytes);
}

static void put_u32(grid *g, uint64_t at, uint32_t value)
{
    put(g, at, &value, sizeof value);
}

static void put_u64(grid *g, uint64_t at, uint64_t value)
{
    put(g, at, &value, sizeof value);
}

static void put_f64(grid *g, uint64_t at, double value)
{
    put(g, at, &value, sizeof value);
}

static void set_bit(grid *g, uint64_t mask, uint32_t bit)
{
    g->bytes[mask + (bit >> 3)] |= (uint8_t)(1u << (bit & 7u));
}

/* ---- the shape ---- */

/* Whether two voxels lie in one node. */
static bool share_node(const svo_voxel *a, const svo_voxel *b, int level)
{
    const uint32_t shift = vdb_voxels_log2(level);
    return a->x >> shift == b->x >> shift && a->y >> shift == b->y >> shift && a->z >> shift == b->z >> shift;
}

/* Sorts the voxels by nodes and counts those. */
static svo_status make_shape(const voxel_writer *writer, shape *made)
{
    const size_t count = (size_t)writer->list.voxel_count;
    int32_t low[3];
    *made = (shape){.writer = writer, .voxel_count = count};
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = writer->list.low[axis] & ~((1 << VDB_NODE_LOG2) - 1);
        const int64_t extent = (int64_t)writer->list.high[axis] - writer->list.low[axis];
        if (extent > EXTENT_MAX) {
            return svo_i_voxels_write_fail(writer, SVO_INVALID_ARGUMENT,
                                           "%" PRId64 " voxels along an axis are above the limit of .nvdb files, %d",
                                           extent, EXTENT_MAX);
        }
    }
    SVO_I_TRY(svo_i_voxels_sorted(writer, low, SVO_I_VOXEL_MORTON, &made->voxels));
    for (size_t i = 0; i < count; ++i) {
        for (int level = VDB_LEAF; level < VDB_NODE_LEVELS; ++level) {
            made->counts[level] += i == 0 || !share_node(&made->voxels[i - 1], &made->voxels[i], level) ? 1u : 0u;
        }
    }
    return SVO_OK;
}

/* ---- the tree of a grid ---- */

static void grow(int32_t box[2][3], const int32_t at[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        box[0][axis] = at[axis] < box[0][axis] ? at[axis] : box[0][axis];
        box[1][axis] = at[axis] > box[1][axis] ? at[axis] : box[1][axis];
    }
}

/* Writes the box of the node that was filled. */
static void end_node(grid *g, int level)
{
    int32_t(*box)[3] = g->boxes[level];
    put(g, g->at[level], box[0], sizeof box[0]);
    if (level == VDB_LEAF) {
        const uint8_t wide[4] = {(uint8_t)(box[1][0] - box[0][0]), (uint8_t)(box[1][1] - box[0][1]),
                                 (uint8_t)(box[1][2] - box[0][2]), BOX_FLAG};
        put(g, g->at[level] + PNANOVDB_LEAF_OFF_BBOX_DIF_AND_FLAGS, wide, sizeof wide);
        return;
    }
    put(g, g->at[level] + PNANOVDB_LOWER_OFF_BBOX_MAX, box[1], sizeof box[1]);
    put_u64(g, g->at[level] + PNANOVDB_LOWER_OFF_FLAGS, BOX_FLAG);
}

/* The least, greatest and mean value and the deviation of a node's voxels, which all have density 1. */
static void put_statistics(grid *g, uint64_t at, uint32_t least, uint32_t greatest, uint32_t mean)
{
    const float one = 1.0f;
    if (g->kind == &density) {
        put(g, at + least, &one, sizeof one);
        put(g, at + greatest, &one, sizeof one);
        put(g, at + mean, &one, sizeof one);
    }
}

/* Begins a node below the one above it, which for upper nodes is the root, and there the tile of that number. */
static void begin_node(grid *g, int level, const int32_t at[3], uint32_t tile)
{
    const pnanovdb_grid_type_constants_t *p = g->parts.places;
    const uint64_t node = g->at[level];
    if (level == VDB_UPPER) {
        const uint64_t entry = g->parts.root + p->root_size + (uint64_t)tile * p->root_tile_size;
        put_u64(g, entry + PNANOVDB_ROOT_TILE_OFF_KEY, nvdb_key_of(at));
        put_u64(g, entry + PNANOVDB_ROOT_TILE_OFF_CHILD, node - g->parts.root);
        put_statistics(g, node, p->upper_off_min, p->upper_off_max, p->upper_off_ave);
    } else {
        const uint64_t above = g->at[level + 1];
        const uint32_t child = vdb_child_of(level + 1, at);
        set_bit(g, above + nvdb_child_mask(level + 1), child);
        put_u64(g, above + nvdb_table(p, level + 1) + (uint64_t)p->table_stride * child, node - above);
    }
    if (level == VDB_LOWER) {
        put_statistics(g, node, p->lower_off_min, p->lower_off_max, p->lower_off_ave);
    } else if (level == VDB_LEAF && g->kind == &density) {
        /* Codes 0 and 1 stand for 0 and 1: the value is a code times this; the least, greatest and mean code are 1. */
        const float quantum = 1.0f;
        const uint16_t code = 1;
        put(g, node + p->leaf_off_table - PNANOVDB_LEAF_TABLE_NEG_OFF_QUANTUM, &quantum, sizeof quantum);
        put(g, node + p->leaf_off_min, &code, sizeof code);
        put(g, node + p->leaf_off_max, &code, sizeof code);
        put(g, node + p->leaf_off_ave, &code, sizeof code);
    }
    memcpy(g->boxes[level][0], at, sizeof g->boxes[level][0]);
    memcpy(g->boxes[level][1], at, sizeof g->boxes[level][1]);
}

static void put_value(grid *g, const svo_voxel *voxel, uint32_t place)
{
    const uint64_t table = g->at[VDB_LEAF] + g->parts.places->leaf_off_table;
    set_bit(g, g->at[VDB_LEAF] + PNANOVDB_LEAF_OFF_VALUE_MASK, place);
    if (g->kind == &density) {
        g->bytes[table + (place >> 1)] |= (uint8_t)(1u << 4 * (place & 1u));
    } else if (g->kind == &color || g->kind == &surface) {
        put(g, table + 4u * (uint64_t)place, voxel->rgba, sizeof voxel->rgba);
    } else {
        put_u32(g, table + 4u * (uint64_t)place, voxel->material);
    }
}

/* Fills the nodes and the root's tiles, in the voxels' order. */
static void fill_nodes(grid *g)
{
    const shape *of = g->of;
    uint32_t begun[VDB_NODE_LEVELS] = {0, 0, 0};
    for (uint64_t i = 0; i < of->voxel_count; ++i) {
        const svo_voxel *voxel = &of->voxels[i];
        const int32_t at[3] = {voxel->x, voxel->y, voxel->z};
        for (int level = VDB_UPPER; level >= VDB_LEAF; --level) {
            if (i == 0 || !share_node(&of->voxels[i - 1], voxel, level)) {
                if (i > 0) {
                    end_node(g, level);
                }
                g->at[level] = g->parts.nodes[level] + (uint64_t)begun[level] * nvdb_node_bytes(g->parts.places, level);
                begin_node(g, level, at, begun[VDB_UPPER]);
                ++begun[level];
            }
            grow(g->boxes[level], at);
        }
        if (i == 0) {
            memcpy(g->boxes[VDB_ROOT], g->boxes[VDB_UPPER], sizeof g->boxes[VDB_ROOT]);
        }
        grow(g->boxes[VDB_ROOT], at);
        put_value(g, voxel, vdb_child_of(VDB_LEAF, at));
    }
    for (int level = VDB_LEAF; level < VDB_NODE_LEVELS && of->voxel_count > 0; ++level) {
        end_node(g, level);
    }
}

/* Sorts the root's tiles by key, as those that search them want it; there are few. */
static void sort_tiles(grid *g)
{
    const size_t bytes = g->parts.places->root_tile_size;
    uint8_t *tiles = g->bytes + g->parts.root + g->parts.places->root_size;
    uint8_t held[64];
    for (uint32_t i = 1; i < g->of->counts[VDB_UPPER]; ++i) {
        uint64_t key = 0;
        uint64_t before = 0;
        uint32_t place = i;
        memcpy(held, tiles + i * bytes, bytes);
        memcpy(&key, held, sizeof key);
        for (; place > 0; --place) {
            memcpy(&before, tiles + (place - 1) * bytes, sizeof before);
            if (before < key) {
                break;
            }
            memcpy(tiles + place * bytes, tiles + (place - 1) * bytes, bytes);
        }
        memcpy(tiles + place * bytes, held, bytes);
    }
}

/*
 * ---- what is not in the band ----
 *
 * Signs of voxels and of parts of nodes without voxels: that of the voxel before them in their row, of the row before
 * in its plane, or of the plane before, which is the flood fill of OpenVDB's level sets.
 */

static float get_float(const grid *g, uint64_t at)
{
    float value = 0.0f;
    memcpy(&value, g->bytes + at, sizeof value);
    return value;
}

static bool has_bit(const grid *g, uint64_t mask, uint32_t bit)
{
    return (g->bytes[mask + (bit >> 3)] >> (bit & 7u) & 1u) != 0;
}

/* The value of the first or the last voxel of a node. */
static float end_value(const grid *g, uint64_t node, int level, bool last)
{
    const pnanovdb_grid_type_constants_t *p = g->parts.places;
    for (; level > VDB_LEAF; --level) {
        const uint32_t entry = last ? (1u << 3 * vdb_children_log2(level)) - 1 : 0;
        const uint64_t place = node + nvdb_table(p, level) + (uint64_t)p->table_stride * entry;
        int64_t child = 0;
        if (!has_bit(g, node + nvdb_child_mask(level), entry)) {
            return get_float(g, place);
        }
        memcpy(&child, g->bytes + place, sizeof child);
        node += (uint64_t)child;
    }
    return get_float(g, node + p->leaf_off_table + (last ? 4u * 511u : 0u));
}

/* Whether an entry of a node has a sign of its own; then *inside is that of its first or its last voxel. */
static bool has_sign(const grid *g, uint64_t node, int level, uint32_t entry, bool last, bool *inside)
{
    const pnanovdb_grid_type_constants_t *p = g->parts.places;
    const uint64_t mask = node + (level == VDB_LEAF ? PNANOVDB_LEAF_OFF_VALUE_MASK : nvdb_child_mask(level));
    if (!has_bit(g, mask, entry)) {
        return false;
    }
    if (level == VDB_LEAF) {
        *inside = get_float(g, node + p->leaf_off_table + 4 * (uint64_t)entry) < 0.0f;
        return true;
    }
    int64_t child = 0;
    memcpy(&child, g->bytes + node + nvdb_table(p, level) + (uint64_t)p->table_stride * entry, sizeof child);
    *inside = end_value(g, node + (uint64_t)child, level - 1, last) < 0.0f;
    return true;
}

/* Fills the entries of a node that have no sign of their own. */
static void fill_node(grid *g, uint64_t node, int level)
{
    const pnanovdb_grid_type_constants_t *p = g->parts.places;
    const uint32_t bits = vdb_children_log2(level);
    const uint32_t count = 1u << 3 * bits;
    const uint32_t along = (1u << bits) - 1;
    const uint64_t table = node + (level == VDB_LEAF ? p->leaf_off_table : nvdb_table(p, level));
    const uint64_t stride = level == VDB_LEAF ? sizeof(float) : p->table_stride;
    bool of_plane = false;
    for (uint32_t entry = 0; entry < count && !has_sign(g, node, level, entry, false, &of_plane); ++entry) {
    }
    bool of_row = of_plane;
    bool inside = of_plane;
    for (uint32_t entry = 0; entry < count; ++entry) {
        const bool begins_row = (entry & along) == 0;
        const bool begins_plane = begins_row && (entry >> bits & along) == 0;
        inside = begins_plane ? of_plane : begins_row ? of_row : inside;
        if (!has_sign(g, node, level, entry, true, &inside)) {
            const float value = inside ? -g->of->writer->background : g->of->writer->background;
            put(g, table + stride * entry, &value, sizeof value);
        }
        of_row = begins_row ? inside : of_row;
        of_plane = begins_plane ? inside : of_plane;
    }
}

static void fill_background(grid *g)
{
    for (int level = VDB_LEAF; level < VDB_NODE_LEVELS; ++level) {
        for (uint32_t i = 0; i < g->parts.counts[level]; ++i) {
            fill_node(g, g->parts.nodes[level] + (uint64_t)i * nvdb_node_bytes(g->parts.places, level), level);
        }
    }
    put(g, g->parts.root + g->parts.places->root_off_background, &g->of->writer->background, sizeof(float));
}

/* ---- the headers of a grid ---- */

/* The world position of the center of a voxel is voxel_edge times its coordinates, plus this. */
static double center_of(const voxel_writer *writer, int axis)
{
    return svo_i_voxels_world(writer, axis, 0.5);
}

static void put_map(grid *g)
{
    const voxel_writer *writer = g->of->writer;
    const double edge = writer->list.voxel_edge;
    const float edge_float = (float)edge;
    const float inverse_float = (float)(1.0 / edge);
    const float one = 1.0f;
    const uint64_t map = PNANOVDB_GRID_OFF_MAP;
    for (uint64_t axis = 0; axis < 3; ++axis) {
        const float center_float = (float)center_of(writer, (int)axis);
        put(g, map + PNANOVDB_MAP_OFF_MATF + 16 * axis, &edge_float, sizeof edge_float);
        put(g, map + PNANOVDB_MAP_OFF_INVMATF + 16 * axis, &inverse_float, sizeof inverse_float);
        put(g, map + PNANOVDB_MAP_OFF_VECF + 4 * axis, &center_float, sizeof center_float);
        put_f64(g, map + PNANOVDB_MAP_OFF_MATD + 32 * axis, edge);
        put_f64(g, map + PNANOVDB_MAP_OFF_INVMATD + 32 * axis, 1.0 / edge);
        put_f64(g, map + PNANOVDB_MAP_OFF_VECD + 8 * axis, center_of(writer, (int)axis));
        put_f64(g, PNANOVDB_GRID_OFF_VOXEL_SIZE + 8 * axis, edge);
    }
    put(g, map + PNANOVDB_MAP_OFF_TAPERF, &one, sizeof one);
    put_f64(g, map + PNANOVDB_MAP_OFF_TAPERD, 1.0);
}

static void put_headers(grid *g)
{
    const uint64_t tree = PNANOVDB_GRID_SIZE;
    const pnanovdb_grid_type_constants_t *p = g->parts.places;
    put(g, PNANOVDB_GRID_OFF_MAGIC, NVDB_MAGIC "0", 8);
    put_u32(g, PNANOVDB_GRID_OFF_VERSION, svo_i_nvdb_version());
    put_u32(g, PNANOVDB_GRID_OFF_FLAGS,
            PNANOVDB_GRID_FLAGS_HAS_BBOX | PNANOVDB_GRID_FLAGS_IS_BREADTH_FIRST |
                (g->kind == &density ? PNANOVDB_GRID_FLAGS_HAS_MIN_MAX | PNANOVDB_GRID_FLAGS_HAS_AVERAGE |
                                           PNANOVDB_GRID_FLAGS_HAS_STD_DEVIATION
                                     : 0));
    put_u32(g, PNANOVDB_GRID_OFF_GRID_COUNT, 1);
    put_u64(g, PNANOVDB_GRID_OFF_GRID_SIZE, g->byte_count);
    put(g, PNANOVDB_GRID_OFF_GRID_NAME, g->kind->name, strlen(g->kind->name));
    put_map(g);
    for (uint64_t axis = 0; axis < 3 && g->of->voxel_count > 0; ++axis) {
        for (uint64_t side = 0; side < 2; ++side) {
            const double place = (double)g->boxes[VDB_ROOT][side][axis] + (double)side + 0.5;
            put_f64(g, PNANOVDB_GRID_OFF_WORLD_BBOX + 24 * side + 8 * axis,
                    svo_i_voxels_world(g->of->writer, (int)axis, place));
        }
    }
    put_u32(g, PNANOVDB_GRID_OFF_GRID_CLASS, g->kind->class);
    put_u32(g, PNANOVDB_GRID_OFF_GRID_TYPE, g->kind->type);
    for (uint64_t level = 0; level < VDB_NODE_LEVELS; ++level) {
        put_u64(g, tree + 8 * level, g->of->counts[level] > 0 ? g->parts.nodes[level] - tree : 0);
        put_u32(g, tree + PNANOVDB_TREE_OFF_NODE_COUNT_LEAF + 4 * level, g->of->counts[level]);
    }
    put_u64(g, tree + PNANOVDB_TREE_OFF_NODE_OFFSET_ROOT, g->parts.root - tree);
    put_u64(g, tree + PNANOVDB_TREE_OFF_VOXEL_COUNT, g->of->voxel_count);
    put(g, g->parts.root + PNANOVDB_ROOT_OFF_BBOX_MIN, g->boxes[VDB_ROOT], sizeof g->boxes[VDB_ROOT]);
    put_u32(g, g->parts.root + PNANOVDB_ROOT_OFF_TABLE_SIZE, g->of->counts[VDB_UPPER]);
    put_statistics(g, g->parts.root, p->root_off_min, p->root_off_max, p->root_off_ave);
}

/* Makes a grid of the voxels. */
static svo_status make_grid(const shape *of, const grid_kind *kind, grid *made)
{
    const pnanovdb_grid_type_constants_t *p = &pnanovdb_grid_type_constants[kind->type];
    nvdb_parts *parts = &made->parts;
    uint32_t sums[2];
    *made = (grid){.of = of, .kind = kind};
    parts->places = p;
    parts->root = PNANOVDB_GRID_SIZE + PNANOVDB_TREE_SIZE;
    parts->root_end = parts->root + p->root_size + (uint64_t)of->counts[VDB_UPPER] * p->root_tile_size;
    made->byte_count = parts->root_end;
    for (int level = VDB_UPPER; level >= VDB_LEAF; --level) {
        parts->counts[level] = of->counts[level];
        parts->nodes[level] = made->byte_count;
        made->byte_count += (uint64_t)of->counts[level] * nvdb_node_bytes(p, level);
    }
    made->bytes = svo_i_alloc_zeroed(of->writer->memory, (size_t)made->byte_count, 1);
    if (made->bytes == NULL) {
        return svo_i_voxels_write_fail(of->writer, SVO_OUT_OF_HOST_MEMORY, "no memory for the grid \"%s\" of %s",
                                       kind->name, svo_i_bytes(made->byte_count).text);
    }
    if (of->voxel_count == 0) { /* an empty box ends before it begins */
        for (int axis = 0; axis < 3; ++axis) {
            made->boxes[VDB_ROOT][0][axis] = INT32_MAX;
            made->boxes[VDB_ROOT][1][axis] = INT32_MIN;
        }
    }
    fill_nodes(made);
    if (kind == &surface) {
        fill_background(made);
    }
    sort_tiles(made);
    put_headers(made);
    svo_i_nvdb_sums(made->bytes, parts, sums);
    put(made, PNANOVDB_GRID_OFF_CHECKSUM, sums, sizeof sums);
    return SVO_OK;
}

/* ---- the file ---- */

/* A number for a name, by which readers find a grid. */
static uint64_t hash_name(const char *name)
{
    uint64_t hash = 0;
    for (; *name != '\0'; ++name) {
        const uint64_t overflow = hash >> 56;
        hash = hash * 67 + (uint64_t)(unsigned char)*name + overflow;
    }
    return hash;
}

static svo_status put_record(voxel_writer *writer, const grid *g)
{
    uint8_t record[NVDB_RECORD_BYTES] = {0};
    const uint64_t hash = hash_name(g->kind->name);
    const uint32_t name_bytes = (uint32_t)strlen(g->kind->name) + 1;
    const uint32_t version = svo_i_nvdb_version();
    const uint32_t root_count = 1;
    memcpy(record + NVDB_RECORD_GRID_BYTES, &g->byte_count, 8);
    memcpy(record + NVDB_RECORD_FILE_BYTES, &g->byte_count, 8);
    memcpy(record + NVDB_RECORD_NAME_HASH, &hash, 8);
    memcpy(record + NVDB_RECORD_VOXELS, &g->of->voxel_count, 8);
    memcpy(record + NVDB_RECORD_TYPE, &g->kind->type, 4);
    memcpy(record + NVDB_RECORD_CLASS, &g->kind->class, 4);
    memcpy(record + NVDB_RECORD_WORLD_BOX, g->bytes + PNANOVDB_GRID_OFF_WORLD_BBOX, 48);
    memcpy(record + NVDB_RECORD_BOX, g->bytes + g->parts.root + PNANOVDB_ROOT_OFF_BBOX_MIN, 24);
    memcpy(record + NVDB_RECORD_VOXEL_SIZE, g->bytes + PNANOVDB_GRID_OFF_VOXEL_SIZE, 24);
    memcpy(record + NVDB_RECORD_NAME_BYTES, &name_bytes, 4);
    memcpy(record + NVDB_RECORD_NODE_COUNTS, g->of->counts, sizeof g->of->counts);
    memcpy(record + NVDB_RECORD_NODE_COUNTS + sizeof g->of->counts, &root_count, sizeof root_count);
    memcpy(record + NVDB_RECORD_VERSION, &version, 4);
    SVO_I_TRY(svo_i_voxels_put(writer, record, sizeof record));
    return svo_i_voxels_put(writer, g->kind->name, name_bytes);
}

static svo_status put_file(voxel_writer *writer, const grid *grids, uint16_t grid_count)
{
    uint8_t header[NVDB_HEADER_BYTES] = NVDB_MAGIC "0";
    const uint32_t version = svo_i_nvdb_version();
    memcpy(header + NVDB_HEADER_VERSION, &version, sizeof version);
    memcpy(header + NVDB_HEADER_GRID_COUNT, &grid_count, sizeof grid_count);
    SVO_I_TRY(svo_i_voxels_put(writer, header, sizeof header));
    for (uint16_t i = 0; i < grid_count; ++i) {
        SVO_I_TRY(put_record(writer, &grids[i]));
    }
    for (uint16_t i = 0; i < grid_count; ++i) {
        SVO_I_TRY(svo_i_voxels_put(writer, grids[i].bytes, (size_t)grids[i].byte_count));
    }
    return SVO_OK;
}

svo_status svo_i_voxels_write_nvdb(voxel_writer *writer)
{
    shape of = {.voxels = NULL};
    grid grids[GRIDS_MAX] = {{.bytes = NULL}};
    uint16_t grid_count = 1;
    bool has_colors = false;
    bool has_materials = false;
    svo_status status = SVO_OK;
    const bool is_surface = writer->background > 0.0f;
    for (uint64_t i = 0; i < writer->list.voxel_count && !is_surface; ++i) {
        static const uint8_t white[4] = {255, 255, 255, 255};
        has_colors = has_colors || memcmp(writer->voxels[i].rgba, white, sizeof white) != 0;
        has_materials = has_materials || writer->voxels[i].material != 0;
    }
    SVO_I_TRY_CLEANUP(make_shape(writer, &of));
    SVO_I_TRY_CLEANUP(make_grid(&of, is_surface ? &surface : &density, &grids[0]));
    if (has_colors) {
        SVO_I_TRY_CLEANUP(make_grid(&of, &color, &grids[grid_count++]));
    }
    if (has_materials) {
        SVO_I_TRY_CLEANUP(make_grid(&of, &material, &grids[grid_count++]));
    }
    SVO_I_TRY_CLEANUP(put_file(writer, grids, grid_count));
cleanup:
    for (int i = 0; i < GRIDS_MAX; ++i) {
        svo_i_free(grids[i].bytes);
    }
    svo_i_free(of.voxels);
    return status;
}
