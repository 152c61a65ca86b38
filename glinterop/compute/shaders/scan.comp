/* SPDX-License-Identifier: MIT */
/*
 * Exclusive sums in three passes, reduce, partials, add: kernels/stages/scan.cl in GLSL.
 *
 * Sums over a level's masks launch one group per range of the level. Only the device knows the number of nodes, so the
 * partials pass of one level writes the launch of the next (SVO_K_SCAN_MASKS_PARTIALS, Launches). Sums over the leaf
 * lists, or over the entries of a level's nodes (material.comp), launch SVO_SCAN_GROUPS groups.
 */
#define SVO_ITEM_ELEMENTS 16u
#define SVO_TILE_ELEMENTS (uint(SVO_GROUP_ITEMS) * SVO_ITEM_ELEMENTS)
#define SVO_ITEM_PARTIALS uint(SVO_SCAN_GROUPS / SVO_GROUP_ITEMS)

shared uint scratch[SVO_GROUP_ITEMS];

/* Exclusive sum over the group's items. total: the sum of all. */
uint svo_group_exclusive(uint value, out uint total)
{
    uint item = gl_LocalInvocationID.x;
    uint sum = value;
    scratch[item] = sum;
    barrier();
    for (uint reach = 1u; reach < uint(SVO_GROUP_ITEMS); reach *= 2u) {
        uint before = item >= reach ? scratch[max(item, reach) - reach] : 0u;
        barrier();
        sum += before;
        scratch[item] = sum;
        barrier();
    }
    total = scratch[SVO_GROUP_ITEMS - 1];
    barrier();
    return sum - value;
}

/* For count elements: the tiles of a range, and the number of ranges that have any. */
uint svo_tiles_per_group(uint count)
{
    uint tiles = count / SVO_TILE_ELEMENTS + (count % SVO_TILE_ELEMENTS != 0u ? 1u : 0u);
    return (tiles + uint(SVO_SCAN_GROUPS) - 1u) / uint(SVO_SCAN_GROUPS);
}

uint svo_groups_of(uint count)
{
    uint elements = svo_tiles_per_group(count) * SVO_TILE_ELEMENTS;
    return elements == 0u ? 0u : count / elements + (count % elements != 0u ? 1u : 0u);
}

/* First and one past last element of this group. */
uvec2 svo_group_range(uint count)
{
    uint elements = svo_tiles_per_group(count) * SVO_TILE_ELEMENTS;
    uint first = min(gl_WorkGroupID.x * elements, count);
    return uvec2(first, min(first + elements, count));
}

#if defined(SVO_K_SCAN_MASKS_REDUCE) || defined(SVO_K_SCAN_MASKS_ADD)

uniform svo_subdivide_params params;

layout(std430, binding = 0) readonly buffer Masks
{
    uint masks[];
};

/* The masks of four nodes, starting at node. Masks at and past end are 0. */
uint svo_four_masks(uint node, uint end)
{
    uint shift = 8u * (node & 3u);
    uint low = masks[node >> 2] >> shift;
    uint high = masks[(node >> 2) + 1u] << (32u - shift & 31u);
    uint four = shift == 0u ? low : low | high;
    uint left = end > node ? end - node : 0u;
    return left >= 4u ? four : four & ((1u << (8u * left)) - 1u);
}

#endif

#if defined(SVO_K_SCAN_LISTS_REDUCE) || defined(SVO_K_SCAN_LISTS_ADD)

layout(std430, binding = 0) readonly buffer Counts
{
    uint counts[];
};

/* The number of an element of the window. */
uint svo_count_of(uint element)
{
    return counts[window_begin + element - svo_first[0]];
}

#endif

#if defined(SVO_K_SCAN_MASKS_REDUCE) || defined(SVO_K_SCAN_LISTS_REDUCE)

layout(std430, binding = 1) writeonly buffer Partials
{
    uint partials[];
};

void svo_store_partial(uint sum)
{
    uint total;
    svo_group_exclusive(sum, total);
    if (gl_LocalInvocationID.x == 0u) {
        partials[gl_WorkGroupID.x] = total;
    }
}

#endif

#ifdef SVO_K_SCAN_MASKS_REDUCE

layout(std430, binding = 2) readonly buffer State
{
    svo_build_state state;
};

void main()
{
    uint begin = state.level_begin[params.level];
    uvec2 range = svo_group_range(state.level_begin[params.level + 1u] - begin);
    uint sum = 0u;
    for (uint i = range.x + gl_LocalInvocationID.x * 4u; i < range.y; i += uint(SVO_GROUP_ITEMS) * 4u) {
        sum += uint(bitCount(svo_four_masks(begin + i, begin + range.y)));
    }
    svo_store_partial(sum);
}

#endif

#ifdef SVO_K_SCAN_LISTS_REDUCE

void main()
{
    uvec2 range = svo_group_range(window_count);
    uint sum = 0u;
    for (uint i = range.x + gl_LocalInvocationID.x; i < range.y; i += uint(SVO_GROUP_ITEMS)) {
        sum += svo_count_of(i);
    }
    svo_store_partial(sum);
}

#endif

#if defined(SVO_K_SCAN_MASKS_PARTIALS) || defined(SVO_K_SCAN_LISTS_PARTIALS)

layout(std430, binding = 0) buffer Partials
{
    uint partials[];
};

/* Replaces partials by their exclusive sums plus base, in place. Returns the sum of all. One group. */
uint svo_scan_partials(uint partial_count, uint base)
{
    uint first = gl_LocalInvocationID.x * SVO_ITEM_PARTIALS;
    uint sums[SVO_ITEM_PARTIALS];
    uint sum = 0u;
    for (uint k = 0u; k < SVO_ITEM_PARTIALS; ++k) {
        sums[k] = sum;
        sum += first + k < partial_count ? partials[first + k] : 0u;
    }
    uint total;
    uint before = svo_group_exclusive(sum, total);
    for (uint k = 0u; k < SVO_ITEM_PARTIALS; ++k) {
        partials[first + k] = base + before + sums[k];
    }
    return total;
}

#endif

#ifdef SVO_K_SCAN_MASKS_PARTIALS

uniform svo_subdivide_params params;

layout(std430, binding = 1) buffer State
{
    svo_build_state state;
};
/* The groups of the passes over each level, three words per level. */
layout(std430, binding = 2) writeonly buffer Launches
{
    uint launches[];
};

/* The total is where the level below the children begins. */
void main()
{
    uint child_begin = state.level_begin[params.level + 1u];
    uint count = child_begin - state.level_begin[params.level];
    uint overflow = state.overflow;
    uint total = svo_scan_partials(overflow != 0u ? 0u : svo_groups_of(count), child_begin);
    if (gl_LocalInvocationID.x == 0u && overflow == 0u) {
        uint child_end = child_begin + total;
        state.level_begin[params.level + 2u] = child_end;
        bool inner = params.level + 1u < params.depth;
        bool fits = child_end >= child_begin && !(inner && child_end > params.inner_capacity);
        state.overflow = fits ? 0u : params.level + 1u;
        launches[3u * (params.level + 1u)] = fits ? svo_groups_of(total) : 0u;
    }
}

#endif

#ifdef SVO_K_SCAN_LISTS_PARTIALS

layout(std430, binding = 1) buffer ListBegin
{
    uint list_begin[];
};

/* A window begins where the one before it ends. */
void main()
{
    uint begin = window_begin - svo_first[1];
    uint base = window_begin > 0u ? list_begin[begin] : 0u;
    uint total = svo_scan_partials(svo_groups_of(window_count), base);
    if (gl_LocalInvocationID.x == 0u) {
        list_begin[begin + window_count] = base + total;
    }
}

#endif

#ifdef SVO_K_SCAN_MASKS_ADD

layout(std430, binding = 1) readonly buffer Partials
{
    uint partials[];
};
layout(std430, binding = 2) writeonly buffer FirstChild
{
    uint first_child[];
};
layout(std430, binding = 3) readonly buffer State
{
    svo_build_state state;
};

/* A tile: each item owns sixteen consecutive nodes. */
void main()
{
    uint begin = state.level_begin[params.level];
    uvec2 range = svo_group_range(state.level_begin[params.level + 1u] - begin);
    uint sum = partials[gl_WorkGroupID.x];
    for (uint tile = range.x; tile < range.y; tile += SVO_TILE_ELEMENTS) {
        uint first = tile + gl_LocalInvocationID.x * SVO_ITEM_ELEMENTS;
        uint words[4];
        uint own = 0u;
        for (uint k = 0u; k < 4u; ++k) {
            words[k] = svo_four_masks(begin + first + 4u * k, begin + range.y);
            own += uint(bitCount(words[k]));
        }
        uint total;
        uint prefix = sum + svo_group_exclusive(own, total);
        for (uint k = 0u; k < SVO_ITEM_ELEMENTS; ++k) {
            uint node = begin + first + k;
            if (first + k < range.y && svo_in_window(node)) {
                first_child[node - svo_first[2]] = prefix;
            }
            prefix += uint(bitCount(words[k >> 2] >> (8u * (k & 3u)) & 255u));
        }
        sum += total;
    }
}

#endif

#ifdef SVO_K_SCAN_LISTS_ADD

layout(std430, binding = 1) readonly buffer Partials
{
    uint partials[];
};
layout(std430, binding = 2) writeonly buffer ListBegin
{
    uint list_begin[];
};

void main()
{
    uvec2 range = svo_group_range(window_count);
    uint sum = partials[gl_WorkGroupID.x];
    for (uint tile = range.x; tile < range.y; tile += SVO_TILE_ELEMENTS) {
        uint first = tile + gl_LocalInvocationID.x * SVO_ITEM_ELEMENTS;
        uint lengths[SVO_ITEM_ELEMENTS];
        uint own = 0u;
        for (uint k = 0u; k < SVO_ITEM_ELEMENTS; ++k) {
            lengths[k] = first + k < range.y ? svo_count_of(first + k) : 0u;
            own += lengths[k];
        }
        uint total;
        uint prefix = sum + svo_group_exclusive(own, total);
        for (uint k = 0u; k < SVO_ITEM_ELEMENTS; ++k) {
            if (first + k < range.y) {
                list_begin[window_begin + first + k - svo_first[2]] = prefix;
            }
            prefix += lengths[k];
        }
        sum += total;
    }
}

#endif
