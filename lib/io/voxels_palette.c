/* SPDX-License-Identifier: MIT */
/*
 * A palette of at most 255 colors for a list of voxels. Up to 255 pairs of a color and a material have an entry each.
 * More are put together by k-means (Lloyd, "Least Squares Quantization in PCM", 1982) from centers that lie far from
 * one another (Gonzalez, "Clustering to Minimize the Maximum Intercluster Distance", 1985), in integers and in the
 * order of the pairs, so that the result is the same everywhere.
 */
#include "io/voxels_palette.h"

#include <stdlib.h>
#include <string.h>

#define COLORS     255u
#define ROUNDS_MAX 8
#define NO_KEY     UINT64_MAX

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

svo_status svo_i_palette_make(const voxel_writer *writer, voxel_palette *palette)
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

void svo_i_palette_free(voxel_palette *palette)
{
    svo_i_free(palette->pairs);
    palette->pairs = NULL;
}

uint8_t svo_i_palette_entry(const voxel_palette *palette, const svo_voxel *voxel)
{
    if (palette->by_material) {
        return (uint8_t)voxel->material;
    }
    const palette_pair key = {.key = key_of(voxel)};
    const palette_pair *pair = bsearch(&key, palette->pairs, palette->pair_count, sizeof key, compare_pairs);
    return (uint8_t)pair->entry;
}
