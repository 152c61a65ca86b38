/* SPDX-License-Identifier: MIT */
/*
 * The .vdb reader: the list of grids, what stands before their trees, and the voxels. Those of a level set are inside,
 * with a negative value; of every other grid they are the active ones, tiles among them. Nothing in a file is trusted:
 * voxels_vdb_tree.c checks the trees, and what is here the offsets and lengths of all else.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "io/srgb.h"
#include "io/voxels_files.h"
#include "io/voxels_formats.h"
#include "io/voxels_vdb_file.h"

#define NAME_BYTES   256
#define OFFSET_BYTES 24u /* of a grid, its leaves' values, and its end */
#define ENTRY_BYTES  (12u + OFFSET_BYTES) /* a descriptor with empty texts */
#define LEVEL_SET    "level set"

/* A text of the file. */
typedef struct vdb_text {
    const char *text; /* not terminated */
    uint32_t bytes;
} vdb_text;

/* A descriptor. */
typedef struct vdb_entry {
    vdb_text unique; /* its name, and a number where several have that */
    vdb_text type, parent; /* parent: the unique name of the grid whose tree is its own; empty: none */
    const vdb_type *read_as; /* NULL: grids of its type are not read */
    bool is_half;
    size_t begin, end; /* of the grid */
    size_t blocks; /* of its leaves' values; 0: the file does not say */
} vdb_entry;

/* A grid whose tree was read. */
typedef struct vdb_grid {
    char name[NAME_BYTES];
    vdb_input in; /* reader NULL: there is no grid */
    vdb_tree tree;
    bool is_level_set;
    vdb_text map;
    double linear[9], offset[3]; /* of the map from indices to the world, by rows */
} vdb_grid;

typedef enum vdb_role { VDB_OF_VOXELS, VDB_OF_COLORS, VDB_OF_MATERIALS, VDB_ROLES } vdb_role;

typedef struct vdb_file {
    voxel_reader *reader;
    bool has_offsets;
    vdb_entry *entries; /* owned */
    uint32_t entry_count;
    vdb_grid grids[VDB_ROLES];
} vdb_file;

static svo_status take_u32(vdb_input *in, const char *what, uint32_t *value)
{
    const uint8_t *from = NULL;
    SVO_I_TRY(svo_i_vdb_take(in, sizeof *value, what, &from));
    memcpy(value, from, sizeof *value);
    return SVO_OK;
}

static svo_status take_text(vdb_input *in, const char *what, vdb_text *text)
{
    const uint8_t *from = NULL;
    SVO_I_TRY(take_u32(in, what, &text->bytes));
    SVO_I_TRY(svo_i_vdb_take(in, text->bytes, what, &from));
    text->text = (const char *)from;
    return SVO_OK;
}

static bool is_text(vdb_text a, const char *b)
{
    return a.bytes == strlen(b) && memcmp(a.text, b, a.bytes) == 0;
}

/* The beginning of a text, in one line and terminated. */
static void print_text(vdb_text from, char to[NAME_BYTES])
{
    uint32_t used = 0;
    for (; used < from.bytes && used < NAME_BYTES - 1 && from.text[used] != VDB_SEPARATOR; ++used) {
        const char letter = from.text[used];
        to[used] = (unsigned char)letter < ' ' || letter == '\x7f' ? '?' : letter;
    }
    to[used] = '\0';
}

/* ---- what stands before a tree ---- */

/* Skips metadata: names, types and values with their lengths. is_level_set: NULL, or whether the class says so. */
static svo_status read_metadata(vdb_input *in, bool *is_level_set)
{
    uint32_t count = 0;
    SVO_I_TRY(take_u32(in, "metadata are", &count));
    for (uint32_t i = 0; i < count; ++i) {
        vdb_text name;
        vdb_text type;
        vdb_text value;
        SVO_I_TRY(take_text(in, "metadata are", &name));
        SVO_I_TRY(take_text(in, "metadata are", &type));
        SVO_I_TRY(take_text(in, "metadata are", &value));
        if (is_level_set != NULL && is_text(name, "class") && is_text(type, "string")) {
            *is_level_set = is_text(value, LEVEL_SET);
        }
    }
    return SVO_OK;
}

/* Reads a map. Scales have, behind them, four vectors that follow from them. */
static svo_status read_map(vdb_input *in, vdb_grid *g)
{
    double numbers[18] = {0.0};
    const uint8_t *from = NULL;
    char name[NAME_BYTES];
    const size_t field = in->at;
    SVO_I_TRY(take_text(in, "the map is", &g->map));
    const bool translates = is_text(g->map, "UniformScaleTranslateMap") || is_text(g->map, "ScaleTranslateMap") ||
                            is_text(g->map, "TranslationMap");
    const bool scales = is_text(g->map, "UniformScaleMap") || is_text(g->map, "ScaleMap") ||
                        (translates && !is_text(g->map, "TranslationMap"));
    const bool is_affine = is_text(g->map, "AffineMap") || is_text(g->map, "UnitaryMap");
    const size_t count = is_affine ? 16 : (translates ? 3u : 0u) + (scales ? 15u : 0u);
    if (count == 0) {
        print_text(g->map, name);
        return svo_i_voxels_fail(in->reader, SVO_UNSUPPORTED, "grid \"%s\": a %s is not read, at byte %zu", g->name,
                                 name, field);
    }
    SVO_I_TRY(svo_i_vdb_take(in, count * sizeof numbers[0], "the map is", &from));
    memcpy(numbers, from, count * sizeof numbers[0]);
    for (size_t row = 0; row < 3; ++row) {
        for (size_t column = 0; column < 3; ++column) {
            /* A matrix stands by columns, as it multiplies row vectors. */
            g->linear[3 * row + column] = is_affine       ? numbers[4 * column + row]
                                          : row != column ? 0.0
                                          : scales        ? numbers[(translates ? 3 : 0) + row]
                                                          : 1.0;
        }
        g->offset[row] = is_affine ? numbers[12 + row] : translates ? numbers[row] : 0.0;
    }
    return SVO_OK;
}

/* Reads how a grid is compressed, its metadata and its map. */
static svo_status read_head(vdb_input *in, vdb_grid *g)
{
    SVO_I_TRY(take_u32(in, "the compression is", &g->tree.compression));
    SVO_I_TRY(read_metadata(in, &g->is_level_set));
    return read_map(in, g);
}

/* ---- a grid ---- */

static void end_grid(vdb_grid *g)
{
    svo_i_vdb_tree_end(&g->tree);
    svo_i_vdb_input_end(&g->in);
}

/* Reads the tree behind the head. */
static svo_status read_tree(vdb_grid *g, const vdb_entry *entry)
{
    vdb_input *in = &g->in;
    SVO_I_TRY(svo_i_vdb_read_topology(in, &g->tree));
    if (entry->blocks != 0 && in->at != entry->blocks) {
        return svo_i_vdb_damaged(in, "the masks do not end where values begin", in->at);
    }
    SVO_I_TRY(svo_i_vdb_read_buffers(in, &g->tree));
    if (entry->blocks != 0 && in->at != entry->end) {
        return svo_i_vdb_damaged(in, "the values do not end where the grid does", in->at);
    }
    return SVO_OK;
}

static svo_status find_parent(const vdb_file *file, const vdb_entry *entry, const vdb_input *in, const vdb_entry **out)
{
    for (uint32_t i = 0; i < file->entry_count; ++i) {
        const vdb_entry *one = &file->entries[i];
        if (one->unique.bytes == entry->parent.bytes &&
            memcmp(one->unique.text, entry->parent.text, entry->parent.bytes) == 0) {
            *out = one;
            return one->parent.bytes == 0 && one->read_as == entry->read_as
                       ? SVO_OK
                       : svo_i_vdb_damaged(in, "the grid whose tree is its own has no such tree", entry->begin);
        }
    }
    return svo_i_vdb_damaged(in, "the grid whose tree is its own is not there", entry->begin);
}

/* Reads a grid. An instance has its own map and class, and the tree of another one. */
static svo_status read_grid(const vdb_file *file, const vdb_entry *entry, vdb_grid *g)
{
    *g = (vdb_grid){.in = {.reader = file->reader, .at = entry->begin, .end = entry->end}};
    print_text(entry->unique, g->name);
    g->in.grid = g->name;
    g->tree.type = entry->read_as;
    g->tree.is_half = entry->is_half;
    SVO_I_TRY(read_head(&g->in, g));
    if (entry->parent.bytes == 0) {
        return read_tree(g, entry);
    }
    const vdb_entry *parent = NULL;
    vdb_grid head = {.name = ""};
    SVO_I_TRY(find_parent(file, entry, &g->in, &parent));
    g->in.at = parent->begin;
    g->in.end = parent->end;
    memcpy(head.name, g->name, sizeof head.name);
    SVO_I_TRY(read_head(&g->in, &head));
    g->tree.compression = head.tree.compression;
    g->tree.is_half = parent->is_half;
    return read_tree(g, parent);
}

/* ---- the list of grids ---- */

static svo_status take_offsets(const vdb_file *file, vdb_input *in, vdb_entry *entry)
{
    const uint8_t *from = NULL;
    uint64_t offsets[3];
    SVO_I_TRY(svo_i_vdb_take(in, OFFSET_BYTES, "a grid's descriptor is", &from));
    memcpy(offsets, from, sizeof offsets);
    entry->begin = in->at;
    entry->end = in->end;
    if (!file->has_offsets) {
        return SVO_OK;
    }
    const bool has_tree = entry->parent.bytes == 0;
    if (offsets[0] < in->at || offsets[2] < offsets[0] || offsets[2] > in->end ||
        (has_tree && (offsets[1] <= offsets[0] || offsets[1] > offsets[2]))) {
        return svo_i_vdb_damaged(in, "a grid's offsets lie outside or are out of order", in->at - OFFSET_BYTES);
    }
    entry->begin = (size_t)offsets[0];
    entry->blocks = has_tree ? (size_t)offsets[1] : 0;
    entry->end = (size_t)offsets[2];
    return SVO_OK;
}

/* Where a grid ends in a file without offsets: its tree says it. */
static svo_status find_end(const vdb_file *file, vdb_entry *entry)
{
    vdb_grid g = {.in = {.reader = file->reader, .at = entry->begin, .end = entry->end}};
    svo_status status = SVO_OK;
    print_text(entry->unique, g.name);
    if (entry->read_as == NULL) {
        return svo_i_voxels_fail(file->reader, SVO_UNSUPPORTED,
                                 "grid \"%s\" is of a type that is not read, and the file does not say where it ends",
                                 g.name);
    }
    g.in.grid = g.name;
    g.tree.type = entry->read_as;
    g.tree.is_half = entry->is_half;
    SVO_I_TRY_CLEANUP(read_head(&g.in, &g));
    if (entry->parent.bytes == 0) {
        SVO_I_TRY_CLEANUP(read_tree(&g, entry));
    }
    entry->end = g.in.at;
cleanup:
    end_grid(&g);
    return status;
}

static svo_status read_entry(const vdb_file *file, vdb_input *in, vdb_entry *entry)
{
    const size_t suffix_bytes = strlen(VDB_HALF_SUFFIX);
    SVO_I_TRY(take_text(in, "a grid's descriptor is", &entry->unique));
    SVO_I_TRY(take_text(in, "a grid's descriptor is", &entry->type));
    SVO_I_TRY(take_text(in, "a grid's descriptor is", &entry->parent));
    size_t type_bytes = entry->type.bytes;
    if (type_bytes > suffix_bytes &&
        memcmp(entry->type.text + type_bytes - suffix_bytes, VDB_HALF_SUFFIX, suffix_bytes) == 0) {
        type_bytes -= suffix_bytes;
        entry->is_half = true;
    }
    entry->read_as = svo_i_vdb_type(entry->type.text, type_bytes);
    SVO_I_TRY(take_offsets(file, in, entry));
    if (!file->has_offsets) {
        SVO_I_TRY(find_end(file, entry));
    }
    in->at = entry->end;
    return SVO_OK;
}

/* Reads the header and the descriptors. */
static svo_status read_entries(vdb_file *file)
{
    voxel_reader *reader = file->reader;
    vdb_input in = {.reader = reader, .end = reader->byte_count};
    const uint8_t *from = NULL;
    uint32_t count = 0;
    SVO_I_TRY(svo_i_vdb_take(&in, VDB_MAGIC_BYTES + 3 * sizeof(uint32_t) + 1 + VDB_UUID_BYTES, "the header is", &from));
    memcpy(&reader->info.version, from + VDB_MAGIC_BYTES, sizeof reader->info.version);
    if (reader->info.version < VDB_VERSION_LEAST || reader->info.version > VDB_VERSION_MOST) {
        return svo_i_voxels_fail(reader, SVO_UNSUPPORTED,
                                 "version %" PRIu32 " of the format is not read, %u to %u are, at byte %u",
                                 reader->info.version, VDB_VERSION_LEAST, VDB_VERSION_MOST, VDB_MAGIC_BYTES);
    }
    file->has_offsets = from[VDB_MAGIC_BYTES + 3 * sizeof(uint32_t)] != 0;
    SVO_I_TRY(read_metadata(&in, NULL));
    SVO_I_TRY(take_u32(&in, "the number of grids is", &count));
    if (count == 0 || count > (in.end - in.at) / ENTRY_BYTES) {
        return svo_i_vdb_damaged(&in, count == 0 ? "it holds no grid" : "it has more grids than can follow",
                                 in.at - sizeof count);
    }
    file->entries = svo_i_alloc_zeroed(&reader->memory, count, sizeof *file->entries);
    if (file->entries == NULL) {
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %" PRIu32 " grids", count);
    }
    for (; file->entry_count < count; ++file->entry_count) {
        SVO_I_TRY(read_entry(file, &in, &file->entries[file->entry_count]));
    }
    return SVO_OK;
}

static vdb_role role_of(const vdb_entry *entry, const char *name)
{
    const vdb_type *type = entry->read_as;
    return type->components == 3 && type->kind != VDB_INT32 && (strcmp(name, VDB_COLOR) == 0 || strcmp(name, "Cd") == 0)
               ? VDB_OF_COLORS
           : type->components == 1 && (type->kind == VDB_INT32 || type->kind == VDB_INT64) &&
                   strcmp(name, VDB_MATERIAL) == 0
               ? VDB_OF_MATERIALS
               : VDB_OF_VOXELS;
}

/* Reads the first grid for each purpose. Others are warnings. */
static svo_status read_grids(vdb_file *file)
{
    for (uint32_t i = 0; i < file->entry_count; ++i) {
        const vdb_entry *entry = &file->entries[i];
        char name[NAME_BYTES];
        char type[NAME_BYTES];
        print_text(entry->unique, name);
        print_text(entry->type, type);
        if (entry->read_as == NULL) {
            svo_i_voxels_warn(file->reader, "grid \"%s\" of type %s is not read", name, type);
            continue;
        }
        vdb_grid *place = &file->grids[role_of(entry, name)];
        if (place->in.reader != NULL) {
            svo_i_voxels_warn(file->reader, "grid \"%s\" is not read", name);
            continue;
        }
        SVO_I_TRY(read_grid(file, entry, place));
    }
    return SVO_OK;
}

/* ---- voxels ---- */

/* Unpacks the values of all nodes, so that what is damaged is found where no voxel asks for it. */
static svo_status check_values(vdb_grid *g)
{
    const bool has_leaves = g->tree.type->kind != VDB_BOOL && g->tree.type->kind != VDB_MASK;
    const uint8_t *values = NULL;
    for (int level = has_leaves ? VDB_LEAF : VDB_LOWER; level < VDB_NODE_LEVELS; ++level) {
        for (uint64_t i = 0; i < g->tree.counts[level]; ++i) {
            SVO_I_TRY(svo_i_vdb_values(&g->in, &g->tree, level, &g->tree.nodes[level][i], &values));
        }
    }
    return SVO_OK;
}

/* The value of an active voxel or tile; NULL: there is none. byte: receives where the values of its node begin. */
static svo_status find_value(vdb_grid *g, const int32_t at[3], const uint8_t **value, size_t *byte)
{
    *value = NULL;
    *byte = g->tree.tiles;
    for (int level = VDB_LEAF; level < VDB_NODE_LEVELS; ++level) {
        const vdb_node *held = g->tree.held[level];
        const uint32_t shift = vdb_voxels_log2(level);
        const bool is_held = held != NULL && held->at[0] >> shift == at[0] >> shift &&
                             held->at[1] >> shift == at[1] >> shift && held->at[2] >> shift == at[2] >> shift;
        const vdb_node *node = is_held ? held : svo_i_vdb_find(&g->tree, level, at);
        if (node != NULL) {
            const uint32_t slot = vdb_child_of(level, at);
            const uint8_t *masks = g->in.reader->bytes + node->masks;
            if (vdb_has_bit(masks + (level == VDB_LEAF ? 0 : vdb_slots(level) / 8), slot)) {
                SVO_I_TRY(svo_i_vdb_values(&g->in, &g->tree, level, node, value));
                *value += (size_t)slot * g->tree.type->value_bytes;
                *byte = node->values;
            }
            return SVO_OK;
        }
    }
    const uint8_t *tile = svo_i_vdb_find_tile(&g->in, &g->tree, at);
    if (tile != NULL && tile[3 * sizeof(int32_t) + g->tree.type->value_bytes] != 0) {
        *value = tile + 3 * sizeof(int32_t);
    }
    return SVO_OK;
}

static svo_status add_voxel(vdb_file *file, const int32_t at[3])
{
    svo_voxel voxel = {.x = at[0], .y = at[1], .z = at[2], .rgba = {255, 255, 255, 255}};
    vdb_grid *colors = &file->grids[VDB_OF_COLORS];
    vdb_grid *materials = &file->grids[VDB_OF_MATERIALS];
    const uint8_t *value = NULL;
    size_t byte = 0;
    if (colors->in.reader != NULL) {
        SVO_I_TRY(find_value(colors, at, &value, &byte));
        for (uint32_t i = 0; i < 3 && value != NULL; ++i) {
            voxel.rgba[i] = svo_i_srgb_byte(svo_i_vdb_number(colors->tree.type, value, i));
        }
    }
    if (materials->in.reader != NULL) {
        SVO_I_TRY(find_value(materials, at, &value, &byte));
        const double number = value != NULL ? svo_i_vdb_number(materials->tree.type, value, 0) : 0.0;
        if (!(number >= 0.0 && number < UINT16_MAX)) {
            return svo_i_vdb_damaged(&materials->in, "a material is not in 0 .. 65534", byte);
        }
        voxel.material = (uint16_t)number;
    }
    return svo_i_voxels_append(file->reader, voxel);
}

/* Adds a cube of voxels. */
static svo_status add_voxels(vdb_file *file, const int32_t at[3], uint32_t edge)
{
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

/* Adds what a node has besides its children. */
static svo_status add_node(vdb_file *file, vdb_grid *g, int level, const vdb_node *node)
{
    const uint32_t slots = vdb_slots(level);
    const uint8_t *masks = file->reader->bytes + node->masks;
    const uint8_t *active = masks + (level == VDB_LEAF ? 0 : slots / 8);
    const uint32_t edge = level == VDB_LEAF ? 1 : 1u << vdb_voxels_log2(level - 1);
    const uint8_t *values = NULL;
    if (g->is_level_set) {
        SVO_I_TRY(svo_i_vdb_values(&g->in, &g->tree, level, node, &values));
    }
    for (uint32_t slot = 0; slot < slots; ++slot) {
        const uint8_t *value = values != NULL ? values + (size_t)slot * g->tree.type->value_bytes : NULL;
        const bool is_child = level != VDB_LEAF && vdb_has_bit(masks, slot);
        if (!is_child && (value != NULL ? svo_i_vdb_number(g->tree.type, value, 0) < 0.0 : vdb_has_bit(active, slot))) {
            int32_t corner[3];
            vdb_corner_of(level, node->at, slot, corner);
            SVO_I_TRY(add_voxels(file, corner, edge));
        }
    }
    return SVO_OK;
}

/* Adds the voxels of a grid. */
static svo_status add_grid(vdb_file *file, vdb_grid *g)
{
    const vdb_type *type = g->tree.type;
    const uint8_t *tile = file->reader->bytes + g->tree.tiles;
    if (g->is_level_set && (type->components != 1 || (type->kind != VDB_FLOAT && type->kind != VDB_DOUBLE))) {
        return svo_i_vdb_damaged(&g->in, "a level set without numbers", g->tree.tiles);
    }
    for (uint32_t i = 0; i < g->tree.tile_count; ++i) {
        int32_t at[3];
        const uint8_t *value = tile + sizeof at;
        memcpy(at, tile, sizeof at);
        if (g->is_level_set ? svo_i_vdb_number(type, value, 0) < 0.0 : value[type->value_bytes] != 0) {
            SVO_I_TRY(add_voxels(file, at, 1u << VDB_NODE_LOG2));
        }
        tile = value + type->value_bytes + 1;
    }
    for (int level = VDB_UPPER; level >= VDB_LEAF; --level) {
        for (uint64_t i = 0; i < g->tree.counts[level]; ++i) {
            SVO_I_TRY(add_node(file, g, level, &g->tree.nodes[level][i]));
        }
    }
    return SVO_OK;
}

/* The place and the width of voxels. Where widths differ the voxels keep their places in the grid alone. */
static svo_status take_map(voxel_reader *reader, const vdb_grid *g)
{
    const double edge = g->linear[0];
    bool is_plain = edge > 0.0;
    char name[NAME_BYTES];
    print_text(g->map, name);
    for (int i = 0; i < 9; ++i) {
        if (i % 4 != 0 && g->linear[i] != 0.0) {
            return svo_i_voxels_fail(reader, SVO_UNSUPPORTED,
                                     "grid \"%s\": a %s that turns or shears voxels is not read", g->name, name);
        }
        is_plain = is_plain && isfinite(g->linear[i]) && g->linear[i] == (i % 4 == 0 ? edge : 0.0);
    }
    for (int axis = 0; axis < 3; ++axis) {
        is_plain = is_plain && isfinite(g->offset[axis]);
    }
    if (!is_plain) {
        svo_i_voxels_warn(reader, "the map of grid \"%s\" is more than a width and a place, and is not read", g->name);
        return SVO_OK;
    }
    reader->voxel_edge = edge;
    for (int axis = 0; axis < 3; ++axis) {
        reader->origin[axis] = g->offset[axis] - 0.5 * edge;
    }
    return SVO_OK;
}

static svo_status add_file(vdb_file *file)
{
    vdb_grid *shape = NULL;
    SVO_I_TRY(read_entries(file));
    SVO_I_TRY(read_grids(file));
    for (int role = VDB_ROLES - 1; role >= 0; --role) {
        shape = file->grids[role].in.reader != NULL ? &file->grids[role] : shape;
    }
    if (shape == NULL) {
        return svo_i_voxels_fail(file->reader, SVO_UNSUPPORTED,
                                 "none of its %" PRIu32 " grids is of a type that is read", file->entry_count);
    }
    SVO_I_TRY(take_map(file->reader, shape));
    for (int role = 0; role < VDB_ROLES; ++role) {
        if (file->grids[role].in.reader != NULL) {
            SVO_I_TRY(check_values(&file->grids[role]));
        }
    }
    SVO_I_TRY(add_grid(file, shape));
    file->reader->info.instance_voxels = file->reader->voxel_count;
    return SVO_OK;
}

svo_status svo_i_voxels_read_vdb(voxel_reader *reader)
{
    vdb_file file = {.reader = reader};
    const svo_status status = add_file(&file);
    for (int role = 0; role < VDB_ROLES; ++role) {
        end_grid(&file.grids[role]);
    }
    svo_i_free(file.entries);
    return status;
}
