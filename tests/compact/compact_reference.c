/* SPDX-License-Identifier: MIT */
/* Trees by hand, and the descriptors of a tree by recursion. */
#include "compact_reference.h"

#include <assert.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

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
