/* SPDX-License-Identifier: MIT */
/*
 * The material of every node: the one with the largest weight among its triangles, the smallest of equals.
 * kernels/stages/material.cl in GLSL, which describes the entries and why their order does not matter.
 *
 *   SVO_K_MATERIAL_SCATTER  per fragment: writes (material, weight) into its leaf's range of entries, in any order
 *   SVO_K_MATERIAL_LEAVES   per leaf: sorts its entries by material and sums up those of one material
 *   SVO_K_MATERIAL_PASS     per entry: one pass of that merge sort, where a leaf is too long for one invocation
 *                           (compute.glsl)
 *   SVO_K_MATERIAL_MERGE    per node of a level: merges its children's entries, in place of the first child's
 *
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
layout(std430, binding = 5) readonly buffer ListBegin
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
    if (index < params.fragment_count) {
        uint triangle = svo_fragment_triangle(index);
        svo_share share = svo_pair_share(triangle, svo_fragment_code(index));
        uint leaf = cursors[index] - params.leaf_begin;
        uint slot = list_begin[leaf] + atomicAdd(counts[leaf], 1u);
        entries[slot] = uint64_t(records[triangle].material) << SVO_ENTRY_SHIFT | uint64_t(share.weight);
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
#else
layout(std430, binding = 4) readonly buffer ChildEntries
{
    uint64_t spare[]; /* the children's */
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

void svo_put_material(uint node, uint material)
{
    atomicOr(materials[node >> 1], material << (16u * (node & 1u)));
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

#if defined(SVO_K_MATERIAL_LEAVES) || defined(SVO_K_MATERIAL_PASS)

layout(std430, binding = 0) readonly buffer ListBegin
{
    uint list_begin[];
};

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

/* The leaf whose range contains an entry: the last that begins no later. */
uint svo_leaf_of(uint index)
{
    uint leaf = 0u;
    for (uint reach = 0x80000000u; reach != 0u; reach >>= 1) {
        if (reach < params.leaf_count - leaf && list_begin[leaf + reach] <= index) {
            leaf += reach;
        }
    }
    return leaf;
}

/* params.level: log2 of the runs' width. Even levels read entries and write spare. */
void main()
{
    uint index = svo_item();
    if (index >= params.fragment_count) {
        return;
    }
    uint leaf = svo_leaf_of(index);
    uint width = 1u << params.level;
    uint end = list_begin[leaf + 1u];
    if ((index - list_begin[leaf]) % (2u * width) == 0u) {
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
    uint leaf = svo_item();
    if (leaf >= params.leaf_count) {
        return;
    }
    uint begin = list_begin[leaf];
    uint end = list_begin[leaf + 1u];
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
    counts[leaf] = count;
    svo_put_material(params.leaf_begin + leaf, svo_heaviest(begin, begin + count));
    svo_check_loops();
}

#endif

#ifdef SVO_K_MATERIAL_MERGE

layout(std430, binding = 0) readonly buffer Masks
{
    uint masks[];
};
layout(std430, binding = 1) readonly buffer FirstChild
{
    uint first_child[];
};
layout(std430, binding = 2) readonly buffer ChildBegins
{
    uint child_begins[];
};
layout(std430, binding = 3) readonly buffer ChildCounts
{
    uint child_counts[];
};
layout(std430, binding = 5) writeonly buffer Begins
{
    uint begins[];
};
layout(std430, binding = 6) writeonly buffer Counts
{
    uint counts[];
};

/* child_begins and child_counts are indexed from the first node of their level. */
void main()
{
    uint index = svo_item();
    if (index >= params.level_count) {
        return;
    }
    uint node = params.level_begin + index;
    uint child = first_child[node] - params.child_begin;
    uint children = uint(bitCount(masks[node >> 2] >> (8u * (node & 3u)) & 255u));
    uint next[8];
    uint last[8];
    for (uint i = 0u; i < children; ++i) {
        next[i] = child_begins[child + i];
        last[i] = next[i] + child_counts[child + i];
    }
    uint begin = next[0];
    uint end = begin;
    uint64_t open = SVO_NO_ENTRY;
    for (;;) {
        uint chosen = 0u;
        uint64_t least = SVO_NO_ENTRY;
        for (uint i = 0u; i < children; ++i) {
            uint64_t entry = next[i] < last[i] ? spare[next[i]] : SVO_NO_ENTRY;
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
    begins[index] = begin;
    counts[index] = end - begin;
    svo_put_material(node, svo_heaviest(begin, end));
    svo_check_loops();
}

#endif
