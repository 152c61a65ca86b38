/* SPDX-License-Identifier: MIT */
/*
 * Fetches a triangle and positions a primitive that covers every pixel whose column of voxels the triangle can touch:
 *
 *   SVO_POINT  one pixel (GL_POINTS)
 *   bounds     for needles, triangles without area and those that reach outside the grid: a right triangle around the
 *              bounding rectangle or, where that is thinner, around a band along the longest edge, so that the cost of
 *              a needle grows with its length
 *   otherwise  the triangle with its edges moved outwards by SVO_REACH pixels along each axis, after Hasselgren,
 *              Akenine-Moller and Ohlsson, "Conservative Rasterization", GPU Gems 2, 2005
 *
 * Each item has three vertices (a point has one), pulled from storage blocks. All outputs are flat.
 *
 * SVO_REACH is half a pixel (0 where the hardware rasterizes conservatively) plus a margin of 1/16 pixel. The margin
 * covers two roundings: of positions to the rasterizer's sub-pixel grid, which is 1/256 pixel or coarser, and of the
 * float arithmetic here, which no hardware knows of. Positions are below 2^14 pixels and exact to 2^-9.
 */
layout(std430, binding = 0) readonly buffer Vertices
{
    int vertices[];
};
layout(std430, binding = 1) readonly buffer Indices
{
    uint indices[];
};
layout(std430, binding = 2) readonly buffer Items
{
    svo_draw_item items[];
};

uniform uint first_item;
uniform int view_log2; /* log2 of the viewport's pixels per axis */

flat out ivec4 corner_a;    /* u, v, t in units from the first voxel's corner; w: axis of projection */
flat out ivec4 corner_b;    /* w: the triangle */
flat out ivec4 corner_c;    /* w: log2 of the units per voxel */
flat out ivec4 first_voxel; /* u, v, t in voxels */
flat out ivec4 last_voxel;  /* u, v, t in voxels from the first */

ivec3 fetch(uint triangle, uint corner)
{
    uint vertex = indices[triangle * 3u + corner] * 3u;
    return ivec3(vertices[vertex], vertices[vertex + 1u], vertices[vertex + 2u]);
}

/* The position of corner b after the edges a-b and b-c have moved outwards. In pixels. */
vec2 expand(vec2 a, vec2 b, vec2 c)
{
    vec2 n = vec2(b.y - a.y, a.x - b.x);
    vec2 m = vec2(c.y - b.y, b.x - c.x);
    float cross_z = n.x * m.y - n.y * m.x;
    float side = cross_z < 0.0 ? -1.0 : 1.0;
    float reach = side * SVO_REACH;
    float n_reach = reach * (abs(n.x) + abs(n.y));
    float m_reach = reach * (abs(m.x) + abs(m.y));
    return b + vec2(n_reach * m.y - m_reach * n.y, m_reach * n.x - n_reach * m.x) / cross_z;
}

vec2 longer(vec2 a, vec2 b)
{
    return max(abs(a.x), abs(a.y)) < max(abs(b.x), abs(b.y)) ? b : a;
}

/* A corner of a triangle that covers all pixels a-b-c touches: (0, 0), (2, 0) and (0, 2) of its bounding rectangle, or
   of the band, which is the rectangle sheared along the longest edge. size: of the rectangle. In pixels.

   The center of a touched pixel is at most half a pixel away along either axis, so at most one from the band's line. A
   quarter pixel is reserved for the sub-pixel grid, and 2^-19 of the largest coordinate for the float arithmetic here
   and in clipping. */
vec2 bound(vec2 a, vec2 b, vec2 c, vec2 size, uint corner)
{
    vec2 edge = longer(longer(b - a, c - b), a - c);
    bool steep = abs(edge.y) > abs(edge.x);
    a = steep ? a.yx : a;
    b = steep ? b.yx : b;
    c = steep ? c.yx : c;
    edge = steep ? edge.yx : edge;
    size = steep ? size.yx : size;

    vec2 largest = max(abs(a), max(abs(b), abs(c)));
    float reach = 1.25 + max(largest.x, largest.y) * 1.9073486e-6;
    float slope = edge.x != 0.0 ? edge.y / edge.x : 0.0;
    vec3 above = vec3(a.y - slope * a.x, b.y - slope * b.x, c.y - slope * c.x);
    float low = min(above.x, min(above.y, above.z)) - reach;
    float height = max(above.x, max(above.y, above.z)) + reach - low;
    bool is_band = height < size.y;

    float along = corner == 1u ? 2.0 * size.x : 0.0;
    float across = corner == 2u ? 2.0 : 0.0;
    vec2 placed = vec2(along, is_band ? low + slope * along + across * height : across * size.y);
    return steep ? placed.yx : placed;
}

ivec4 coarse(svo_point p, int dropped, int w)
{
    p = svo_coarse_point(p, dropped);
    return ivec4(p.u, p.v, p.t, w);
}

vec2 pixels(svo_point p)
{
    return vec2(p.u, p.v) / float(1 << voxel_log2);
}

void main()
{
#ifdef SVO_POINT
    uint corner = 0u;
    svo_draw_item item = items[first_item + uint(gl_VertexID)];
#else
    uint corner = uint(gl_VertexID) % 3u;
    svo_draw_item item = items[first_item + uint(gl_VertexID) / 3u];
#endif
    uint axis = item.flags & SVO_DRAW_AXIS_MASK;
    ivec3 a = fetch(item.triangle, 0u);
    ivec3 b = fetch(item.triangle, 1u);
    ivec3 c = fetch(item.triangle, 2u);
    ivec3 limit = ivec3((1 << depth) - 1);
    ivec3 first = clamp((min(a, min(b, c)) - (1 - open)) >> voxel_log2, ivec3(0), limit);
    ivec3 last = clamp(max(a, max(b, c)) >> voxel_log2, ivec3(0), limit) - first;
    ivec3 base = first << voxel_log2;
    svo_point local[3] =
        svo_point[3](permute(a - base, axis), permute(b - base, axis), permute(c - base, axis));
    svo_point start = permute(first, axis);
    svo_point extent = permute(last, axis);

    int dropped = svo_dropped_bits(max(last.x, max(last.y, last.z)), voxel_log2);
    corner_a = coarse(local[0], dropped, int(axis));
    corner_b = coarse(local[1], dropped, int(item.triangle));
    corner_c = coarse(local[2], dropped, voxel_log2 - dropped);
    first_voxel = ivec4(start.u, start.v, start.t, 0);
    last_voxel = ivec4(extent.u, extent.v, extent.t, 0);

    vec2 position;
#ifdef SVO_POINT
    position = vec2(0.5);
    gl_PointSize = 1.0;
#else
    vec2 p = pixels(local[0]);
    vec2 q = pixels(local[1]);
    vec2 r = pixels(local[2]);
    if ((item.flags & SVO_DRAW_BOUNDS) != 0u) {
        position = bound(p, q, r, vec2(extent.u + 1, extent.v + 1), corner);
    } else {
        position = corner == 0u ? expand(r, p, q) : corner == 1u ? expand(p, q, r) : expand(q, r, p);
    }
#endif
    vec2 ndc = (position + vec2(ivec2(start.u, start.v) - view_origin)) * (2.0 / float(1 << view_log2)) - 1.0;
    gl_Position = vec4(ndc, 0.0, 1.0);
}
