/* SPDX-License-Identifier: MIT */
/*
 * SVO_FORM_DESCRIPTOR, third stage: the words of each group and its far words.
 *
 * Launch: one work-item per inner node, rounded up to whole groups. A work-item writes the words of its node's inner
 * children and their far words; that of the root writes the root's too. Reads the nodes, sizes, far, places and groups.
 * No atomics, no local memory.
 */
#include "compact/group.clh"

/* A node's word. field: its distance, or that to its far word. */
static uint svo_make_word(uint valid, uint leaf, bool far, uint field)
{
    return valid | leaf << SVO_WORD_LEAF_SHIFT | (far ? SVO_WORD_FAR : 0u) | field << SVO_WORD_DISTANCE_SHIFT;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_compact_words(__global const uchar *valid, __global const uchar *leaf, __global const uint *first_inner,
                    __global const uint *sizes, __global const uchar *far, __global const uint *groups,
                    __global uint *words, svo_compact_params params)
{
    const uint node = (uint)get_global_id(0);
    if (node >= params.node_count) {
        return;
    }
    const svo_siblings siblings = svo_find_siblings(valid, leaf, first_inner, node);
    const uint first_word = groups[node];
    const uint flags = far[node];
    uint far_word = first_word + siblings.count;
    for (uint rank = 0; rank < siblings.count; ++rank) {
        const uint member = siblings.first + rank;
        const uint place = first_word + rank;
        const uint distance = sizes[member] > 0u ? groups[member] - place : 0u;
        const bool is_far = (flags >> rank & 1u) != 0u;
        words[place] = svo_make_word(valid[member], leaf[member], is_far, is_far ? far_word - place : distance);
        if (is_far) {
            words[far_word] = distance;
            ++far_word;
        }
    }
    if (node == 0u) {
        words[0] = svo_make_word(valid[0], leaf[0], false, siblings.count > 0u ? 1u : 0u);
    }
}
