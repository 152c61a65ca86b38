/* SPDX-License-Identifier: MIT */
/*
 * Reads the implied form of a compact tree (svocl/compact.h, SVO_FORM_IMPLIED) from textures, as
 * kernels/rays/read_implied.clh reads it from buffers. Element i of an array is texel (i & 2047, i >> 11 & 2047) of
 * layer i >> 22. A texel of masks has those of 16 nodes, for which the directory has one entry: a node is opened with
 * two fetches.
 */
precision highp float;
precision highp int;
precision highp sampler2DArray;
precision highp usampler2DArray;

#define CHILD_NONE 0
#define CHILD_NODE 1
#define CHILD_SELF 2 /* the node that was to be opened is a leaf itself */

uniform usampler2DArray masks; /* RGBA32UI */
uniform usampler2DArray directory; /* R32UI: the first child of every 16th node */
uniform sampler2DArray colors; /* RGBA8 */
uniform sampler2DArray normals; /* RG8 */
uniform sampler2DArray light; /* RGBA8: six texels a node, +x, -x, +y, -y, +z, -z; alpha is an exponent, 0: none */
/* The element of a node is at (node - x) * y; nodes before x have none. */
uniform uvec2 colorRange;
uniform uvec2 normalRange;

ivec3 placeTexel(uint index)
{
    return ivec3(uvec3(index & 2047u, index >> 11 & 2047u, index >> 22));
}

/* GLSL ES 3.00 has no bitCount: sums in fields of 2, 4 and 8 bits, then of the bytes. */
uint countBits(uvec4 words)
{
    words -= words >> 1 & 0x55555555u;
    words = (words & 0x33333333u) + (words >> 2 & 0x33333333u);
    words = words + (words >> 4) & 0x0f0f0f0fu;
    return (words.x + words.y + words.z + words.w) * 0x01010101u >> 24;
}

/* The lowest bits of four words that follow each other: count of them. A shift by 32 has no meaning, so each word is
   made of two halves. */
uvec4 lowestBits(int count)
{
    ivec4 inWord = clamp(ivec4(count) - ivec4(0, 32, 64, 96), 0, 32);
    ivec4 low = min(inWord, 16);
    ivec4 high = inWord - low;
    return (uvec4(1u) << low) - 1u | (uvec4(1u) << high) - 1u << 16;
}

/* The child of a node in an octant, and whether there is one: CHILD_*. */
int openNode(uint node, uint octant, out uint child)
{
    uvec4 sixteen = texelFetch(masks, placeTexel(node >> 4), 0);
    uint place = node & 15u;
    uint mask = sixteen[place >> 2] >> (8u * (place & 3u)) & 255u;
    child = 0u;
    if ((mask >> octant & 1u) == 0u) {
        return mask == 0u && node != 0u ? CHILD_SELF : CHILD_NONE;
    }
    uint first = texelFetch(directory, placeTexel(node >> 4), 0).x;
    child = first + countBits(sixteen & lowestBits(int(8u * place + octant)));
    return CHILD_NODE;
}

/* Red, green, blue of a node; false where it has none. */
bool readColor(uint node, out vec3 color)
{
    color = vec3(0.0);
    if (node < colorRange.x) {
        return false;
    }
    color = texelFetch(colors, placeTexel((node - colorRange.x) * colorRange.y), 0).rgb;
    return true;
}

/* How much of a node shows, 0 .. 255; all where nodes have no color. */
uint readAlpha(uint node)
{
    return node < colorRange.x
        ? 255u
        : uint(texelFetch(colors, placeTexel((node - colorRange.x) * colorRange.y), 0).a * 255.0 + 0.5);
}

/* The unit normal of a node from octahedral coordinates; false where it has none. At 0 the sign is +, which sign() does
   not say. */
bool readNormal(uint node, out vec3 normal)
{
    normal = vec3(0.0);
    if (node < normalRange.x) {
        return false;
    }
    vec2 stored = texelFetch(normals, placeTexel((node - normalRange.x) * normalRange.y), 0).rg;
    if (stored == vec2(0.0)) {
        return false;
    }
    vec2 map = (round(255.0 * stored) - 128.0) / 127.0;
    normal = vec3(map, 1.0 - abs(map.x) - abs(map.y));
    if (normal.z < 0.0) {
        vec2 side = vec2(map.x >= 0.0 ? 1.0 : -1.0, map.y >= 0.0 ? 1.0 : -1.0);
        normal.xy = (1.0 - abs(map.yx)) * side;
    }
    normal = normalize(normal);
    return true;
}

/* The node of a cell of a level, or the leaf above it; false: the cell is empty. */
bool findNode(ivec3 cell, int level, out uint node)
{
    node = 0u;
    if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, ivec3(1 << level)))) {
        return false;
    }
    for (int shift = level - 1; shift >= 0; --shift) {
        ivec3 bits = cell >> shift & 1;
        uint child;
        int kind = openNode(node, uint(bits.x | bits.y << 1 | bits.z << 2), child);
        if (kind != CHILD_NODE) {
            return kind == CHILD_SELF;
        }
        node = child;
    }
    return true;
}

/* Three numbers with a shared exponent. */
vec3 unpackLight(vec4 stored)
{
    return stored.rgb * exp2(round(255.0 * stored.a) - 128.0);
}

/* Baked irradiance of a node from one of six directions; false where it has none. */
bool readLight(uint node, int face, out vec3 irradiance)
{
    vec4 stored = texelFetch(light, placeTexel(6u * node + uint(face)), 0);
    irradiance = unpackLight(stored);
    return stored.a > 0.0;
}
