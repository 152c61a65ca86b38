/* SPDX-License-Identifier: MIT */
/* Trees by hand, and the descriptors of a tree by recursion. */
#include "compact_reference.h"

#include <assert.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "core/compact.h"
#include "core/tree.h"
#include "support/meshes.h"

static void *allocate(size_t count, size_t bytes)
{
    void *made = svo_i_alloc_zeroed(NULL, count + 1, bytes);
    if (made == NULL) {
        abort();
    }
    return made;
}

/* ---- trees ---- */

static unsigned count_bits(unsigned mask)
{
    unsigned count = 0;
    for (; mask != 0; mask &= mask - 1) {
        ++count;
    }
    return count;
}

static void fill_randomly(svo_tree *tree)
{
    uint64_t seed = 5;
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const svo_tree_buffer buffer = (svo_tree_buffer)i;
        const bool payload = buffer == SVO_TREE_COLORS || buffer == SVO_TREE_NORMALS || buffer == SVO_TREE_MATERIALS ||
                             buffer == SVO_TREE_FILLS;
        if (payload && svo_i_tree_holds(&tree->info, buffer)) {
            const size_t bytes = (size_t)svo_i_tree_payload_count(&tree->info) * svo_i_tree_element_bytes(buffer);
            uint8_t *array = allocate(bytes, 1);
            for (size_t at = 0; at < bytes; ++at) {
                array[at] = (uint8_t)random_below(&seed, 256);
            }
            tree->host[i] = array;
        }
    }
}

svo_tree *hand_tree(uint32_t depth, mask_of_node *masks, void *user, uint32_t need, uint32_t payload_level)
{
    svo_tree *tree = svo_i_tree_new(NULL);
    size_t capacity = 1024;
    size_t count = 1;
    uint64_t *codes = allocate(capacity, sizeof *codes);
    uint8_t *child_mask = NULL;
    uint32_t *first_child = NULL;
    assert(tree != NULL);
    svo_tree_info *info = &tree->info;
    *info = (svo_tree_info){.struct_size = sizeof *info,
                            .depth = depth,
                            .snap_bits = 20,
                            .need = need,
                            .payload_level = payload_level,
                            .edge = 2,
                            .scale = 0x1p19,
                            .triangles = 9};
    size_t node = 0;
    for (uint32_t level = 0; level < depth; ++level) {
        info->level_begin[level + 1] = (uint32_t)count;
        child_mask = svo_i_grow(NULL, child_mask, count);
        first_child = svo_i_grow(NULL, first_child, count * sizeof *first_child);
        for (; node < info->level_begin[level + 1]; ++node) {
            child_mask[node] = masks(user, level, codes[node]);
            first_child[node] = (uint32_t)count;
            for (unsigned octant = 0; octant < 8; ++octant) {
                if ((child_mask[node] >> octant & 1) != 0) {
                    if (count == capacity) {
                        capacity *= 2;
                        codes = svo_i_grow(NULL, codes, capacity * sizeof *codes);
                    }
                    codes[count++] = codes[node] << 3 | octant;
                }
            }
        }
    }
    info->level_begin[depth + 1] = (uint32_t)count;
    info->node_count = count;
    info->inner_count = info->level_begin[depth];
    info->leaf_count = count - info->inner_count;
    tree->host[SVO_TREE_CHILD_MASK] = child_mask;
    tree->host[SVO_TREE_FIRST_CHILD] = first_child;
    fill_randomly(tree);
    tree->downloaded = true;
    svo_i_free(codes);
    return tree;
}

/* ---- descriptors ---- */

typedef struct encoder {
    const uint8_t *child_mask;
    const uint32_t *first_child;
    uint32_t depth, payload_level;
    reference_words *out;
    uint64_t capacity;
    uint64_t next; /* the next free word */
} encoder;

/* The far members of a node's group: tried from none upwards until no distance asks for more. */
static unsigned find_far(const encoder *e, uint32_t node, const uint64_t sizes[8])
{
    const unsigned count = count_bits(e->child_mask[node]);
    bool far[8] = {false};
    unsigned far_count = 0;
    for (bool changed = true; changed;) {
        changed = false;
        uint64_t descendants = 0;
        for (unsigned member = 0; member < count; ++member) {
            const uint64_t distance = count - member + far_count + descendants;
            if (sizes[member] > 0 && distance >= 32768 && !far[member]) {
                far[member] = changed = true;
            }
            descendants += sizes[member];
        }
        far_count = 0;
        for (unsigned member = 0; member < count; ++member) {
            far_count += far[member];
        }
    }
    unsigned flags = 0;
    for (unsigned member = 0; member < count; ++member) {
        flags |= (unsigned)far[member] << member;
    }
    return flags;
}

/* Words of a node's descendants. */
static uint64_t count_words(const encoder *e, uint32_t node, uint32_t level)
{
    uint64_t sizes[8] = {0};
    uint64_t sum = 0;
    if (level + 1 >= e->depth) {
        return 0;
    }
    const unsigned count = count_bits(e->child_mask[node]);
    for (unsigned member = 0; member < count; ++member) {
        sizes[member] = count_words(e, e->first_child[node] + member, level + 1);
        sum += sizes[member];
    }
    return sum + count + count_bits(find_far(e, node, sizes));
}

static void put(encoder *e, uint64_t at, uint32_t word)
{
    assert(at < e->capacity);
    e->out->words[at] = word;
}

/* Notes where the payload of a node's children goes: that of the node whose word is at a place. */
static void note_payload(encoder *e, uint32_t node, uint32_t level)
{
    for (unsigned rank = 0; rank < count_bits(e->child_mask[node]) && level + 1 >= e->payload_level; ++rank) {
        e->out->order[e->out->payload_count++] = e->first_child[node] + rank;
    }
}

/* Writes the group of a node's children, the far words, and the descendants. */
static void write_group(encoder *e, uint32_t node, uint32_t level)
{
    uint64_t sizes[8] = {0};
    const unsigned count = count_bits(e->child_mask[node]);
    for (unsigned member = 0; member < count; ++member) {
        sizes[member] = count_words(e, e->first_child[node] + member, level + 1);
    }
    const unsigned far = find_far(e, node, sizes);
    const uint64_t group = e->next;
    uint64_t far_word = group + count;
    uint64_t descendants = group + count + count_bits(far);
    for (unsigned member = 0; member < count; ++member) {
        const uint32_t child = e->first_child[node] + member;
        const uint32_t valid = e->child_mask[child];
        const uint32_t leaf = level + 2 == e->depth ? valid : 0;
        const uint64_t place = group + member;
        const uint32_t distance = sizes[member] > 0 ? (uint32_t)(descendants - place) : 0;
        if ((far >> member & 1) != 0) {
            put(e, place, valid | leaf << 8 | 1u << 16 | (uint32_t)(far_word - place) << 17);
            put(e, far_word++, distance);
            ++e->out->far_count;
        } else {
            put(e, place, valid | leaf << 8 | distance << 17);
        }
        descendants += sizes[member];
    }
    e->next = group + count + count_bits(far);
    for (unsigned member = 0; member < count; ++member) {
        if (sizes[member] > 0) {
            write_group(e, e->first_child[node] + member, level + 1);
        }
    }
}

/* bases and order: a walk in the order of the words, which are written. */
static void place_payload(encoder *e, uint32_t node, uint32_t level, uint64_t word, uint32_t *node_of_word)
{
    node_of_word[word] = node + 1;
    const uint32_t own = e->out->words[word];
    uint64_t child = word + (own >> 17);
    if ((own >> 16 & 1) != 0) {
        child = word + e->out->words[child];
    }
    for (unsigned rank = 0; level + 1 < e->depth && rank < count_bits(own & 255); ++rank) {
        place_payload(e, e->first_child[node] + rank, level + 1, child + rank, node_of_word);
    }
}

static uint32_t level_of(const svo_tree_info *info, uint32_t node)
{
    uint32_t level = 0;
    while (node >= info->level_begin[level + 1]) {
        ++level;
    }
    return level;
}

void reference_words_make(const svo_tree *tree, reference_words *out)
{
    const svo_tree_info *info = &tree->info;
    *out = (reference_words){.words = NULL};
    encoder e = {.child_mask = tree->host[SVO_TREE_CHILD_MASK],
                 .first_child = tree->host[SVO_TREE_FIRST_CHILD],
                 .depth = info->depth,
                 .payload_level = info->payload_level,
                 .out = out};
    e.capacity = 1 + count_words(&e, 0, 0);
    out->words = allocate(e.capacity, sizeof *out->words);
    out->bases = allocate(e.capacity, sizeof *out->bases);
    out->order = allocate((size_t)info->node_count, sizeof *out->order);
    const uint32_t valid = e.child_mask[0];
    const bool has_group = info->depth > 1 && valid != 0;
    put(&e, 0, valid | (info->depth == 1 ? valid << 8 : 0) | (has_group ? 1u << 17 : 0));
    e.next = 1;
    if (has_group) {
        write_group(&e, 0, 0);
    }
    out->word_count = e.next;
    uint32_t *node_of_word = allocate(e.capacity, sizeof *node_of_word);
    place_payload(&e, 0, 0, 0, node_of_word);
    if (info->payload_level == 0) {
        out->order[out->payload_count++] = 0;
    }
    for (uint64_t word = 0; word < out->word_count; ++word) {
        if (node_of_word[word] != 0) {
            const uint32_t node = node_of_word[word] - 1;
            const uint32_t level = level_of(info, node);
            out->bases[word] = level + 1 >= info->payload_level ? (uint32_t)out->payload_count : SVO_NO_NODE;
            note_payload(&e, node, level);
        }
    }
    svo_i_free(node_of_word);
}

void reference_words_free(reference_words *made)
{
    svo_i_free(made->words);
    svo_i_free(made->bases);
    svo_i_free(made->order);
    *made = (reference_words){.words = NULL};
}

/* ---- half words ---- */

typedef struct half_walk {
    const svo_tree *tree;
    const svo_compact *compact;
    bool has_places;
    uint32_t next; /* the next place */
    mirrored_walk *found;
} half_walk;

static uint32_t half_of(const half_walk *w, uint64_t at)
{
    uint16_t half = 0;
    if (at < 2 * w->compact->info.stored_count) {
        memcpy(&half, (const uint8_t *)w->compact->host[SVO_COMPACT_NODES] + 2 * at, sizeof half);
    }
    return half;
}

static uint32_t byte_of(const half_walk *w, uint64_t record, uint32_t index)
{
    return half_of(w, record + index / 2) >> 8 * (index % 2) & 255;
}

static uint32_t bits_in(uint32_t mask)
{
    uint32_t count = 0;
    for (; mask != 0; mask &= mask - 1) {
        ++count;
    }
    return count;
}

static uint32_t turned(uint32_t mask, uint32_t mirror)
{
    uint32_t to = 0;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        to |= (mask >> octant & 1) << (octant ^ mirror);
    }
    return to;
}

/* A node and what is below it, in the order of its record. record: above the voxels its valid mask, as stored. */
static void walk_half_words(half_walk *w, uint32_t node, uint32_t level, uint64_t record, uint32_t mirror)
{
    const svo_tree_info *info = &w->tree->info;
    const uint32_t levels = info->depth - level;
    const uint32_t *links = w->compact->host[SVO_COMPACT_LINKS];
    w->found->places[node] = w->has_places ? SVO_NO_NODE : 0;
    if (w->has_places && level >= info->payload_level) {
        w->found->places[node] = w->next++;
    }
    ++w->found->visited;
    if (levels == 0) {
        return;
    }
    const uint32_t mask = ((const uint8_t *)w->tree->host[SVO_TREE_CHILD_MASK])[node];
    const uint32_t first = ((const uint32_t *)w->tree->host[SVO_TREE_FIRST_CHILD])[node];
    const uint32_t stored = levels == 1 ? (uint32_t)record : half_of(w, record) & 255;
    const uint32_t is_long = half_of(w, record) >> 8;
    const uint32_t begin = w->next;
    uint32_t numbers = w->has_places && levels > 2 && mask != 0 ? bits_in(mask) - 1 : 0;
    uint64_t at = record + 1 + (levels > 5 ? 2 * numbers : numbers);
    uint32_t rank = 0;
    if (turned(stored, mirror) != mask) {
        return;
    }
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const uint32_t own = octant ^ mirror;
        uint64_t below = 0;
        uint32_t turn = 0;
        if ((stored >> octant & 1) == 0) {
            continue;
        }
        if (levels == 2) {
            below = byte_of(w, record, 1 + rank);
        } else if (levels > 2) {
            const uint32_t half = half_of(w, at);
            below = links[levels - 1] + (half & 0x1fff);
            turn = half >> 13;
            below += (is_long >> octant & 1) != 0 ? (uint64_t)half_of(w, at + 1) << 13 : 0;
            at += 1 + (is_long >> octant & 1);
            w->found->long_references += is_long >> octant & 1;
            w->found->reflected += turn != 0;
        }
        const uint32_t before = levels > 5 ? half_of(w, record + 2 * rank - 1) | half_of(w, record + 2 * rank) << 16
                                           : half_of(w, record + rank);
        if (rank > 0 && rank <= numbers && before != w->next - begin) {
            return;
        }
        walk_half_words(w, first + bits_in(mask & ((1u << own) - 1)), level + 1, below, mirror ^ turn);
        ++rank;
    }
}

void mirrored_walk_make(const svo_compact *compact, const svo_tree *tree, mirrored_walk *out)
{
    half_walk w = {
        .tree = tree, .compact = compact, .has_places = svo_i_compact_has_places(&compact->info), .found = out};
    *out = (mirrored_walk){.places = allocate(tree->info.node_count, sizeof *out->places)};
    walk_half_words(&w, 0, 0, tree->info.depth == 1 ? half_of(&w, 0) & 255 : 0, 0);
}

void mirrored_walk_free(mirrored_walk *made)
{
    svo_i_free(made->places);
    *made = (mirrored_walk){.places = NULL};
}
