/* SPDX-License-Identifier: MIT */
/*
 * The payload, bottom up: mean color, mean normal and fill of every node, in integers. kernels/stages/filter.cl in
 * GLSL.
 *
 *   SVO_K_GATHER  per fragment of a chunk: adds its contribution to the sums of its leaf, which start at zero. 64-bit
 *                 sums by 32-bit atomics, with a carry from the low to the high word. The window is one of leaves
 *   SVO_K_FILTER  per node of a level, upwards from the deepest inner one: writes its children's payload and its own
 *                 sums
 *
 * Launch: one invocation per node or fragment. The sums of a node are adjacent: weight, color (four words), normal
 * (three), 64 bits each, as far as the variant has them. Normals and fills are 16-bit numbers, two per word: their
 * arrays start at zero, and an atomicOr writes each number.
 */
#include "leaf_sums.glsl"

#ifdef SVO_K_FILTER
uniform svo_filter_params params; /* attribute.glsl declares it for the other entry points */
#endif

/* The sums of a node. */
struct svo_sums {
    uint64_t weight;
#ifdef SVO_COLOR
    u64vec4 color;
#endif
#ifdef SVO_NORMAL
    u64vec3 normal; /* each plus 32768 times its weight: numbers that are not negative rarely carry to the high word */
#endif
};

svo_sums svo_no_sums()
{
    svo_sums sums;
    sums.weight = uint64_t(0);
#ifdef SVO_COLOR
    sums.color = u64vec4(0);
#endif
#ifdef SVO_NORMAL
    sums.normal = u64vec3(0);
#endif
    return sums;
}

svo_sums svo_join_sums(svo_sums a, svo_sums b)
{
    a.weight += b.weight;
#ifdef SVO_COLOR
    a.color += b.color;
#endif
#ifdef SVO_NORMAL
    a.normal += b.normal;
#endif
    return a;
}

/* 64-bit words of a node's sums, and the offsets of color and normal in them. */
#ifdef SVO_COLOR
#define SVO_NORMAL_SUM 5u
#else
#define SVO_NORMAL_SUM 1u
#endif
#ifdef SVO_NORMAL
#define SVO_SUM_WORDS (SVO_NORMAL_SUM + 3u)
#else
#define SVO_SUM_WORDS SVO_NORMAL_SUM
#endif

#ifdef SVO_K_FILTER

/* The nodes' own sums, from the first of their level on. */
layout(std430, binding = 3) writeonly buffer Sums
{
    uint64_t node_sums[];
};

void svo_store_sums(svo_sums sums, uint node)
{
    uint at = node * SVO_SUM_WORDS - svo_first[3] / 2u;
    node_sums[at] = sums.weight;
#ifdef SVO_COLOR
    node_sums[at + 1u] = sums.color.x;
    node_sums[at + 2u] = sums.color.y;
    node_sums[at + 3u] = sums.color.z;
    node_sums[at + 4u] = sums.color.w;
#endif
#ifdef SVO_NORMAL
    node_sums[at + SVO_NORMAL_SUM] = sums.normal.x;
    node_sums[at + SVO_NORMAL_SUM + 1u] = sums.normal.y;
    node_sums[at + SVO_NORMAL_SUM + 2u] = sums.normal.z;
#endif
}

layout(std430, binding = 0) readonly buffer Masks
{
    uint masks[];
};
layout(std430, binding = 1) readonly buffer FirstChild
{
    uint first_child[];
};

uint svo_first_child(uint node)
{
    return first_child[node - svo_first[1]];
}

uint svo_child_count(uint node)
{
    return uint(bitCount(masks[node >> 2] >> (8u * (node & 3u)) & 255u));
}

#ifdef SVO_COLOR

layout(std430, binding = 4) writeonly buffer Colors
{
    uint colors[];
};

/* (2 s + w) / (2 w), that is s / w rounded half up; w is the sum of alpha, and for alpha the weight. Black if nothing
   shows. Small sums divide in 32 bits. */
uvec4 svo_rounded_color(u64vec4 sum, uint64_t weight)
{
    u64vec4 by = u64vec4(u64vec3(max(sum.w, uint64_t(1))), weight);
    if (max(sum.w, weight) < uint64_t(1 << 22)) {
        return (2u * uvec4(sum) + uvec4(by)) / (2u * uvec4(by));
    }
    return uvec4((sum * uint64_t(2) + by) / (uint64_t(2) * by));
}

/* Alpha is 255 where all shows, and 0 where nothing does, and nowhere else. */
uvec4 svo_mean_color(u64vec4 sum, uint64_t weight)
{
    uvec4 mean = svo_rounded_color(sum, weight);
    mean.w = max(mean.w, sum.w != uint64_t(0) ? 1u : 0u);
    mean.w = min(mean.w, sum.w == uint64_t(255) * weight ? 255u : 254u);
    return mean;
}

#endif

#ifdef SVO_NORMAL

layout(std430, binding = 5) buffer Normals
{
    uint normals[]; /* two numbers per word */
};

/* s / w rounded half up: floor((2 s + w) / (2 w)), where the sum is s + 32768 w. */
int svo_mean_normal(uint64_t sum, uint64_t weight)
{
    if (weight < uint64_t(1 << 14)) {
        return int((2u * uint(sum) + uint(weight)) / (2u * uint(weight))) - 32768;
    }
    return int(uint((sum * uint64_t(2) + weight) / (uint64_t(2) * weight))) - 32768;
}

void svo_put_normal(uint index, int number)
{
    atomicOr(normals[(index >> 1) - svo_first[5]], (uint(number) & 0xffffu) << (16u * (index & 1u)));
}

#endif

#ifdef SVO_FILL

layout(std430, binding = 6) buffer Fills
{
    uint fills[]; /* two numbers per word */
};

/* The surface in 4096ths of a node's face, rounded half up, at most 65535. shift: log2 of the face's weight, minus
   twelve; above 0. */
uint svo_fill_of(uint64_t weight, uint shift)
{
    if (shift > 62u) {
        return 0u;
    }
    uint64_t fill = ((weight >> (shift - 1u)) + uint64_t(1)) >> 1;
    return fill < uint64_t(65535) ? uint(fill) : 65535u;
}

#endif

void svo_store_payload(svo_sums sums, uint node, uint fill_shift)
{
#ifdef SVO_COLOR
    uvec4 mean = svo_mean_color(sums.color, sums.weight);
    colors[node - svo_first[4]] = mean.x | mean.y << 8 | mean.z << 16 | mean.w << 24;
#endif
#ifdef SVO_NORMAL
    svo_put_normal(3u * node, svo_mean_normal(sums.normal.x, sums.weight));
    svo_put_normal(3u * node + 1u, svo_mean_normal(sums.normal.y, sums.weight));
    svo_put_normal(3u * node + 2u, svo_mean_normal(sums.normal.z, sums.weight));
#endif
#ifdef SVO_FILL
    atomicOr(fills[(node >> 1) - svo_first[6]],
             svo_fill_of(sums.weight, fill_shift) << (16u * (node & 1u)));
#endif
}

/* Stores the root's payload, which no level above can do. */
void svo_store_root(svo_sums sums, uint node)
{
    if (node == 0u && sums.weight != uint64_t(0)) {
        svo_store_payload(sums, 0u, params.fill_shift + 2u);
    }
}

#endif

#ifdef SVO_K_GATHER

void svo_add_pair(inout svo_sums sums, uint triangle, svo_code code)
{
    svo_share share = svo_pair_share(triangle, code);
    sums.weight += uint64_t(share.weight);
#ifdef SVO_COLOR
    uvec4 color = svo_surface_color(triangle, share.corners);
    sums.color += uint64_t(share.weight) * u64vec4(color.xyz * color.w, color.w); /* colors weigh by alpha */
#endif
#ifdef SVO_NORMAL
    sums.normal += uint64_t(share.weight) * u64vec3(svo_surface_normal(triangle, share.corners) + 32768);
#endif
}

layout(std430, binding = 1) readonly buffer Cursors
{
    uint cursors[];
};

void main()
{
    uint index = svo_item();
    if (index >= params.fragment_count) {
        return;
    }
    uint triangle = svo_fragment_triangle(index) - first_triangle;
    uint leaf = cursors[index] - params.leaf_begin;
    if (triangle >= triangle_count || !svo_in_window(leaf)) {
        return;
    }
    svo_sums sums = svo_no_sums();
    svo_add_pair(sums, triangle, svo_fragment_code(index));
    uint at = leaf * SVO_SUM_WORDS;
    svo_add_sum(at, sums.weight);
#ifdef SVO_COLOR
    svo_add_sum(at + 1u, sums.color.x);
    svo_add_sum(at + 2u, sums.color.y);
    svo_add_sum(at + 3u, sums.color.z);
    svo_add_sum(at + 4u, sums.color.w);
#endif
#ifdef SVO_NORMAL
    svo_add_sum(at + SVO_NORMAL_SUM, sums.normal.x);
    svo_add_sum(at + SVO_NORMAL_SUM + 1u, sums.normal.y);
    svo_add_sum(at + SVO_NORMAL_SUM + 2u, sums.normal.z);
#endif
}

#endif

#ifdef SVO_K_FILTER

layout(std430, binding = 2) readonly buffer ChildSums
{
    uint64_t child_sums[];
};

svo_sums svo_load_sums(uint node)
{
    uint at = node * SVO_SUM_WORDS - svo_first[2] / 2u;
    svo_sums sums;
    sums.weight = child_sums[at];
#ifdef SVO_COLOR
    sums.color = u64vec4(child_sums[at + 1u], child_sums[at + 2u], child_sums[at + 3u], child_sums[at + 4u]);
#endif
#ifdef SVO_NORMAL
    sums.normal = u64vec3(child_sums[at + SVO_NORMAL_SUM], child_sums[at + SVO_NORMAL_SUM + 1u],
                          child_sums[at + SVO_NORMAL_SUM + 2u]);
#endif
    return sums;
}

/* Sums are indexed from the first node of their level, payload from the root. */
void main()
{
    uint index = window_begin + svo_item();
    if (!svo_in_window(index)) {
        return;
    }
    uint node = params.level_begin + index;
    uint begin = svo_first_child(node);
    uint end = begin + svo_child_count(node);
    svo_sums sums = svo_no_sums();
    for (uint child = begin; child < end; ++child) {
        svo_sums part = svo_load_sums(child - params.child_begin);
        svo_store_payload(part, child, params.fill_shift);
        sums = svo_join_sums(sums, part);
    }
    svo_store_sums(sums, index);
    svo_store_root(sums, node);
}

#endif
