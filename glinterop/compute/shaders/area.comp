/* SPDX-License-Identifier: MIT */
/*
 * The leaves' projected areas. kernels/stages/area.clh in GLSL, which describes them.
 *
 *   SVO_K_AREA         per fragment of a chunk: adds what the triangle shows inside the voxel to the sums of its leaf,
 *                      which start at zero
 *   SVO_K_ROUND_AREAS  per leaf, after all chunks: writes its six numbers, which are three words
 *
 * Launch: one invocation per fragment or leaf. A leaf has six sums of 64 bits.
 */
#include "leaf_sums.glsl"

#ifdef SVO_K_AREA

layout(std430, binding = 1) readonly buffer Cursors
{
    uint cursors[];
};

/* The triangle's normal: fine.clh. */
i64vec3 svo_triangle_normal(uint triangle)
{
    i64vec3 first = svo_fine_vertex(indices[triangle * 3u]);
    i64vec3 p = svo_fine_vertex(indices[triangle * 3u + 1u]) - first;
    i64vec3 q = svo_fine_vertex(indices[triangle * 3u + 2u]) - first;
    int64_t edges[6] = int64_t[6](p.x, p.y, p.z, q.x, q.y, q.z);
    svo_fine_normal made = svo_make_fine_normal(edges);
    return i64vec3(made.x, made.y, made.z);
}

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
    uint axis = svo_triangle_axis(records[triangle]);
    i64vec3 normal = svo_triangle_normal(triangle);
    int64_t largest = axis == 0u ? normal.x : axis == 1u ? normal.y : normal.z;
    if (largest == int64_t(0)) {
        return; /* a segment or a point */
    }
    svo_load_corners(triangle, axis, svo_fragment_code(index));
    svo_part part = svo_clip();
    uint at = leaf * 6u;
    for (uint i = 0u; i < 3u; ++i) {
        int64_t n = i == 0u ? normal.x : i == 1u ? normal.y : normal.z;
        uint64_t seen = uint64_t(svo_part_seen(part.doubled_area, svo_cut_share(int64_t(0), largest, n)));
        if (params.both_sides != 0u || n < int64_t(0)) {
            svo_add_sum(at + 2u * i, seen);
        }
        if (params.both_sides != 0u || n > int64_t(0)) {
            svo_add_sum(at + 2u * i + 1u, seen);
        }
    }
}

#endif

#ifdef SVO_K_ROUND_AREAS

layout(std430, binding = 9) readonly buffer AreaSums
{
    uint64_t area_sums[];
};
layout(std430, binding = 10) writeonly buffer Areas
{
    uint areas[]; /* two numbers per word */
};

void main()
{
    uint leaf = window_begin + svo_item();
    if (!svo_in_window(leaf)) {
        return;
    }
    for (uint word = 3u * leaf; word < 3u * leaf + 3u; ++word) {
        uint sum = 2u * word - svo_first[9] / 2u;
        uint low = svo_projected_area(area_sums[sum]);
        uint high = svo_projected_area(area_sums[sum + 1u]);
        areas[word - svo_first[10]] = low | high << 16;
    }
}

#endif
