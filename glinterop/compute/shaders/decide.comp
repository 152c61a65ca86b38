/* SPDX-License-Identifier: MIT */
/*
 * Decides the fragments that rasterization has left undecided, at the end of a chunk, by the caller's numbers:
 * kernels/stages/decide.cl in GLSL, in integers alone. Those that touch are gathered in a buffer of their own, in any
 * order, which the host copies to the chunk's others.
 *
 * Launch: one invocation per undecided fragment. Atomics: places in that buffer. Axes of the box separate nothing, as a
 * voxel lies inside its triangle's bounds.
 */
#include "shared/exact.clh"

uniform svo_filter_params params;

layout(std430, binding = 1) readonly buffer Positions
{
    uint positions[]; /* floats, or doubles of two words */
};
layout(std430, binding = 2) readonly buffer Indices
{
    uint indices[];
};
layout(std430, binding = 3) readonly buffer Grid
{
    svo_decide_params grid;
};
layout(std430, binding = 4) writeonly buffer Kept
{
    uint kept[];
};
layout(std430, binding = 5) buffer Counters
{
    uint counters[2]; /* fragments that touch; those of triangles that the mesh does not have */
};

/* Coordinate k of a vertex. */
svo_number svo_position(uint vertex, uint k)
{
    uint at = 3u * vertex + k;
    if (grid.is_double != 0u) {
        return svo_number_of_double(positions[2u * at], positions[2u * at + 1u]);
    }
    return svo_number_of_float(positions[at]);
}

bool svo_touches(svo_code code, uint triangle)
{
    svo_number edge = svo_number_of_double(grid.edge[0], grid.edge[1]);
    svo_short width = svo_exact_width(edge, int(grid.depth));
    svo_exact_triangle placed;
    for (int i = 0; i < SVO_TURNS(9); ++i) {
        uint k = uint(i % 3);
        svo_number origin = svo_number_of_double(grid.origin[2u * k], grid.origin[2u * k + 1u]);
        svo_number vertex = svo_position(indices[3u * triangle + uint(i / 3)], k);
        svo_short offset = svo_exact_offset(vertex, origin, svo_exact_unit(edge));
        placed.at[i] = svo_exact_place(offset, grid.corner[k] + uint(svo_code_axis(code, k)), width);
    }
    return svo_exact_touches(placed.at, width, int(grid.coverage), SVO_EXACT_ALL & ~7u);
}

void main()
{
    uint item = svo_item();
    if (item >= params.fragment_count) {
        return;
    }
    uint index = grid.capacity - 1u - item;
    svo_code code = svo_fragment_code(index);
    uint triangle = svo_fragment_triangle(index);
    if (triangle >= uint(indices.length()) / 3u) {
        atomicAdd(counters[1], 1u);
    } else if (svo_touches(code, triangle)) {
        uint place = atomicAdd(counters[0], 1u);
#ifdef SVO_CODE48
        kept[SVO_FRAGMENT_WORDS_48 * place] = code.x;
        kept[SVO_FRAGMENT_WORDS_48 * place + 1u] = code.y;
        kept[SVO_FRAGMENT_WORDS_48 * place + 2u] = triangle;
#else
        kept[SVO_FRAGMENT_WORDS_30 * place] = code;
        kept[SVO_FRAGMENT_WORDS_30 * place + 1u] = triangle;
#endif
    }
}
