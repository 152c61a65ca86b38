/* SPDX-License-Identifier: MIT */
/*
 * Reads the fragment list like kernels/shared/fragment.clh, without 64-bit integers: a code of 48 bits is two words.
 */
layout(std430, binding = 0) readonly buffer Fragments
{
    uint fragments[];
};

#ifdef SVO_CODE48

#define svo_code uvec2

/* Whether the code is that of a voxel in a grid of this depth, 11 .. 16. */
bool svo_code_in_grid(svo_code code, uint depth)
{
    return code.y >> (3u * depth - 32u) == 0u;
}

svo_code svo_fragment_code(uint index)
{
    return uvec2(fragments[index * SVO_FRAGMENT_WORDS_48], fragments[index * SVO_FRAGMENT_WORDS_48 + 1u]);
}

uint svo_fragment_triangle(uint index)
{
    return fragments[index * SVO_FRAGMENT_WORDS_48 + 2u];
}

/* The octant (x | y << 1 | z << 2) of the voxel below its ancestor on a level. */
uint svo_octant(svo_code code, uint depth, uint level)
{
    uint shift = 3u * (depth - 1u - level); /* never 32 */
    uint low = shift == 0u ? code.x : code.x >> (shift & 31u) | code.y << (32u - shift & 31u);
    return (shift > 31u ? code.y >> (shift & 31u) : low) & 7u;
}

#else

#define svo_code uint

bool svo_code_in_grid(svo_code code, uint depth)
{
    return code >> (3u * depth) == 0u;
}

svo_code svo_fragment_code(uint index)
{
    return fragments[index * SVO_FRAGMENT_WORDS_30];
}

uint svo_fragment_triangle(uint index)
{
    return fragments[index * SVO_FRAGMENT_WORDS_30 + 1u];
}

uint svo_octant(svo_code code, uint depth, uint level)
{
    return code >> (3u * (depth - 1u - level)) & 7u;
}

#endif

/* Every third of 30 bits, packed. */
int svo_pack_thirds(uint bits)
{
    bits &= 0x09249249u;
    bits = (bits | bits >> 2) & 0x030c30c3u;
    bits = (bits | bits >> 4) & 0x0300f00fu;
    bits = (bits | bits >> 8) & 0x030000ffu;
    return int((bits | bits >> 16) & 0x3ffu);
}

/* One coordinate of the voxel. axis: 0 x, 1 y, 2 z. */
int svo_code_axis(svo_code code, uint axis)
{
#ifdef SVO_CODE48
    uint rest = code.x >> 30 | code.y << 2;
    return svo_pack_thirds((code.x & 0x3fffffffu) >> axis) | svo_pack_thirds(rest >> axis) << 10;
#else
    return svo_pack_thirds(code >> axis);
#endif
}
