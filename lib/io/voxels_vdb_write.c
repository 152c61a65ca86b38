/* SPDX-License-Identifier: MIT */
/*
 * The .vdb writer: the grids of the .nvdb writer in OpenVDB's types, "density" and "surface" of floats, "color" of
 * vectors in linear light and "material" of whole numbers. Values are those of active voxels alone, packed by zlib leaf
 * by leaf. The file is made in memory, since its header has a hash of the rest and each grid its offsets.
 */
#include <inttypes.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>
#include <zlib.h>

#include "io/srgb.h"
#include "io/voxels_files.h"
#include "io/voxels_formats.h"
#include "io/voxels_vdb_file.h"

#define EXTENT_MAX      (SVO_VOXELS_EXTENT_MAX - (1 << VDB_NODE_LOG2))
#define HEADER_BYTES    (VDB_MAGIC_BYTES + 3 * 4 + 1 + VDB_UUID_BYTES)
#define LIBRARY_MAJOR   10u /* the version of OpenVDB whose files these are like */
#define LIBRARY_MINOR   0u
#define VALUE_BYTES_MAX 12u
#define LEAF_BYTES_MAX  (VDB_LEAF_VALUES * VALUE_BYTES_MAX)
#define PACKED_BYTES    (LEAF_BYTES_MAX + 1024) /* above zlib's bound */

/* What a grid holds. */
typedef struct grid_kind {
    const char *name, *type, *class;
    uint32_t value_bytes;
} grid_kind;

static const grid_kind density = {VDB_DENSITY, "Tree_float_5_4_3", "fog volume", 4};
static const grid_kind color = {VDB_COLOR, "Tree_vec3s_5_4_3", "unknown", 12};
static const grid_kind material = {VDB_MATERIAL, "Tree_int32_5_4_3", "unknown", 4};
static const grid_kind surface = {VDB_SURFACE, "Tree_float_5_4_3", "level set", 4};

/* A node: its children or, of a leaf, its voxels follow one another, up to those of the next node. */
typedef struct node {
    uint64_t begin;
    bool first, last; /* whether the first and the last voxel of it lie inside */
} node;

typedef struct vdb_writer {
    const voxel_writer *writer;
    svo_voxel *voxels; /* in Morton order from a corner of a node below the root; owned, as all pointers below */
    node *nodes[VDB_NODE_LEVELS]; /* in that order, and one behind the last */
    uint64_t counts[VDB_NODE_LEVELS];
    uint64_t *roots; /* numbers of upper nodes in the order of the file */
    uint32_t *children[VDB_NODE_LEVELS]; /* by their place in a node, from its first one on */
    float linear[256]; /* of sRGB */
    z_stream zip;
    bool has_zip;
    uint8_t *bytes; /* the file behind its header */
    size_t used, capacity;
    uint8_t plain[LEAF_BYTES_MAX], packed[PACKED_BYTES]; /* the values of a leaf */
} vdb_writer;

static svo_status fail_memory(const vdb_writer *w)
{
    return svo_i_voxels_write_fail(w->writer, SVO_OUT_OF_HOST_MEMORY, "no memory for a .vdb file of %" PRIu64 " voxels",
                                   w->writer->list.voxel_count);
}

/* ---- bytes ---- */

static svo_status put(vdb_writer *w, const void *bytes, size_t count)
{
    if (count > w->capacity - w->used) {
        const size_t capacity = 2 * w->capacity + count + 4096;
        uint8_t *grown = svo_i_grow(w->writer->memory, w->bytes, capacity);
        if (grown == NULL) {
            return fail_memory(w);
        }
        w->bytes = grown;
        w->capacity = capacity;
    }
    memcpy(w->bytes + w->used, bytes, count);
    w->used += count;
    return SVO_OK;
}

static svo_status put_u32(vdb_writer *w, uint32_t value)
{
    return put(w, &value, sizeof value);
}

static svo_status put_text(vdb_writer *w, const char *text)
{
    SVO_I_TRY(put_u32(w, (uint32_t)strlen(text)));
    return put(w, text, strlen(text));
}

static voidpf allocate(voidpf user, uInt items, uInt bytes)
{
    const vdb_writer *w = user;
    return svo_i_alloc(w->writer->memory, (size_t)items * bytes);
}

static void release(voidpf user, voidpf block)
{
    (void)user;
    svo_i_free(block);
}

/* Writes values: a length and the packed bytes, or where those are no fewer, minus their number and the bytes. */
static svo_status put_values(vdb_writer *w, size_t byte_count)
{
    int64_t length = -(int64_t)byte_count;
    if (byte_count > 0) {
        (void)deflateReset(&w->zip);
        w->zip.next_in = w->plain;
        w->zip.avail_in = (uInt)byte_count;
        w->zip.next_out = w->packed;
        w->zip.avail_out = (uInt)PACKED_BYTES;
        const bool is_whole = deflate(&w->zip, Z_FINISH) == Z_STREAM_END;
        if (is_whole && w->zip.total_out < byte_count) {
            length = (int64_t)w->zip.total_out;
        }
    }
    SVO_I_TRY(put(w, &length, sizeof length));
    return length > 0 ? put(w, w->packed, (size_t)length) : put(w, w->plain, byte_count);
}

/* ---- the shape ---- */

static bool share_node(const svo_voxel *a, const svo_voxel *b, int level)
{
    const uint32_t shift = vdb_voxels_log2(level);
    return a->x >> shift == b->x >> shift && a->y >> shift == b->y >> shift && a->z >> shift == b->z >> shift;
}

static const svo_voxel *first_voxel(const vdb_writer *w, int level, uint64_t index)
{
    for (; level >= VDB_LEAF; --level) {
        index = w->nodes[level][index].begin;
    }
    return &w->voxels[index];
}

/* Finds the nodes of a level. */
static svo_status find_nodes(vdb_writer *w, int level)
{
    const uint64_t below = level == VDB_LEAF ? w->writer->list.voxel_count : w->counts[level - 1];
    uint64_t count = 0;
    for (int pass = 0; pass < 2; ++pass) {
        count = 0;
        for (uint64_t i = 0; i < below; ++i) {
            if (i == 0 || !share_node(first_voxel(w, level - 1, i - 1), first_voxel(w, level - 1, i), level)) {
                if (pass == 1) {
                    w->nodes[level][count].begin = i;
                }
                ++count;
            }
        }
        if (pass == 0) {
            w->nodes[level] = svo_i_alloc_zeroed(w->writer->memory, (size_t)count + 1, sizeof(node));
            if (w->nodes[level] == NULL) {
                return fail_memory(w);
            }
        }
    }
    w->nodes[level][count].begin = below;
    w->counts[level] = count;
    return SVO_OK;
}

/* Sorts the root's children by x, y, z; there are few. */
static svo_status sort_roots(vdb_writer *w)
{
    w->roots = svo_i_alloc(w->writer->memory, (size_t)w->counts[VDB_UPPER] * sizeof *w->roots + 1);
    if (w->roots == NULL) {
        return fail_memory(w);
    }
    for (uint64_t i = 0; i < w->counts[VDB_UPPER]; ++i) {
        const svo_voxel *voxel = first_voxel(w, VDB_UPPER, i);
        uint64_t place = i;
        for (; place > 0; --place) {
            const svo_voxel *before = first_voxel(w, VDB_UPPER, w->roots[place - 1]);
            const int32_t here[3] = {voxel->x >> VDB_NODE_LOG2, voxel->y >> VDB_NODE_LOG2, voxel->z >> VDB_NODE_LOG2};
            const int32_t there[3] = {before->x >> VDB_NODE_LOG2, before->y >> VDB_NODE_LOG2,
                                      before->z >> VDB_NODE_LOG2};
            const int axis = here[0] != there[0] ? 0 : here[1] != there[1] ? 1 : 2;
            if (there[axis] < here[axis]) {
                break;
            }
            w->roots[place] = w->roots[place - 1];
        }
        w->roots[place] = i;
    }
    return SVO_OK;
}

static svo_status make_shape(vdb_writer *w)
{
    const voxel_writer *writer = w->writer;
    int32_t low[3];
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = writer->list.low[axis] & ~((1 << VDB_NODE_LOG2) - 1);
        const int64_t extent = (int64_t)writer->list.high[axis] - writer->list.low[axis];
        if (extent > EXTENT_MAX) {
            return svo_i_voxels_write_fail(writer, SVO_INVALID_ARGUMENT,
                                           "%" PRId64 " voxels along an axis are above the limit of .vdb files, %d",
                                           extent, EXTENT_MAX);
        }
    }
    SVO_I_TRY(svo_i_voxels_sorted(writer, low, SVO_I_VOXEL_MORTON, &w->voxels));
    for (int level = VDB_LEAF; level < VDB_NODE_LEVELS; ++level) {
        SVO_I_TRY(find_nodes(w, level));
        w->children[level] = svo_i_alloc(writer->memory, vdb_slots(level) * sizeof *w->children[level]);
        if (w->children[level] == NULL) {
            return fail_memory(w);
        }
    }
    return sort_roots(w);
}

/* Finds where in a node its children or voxels are. mask: receives a bit for each. */
static void place_children(vdb_writer *w, int level, uint64_t index, uint8_t *mask)
{
    const node *parent = &w->nodes[level][index];
    memset(mask, 0, vdb_slots(level) / 8);
    for (uint64_t i = parent[0].begin; i < parent[1].begin; ++i) {
        const svo_voxel *voxel = first_voxel(w, level - 1, i);
        const int32_t at[3] = {voxel->x, voxel->y, voxel->z};
        const uint32_t slot = vdb_child_of(level, at);
        w->children[level][slot] = (uint32_t)(i - parent->begin);
        mask[slot >> 3] |= (uint8_t)(1u << (slot & 7u));
    }
}

/*
 * ---- what is not in the band ----
 *
 * Signs of voxels and of parts of nodes without voxels: that of the voxel before them in their row, of the row before
 * in its plane, or of the plane before, which is the flood fill of OpenVDB's level sets.
 */

/* Whether the first or the last voxel of a child lies inside. slot: of the children that place_children found. */
static bool is_inside(const vdb_writer *w, int level, uint64_t index, uint32_t slot, bool last)
{
    const uint64_t child = w->nodes[level][index].begin + w->children[level][slot];
    float distance = 0.0F;
    if (level > VDB_LEAF) {
        return last ? w->nodes[level - 1][child].last : w->nodes[level - 1][child].first;
    }
    memcpy(&distance, w->voxels[child].rgba, sizeof distance);
    return distance < 0.0F;
}

/* Finds which entries of a node are outside, for those that have neither child nor voxel. mask: of those that have. */
static void find_outside(const vdb_writer *w, int level, uint64_t index, const uint8_t *mask, uint8_t *outside)
{
    const uint32_t bits = vdb_children_log2(level);
    const uint32_t along = (1u << bits) - 1;
    uint32_t entry = 0;
    memset(outside, 0, vdb_slots(level) / 8);
    while (!vdb_has_bit(mask, entry)) {
        ++entry;
    }
    bool of_plane = is_inside(w, level, index, entry, false);
    bool of_row = of_plane;
    bool inside = of_plane;
    for (entry = 0; entry < vdb_slots(level); ++entry) {
        const bool begins_row = (entry & along) == 0;
        const bool begins_plane = begins_row && (entry >> bits & along) == 0;
        inside = begins_plane ? of_plane : begins_row ? of_row : inside;
        if (vdb_has_bit(mask, entry)) {
            inside = is_inside(w, level, index, entry, true);
        } else if (!inside) {
            outside[entry >> 3] |= (uint8_t)(1u << (entry & 7u));
        }
        of_row = begins_row ? inside : of_row;
        of_plane = begins_plane ? inside : of_plane;
    }
}

/* Finds the signs of the first and the last voxel of all nodes, from the leaves up. */
static void find_signs(vdb_writer *w)
{
    uint8_t mask[VDB_UPPER_BYTES];
    uint8_t outside[VDB_UPPER_BYTES];
    for (int level = VDB_LEAF; level < VDB_NODE_LEVELS; ++level) {
        const uint32_t end = vdb_slots(level) - 1;
        for (uint64_t i = 0; i < w->counts[level]; ++i) {
            place_children(w, level, i, mask);
            find_outside(w, level, i, mask, outside);
            w->nodes[level][i].first =
                vdb_has_bit(mask, 0) ? is_inside(w, level, i, 0, false) : !vdb_has_bit(outside, 0);
            w->nodes[level][i].last =
                vdb_has_bit(mask, end) ? is_inside(w, level, i, end, true) : !vdb_has_bit(outside, end);
        }
    }
}

/* Writes what stands for the inactive values of a node. mask: of its children or voxels. */
static svo_status put_inactive(vdb_writer *w, const grid_kind *kind, int level, uint64_t index, const uint8_t *mask)
{
    uint8_t outside[VDB_UPPER_BYTES];
    uint8_t code = VDB_ALL_BACKGROUND;
    const uint32_t bytes = vdb_slots(level) / 8;
    if (kind == &surface) {
        bool has_outside = false;
        bool has_inside = false;
        find_outside(w, level, index, mask, outside);
        for (uint32_t i = 0; i < bytes; ++i) {
            has_outside = has_outside || outside[i] != 0;
            has_inside = has_inside || (outside[i] | mask[i]) != 0xff;
        }
        code = !has_inside ? VDB_ALL_BACKGROUND : has_outside ? VDB_TWO_SIGNS : VDB_ALL_NEGATIVE;
    }
    SVO_I_TRY(put(w, &code, 1));
    return code == VDB_TWO_SIGNS ? put(w, outside, bytes) : SVO_OK;
}

/* ---- the tree ---- */

static svo_status put_topology(vdb_writer *w, const grid_kind *kind, int level, uint64_t index)
{
    static const uint8_t nothing[VDB_UPPER_BYTES];
    uint8_t mask[VDB_UPPER_BYTES];
    place_children(w, level, index, mask);
    SVO_I_TRY(put(w, mask, vdb_slots(level) / 8));
    if (level == VDB_LEAF) {
        return SVO_OK;
    }
    SVO_I_TRY(put(w, nothing, vdb_slots(level) / 8)); /* no active tiles */
    SVO_I_TRY(put_inactive(w, kind, level, index, mask));
    SVO_I_TRY(put_values(w, 0));
    for (uint32_t slot = 0; slot < vdb_slots(level); ++slot) {
        if (vdb_has_bit(mask, slot)) {
            SVO_I_TRY(put_topology(w, kind, level - 1, w->nodes[level][index].begin + w->children[level][slot]));
        }
    }
    return SVO_OK;
}

static void put_value(vdb_writer *w, const grid_kind *kind, const svo_voxel *voxel, size_t at)
{
    const float one = 1.0F;
    const int32_t number = voxel->material;
    const float rgb[3] = {w->linear[voxel->rgba[0]], w->linear[voxel->rgba[1]], w->linear[voxel->rgba[2]]};
    const void *value = kind == &density    ? (const void *)&one
                        : kind == &color    ? (const void *)rgb
                        : kind == &material ? (const void *)&number
                                            : (const void *)voxel->rgba;
    memcpy(w->plain + at, value, kind->value_bytes);
}

static svo_status put_buffers(vdb_writer *w, const grid_kind *kind, int level, uint64_t index)
{
    uint8_t mask[VDB_UPPER_BYTES];
    size_t used = 0;
    place_children(w, level, index, mask);
    for (uint32_t slot = 0; slot < vdb_slots(level); ++slot) {
        if (!vdb_has_bit(mask, slot)) {
            continue;
        }
        const uint64_t child = w->nodes[level][index].begin + w->children[level][slot];
        if (level > VDB_LEAF) {
            SVO_I_TRY(put_buffers(w, kind, level - 1, child));
        } else {
            put_value(w, kind, &w->voxels[child], used);
            used += kind->value_bytes;
        }
    }
    if (level > VDB_LEAF) {
        return SVO_OK;
    }
    SVO_I_TRY(put(w, mask, VDB_LEAF_BYTES));
    SVO_I_TRY(put_inactive(w, kind, level, index, mask));
    return put_values(w, used);
}

static svo_status put_root(vdb_writer *w, const grid_kind *kind)
{
    const uint8_t zero[VALUE_BYTES_MAX] = {0};
    SVO_I_TRY(put_u32(w, 1)); /* buffer */
    SVO_I_TRY(kind == &surface ? put(w, &w->writer->background, kind->value_bytes) : put(w, zero, kind->value_bytes));
    SVO_I_TRY(put_u32(w, 0)); /* tiles */
    SVO_I_TRY(put_u32(w, (uint32_t)w->counts[VDB_UPPER]));
    for (uint64_t i = 0; i < w->counts[VDB_UPPER]; ++i) {
        const svo_voxel *voxel = first_voxel(w, VDB_UPPER, w->roots[i]);
        const int32_t mask = ~((1 << VDB_NODE_LOG2) - 1);
        const int32_t at[3] = {voxel->x & mask, voxel->y & mask, voxel->z & mask};
        SVO_I_TRY(put(w, at, sizeof at));
        SVO_I_TRY(put_topology(w, kind, VDB_UPPER, w->roots[i]));
    }
    return SVO_OK;
}

/* ---- what stands before it ---- */

static svo_status put_metadata(vdb_writer *w, const char *name, const char *type, const void *value, uint32_t bytes)
{
    SVO_I_TRY(put_text(w, name));
    SVO_I_TRY(put_text(w, type));
    SVO_I_TRY(put_u32(w, bytes));
    return put(w, value, bytes);
}

static svo_status put_string(vdb_writer *w, const char *name, const char *value)
{
    return put_metadata(w, name, "string", value, (uint32_t)strlen(value));
}

/* In the order of their names, as OpenVDB writes them. */
static svo_status put_all_metadata(vdb_writer *w, const grid_kind *kind)
{
    const svo_voxels_info *list = &w->writer->list;
    const bool is_empty = list->voxel_count == 0;
    const int64_t count = (int64_t)list->voxel_count;
    int32_t box[2][3];
    for (int axis = 0; axis < 3; ++axis) { /* an empty box ends before it begins */
        box[0][axis] = is_empty ? INT32_MAX : list->low[axis];
        box[1][axis] = is_empty ? INT32_MIN : list->high[axis] - 1;
    }
    SVO_I_TRY(put_u32(w, 7));
    SVO_I_TRY(put_string(w, "class", kind->class));
    SVO_I_TRY(put_string(w, "creator", "svocl"));
    SVO_I_TRY(put_metadata(w, "file_bbox_max", "vec3i", box[1], sizeof box[1]));
    SVO_I_TRY(put_metadata(w, "file_bbox_min", "vec3i", box[0], sizeof box[0]));
    SVO_I_TRY(put_string(w, "file_compression", "zip + active values"));
    SVO_I_TRY(put_metadata(w, "file_voxel_count", "int64", &count, sizeof count));
    return put_string(w, "name", kind->name);
}

/* Index (0, 0, 0) is the center of a voxel. Behind the scale are what OpenVDB makes of it: the width of voxels, the
   inverse, its square and its half. */
static svo_status put_map(vdb_writer *w)
{
    const double edge = w->writer->list.voxel_edge;
    const double inverse = 1.0 / edge;
    double numbers[6][3];
    for (int axis = 0; axis < 3; ++axis) {
        numbers[0][axis] = svo_i_voxels_world(w->writer, axis, 0.5);
        numbers[1][axis] = edge;
        numbers[2][axis] = edge;
        numbers[3][axis] = inverse;
        numbers[4][axis] = inverse * inverse;
        numbers[5][axis] = 0.5 * inverse;
    }
    SVO_I_TRY(put_text(w, "UniformScaleTranslateMap"));
    return put(w, numbers, sizeof numbers);
}

static svo_status put_grid(vdb_writer *w, const grid_kind *kind)
{
    uint64_t offsets[3] = {0, 0, 0};
    SVO_I_TRY(put_text(w, kind->name));
    SVO_I_TRY(put_text(w, kind->type));
    SVO_I_TRY(put_text(w, "")); /* it has a tree of its own */
    const size_t field = w->used;
    SVO_I_TRY(put(w, offsets, sizeof offsets));
    offsets[0] = HEADER_BYTES + w->used;
    SVO_I_TRY(put_u32(w, VDB_ZIP | VDB_ACTIVE_MASK));
    SVO_I_TRY(put_all_metadata(w, kind));
    SVO_I_TRY(put_map(w));
    SVO_I_TRY(put_root(w, kind));
    offsets[1] = HEADER_BYTES + w->used;
    for (uint64_t i = 0; i < w->counts[VDB_UPPER]; ++i) {
        SVO_I_TRY(put_buffers(w, kind, VDB_UPPER, w->roots[i]));
    }
    offsets[2] = HEADER_BYTES + w->used;
    memcpy(w->bytes + field, offsets, sizeof offsets);
    return SVO_OK;
}

/* ---- the file ---- */

/* Writes the header, with a hash of all else as the file's identity, and the rest. */
static svo_status put_file(const vdb_writer *w, voxel_writer *writer)
{
    static const char digits[] = "0123456789abcdef";
    const uint32_t versions[3] = {VDB_VERSION, LIBRARY_MAJOR, LIBRARY_MINOR};
    const XXH128_hash_t hash = XXH3_128bits(w->bytes, w->used);
    uint8_t header[HEADER_BYTES] = VDB_MAGIC;
    uint8_t *at = header + VDB_MAGIC_BYTES;
    memcpy(at, versions, sizeof versions);
    at += sizeof versions;
    *at++ = 1; /* grids have offsets */
    for (int i = 0; i < 32; ++i) {
        const uint64_t half = i < 16 ? hash.high64 : hash.low64;
        if (i == 8 || i == 12 || i == 16 || i == 20) {
            *at++ = '-';
        }
        *at++ = (uint8_t)digits[half >> 4 * (15 - i % 16) & 15u];
    }
    SVO_I_TRY(svo_i_voxels_put(writer, header, sizeof header));
    return svo_i_voxels_put(writer, w->bytes, w->used);
}

static svo_status put_grids(vdb_writer *w)
{
    const voxel_writer *writer = w->writer;
    const bool is_surface = writer->background > 0.0F;
    bool has_colors = false;
    bool has_materials = false;
    for (uint64_t i = 0; i < writer->list.voxel_count && !is_surface; ++i) {
        const uint8_t *rgba = writer->voxels[i].rgba;
        has_colors = has_colors || rgba[0] != 255 || rgba[1] != 255 || rgba[2] != 255;
        has_materials = has_materials || writer->voxels[i].material != 0;
    }
    w->zip.zalloc = allocate;
    w->zip.zfree = release;
    w->zip.opaque = w;
    if (deflateInit(&w->zip, Z_DEFAULT_COMPRESSION) != Z_OK) {
        return fail_memory(w);
    }
    w->has_zip = true;
    for (int i = 0; i < 256; ++i) {
        w->linear[i] = (float)svo_i_srgb_linear((uint8_t)i);
    }
    SVO_I_TRY(make_shape(w));
    if (is_surface) {
        find_signs(w);
    }
    SVO_I_TRY(put_u32(w, 0)); /* metadata of the file */
    SVO_I_TRY(put_u32(w, 1u + has_colors + has_materials));
    SVO_I_TRY(put_grid(w, is_surface ? &surface : &density));
    SVO_I_TRY(has_colors ? put_grid(w, &color) : SVO_OK);
    return has_materials ? put_grid(w, &material) : SVO_OK;
}

svo_status svo_i_voxels_write_vdb(voxel_writer *writer)
{
    vdb_writer *w = svo_i_alloc_zeroed(writer->memory, 1, sizeof *w);
    svo_status status = SVO_OK;
    if (w == NULL) {
        return svo_i_voxels_write_fail(writer, SVO_OUT_OF_HOST_MEMORY, "no memory for a writer");
    }
    w->writer = writer;
    SVO_I_TRY_CLEANUP(put_grids(w));
    SVO_I_TRY_CLEANUP(put_file(w, writer));
cleanup:
    if (w->has_zip) {
        (void)deflateEnd(&w->zip);
    }
    for (int level = VDB_LEAF; level < VDB_NODE_LEVELS; ++level) {
        svo_i_free(w->nodes[level]);
        svo_i_free(w->children[level]);
    }
    svo_i_free(w->roots);
    svo_i_free(w->voxels);
    svo_i_free(w->bytes);
    svo_i_free(w);
    return status;
}
