/* SPDX-License-Identifier: MIT */
/*
 * The .nvdb reader. The voxels of a level set are those inside, with a negative value; of every other grid they are the
 * active ones, tiles among them. Nothing in a grid is trusted: every offset must lead to a node of the next level, and
 * to each once.
 */
#include <inttypes.h>
#include <math.h>

#include "io/srgb.h"
#include "io/voxels_files.h"
#include "io/voxels_formats.h"
#include "io/voxels_nvdb_file.h"

#define NAME_BYTES (PNANOVDB_GRID_OFF_MAP - PNANOVDB_GRID_OFF_GRID_NAME)

/* ---- a grid of the file ---- */

typedef struct nvdb_grid {
    const uint8_t *bytes; /* in the file; NULL: there is none */
    uint64_t byte_count;
    size_t begin; /* in the file */
    char name[NAME_BYTES];
    uint32_t type, class;
    nvdb_parts parts;
    uint32_t seen[VDB_NODE_LEVELS]; /* nodes that the way through the tree has met */
} nvdb_grid;

static uint32_t get_u32(const uint8_t *bytes, uint64_t at)
{
    uint32_t value = 0;
    memcpy(&value, bytes + at, sizeof value);
    return value;
}

static uint64_t get_u64(const uint8_t *bytes, uint64_t at)
{
    uint64_t value = 0;
    memcpy(&value, bytes + at, sizeof value);
    return value;
}

static float get_f32(const uint8_t *bytes, uint64_t at)
{
    float value = 0.0f;
    memcpy(&value, bytes + at, sizeof value);
    return value;
}

static double get_f64(const uint8_t *bytes, uint64_t at)
{
    double value = 0.0;
    memcpy(&value, bytes + at, sizeof value);
    return value;
}

static bool has_bit(const uint8_t *mask, uint32_t bit)
{
    return (mask[bit >> 3] >> (bit & 7u) & 1u) != 0;
}

static svo_status damaged(const voxel_reader *reader, const nvdb_grid *g, const char *what, uint64_t at)
{
    return svo_i_voxels_damaged(reader, "grid \"%s\": %s, at byte %" PRIu64, g->name, what, g->begin + at);
}

/* Whether so many bytes at an offset from the tree's header lie in the grid, behind the headers. */
static bool fits(const nvdb_grid *g, uint64_t offset, uint64_t bytes)
{
    const uint64_t most = g->byte_count - PNANOVDB_GRID_SIZE;
    return offset >= PNANOVDB_TREE_SIZE && offset <= most && bytes <= most - offset;
}

/* Finds root and nodes. */
static svo_status find_parts(const voxel_reader *reader, nvdb_grid *g)
{
    const uint64_t tree = PNANOVDB_GRID_SIZE;
    nvdb_parts *parts = &g->parts;
    const pnanovdb_grid_type_constants_t *p = parts->places = &pnanovdb_grid_type_constants[g->type];
    const uint64_t root = get_u64(g->bytes, tree + PNANOVDB_TREE_OFF_NODE_OFFSET_ROOT);
    if (!fits(g, root, p->root_size)) {
        return damaged(reader, g, "the root lies outside", tree + PNANOVDB_TREE_OFF_NODE_OFFSET_ROOT);
    }
    parts->root = tree + root;
    const uint64_t tile_bytes =
        (uint64_t)get_u32(g->bytes, parts->root + PNANOVDB_ROOT_OFF_TABLE_SIZE) * p->root_tile_size;
    if (!fits(g, root, p->root_size + tile_bytes)) {
        return damaged(reader, g, "the root's table ends outside", parts->root + PNANOVDB_ROOT_OFF_TABLE_SIZE);
    }
    parts->root_end = parts->root + p->root_size + tile_bytes;
    for (int level = VDB_LEAF; level < VDB_NODE_LEVELS; ++level) {
        const uint64_t field = tree + 8 * (uint64_t)level;
        const uint64_t first = get_u64(g->bytes, field);
        parts->counts[level] = get_u32(g->bytes, tree + PNANOVDB_TREE_OFF_NODE_COUNT_LEAF + 4 * (uint64_t)level);
        const uint64_t bytes = (uint64_t)parts->counts[level] * nvdb_node_bytes(p, level);
        if (bytes > 0 && (!fits(g, first, bytes) || tree + first < parts->root_end)) {
            return damaged(reader, g, "nodes lie outside", field);
        }
        parts->nodes[level] = tree + first;
    }
    return SVO_OK;
}

static svo_status check_sums(const voxel_reader *reader, const nvdb_grid *g)
{
    const uint64_t field = PNANOVDB_GRID_OFF_CHECKSUM;
    const uint32_t there[2] = {get_u32(g->bytes, field), get_u32(g->bytes, field + 4)};
    uint32_t sums[2];
    svo_i_nvdb_sums(g->bytes, &g->parts, sums);
    for (int i = 0; i < 2; ++i) {
        if (there[i] != NVDB_NO_SUM && there[i] != sums[i]) {
            return damaged(reader, g,
                           i == 0 ? "the checksum of its headers is wrong"
                                  : "the checksum of its nodes is "
                                    "wrong",
                           field + 4 * (uint64_t)i);
        }
    }
    return SVO_OK;
}

/* Checks the headers of a grid that begins there and has so many bytes of the file. */
static svo_status open_grid(const voxel_reader *reader, size_t begin, uint64_t byte_count, nvdb_grid *g)
{
    *g = (nvdb_grid){.bytes = reader->bytes + begin, .byte_count = byte_count, .begin = begin, .name = "?"};
    if (byte_count < PNANOVDB_GRID_SIZE + PNANOVDB_TREE_SIZE) {
        return damaged(reader, g, "it is shorter than its headers", 0);
    }
    memcpy(g->name, g->bytes + PNANOVDB_GRID_OFF_GRID_NAME, sizeof g->name - 1);
    g->name[strcspn(g->name, "\n\r\t")] = '\0';
    g->type = get_u32(g->bytes, PNANOVDB_GRID_OFF_GRID_TYPE);
    g->class = get_u32(g->bytes, PNANOVDB_GRID_OFF_GRID_CLASS);
    if (memcmp(g->bytes, NVDB_MAGIC, strlen(NVDB_MAGIC)) != 0) {
        return damaged(reader, g, "it does not begin with NanoVDB", 0);
    }
    if (get_u64(g->bytes, PNANOVDB_GRID_OFF_GRID_SIZE) != byte_count) {
        return damaged(reader, g, "its size is not that of its record", PNANOVDB_GRID_OFF_GRID_SIZE);
    }
    if (g->type == PNANOVDB_GRID_TYPE_UNKNOWN || g->type >= PNANOVDB_GRID_TYPE_END ||
        g->type == PNANOVDB_GRID_TYPE_FPN) {
        return svo_i_voxels_fail(reader, SVO_UNSUPPORTED,
                                 "grid \"%s\": values of type %" PRIu32 " are not read, at byte %" PRIu64, g->name,
                                 g->type, (uint64_t)begin + PNANOVDB_GRID_OFF_GRID_TYPE);
    }
    SVO_I_TRY(find_parts(reader, g));
    return check_sums(reader, g);
}

/* ---- values ---- */

/* Whether values are numbers that number_at reads. */
static bool has_numbers(const nvdb_grid *g)
{
    return g->type == PNANOVDB_GRID_TYPE_FLOAT || g->type == PNANOVDB_GRID_TYPE_DOUBLE ||
           g->type == PNANOVDB_GRID_TYPE_FP4 || g->type == PNANOVDB_GRID_TYPE_FP8 || g->type == PNANOVDB_GRID_TYPE_FP16;
}

/* The number of a tile, or of a voxel of a leaf. */
static double number_at(const nvdb_grid *g, uint64_t at)
{
    return g->type == PNANOVDB_GRID_TYPE_DOUBLE ? get_f64(g->bytes, at) : (double)get_f32(g->bytes, at);
}

static double number_of(const nvdb_grid *g, uint64_t leaf, uint32_t place)
{
    const uint64_t table = leaf + g->parts.places->leaf_off_table;
    uint32_t code = 0;
    switch (g->type) {
    case PNANOVDB_GRID_TYPE_DOUBLE:
        return number_at(g, table + 8 * (uint64_t)place);
    case PNANOVDB_GRID_TYPE_FLOAT:
        return number_at(g, table + 4 * (uint64_t)place);
    case PNANOVDB_GRID_TYPE_FP4:
        code = g->bytes[table + (place >> 1)] >> 4 * (place & 1u) & 15u;
        break;
    case PNANOVDB_GRID_TYPE_FP8:
        code = g->bytes[table + place];
        break;
    default:
        code = g->bytes[table + 2 * (uint64_t)place] | (uint32_t)g->bytes[table + 2 * (uint64_t)place + 1] << 8;
    }
    return (double)get_f32(g->bytes, table - PNANOVDB_LEAF_TABLE_NEG_OFF_QUANTUM) * code +
           (double)get_f32(g->bytes, table - PNANOVDB_LEAF_TABLE_NEG_OFF_MINIMUM);
}

/* ---- the way through a tree ---- */

/* What becomes of the voxels that are met. */
typedef struct nvdb_walk {
    voxel_reader *reader;
    nvdb_grid *grid;
    svo_status (*add)(void *user, const int32_t at[3], uint32_t edge); /* a cube of voxels; NULL: the tree is checked */
    void *user;
} nvdb_walk;

static svo_status add_cube(const nvdb_walk *walk, const int32_t at[3], int level)
{
    return walk->add == NULL ? SVO_OK : walk->add(walk->user, at, 1u << vdb_voxels_log2(level));
}

static svo_status walk_leaf(const nvdb_walk *walk, uint64_t leaf, const int32_t at[3])
{
    const nvdb_grid *g = walk->grid;
    const bool by_sign = g->class == PNANOVDB_GRID_CLASS_LEVEL_SET;
    for (uint32_t place = 0; place < 512 && walk->add != NULL; ++place) {
        if (by_sign ? number_of(g, leaf, place) < 0.0
                    : has_bit(g->bytes + leaf + PNANOVDB_LEAF_OFF_VALUE_MASK, place)) {
            const int32_t voxel[3] = {at[0] + (int32_t)(place >> 6), at[1] + (int32_t)(place >> 3 & 7u),
                                      at[2] + (int32_t)(place & 7u)};
            SVO_I_TRY(walk->add(walk->user, voxel, 1));
        }
    }
    return SVO_OK;
}

/* Checks that a node of a level begins there, and counts it. */
static svo_status meet_node(const nvdb_walk *walk, int level, uint64_t node, uint64_t field)
{
    nvdb_grid *g = walk->grid;
    const uint32_t bytes = nvdb_node_bytes(g->parts.places, level);
    const uint64_t offset = node - g->parts.nodes[level];
    if (node < g->parts.nodes[level] || offset % bytes != 0 || offset / bytes >= g->parts.counts[level]) {
        return damaged(walk->reader, g, "an offset leads to no node of the next level", field);
    }
    return ++g->seen[level] <= g->parts.counts[level]
               ? SVO_OK
               : damaged(walk->reader, g, "more offsets lead to nodes than there are nodes", field);
}

/* Goes through a node above the leaves. */
static svo_status walk_node(const nvdb_walk *walk, int level, uint64_t node, const int32_t at[3])
{
    const nvdb_grid *g = walk->grid;
    const uint8_t *values = g->bytes + node + PNANOVDB_LOWER_OFF_VALUE_MASK;
    const uint8_t *children = g->bytes + node + nvdb_child_mask(level);
    const uint32_t bits = vdb_children_log2(level);
    const uint32_t step = vdb_voxels_log2(level - 1);
    const bool by_sign = g->class == PNANOVDB_GRID_CLASS_LEVEL_SET;
    for (uint32_t child = 0; child < 1u << 3 * bits; ++child) {
        const uint64_t entry =
            node + nvdb_table(g->parts.places, level) + (uint64_t)child * g->parts.places->table_stride;
        int32_t corner[3];
        for (uint32_t axis = 0; axis < 3; ++axis) {
            corner[axis] = at[axis] + (int32_t)((child >> (2 - axis) * bits & ((1u << bits) - 1)) << step);
        }
        if (has_bit(children, child)) {
            const uint64_t below = node + get_u64(g->bytes, entry);
            SVO_I_TRY(meet_node(walk, level - 1, below, entry));
            SVO_I_TRY(level == VDB_LOWER ? walk_leaf(walk, below, corner) : walk_node(walk, level - 1, below, corner));
        } else if (by_sign ? number_at(g, entry) < 0.0 : has_bit(values, child)) {
            SVO_I_TRY(add_cube(walk, corner, level - 1));
        }
    }
    return SVO_OK;
}

static uint64_t tile_at(const nvdb_grid *g, uint32_t tile)
{
    return g->parts.root + g->parts.places->root_size + (uint64_t)tile * g->parts.places->root_tile_size;
}

static uint32_t tile_count(const nvdb_grid *g)
{
    return get_u32(g->bytes, g->parts.root + PNANOVDB_ROOT_OFF_TABLE_SIZE);
}

/* Goes through all of a grid's tree. add, user: see nvdb_walk. */
static svo_status walk_grid(voxel_reader *reader, nvdb_grid *g,
                            svo_status (*add)(void *user, const int32_t at[3], uint32_t edge), void *user)
{
    const nvdb_walk walk = {.reader = reader, .grid = g, .add = add, .user = user};
    const bool by_sign = g->class == PNANOVDB_GRID_CLASS_LEVEL_SET;
    if (by_sign && !has_numbers(g)) {
        return damaged(reader, g, "a level set without numbers", PNANOVDB_GRID_OFF_GRID_TYPE);
    }
    memset(g->seen, 0, sizeof g->seen);
    for (uint32_t i = 0; i < tile_count(g); ++i) {
        const uint64_t tile = tile_at(g, i);
        const uint64_t key = get_u64(g->bytes, tile + PNANOVDB_ROOT_TILE_OFF_KEY);
        const uint64_t child = get_u64(g->bytes, tile + PNANOVDB_ROOT_TILE_OFF_CHILD);
        const int32_t at[3] = {(int32_t)((uint32_t)(key >> 42) << 12), (int32_t)((uint32_t)(key >> 21) << 12),
                               (int32_t)((uint32_t)key << 12)};
        if (child != 0) {
            const uint64_t node = g->parts.root + child;
            SVO_I_TRY(meet_node(&walk, VDB_UPPER, node, tile + PNANOVDB_ROOT_TILE_OFF_CHILD));
            SVO_I_TRY(walk_node(&walk, VDB_UPPER, node, at));
        } else if (by_sign ? number_at(g, tile + g->parts.places->root_tile_off_value) < 0.0
                           : get_u32(g->bytes, tile + PNANOVDB_ROOT_TILE_OFF_STATE) != 0) {
            SVO_I_TRY(add_cube(&walk, at, VDB_UPPER));
        }
    }
    return SVO_OK;
}

/* ---- the value of a voxel in another grid ---- */

/* Where the value of a voxel lies in a grid whose tree was checked; 0: it has none. */
static uint64_t find_value(const nvdb_grid *g, const int32_t at[3])
{
    const nvdb_parts *parts = &g->parts;
    const uint64_t key = nvdb_key_of(at);
    uint64_t node = 0;
    for (uint32_t i = 0; i < tile_count(g) && node == 0; ++i) {
        const uint64_t tile = tile_at(g, i);
        if (get_u64(g->bytes, tile + PNANOVDB_ROOT_TILE_OFF_KEY) == key) {
            const uint64_t child = get_u64(g->bytes, tile + PNANOVDB_ROOT_TILE_OFF_CHILD);
            if (child == 0) {
                return tile + parts->places->root_tile_off_value;
            }
            node = parts->root + child;
        }
    }
    for (int level = VDB_UPPER; level > VDB_LEAF && node != 0; --level) {
        const uint32_t child = vdb_child_of(level, at);
        const uint64_t entry = node + nvdb_table(parts->places, level) + (uint64_t)child * parts->places->table_stride;
        if (!has_bit(g->bytes + node + nvdb_child_mask(level), child)) {
            return entry;
        }
        node += get_u64(g->bytes, entry);
    }
    return node == 0 ? 0
                     : node + parts->places->leaf_off_table +
                           (uint64_t)vdb_child_of(VDB_LEAF, at) * parts->places->value_stride_bits / 8;
}

static bool has_colors(const nvdb_grid *g)
{
    return g->type == PNANOVDB_GRID_TYPE_RGBA8 || g->type == PNANOVDB_GRID_TYPE_VEC3F ||
           g->type == PNANOVDB_GRID_TYPE_VEC4F;
}

static bool has_materials(const nvdb_grid *g)
{
    return g->type == PNANOVDB_GRID_TYPE_UINT32 || g->type == PNANOVDB_GRID_TYPE_INT32;
}

static void get_color(const nvdb_grid *g, uint64_t at, uint8_t rgba[4])
{
    if (g->type == PNANOVDB_GRID_TYPE_RGBA8) {
        memcpy(rgba, g->bytes + at, 4);
        return;
    }
    for (uint64_t i = 0; i < 3; ++i) {
        rgba[i] = svo_i_srgb_byte((double)get_f32(g->bytes, at + 4 * i));
    }
    if (g->type == PNANOVDB_GRID_TYPE_VEC4F) {
        const float alpha = get_f32(g->bytes, at + 12);
        rgba[3] = (uint8_t)((alpha > 0.0f ? (alpha < 1.0f ? alpha : 1.0f) : 0.0f) * 255.0f + 0.5f);
    }
}

/* ---- the file ---- */

/* The grids that count; others have no bytes. */
typedef struct nvdb_file {
    voxel_reader *reader;
    nvdb_grid voxels, colors, materials;
} nvdb_file;

static svo_status add_voxel(nvdb_file *file, const int32_t at[3])
{
    svo_voxel voxel = {.x = at[0], .y = at[1], .z = at[2], .rgba = {255, 255, 255, 255}};
    const uint64_t color = file->colors.bytes != NULL ? find_value(&file->colors, at) : 0;
    const uint64_t material = file->materials.bytes != NULL ? find_value(&file->materials, at) : 0;
    if (color != 0) {
        get_color(&file->colors, color, voxel.rgba);
    }
    if (material != 0) {
        const uint32_t number = get_u32(file->materials.bytes, material);
        if (number >= UINT16_MAX) {
            return damaged(file->reader, &file->materials, "a material is not below 65535", material);
        }
        voxel.material = (uint16_t)number;
    }
    return svo_i_voxels_append(file->reader, voxel);
}

static svo_status add_voxels(void *user, const int32_t at[3], uint32_t edge)
{
    nvdb_file *file = user;
    SVO_I_TRY(svo_i_voxels_limit(file->reader, file->reader->voxel_count + (uint64_t)edge * edge * edge));
    int32_t voxel[3];
    for (uint32_t x = 0; x < edge; ++x) {
        for (uint32_t y = 0; y < edge; ++y) {
            for (uint32_t z = 0; z < edge; ++z) {
                voxel[0] = at[0] + (int32_t)x;
                voxel[1] = at[1] + (int32_t)y;
                voxel[2] = at[2] + (int32_t)z;
                SVO_I_TRY(add_voxel(file, voxel));
            }
        }
    }
    return SVO_OK;
}

/* Takes the next grid as what it is for: by name colors or materials, else the first of the others as voxels. */
static void take_grid(nvdb_file *file, const nvdb_grid *g)
{
    nvdb_grid *place = has_colors(g) && (strcmp(g->name, VDB_COLOR) == 0 || strcmp(g->name, "Cd") == 0) ? &file->colors
                       : has_materials(g) && strcmp(g->name, VDB_MATERIAL) == 0 ? &file->materials
                                                                                : &file->voxels;
    if (place->bytes != NULL) {
        svo_i_voxels_warn(file->reader, "grid \"%s\" is not read", g->name);
        return;
    }
    *place = *g;
}

/* Reads the records and the grids of a segment. *at: its first byte, then the first byte behind it. */
static svo_status read_segment(nvdb_file *file, size_t *at)
{
    voxel_reader *reader = file->reader;
    const uint8_t *header = reader->bytes + *at;
    size_t record = *at + NVDB_HEADER_BYTES;
    if (reader->byte_count - *at < NVDB_HEADER_BYTES || memcmp(header, NVDB_MAGIC, strlen(NVDB_MAGIC)) != 0) {
        return svo_i_voxels_damaged(reader, "no segment of grids begins at byte %zu", *at);
    }
    const uint32_t version = get_u32(header, NVDB_HEADER_VERSION);
    const uint32_t grid_count = get_u32(header, NVDB_HEADER_GRID_COUNT) & UINT16_MAX;
    if (version >> NVDB_MAJOR_SHIFT != NVDB_MAJOR || get_u32(header, NVDB_HEADER_GRID_COUNT) >> 16 != 0) {
        return version >> NVDB_MAJOR_SHIFT != NVDB_MAJOR
                   ? svo_i_voxels_fail(reader, SVO_UNSUPPORTED,
                                       "version %" PRIu32 " of the format is not read, %d is, at byte %zu",
                                       version >> NVDB_MAJOR_SHIFT, NVDB_MAJOR, *at + NVDB_HEADER_VERSION)
                   : svo_i_voxels_fail(reader, SVO_UNSUPPORTED, "packed grids are not read, at byte %zu",
                                       *at + NVDB_HEADER_COMPRESSION);
    }
    size_t end = record;
    for (uint32_t i = 0; i < grid_count; ++i) { /* the grids begin behind the last name */
        const size_t left = reader->byte_count - end;
        if (left < NVDB_RECORD_BYTES ||
            get_u32(reader->bytes, end + NVDB_RECORD_NAME_BYTES) > left - NVDB_RECORD_BYTES) {
            return svo_i_voxels_damaged(reader, "the record of grid %" PRIu32 " is cut off, at byte %zu", i, end);
        }
        end += NVDB_RECORD_BYTES + get_u32(reader->bytes, end + NVDB_RECORD_NAME_BYTES);
    }
    for (uint32_t i = 0; i < grid_count; ++i) {
        nvdb_grid g;
        const uint64_t bytes = get_u64(reader->bytes, record + NVDB_RECORD_FILE_BYTES);
        if (bytes > reader->byte_count - end) {
            return svo_i_voxels_damaged(reader, "grid %" PRIu32 " of %" PRIu64 " bytes is cut off, at byte %zu", i,
                                        bytes, reader->byte_count);
        }
        SVO_I_TRY(open_grid(reader, end, bytes, &g));
        take_grid(file, &g);
        record += NVDB_RECORD_BYTES + get_u32(reader->bytes, record + NVDB_RECORD_NAME_BYTES);
        end += (size_t)bytes;
    }
    *at = end;
    return SVO_OK;
}

/* The place and the width of voxels. A grid that is turned or stretched keeps the places of its voxels alone. */
static svo_status read_map(voxel_reader *reader, const nvdb_grid *g)
{
    const uint64_t map = PNANOVDB_GRID_OFF_MAP;
    const double edge = get_f64(g->bytes, map + PNANOVDB_MAP_OFF_MATD);
    bool plain = edge > 0.0;
    for (uint64_t i = 0; i < 9; ++i) {
        const double value = get_f64(g->bytes, map + PNANOVDB_MAP_OFF_MATD + 8 * i);
        plain = plain && isfinite(value) && value == (i % 4 == 0 ? edge : 0.0);
    }
    for (uint64_t axis = 0; axis < 3; ++axis) {
        plain = plain && isfinite(get_f64(g->bytes, map + PNANOVDB_MAP_OFF_VECD + 8 * axis));
    }
    if (!plain) {
        svo_i_voxels_warn(reader, "the map of grid \"%s\" is more than a width and a place, and is not read", g->name);
        return SVO_OK;
    }
    reader->voxel_edge = edge;
    for (uint64_t axis = 0; axis < 3; ++axis) {
        reader->origin[axis] = get_f64(g->bytes, map + PNANOVDB_MAP_OFF_VECD + 8 * axis) - 0.5 * edge;
    }
    return SVO_OK;
}

svo_status svo_i_voxels_read_nvdb(voxel_reader *reader)
{
    nvdb_file file = {.reader = reader};
    size_t at = 0;
    do {
        SVO_I_TRY(read_segment(&file, &at));
    } while (at < reader->byte_count);
    if (file.voxels.bytes == NULL) {
        file.voxels = file.colors.bytes != NULL ? file.colors : file.materials;
    }
    if (file.voxels.bytes == NULL) {
        return svo_i_voxels_damaged(reader, "it holds no grid, at byte %zu", at);
    }
    if (file.colors.bytes != NULL) {
        SVO_I_TRY(walk_grid(reader, &file.colors, NULL, NULL));
    }
    if (file.materials.bytes != NULL) {
        SVO_I_TRY(walk_grid(reader, &file.materials, NULL, NULL));
    }
    SVO_I_TRY(walk_grid(reader, &file.voxels, add_voxels, &file));
    reader->info.version = get_u32(file.voxels.bytes, PNANOVDB_GRID_OFF_VERSION) >> NVDB_MAJOR_SHIFT;
    reader->info.instance_voxels = reader->voxel_count;
    return read_map(reader, &file.voxels);
}
