/* SPDX-License-Identifier: MIT */
/*
 * The .vox writer. The list is cut into blocks of 256^3 voxels, counted from its least corner; in Morton order each is
 * one run of the list. Each becomes a model as large as what it holds, which the scene moves to its place.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/voxels_files.h"
#include "io/voxels_formats.h"

#define VERSION         150
#define BLOCK_BITS      24 /* of a Morton code within a block */
#define CHUNK_HEAD      12u
#define MATERIAL_ID_MAX 256u

#define PALETTE_ENTRIES 256 /* entry 0 means no voxel */
#define COLORS          255u
#define ROUNDS_MAX      8
#define NO_KEY          UINT64_MAX

/*
 * ---- the palette ----
 *
 * Of at most 255 colors. Up to 255 pairs of a color and a material have an entry each. More are put together by k-means
 * (Lloyd, "Least Squares Quantization in PCM", 1982) from centers that lie far from one another (Gonzalez, "Clustering
 * to Minimize the Maximum Intercluster Distance", 1985), in integers and in the order of the pairs, so that the result
 * is the same everywhere.
 */

/* A pair of a color and a material, with its palette entry. */
typedef struct palette_pair {
    uint64_t key; /* material << 32 | red << 24 | green << 16 | blue << 8 | alpha */
    uint64_t count; /* voxels that have it */
    uint32_t entry; /* 1 .. 255 */
} palette_pair;

typedef struct voxel_palette {
    uint8_t rgba[PALETTE_ENTRIES][4];
    uint32_t material[PALETTE_ENTRIES]; /* whose properties the entry has */
    bool by_material; /* entry i is material i, for voxels and properties alike */
    palette_pair *pairs; /* pair_count, by key; owned */
    size_t pair_count;
    uint32_t error; /* largest difference of a component */
} voxel_palette;

static uint64_t key_of(const svo_voxel *voxel)
{
    return (uint64_t)voxel->material << 32 | (uint32_t)voxel->rgba[0] << 24 | (uint32_t)voxel->rgba[1] << 16 |
           (uint32_t)voxel->rgba[2] << 8 | voxel->rgba[3];
}

static int component(uint64_t key, unsigned channel)
{
    return (int)(key >> (24 - 8 * channel) & 255u);
}

/* A hash table of pairs, whose capacity is a power of two. */
typedef struct pair_table {
    palette_pair *slots; /* owned */
    size_t capacity, used;
} pair_table;

static palette_pair *find_slot(const pair_table *table, uint64_t key)
{
    size_t slot = (size_t)(key * UINT64_C(0x9e3779b97f4a7c15) >> 20) & (table->capacity - 1);
    while (table->slots[slot].key != key && table->slots[slot].key != NO_KEY) {
        slot = (slot + 1) & (table->capacity - 1);
    }
    return &table->slots[slot];
}

static bool grow_table(const svo_i_memory *memory, pair_table *table)
{
    pair_table larger = {.capacity = table->capacity == 0 ? 1024 : 2 * table->capacity, .used = table->used};
    larger.slots = svo_i_alloc(memory, larger.capacity * sizeof *larger.slots);
    if (larger.slots == NULL) {
        return false;
    }
    for (size_t i = 0; i < larger.capacity; ++i) {
        larger.slots[i] = (palette_pair){.key = NO_KEY};
    }
    for (size_t i = 0; i < table->capacity; ++i) {
        if (table->slots[i].key != NO_KEY) {
            *find_slot(&larger, table->slots[i].key) = table->slots[i];
        }
    }
    svo_i_free(table->slots);
    *table = larger;
    return true;
}

static int compare_pairs(const void *a, const void *b)
{
    const palette_pair *left = a;
    const palette_pair *right = b;
    return (left->key > right->key) - (left->key < right->key);
}

/* Counts the voxels of each pair and sorts the pairs. */
static bool collect_pairs(const voxel_writer *writer, voxel_palette *palette)
{
    pair_table table = {.slots = NULL};
    for (uint64_t i = 0; i < writer->list.voxel_count; ++i) {
        if (2 * table.used >= table.capacity && !grow_table(writer->memory, &table)) {
            svo_i_free(table.slots);
            return false;
        }
        palette_pair *pair = find_slot(&table, key_of(&writer->voxels[i]));
        table.used += pair->key == NO_KEY ? 1 : 0;
        pair->key = key_of(&writer->voxels[i]);
        ++pair->count;
    }
    for (size_t i = 0; i < table.capacity; ++i) {
        if (table.slots[i].key != NO_KEY) {
            table.slots[palette->pair_count++] = table.slots[i];
        }
    }
    palette->pairs = table.slots;
    if (palette->pair_count > 0) {
        qsort(palette->pairs, palette->pair_count, sizeof *palette->pairs, compare_pairs);
    }
    return true;
}

/* Whether materials can be the entries: each is 1 .. 255 and has one color. */
static bool are_entries(const voxel_palette *palette)
{
    for (size_t i = 0; i < palette->pair_count; ++i) {
        const uint64_t material = palette->pairs[i].key >> 32;
        if (material < 1 || material > COLORS || (i > 0 && palette->pairs[i - 1].key >> 32 == material)) {
            return false;
        }
    }
    return true;
}

static void set_entry(voxel_palette *palette, uint32_t entry, uint64_t key)
{
    for (unsigned channel = 0; channel < 4; ++channel) {
        palette->rgba[entry][channel] = (uint8_t)component(key, channel);
    }
    palette->material[entry] = (uint32_t)(key >> 32);
}

static uint32_t distance(const voxel_palette *palette, uint32_t entry, uint64_t key)
{
    uint32_t sum = 0;
    for (unsigned channel = 0; channel < 4; ++channel) {
        const int difference = palette->rgba[entry][channel] - component(key, channel);
        sum += (uint32_t)(difference * difference);
    }
    return sum;
}

/* The first centers: the color of most voxels, then each time the one that is farthest from all centers. */
static bool choose_centers(const svo_i_memory *memory, voxel_palette *palette)
{
    uint32_t *nearest = svo_i_alloc(memory, palette->pair_count * sizeof *nearest);
    if (nearest == NULL) {
        return false;
    }
    size_t chosen = 0;
    for (size_t i = 0; i < palette->pair_count; ++i) {
        nearest[i] = UINT32_MAX;
        chosen = palette->pairs[i].count > palette->pairs[chosen].count ? i : chosen;
    }
    for (uint32_t entry = 1; entry <= COLORS; ++entry) {
        set_entry(palette, entry, palette->pairs[chosen].key);
        chosen = 0;
        for (size_t i = 0; i < palette->pair_count; ++i) {
            const uint32_t to_new = distance(palette, entry, palette->pairs[i].key);
            nearest[i] = to_new < nearest[i] ? to_new : nearest[i];
            chosen = nearest[i] > nearest[chosen] ? i : chosen;
        }
    }
    svo_i_free(nearest);
    return true;
}

/* Gives each pair the nearest entry; the smaller one on ties. Returns whether any changed. */
static bool assign_pairs(voxel_palette *palette)
{
    bool changed = false;
    for (size_t i = 0; i < palette->pair_count; ++i) {
        palette_pair *pair = &palette->pairs[i];
        uint32_t best = 1;
        uint32_t least = UINT32_MAX;
        for (uint32_t entry = 1; entry <= COLORS && least > 0; ++entry) {
            const uint32_t to_entry = distance(palette, entry, pair->key);
            best = to_entry < least ? entry : best;
            least = to_entry < least ? to_entry : least;
        }
        changed = changed || pair->entry != best;
        pair->entry = best;
    }
    return changed;
}

/* Moves each entry to the mean of its voxels' colors, rounded half up. */
static void move_centers(voxel_palette *palette)
{
    uint64_t sums[PALETTE_ENTRIES][4] = {{0}};
    uint64_t counts[PALETTE_ENTRIES] = {0};
    for (size_t i = 0; i < palette->pair_count; ++i) {
        const palette_pair *pair = &palette->pairs[i];
        counts[pair->entry] += pair->count;
        for (unsigned channel = 0; channel < 4; ++channel) {
            sums[pair->entry][channel] += pair->count * (uint64_t)component(pair->key, channel);
        }
    }
    for (uint32_t entry = 1; entry <= COLORS; ++entry) {
        for (unsigned channel = 0; channel < 4 && counts[entry] > 0; ++channel) {
            palette->rgba[entry][channel] = (uint8_t)((2 * sums[entry][channel] + counts[entry]) / (2 * counts[entry]));
        }
    }
}

/* Finds the largest difference, and the material of most voxels of each entry. */
static void finish_entries(voxel_palette *palette)
{
    uint64_t most[PALETTE_ENTRIES] = {0};
    for (size_t i = 0; i < palette->pair_count; ++i) {
        const palette_pair *pair = &palette->pairs[i];
        for (unsigned channel = 0; channel < 4; ++channel) {
            const int difference = abs(palette->rgba[pair->entry][channel] - component(pair->key, channel));
            palette->error = (uint32_t)difference > palette->error ? (uint32_t)difference : palette->error;
        }
        if (pair->count > most[pair->entry]) {
            most[pair->entry] = pair->count;
            palette->material[pair->entry] = (uint32_t)(pair->key >> 32);
        }
    }
}

/* Makes the palette of the writer's voxels; free_palette afterwards, on failure too. */
static svo_status make_palette(const voxel_writer *writer, voxel_palette *palette)
{
    *palette = (voxel_palette){.pairs = NULL};
    if (!collect_pairs(writer, palette)) {
        return svo_i_voxels_write_fail(writer, SVO_OUT_OF_HOST_MEMORY, "no memory for the colors");
    }
    palette->by_material = are_entries(palette);
    if (palette->by_material || palette->pair_count <= COLORS) {
        for (size_t i = 0; i < palette->pair_count; ++i) {
            palette_pair *pair = &palette->pairs[i];
            pair->entry = palette->by_material ? (uint32_t)(pair->key >> 32) : (uint32_t)i + 1;
            set_entry(palette, pair->entry, pair->key);
        }
        return SVO_OK;
    }
    if (!choose_centers(writer->memory, palette)) {
        return svo_i_voxels_write_fail(writer, SVO_OUT_OF_HOST_MEMORY, "no memory for %zu colors", palette->pair_count);
    }
    for (int round = 0; round < ROUNDS_MAX && assign_pairs(palette); ++round) {
        move_centers(palette);
    }
    (void)assign_pairs(palette);
    finish_entries(palette);
    return SVO_OK;
}

static void free_palette(voxel_palette *palette)
{
    svo_i_free(palette->pairs);
    palette->pairs = NULL;
}

/* The entry of a voxel, 1 .. 255. */
static uint8_t entry_of(const voxel_palette *palette, const svo_voxel *voxel)
{
    if (palette->by_material) {
        return (uint8_t)voxel->material;
    }
    const palette_pair key = {.key = key_of(voxel)};
    const palette_pair *pair = bsearch(&key, palette->pairs, palette->pair_count, sizeof key, compare_pairs);
    return (uint8_t)pair->entry;
}

/* ---- the file ---- */

/* A run of the list, and its bounds. */
typedef struct block {
    uint64_t begin, count;
    int32_t low[3], high[3];
} block;

typedef struct vox_writer {
    voxel_writer *out;
    voxel_palette palette;
    block *blocks; /* owned */
    size_t block_count;
} vox_writer;

static svo_status put_i32(vox_writer *w, uint64_t value)
{
    const uint32_t word = (uint32_t)value;
    return svo_i_voxels_put(w->out, &word, sizeof word);
}

static svo_status put_chunk(vox_writer *w, const char *id, uint64_t content_bytes, uint64_t children_bytes)
{
    SVO_I_TRY(svo_i_voxels_put(w->out, id, 4));
    SVO_I_TRY(put_i32(w, content_bytes));
    return put_i32(w, children_bytes);
}

static svo_status put_text(vox_writer *w, const char *text)
{
    SVO_I_TRY(put_i32(w, strlen(text)));
    return svo_i_voxels_put(w->out, text, strlen(text));
}

/* Bounds of the block's voxels. */
static void measure_block(const voxel_writer *out, block *b)
{
    for (int axis = 0; axis < 3; ++axis) {
        b->low[axis] = INT32_MAX;
        b->high[axis] = INT32_MIN;
    }
    for (uint64_t i = b->begin; i < b->begin + b->count; ++i) {
        const int32_t place[3] = {out->voxels[i].x, out->voxels[i].y, out->voxels[i].z};
        for (int axis = 0; axis < 3; ++axis) {
            b->low[axis] = place[axis] < b->low[axis] ? place[axis] : b->low[axis];
            b->high[axis] = place[axis] >= b->high[axis] ? place[axis] + 1 : b->high[axis];
        }
    }
}

/* Whether a voxel is the first of its block. */
static bool begins_block(const voxel_writer *out, uint64_t index)
{
    return index == 0 || svo_i_voxel_code(&out->voxels[index], out->list.low) >> BLOCK_BITS !=
                             svo_i_voxel_code(&out->voxels[index - 1], out->list.low) >> BLOCK_BITS;
}

static svo_status find_blocks(vox_writer *w)
{
    const voxel_writer *out = w->out;
    uint64_t count = 0;
    for (uint64_t i = 0; i < out->list.voxel_count; ++i) {
        count += begins_block(out, i) ? 1 : 0;
    }
    if (count > SVO_VOXEL_INSTANCES_MAX) {
        return svo_i_voxels_write_fail(out, SVO_INVALID_ARGUMENT,
                                       "the voxels lie in %" PRIu64 " blocks of 256^3, above the limit of %d models",
                                       count, SVO_VOXEL_INSTANCES_MAX);
    }
    w->blocks = svo_i_alloc_zeroed(out->memory, (size_t)count + 1, sizeof *w->blocks);
    if (w->blocks == NULL) {
        return svo_i_voxels_write_fail(out, SVO_OUT_OF_HOST_MEMORY, "no memory for %" PRIu64 " models", count);
    }
    for (uint64_t i = 0; i < out->list.voxel_count; ++i) {
        if (begins_block(out, i)) {
            w->blocks[w->block_count++] = (block){.begin = i};
        }
        ++w->blocks[w->block_count - 1].count;
    }
    for (size_t i = 0; i < w->block_count; ++i) {
        measure_block(out, &w->blocks[i]);
    }
    return SVO_OK;
}

static svo_status put_model(vox_writer *w, const block *b)
{
    SVO_I_TRY(put_chunk(w, "SIZE", 12, 0));
    for (int axis = 0; axis < 3; ++axis) {
        SVO_I_TRY(put_i32(w, (uint64_t)(b->high[axis] - b->low[axis])));
    }
    SVO_I_TRY(put_chunk(w, "XYZI", 4 + 4 * b->count, 0));
    SVO_I_TRY(put_i32(w, b->count));
    for (uint64_t i = b->begin; i < b->begin + b->count; ++i) {
        const svo_voxel *voxel = &w->out->voxels[i];
        const uint8_t entry[4] = {(uint8_t)(voxel->x - b->low[0]), (uint8_t)(voxel->y - b->low[1]),
                                  (uint8_t)(voxel->z - b->low[2]), entry_of(&w->palette, voxel)};
        SVO_I_TRY(svo_i_voxels_put(w->out, entry, sizeof entry));
    }
    return SVO_OK;
}

/* The translation of a block: readers add the voxel's place less half the size, rounded down. */
static void block_translation(const block *b, char *text, size_t text_bytes)
{
    int32_t moved[3];
    for (int axis = 0; axis < 3; ++axis) {
        moved[axis] = b->low[axis] + (b->high[axis] - b->low[axis]) / 2;
    }
    (void)snprintf(text, text_bytes, "%" PRId32 " %" PRId32 " %" PRId32, moved[0], moved[1], moved[2]);
}

/* A node that moves its child. translation: "" for none. */
static svo_status put_transform(vox_writer *w, uint64_t id, uint64_t child, const char *translation)
{
    const size_t length = strlen(translation);
    SVO_I_TRY(put_chunk(w, "nTRN", 28 + (length > 0 ? 10 + length : 0), 0));
    SVO_I_TRY(put_i32(w, id));
    SVO_I_TRY(put_i32(w, 0)); /* attributes */
    SVO_I_TRY(put_i32(w, child));
    SVO_I_TRY(put_i32(w, UINT32_MAX)); /* reserved */
    SVO_I_TRY(put_i32(w, UINT32_MAX)); /* no layer */
    SVO_I_TRY(put_i32(w, 1)); /* frame */
    SVO_I_TRY(put_i32(w, length > 0 ? 1 : 0));
    if (length > 0) {
        SVO_I_TRY(put_text(w, "_t"));
        SVO_I_TRY(put_text(w, translation));
    }
    return SVO_OK;
}

/* Node 0 moves node 1, the group of nodes 2, 4, 6, ..., each of which moves the shape after it. */
static svo_status put_scene(vox_writer *w)
{
    char translation[64];
    SVO_I_TRY(put_transform(w, 0, 1, ""));
    SVO_I_TRY(put_chunk(w, "nGRP", 12 + 4 * (uint64_t)w->block_count, 0));
    SVO_I_TRY(put_i32(w, 1));
    SVO_I_TRY(put_i32(w, 0)); /* attributes */
    SVO_I_TRY(put_i32(w, w->block_count));
    for (size_t i = 0; i < w->block_count; ++i) {
        SVO_I_TRY(put_i32(w, 2 + 2 * i));
    }
    for (size_t i = 0; i < w->block_count; ++i) {
        block_translation(&w->blocks[i], translation, sizeof translation);
        SVO_I_TRY(put_transform(w, 2 + 2 * i, 3 + 2 * i, translation));
        SVO_I_TRY(put_chunk(w, "nSHP", 20, 0));
        SVO_I_TRY(put_i32(w, 3 + 2 * i));
        SVO_I_TRY(put_i32(w, 0)); /* attributes */
        SVO_I_TRY(put_i32(w, 1)); /* model */
        SVO_I_TRY(put_i32(w, i));
        SVO_I_TRY(put_i32(w, 0)); /* its attributes */
    }
    return SVO_OK;
}

static svo_status put_palette(vox_writer *w)
{
    const uint8_t last[4] = {0, 0, 0, 0};
    SVO_I_TRY(put_chunk(w, "RGBA", 4 * (uint64_t)PALETTE_ENTRIES, 0));
    SVO_I_TRY(svo_i_voxels_put(w->out, w->palette.rgba[1], 4 * (size_t)(PALETTE_ENTRIES - 1)));
    return svo_i_voxels_put(w->out, last, sizeof last);
}

/* The properties of a material: first .. first + count - 1. */
static size_t find_properties(const vox_writer *w, uint32_t material, size_t *first)
{
    const svo_voxel_property *properties = w->out->properties;
    size_t begin = 0;
    size_t end = (size_t)w->out->list.property_count;
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        if (properties[middle].material < material) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    *first = begin;
    size_t count = 0;
    while (begin + count < w->out->list.property_count && properties[begin + count].material == material) {
        ++count;
    }
    return count;
}

/* Writes the properties of the material of palette entry id, if there are any. Without w->out->buffer counts alone;
   returns the bytes in *bytes. */
static svo_status put_material(vox_writer *w, uint32_t id, bool counts, uint64_t *bytes)
{
    const uint32_t material = w->palette.by_material ? id : w->palette.material[id];
    size_t first = 0;
    const size_t count = find_properties(w, material, &first);
    uint64_t content = 8;
    for (size_t i = first; i < first + count; ++i) {
        content += 8 + strlen(w->out->properties[i].key) + strlen(w->out->properties[i].value);
    }
    *bytes += count > 0 ? CHUNK_HEAD + content : 0;
    if (counts || count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(put_chunk(w, "MATL", content, 0));
    SVO_I_TRY(put_i32(w, id));
    SVO_I_TRY(put_i32(w, count));
    for (size_t i = first; i < first + count; ++i) {
        SVO_I_TRY(put_text(w, w->out->properties[i].key));
        SVO_I_TRY(put_text(w, w->out->properties[i].value));
    }
    return SVO_OK;
}

/* Where materials are entries, all that a file can hold are written, used or not. */
static svo_status put_materials(vox_writer *w, bool counts, uint64_t *bytes)
{
    const uint64_t used = w->palette.pair_count < PALETTE_ENTRIES ? w->palette.pair_count : PALETTE_ENTRIES - 1;
    const uint32_t first = w->palette.by_material ? 0 : 1;
    const uint32_t last = w->palette.by_material ? MATERIAL_ID_MAX : (uint32_t)used;
    for (uint32_t id = first; id <= last; ++id) {
        SVO_I_TRY(put_material(w, id, counts, bytes));
    }
    return SVO_OK;
}

/* The length of everything in MAIN. */
static uint64_t measure(vox_writer *w)
{
    char translation[64];
    uint64_t bytes = CHUNK_HEAD + 28 + CHUNK_HEAD + 12 + CHUNK_HEAD + 4 * (uint64_t)PALETTE_ENTRIES;
    for (size_t i = 0; i < w->block_count; ++i) {
        block_translation(&w->blocks[i], translation, sizeof translation);
        bytes += CHUNK_HEAD + 12 + CHUNK_HEAD + 4 + 4 * w->blocks[i].count; /* SIZE, XYZI */
        bytes += 4 + CHUNK_HEAD + 38 + strlen(translation) + CHUNK_HEAD + 20; /* the child's id, nTRN, nSHP */
    }
    (void)put_materials(w, true, &bytes);
    return bytes;
}

static svo_status put_all(vox_writer *w)
{
    uint64_t bytes = 0;
    const uint64_t children_bytes = measure(w);
    if (children_bytes > INT32_MAX) {
        return svo_i_voxels_write_fail(w->out, SVO_INVALID_ARGUMENT,
                                       "a .vox file of %" PRIu64 " bytes is above the limit of %d", children_bytes,
                                       INT32_MAX);
    }
    SVO_I_TRY(svo_i_voxels_put(w->out, "VOX ", 4));
    SVO_I_TRY(put_i32(w, VERSION));
    SVO_I_TRY(put_chunk(w, "MAIN", 0, children_bytes));
    for (size_t i = 0; i < w->block_count; ++i) {
        SVO_I_TRY(put_model(w, &w->blocks[i]));
    }
    SVO_I_TRY(put_scene(w));
    SVO_I_TRY(put_palette(w));
    return put_materials(w, false, &bytes);
}

svo_status svo_i_voxels_write_vox(voxel_writer *writer)
{
    svo_status status = SVO_OK;
    vox_writer w = {.out = writer};
    SVO_I_TRY_CLEANUP(make_palette(writer, &w.palette));
    SVO_I_TRY_CLEANUP(find_blocks(&w));
    SVO_I_TRY_CLEANUP(put_all(&w));
    writer->info.models = w.block_count;
    writer->info.colors = w.palette.pair_count;
    writer->info.color_error = w.palette.error;
cleanup:
    free_palette(&w.palette);
    svo_i_free(w.blocks);
    return status;
}
