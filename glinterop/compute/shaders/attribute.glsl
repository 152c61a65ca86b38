/* SPDX-License-Identifier: MIT */
/*
 * The contribution of a triangle to a voxel: its weight, and its color and normal at one of its points. The same
 * arithmetic as kernels/stages/attribute.clh, with the same defines; both share the text of clip.clh, which computes
 * the part of a triangle inside a voxel. Needs 64-bit integers.
 *
 * Storage blocks 0 to 7 are the same in all users of this file. vertex_attributes holds the colors of all vertices
 * (RGBA8, one word each), then all normals (int16 x and y, z and 0; two words each; all 0: use the triangle's own),
 * then all u and v (two words each, 65536 = 1). Attributes that the mesh lacks take no space. Of a mesh that is too
 * large for storage blocks they hold a part at a time, and triangles count from the part's first.
 */
#include "shared/fine.clh"

uniform svo_filter_params params;
uniform uint vertex_count;
uniform uint first_triangle; /* triangles of this part of the mesh: the first, and how many */
uniform uint triangle_count;

layout(std430, binding = 2) readonly buffer Vertices
{
    int vertices[]; /* x, y, z of each vertex, snapped; then remainders, two words of each (fine.clh) */
};
layout(std430, binding = 3) readonly buffer Indices
{
    uint indices[]; /* three per triangle */
};
layout(std430, binding = 4) readonly buffer Records
{
    svo_triangle_record records[]; /* one per triangle */
};

#define SVO_WEIGHT_ONE 65536

/* The contribution of a pair: its weight, and its point on the triangle as weights of the corners, which sum up to
   SVO_WEIGHT_ONE. */
struct svo_share {
    uint weight;
    ivec3 corners;
};

uint svo_triangle_axis(svo_triangle_record record)
{
    return record.normal_z_flags >> SVO_TRIANGLE_AXIS_SHIFT & SVO_TRIANGLE_AXIS_MASK;
}

bool svo_triangle_is_flat(svo_triangle_record record)
{
    return (record.normal_z_flags & SVO_TRIANGLE_FLAT) != 0u;
}

/* A third each. */
ivec3 svo_equal_weights()
{
    return ivec3(SVO_WEIGHT_ONE - 2 * (SVO_WEIGHT_ONE / 3), SVO_WEIGHT_ONE / 3, SVO_WEIGHT_ONE / 3);
}

#if defined(SVO_WEIGHTS_AREA) || defined(SVO_WEIGHTS_CENTER) || defined(SVO_AREAS)

/* A vertex in sub-units. */
i64vec3 svo_fine_vertex(uint vertex)
{
    int bits = SVO_SUB_LOG2 - int(params.voxel_log2);
    uint at = vertex * 3u;
    uint place = vertex_count * 3u + vertex * 2u;
    uint64_t remainders = uint64_t(uint(vertices[place])) | uint64_t(uint(vertices[place + 1u])) << 32;
    return i64vec3(svo_fine_coordinate(vertices[at], remainders, 0, bits),
                   svo_fine_coordinate(vertices[at + 1u], remainders, 1, bits),
                   svo_fine_coordinate(vertices[at + 2u], remainders, 2, bits));
}

/* A triangle's corners u, v, t from the voxel's minimum corner, in sub-units, at the front of the polygons; t is its
   axis. */
void svo_load_corners(uint triangle, uint axis, svo_code code)
{
    i64vec3 origin =
        i64vec3(ivec3(svo_code_axis(code, 0u), svo_code_axis(code, 1u), svo_code_axis(code, 2u))) * SVO_SUB_EDGE;
    for (uint i = 0u; i < 3u; ++i) {
        i64vec3 at = svo_fine_vertex(indices[triangle * 3u + i]) - origin;
        corners[3u * i] = axis == 0u ? at.y : axis == 1u ? at.z : at.x;
        corners[3u * i + 1u] = axis == 0u ? at.z : axis == 1u ? at.x : at.y;
        corners[3u * i + 2u] = axis == 0u ? at.x : axis == 1u ? at.y : at.z;
    }
}

#define SVO_WEIGHED_BITS 30

/* Twice the signed area of the triangle of two points and the origin. */
int64_t svo_area_from(ivec2 p, ivec2 q)
{
    return int64_t(p.x) * int64_t(q.y) - int64_t(p.y) * int64_t(q.x);
}

/* GLSL 4.30 has no max of 64-bit integers. */
int64_t svo_not_negative(int64_t number)
{
    return number > int64_t(0) ? number : int64_t(0);
}

ivec2 svo_near_point(int64_t u, int64_t v, int dropped)
{
    return ivec2(int(u >> dropped), int(v >> dropped));
}

/* The u and v of a triangle's corners: clipping overwrites those that are loaded. */
struct svo_corner_points {
    i64vec2 a, b, c;
};

svo_corner_points svo_loaded_points()
{
    return svo_corner_points(i64vec2(corners[0], corners[1]), i64vec2(corners[3], corners[4]),
                             i64vec2(corners[6], corners[7]));
}

/* The barycentric weights of a point; a third each for a triangle without area. */
ivec3 svo_corner_weights(svo_corner_points points, int64_t u, int64_t v)
{
    i64vec2 a = points.a - i64vec2(u, v);
    i64vec2 b = points.b - i64vec2(u, v);
    i64vec2 c = points.c - i64vec2(u, v);
    u64vec2 reach = u64vec2(abs(a)) | u64vec2(abs(b)) | u64vec2(abs(c));
    int dropped = svo_bits_beyond(reach.x | reach.y, SVO_WEIGHED_BITS);
    ivec2 p = svo_near_point(a.x, a.y, dropped);
    ivec2 q = svo_near_point(b.x, b.y, dropped);
    ivec2 r = svo_near_point(c.x, c.y, dropped);
    int64_t part_x = svo_area_from(q, r);
    int64_t part_y = svo_area_from(r, p);
    int64_t part_z = svo_area_from(p, q);
    int64_t area = part_x + part_y + part_z;
    if (area == int64_t(0)) {
        return svo_equal_weights();
    }
    int64_t side = area < int64_t(0) ? int64_t(-1) : int64_t(1);
    part_x = svo_not_negative(part_x * side);
    part_y = svo_not_negative(part_y * side);
    part_z = svo_not_negative(part_z * side);
    uint64_t total = uint64_t(part_x + part_y + part_z);
    /* Sixteen significant bits suffice and allow a 32-bit division. */
    int shift = svo_bits_beyond(total, 16);
    uint whole = uint(total >> shift);
    int second = int((uint(part_y >> shift) << 16) / whole);
    int third = int((uint(part_z >> shift) << 16) / whole);
    return ivec3(SVO_WEIGHT_ONE - second - third, second, third);
}

#endif

svo_share svo_pair_share(uint triangle, svo_code code)
{
    svo_share share = svo_share(1u, svo_equal_weights());
#if defined(SVO_WEIGHTS_AREA)
    svo_triangle_record record = records[triangle];
    svo_load_corners(triangle, svo_triangle_axis(record), code);
    svo_corner_points points = svo_loaded_points();
    svo_part part = svo_clip();
    share.weight = svo_part_weight(part.doubled_area, record.stretch, params.weight_log2);
    if (!svo_triangle_is_flat(record)) {
        share.corners = svo_corner_weights(points, part.u, part.v);
    }
#elif defined(SVO_WEIGHTS_CENTER)
    svo_triangle_record record = records[triangle];
    if (!svo_triangle_is_flat(record)) {
        svo_load_corners(triangle, svo_triangle_axis(record), code);
        share.corners = svo_corner_weights(svo_loaded_points(), SVO_SUB_EDGE / int64_t(2), SVO_SUB_EDGE / int64_t(2));
    }
#endif
    return share;
}

/* The offsets of a vertex's attributes. */
#if defined(SVO_VERTEX_COLOR) || defined(SVO_VERTEX_NORMAL) || defined(SVO_TEXTURE)

layout(std430, binding = 5) readonly buffer VertexAttributes
{
    uint vertex_attributes[];
};

uint svo_normal_words(uint vertex)
{
#ifdef SVO_VERTEX_COLOR
    return vertex_count + 2u * vertex;
#else
    return 2u * vertex;
#endif
}

uint svo_uv_words(uint vertex)
{
#ifdef SVO_VERTEX_NORMAL
    return svo_normal_words(vertex_count) + 2u * vertex;
#else
    return svo_normal_words(vertex);
#endif
}

#endif

int svo_blend(int a, int b, int c, ivec3 weights)
{
    return int((int64_t(a) * int64_t(weights.x) + int64_t(b) * int64_t(weights.y) + int64_t(c) * int64_t(weights.z) +
                int64_t(SVO_WEIGHT_ONE / 2)) >> 16);
}

/* SVO_K_GATHER alone reads colors; drivers count the blocks of all that is declared. */
#if defined(SVO_COLOR) && defined(SVO_K_GATHER)

layout(std430, binding = 6) readonly buffer Materials
{
    svo_material_record materials[];
};

uvec4 svo_unpack(uint rgba)
{
    return uvec4(rgba, rgba >> 8, rgba >> 16, rgba >> 24) & 255u;
}

/* a * b / 255 per channel, rounded half up. */
uvec4 svo_modulate(uvec4 a, uvec4 b)
{
    return (2u * a * b + 255u) / 510u;
}

#ifdef SVO_TEXTURE

layout(std430, binding = 7) readonly buffer Texels
{
    uint texels[];
};

/* Texels go on in the blocks that are left, each of 2^texel_block_log2 of them. */
uniform uint texel_block_log2;

layout(std430, binding = 8) readonly buffer Texels1
{
    uint texels_1[];
};
layout(std430, binding = 10) readonly buffer Texels2
{
    uint texels_2[];
};
layout(std430, binding = 11) readonly buffer Texels3
{
    uint texels_3[];
};
layout(std430, binding = 12) readonly buffer Texels4
{
    uint texels_4[];
};
layout(std430, binding = 13) readonly buffer Texels5
{
    uint texels_5[];
};
layout(std430, binding = 14) readonly buffer Texels6
{
    uint texels_6[];
};

uint svo_texel(uint at)
{
    uint inside = at & ((1u << texel_block_log2) - 1u);
    switch (at >> texel_block_log2) {
    case 0u:
        return texels[inside];
    case 1u:
        return texels_1[inside];
    case 2u:
        return texels_2[inside];
    case 3u:
        return texels_3[inside];
    case 4u:
        return texels_4[inside];
    case 5u:
        return texels_5[inside];
    default:
        return texels_6[inside];
    }
}

/* The texel's index along one axis of a texture. GLSL leaves the remainder of negative numbers undefined. */
uint svo_wrap_texel(int texel, int texel_count, uint wrap)
{
    if (wrap == 1u) {
        return uint(clamp(texel, 0, texel_count - 1));
    }
    int period = wrap == 2u ? 2 * texel_count : texel_count;
    int inside = texel >= 0 ? texel % period : period - 1 - (-1 - texel) % period;
    return uint(inside < texel_count ? inside : period - 1 - inside);
}

/* A texel, its red, green and blue times alpha. */
uvec4 svo_weighed_texel(uint at)
{
    uvec4 color = svo_unpack(svo_texel(at));
    return uvec4(color.xyz * color.w, color.w);
}

/* Bilinear filter with eight bits of position between texels, rounded half up. Texels weigh by alpha.
   u, v: 65536 = 1. */
uvec4 svo_sample(svo_material_record material, int u, int v)
{
    int64_t x = ((int64_t(u) * int64_t(material.width) * int64_t(256) + int64_t(32768)) >> 16) - int64_t(128);
    int64_t y = ((int64_t(v) * int64_t(material.height) * int64_t(256) + int64_t(32768)) >> 16) - int64_t(128);
    uint x0 = svo_wrap_texel(int(x >> 8), int(material.width), material.wrap_u);
    uint x1 = svo_wrap_texel(int(x >> 8) + 1, int(material.width), material.wrap_u);
    uint y0 = svo_wrap_texel(int(y >> 8), int(material.height), material.wrap_v);
    uint y1 = svo_wrap_texel(int(y >> 8) + 1, int(material.height), material.wrap_v);
    uint row0 = material.texel_offset + y0 * material.width;
    uint row1 = material.texel_offset + y1 * material.width;
    uint fx = uint(x & int64_t(255));
    uint fy = uint(y & int64_t(255));
    uvec4 upper = svo_weighed_texel(row0 + x0) * (256u - fx) + svo_weighed_texel(row0 + x1) * fx;
    uvec4 lower = svo_weighed_texel(row1 + x0) * (256u - fx) + svo_weighed_texel(row1 + x1) * fx;
    uvec4 sum = upper * (256u - fy) + lower * fy;
    return uvec4((sum.xyz + (sum.w >> 1)) / max(sum.w, 1u), (sum.w + 32768u) >> 16);
}

uvec4 svo_texture_color(svo_material_record material, uint triangle, ivec3 weights)
{
    uint a = svo_uv_words(indices[triangle * 3u]);
    uint b = svo_uv_words(indices[triangle * 3u + 1u]);
    uint c = svo_uv_words(indices[triangle * 3u + 2u]);
    int u = svo_blend(int(vertex_attributes[a]), int(vertex_attributes[b]), int(vertex_attributes[c]), weights);
    int v = svo_blend(int(vertex_attributes[a + 1u]), int(vertex_attributes[b + 1u]), int(vertex_attributes[c + 1u]),
                      weights);
    return svo_sample(material, u, v);
}

#endif

uvec4 svo_surface_color(uint triangle, ivec3 weights)
{
    svo_material_record material = materials[records[triangle].material];
    uvec4 color = svo_unpack(material.rgba);
#ifdef SVO_VERTEX_COLOR
    uvec4 a = svo_unpack(vertex_attributes[indices[triangle * 3u]]);
    uvec4 b = svo_unpack(vertex_attributes[indices[triangle * 3u + 1u]]);
    uvec4 c = svo_unpack(vertex_attributes[indices[triangle * 3u + 2u]]);
    uvec4 blend = (a * uint(weights.x) + b * uint(weights.y) + c * uint(weights.z) + uint(SVO_WEIGHT_ONE / 2)) >> 16;
    color = svo_modulate(color, blend);
#endif
#ifdef SVO_TEXTURE
    if (material.width != 0u) {
        color = svo_modulate(color, svo_texture_color(material, triangle, weights));
    }
#endif
    return color;
}

#endif

#ifdef SVO_NORMAL

int svo_low_half(uint word)
{
    return bitfieldExtract(int(word), 0, 16);
}

int svo_high_half(uint word)
{
    return int(word) >> 16;
}

ivec3 svo_own_normal(svo_triangle_record record)
{
    return ivec3(svo_low_half(record.normal_xy), svo_high_half(record.normal_xy), svo_low_half(record.normal_z_flags));
}

#ifdef SVO_VERTEX_NORMAL

ivec3 svo_vertex_normal(uint vertex, ivec3 own)
{
    uint words = svo_normal_words(vertex);
    uint xy = vertex_attributes[words];
    ivec3 normal = ivec3(svo_low_half(xy), svo_high_half(xy), svo_low_half(vertex_attributes[words + 1u]));
    return normal == ivec3(0) ? own : normal;
}

#endif

ivec3 svo_surface_normal(uint triangle, ivec3 weights)
{
    ivec3 own = svo_own_normal(records[triangle]);
#ifdef SVO_VERTEX_NORMAL
    ivec3 a = svo_vertex_normal(indices[triangle * 3u], own);
    ivec3 b = svo_vertex_normal(indices[triangle * 3u + 1u], own);
    ivec3 c = svo_vertex_normal(indices[triangle * 3u + 2u], own);
    return ivec3(svo_blend(a.x, b.x, c.x, weights), svo_blend(a.y, b.y, c.y, weights),
                 svo_blend(a.z, b.z, c.z, weights));
#else
    return own;
#endif
}

#endif
