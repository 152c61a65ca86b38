/* SPDX-License-Identifier: MIT */
/*
 * Subdivides top down, level by level: kernels/stages/subdivide.cl in GLSL.
 *
 *   SVO_K_MARK     once: every fragment marks its octant in the root
 *   SVO_K_DESCEND  per level: every fragment moves its cursor to the child and marks its octant there. Nodes of a
 *                  window count from the root
 *
 * Launch: one invocation per fragment of a chunk, rounded up to whole groups. subdivide.cl describes the masks (four
 * per word), why plain reads beside atomicOr suffice, and how invalid fragments are handled.
 */
uniform svo_subdivide_params params;

#ifdef SVO_K_MARK
layout(std430, binding = 1) coherent buffer Masks
{
    uint masks[];
};
layout(std430, binding = 2) buffer State
{
    svo_build_state state;
};
#else
layout(std430, binding = 1) buffer Cursors
{
    uint cursors[];
};
layout(std430, binding = 2) coherent buffer Masks
{
    uint masks[];
};
layout(std430, binding = 3) readonly buffer FirstChild
{
    uint first_child[];
};
layout(std430, binding = 4) readonly buffer State
{
    svo_build_state state;
};
#endif

void svo_mark(uint node, uint octant)
{
    uint bit = 1u << (8u * (node & 3u) + octant);
    if ((masks[node >> 2] & bit) == 0u) {
        atomicOr(masks[node >> 2], bit);
    }
}

#ifdef SVO_K_MARK

void main()
{
    uint index = svo_item();
    if (index < params.fragment_count) {
        svo_code code = svo_fragment_code(index);
        svo_mark(0u, svo_octant(code, params.depth, 0u));
        if (!svo_code_in_grid(code, params.depth) || svo_fragment_triangle(index) >= state.triangle_count) {
            state.overflow = SVO_DAMAGED_LIST;
        }
    }
}

#else

void main()
{
    uint index = svo_item();
    if (index >= params.fragment_count || state.overflow != 0u) {
        return;
    }
    svo_code code = svo_fragment_code(index);
    uint node = params.level == 0u ? 0u : cursors[index];
    if (!svo_in_window(node)) {
        return; /* of another window, or moved by an earlier one */
    }
    uint mask = masks[node >> 2] >> (8u * (node & 3u)) & 255u;
    uint octant = svo_octant(code, params.depth, params.level);
    uint child = first_child[node - svo_first[3]] + uint(bitCount(mask & ((1u << octant) - 1u)));
    cursors[index] = child;
    if (params.level + 1u < params.depth) {
        svo_mark(child, svo_octant(code, params.depth, params.level + 1u));
    }
}

#endif
