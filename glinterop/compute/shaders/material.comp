/* SPDX-License-Identifier: MIT */
/*
 * The material of every node: the one with the largest weight among its triangles, the smallest of equals.
 * kernels/stages/material.cl in GLSL, which describes the entries and why their order does not matter.
 *
 *   SVO_K_MATERIAL_SCATTER  per fragment: writes (material, weight) into its leaf's range of entries, in any order
 *   SVO_K_MATERIAL_LEAVES   per leaf: sorts its entries by material and sums up those of one material
 *   SVO_K_MATERIAL_PASS     per entry: one pass of that merge sort, where a leaf is too long for one invocation
 *                           (compute.glsl)
 *   SVO_K_MATERIAL_ROOM     per node of a level: the number of its children's entries
 *   scan.comp               per node: where its own entries begin
 *   SVO_K_MATERIAL_MERGE    per node: merges its children's entries
 *
 * Entries of leaves begin where their lists do, and those of other nodes follow one another without gaps.
 * Materials are 16-bit numbers, two per word: their array starts at zero, and an atomicOr writes each number.
 */
#define SVO_ENTRY_SHIFT 48
/* Sorts after all materials, which are below 65535. */
#define SVO_NO_ENTRY (~uint64_t(0))

#ifdef SVO_K_MATERIAL_SCATTER

layout(std430, binding = 1) readonly buffer Cursors
{
    uint cursors[];
};
layout(std430, binding = 8) readonly buffer ListBegin
{
    uint list_begin[];
};
layout(std430, binding = 6) buffer Counts
{
    uint counts[];
};
layout(std430, binding = 7) writeonly buffer Entries
{
    uint64_t entries[];
};

void main()
{
    uint index = svo_item();
    if (index >= params.fragment_count) {
        return;
    }
    uint triangle = svo_fragment_triangle(index) - first_triangle;
    uint leaf = cursors[index] - params.leaf_begin;
    if (triangle < triangle_count && svo_in_window(leaf)) {
        svo_share share = svo_pair_share(triangle, svo_fragment_code(index));
        uint slot = list_begin[leaf - svo_first[8]] + atomicAdd(counts[leaf - svo_first[6]], 1u);
        entries[slot - svo_first[7] / 2u] =
            uint64_t(records[triangle].material) << SVO_ENTRY_SHIFT | uint64_t(share.weight);
    }
}

#else

uniform svo_filter_params params;

#if defined(SVO_K_MATERIAL_LEAVES) || defined(SVO_K_MATERIAL_PASS)
layout(std430, binding = 2) buffer Entries
{
    uint64_t entries[];
};
layout(std430, binding = 3) buffer Spare
{
    uint64_t spare[];
};
layout(std430, binding = 4) buffer Materials
{
    uint materials[]; /* two numbers per word */
};
#endif

#ifdef SVO_K_MATERIAL_MERGE
layout(std430, binding = 4) readonly buffer ChildEntries
{
    uint64_t child_entries[];
};
layout(std430, binding = 7) buffer Entries
{
    uint64_t entries[];
};
layout(std430, binding = 8) buffer Materials
{
    uint materials[]; /* two numbers per word */
};
#endif

uint svo_entry_material(uint64_t entry)
{
    return uint(entry >> SVO_ENTRY_SHIFT);
}

uint64_t svo_entry_weight(uint64_t entry)
{
    return entry & ((uint64_t(1) << SVO_ENTRY_SHIFT) - uint64_t(1));
}

#ifndef SVO_K_MATERIAL_ROOM

/* first: of the range of materials. */
void svo_put_material(uint node, uint material, uint first)
{
    atomicOr(materials[(node >> 1) - first], material << (16u * (node & 1u)));
}

uint svo_heaviest(uint begin, uint end)
{
    uint64_t most = uint64_t(0);
    uint material = 0u;
    for (uint i = begin; i < end; ++i) {
        uint64_t weight = svo_entry_weight(entries[i]);
        material = weight > most ? svo_entry_material(entries[i]) : material;
        most = weight > most ? weight : most;
    }
    return material;
}

#endif

#endif

#if defined(SVO_K_MATERIAL_LEAVES) || defined(SVO_K_MATERIAL_PASS)

layout(std430, binding = 0) readonly buffer ListBegin
{
    uint list_begin[];
};

/* The first entry that is bound, of both arrays. */
uint svo_first_entry()
{
    return svo_first[2] / 2u;
}

/* The array to read from, and the other one to write to. */
uint64_t svo_from(bool forth, uint index)
{
    return forth ? entries[index] : spare[index];
}

void svo_put(bool forth, uint index, uint64_t entry)
{
    if (forth) {
        spare[index] = entry;
    } else {
        entries[index] = entry;
    }
}

/* Merges two neighboring runs into one. SVO_NO_ENTRY ends a run early. Sums up the entries of one material before
   writing them. */
void svo_merge_pair(bool forth, uint begin, uint middle, uint end)
{
    uint a = begin;
    uint b = middle;
    uint written = begin;
    uint64_t open = SVO_NO_ENTRY;
    for (;;) {
        uint64_t first = a < middle ? svo_from(forth, a) : SVO_NO_ENTRY;
        uint64_t second = b < end ? svo_from(forth, b) : SVO_NO_ENTRY;
        uint64_t least = first < second ? first : second;
        if (open != SVO_NO_ENTRY && svo_entry_material(open) != svo_entry_material(least)) {
            svo_put(forth, written, open);
            ++written;
            open = SVO_NO_ENTRY;
        }
        if (least == SVO_NO_ENTRY) {
            break;
        }
        open = open == SVO_NO_ENTRY ? least : open + svo_entry_weight(least);
        a += first == least ? 1u : 0u;
        b += first == least ? 0u : 1u;
    }
    if (written < end) {
        svo_put(forth, written, SVO_NO_ENTRY);
    }
}

#endif

#ifdef SVO_K_MATERIAL_PASS

/* The leaf whose range contains an entry: the last of the window that begins no later. */
uint svo_leaf_of(uint index)
{
    uint leaf = 0u;
    for (uint reach = 0x80000000u; reach != 0u; reach >>= 1) {
        if (reach < window_count - leaf && list_begin[window_begin + leaf + reach - svo_first[0]] <= index) {
            leaf += reach;
        }
    }
    return window_begin + leaf - svo_first[0];
}

/* params.level: log2 of the runs' width. Even levels read entries and write spare. params.fragment_count: the entries
   of the window. */
void main()
{
    if (svo_item() >= params.fragment_count) {
        return;
    }
    uint index = list_begin[window_begin - svo_first[0]] + svo_item();
    uint leaf = svo_leaf_of(index);
    uint width = 1u << params.level;
    uint begin = list_begin[leaf] - svo_first_entry();
    uint end = list_begin[leaf + 1u] - svo_first_entry();
    index -= svo_first_entry();
    if ((index - begin) % (2u * width) == 0u) {
        svo_merge_pair((params.level & 1u) == 0u, index, min(index + width, end), min(index + 2u * width, end));
    }
    svo_check_loops();
}

#endif

#ifdef SVO_K_MATERIAL_LEAVES

layout(std430, binding = 1) writeonly buffer Counts
{
    uint counts[];
};

/* Bottom-up merge sort that alternates between entries and spare. An odd number of passes ends with a copy.
   params.digit_passes: not 0 when other launches have already sorted. */
void main()
{
    uint leaf = window_begin + svo_item();
    if (!svo_in_window(leaf)) {
        return;
    }
    uint begin = list_begin[leaf - svo_first[0]] - svo_first_entry();
    uint end = list_begin[leaf - svo_first[0] + 1u] - svo_first_entry();
    bool forth = true;
    uint unsorted = params.digit_passes != 0u ? 0u : end - begin;
    if (svo_is_long(unsorted)) {
        return;
    }
    for (uint width = 1u; width < unsorted; width *= 2u) {
        for (uint run = begin; run < end; run += 2u * width) {
            svo_merge_pair(forth, run, min(run + width, end), min(run + 2u * width, end));
        }
        forth = !forth;
    }
    uint count = 0u;
    for (uint i = begin; i < end; ++i) {
        uint64_t entry = svo_from(forth, i);
        if (entry == SVO_NO_ENTRY) {
            break;
        }
        entries[i] = entry;
        ++count;
    }
    counts[leaf - svo_first[1]] = count;
    svo_put_material(params.leaf_begin + leaf, svo_heaviest(begin, begin + count), svo_first[4]);
    svo_check_loops();
}

#endif

#if defined(SVO_K_MATERIAL_ROOM) || defined(SVO_K_MATERIAL_MERGE)

layout(std430, binding = 0) readonly buffer Masks
{
    uint masks[];
};
layout(std430, binding = 1) readonly buffer FirstChild
{
    uint first_child[];
};
layout(std430, binding = 3) readonly buffer ChildCounts
{
    uint child_counts[];
};
layout(std430, binding = 6) writeonly buffer Counts
{
    uint counts[];
};

/* Arrays of a level are indexed from its first node. */
uint svo_child_of(uint node)
{
    return first_child[node - svo_first[1]] - params.child_begin;
}

uint svo_children_of(uint node)
{
    return uint(bitCount(masks[node >> 2] >> (8u * (node & 3u)) & 255u));
}

#endif

#ifdef SVO_K_MATERIAL_ROOM

void main()
{
    uint index = window_begin + svo_item();
    if (!svo_in_window(index)) {
        return;
    }
    uint node = params.level_begin + index;
    uint child = svo_child_of(node) - svo_first[3];
    uint children = svo_children_of(node);
    uint sum = 0u;
    for (uint i = 0u; i < children; ++i) {
        sum += child_counts[child + i];
    }
    counts[index - svo_first[6]] = sum;
}

#endif

#ifdef SVO_K_MATERIAL_MERGE

layout(std430, binding = 2) readonly buffer ChildBegins
{
    uint child_begins[];
};
layout(std430, binding = 5) readonly buffer Begins
{
    uint begins[];
};

void main()
{
    uint index = window_begin + svo_item();
    if (!svo_in_window(index)) {
        return;
    }
    uint node = params.level_begin + index;
    uint child = svo_child_of(node);
    uint children = svo_children_of(node);
    uint next[8];
    uint last[8];
    for (uint i = 0u; i < children; ++i) {
        next[i] = child_begins[child + i - svo_first[2]] - svo_first[4] / 2u;
        last[i] = next[i] + child_counts[child + i - svo_first[3]];
    }
    uint begin = begins[index - svo_first[5]] - svo_first[7] / 2u;
    uint end = begin;
    uint64_t open = SVO_NO_ENTRY;
    for (;;) {
        uint chosen = 0u;
        uint64_t least = SVO_NO_ENTRY;
        for (uint i = 0u; i < children; ++i) {
            uint64_t entry = next[i] < last[i] ? child_entries[next[i]] : SVO_NO_ENTRY;
            chosen = entry < least ? i : chosen;
            least = entry < least ? entry : least;
        }
        if (open != SVO_NO_ENTRY && svo_entry_material(open) != svo_entry_material(least)) {
            entries[end] = open;
            ++end;
            open = SVO_NO_ENTRY;
        }
        if (least == SVO_NO_ENTRY) {
            break;
        }
        open = open == SVO_NO_ENTRY ? least : open + svo_entry_weight(least);
        ++next[chosen];
    }
    counts[index - svo_first[6]] = end - begin;
    svo_put_material(node, svo_heaviest(begin, end), svo_first[8]);
    svo_check_loops();
}

#endif
