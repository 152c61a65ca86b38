/* SPDX-License-Identifier: MIT */
/*
 * The nearest triangle of each pixel, in three steps over the same triangles: the least distance along the pixel's
 * ray, by an atomic minimum of its bits; of the triangles at that distance the first one; and its hit. So hits are
 * whole, and the same whatever the order of fragments. The ray goes through the pixel's center, as those of OpenCL do
 * (kernels/light/light_view.cl), and photons have the same order.
 */
#define SVO_STEP_DISTANCE 0
#define SVO_STEP_TRIANGLE 1

layout(std430, binding = 3) readonly buffer TriangleIds
{
    uint triangle_ids[];
};
layout(std430, binding = 4) readonly buffer Weights
{
    uint weights[]; /* svo_photon_weight */
};
layout(std430, binding = 5) buffer Nearest
{
    uint nearest[]; /* of a photon: bits of the distance, and the triangle */
};
layout(std430, binding = 6) writeonly buffer Hits
{
    uint hits[]; /* svo_hit */
};

uniform int step_number;

flat in vec3 corner;
flat in vec3 edge_b;
flat in vec3 edge_c;
flat in uint triangle;

/* A photon's number among the band's, by the pixel: tiles in rows, and Morton order in a tile. */
uint photon_of(uvec2 pixel)
{
    uvec2 tile = pixel >> 3;
    uint inside = 0u;
    for (uint bit = 0u; bit < 3u; ++bit) {
        inside |= (pixel.x >> bit & 1u) << 2u * bit | (pixel.y >> bit & 1u) << (2u * bit + 1u);
    }
    return (tile.y * view.z + tile.x) * 64u + inside - view.w;
}

void main()
{
    uvec2 pixel = uvec2(gl_FragCoord.xy) + uvec2(0u, band.x);
    uint photon = photon_of(pixel);
    if (photon >= band.z || weights[2u * photon] == 0u) {
        return;
    }
    vec2 at = vec2(ivec2(2u * pixel + 1u) - ivec2(view.xy)) * vec2(right.w, up.w);
    vec3 across = at.x * right.xyz + at.y * up.xyz;
    vec3 from = (forward.w != 0.0 ? across : vec3(0.0)) - corner;
    vec3 ray = forward.w != 0.0 ? forward.xyz : forward.xyz + across;
    /* After Moller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997. */
    precise vec3 p = cross(ray, edge_c);
    precise vec3 q = cross(from, edge_b);
    precise float determinant = dot(edge_b, p);
    precise float t = dot(edge_c, q) / determinant;
    if (!(t >= 0.0) || isinf(t)) {
        return;
    }
    uint bits = floatBitsToUint(t);
    if (step_number == SVO_STEP_DISTANCE) {
        atomicMin(nearest[2u * photon], bits);
        return;
    }
    if (nearest[2u * photon] != bits) {
        return;
    }
    if (step_number == SVO_STEP_TRIANGLE) {
        atomicMin(nearest[2u * photon + 1u], triangle);
        return;
    }
    if (nearest[2u * photon + 1u] != triangle) {
        return;
    }
    /* The center of a pixel at an edge may lie a little outside. */
    vec2 weight = max(vec2(dot(from, p), dot(ray, q)) / determinant, 0.0);
    weight /= max(weight.x + weight.y, 1.0);
    vec3 normal = normalize(cross(edge_b, edge_c));
    hits[8u * photon] = floatBitsToUint(t * base.w);
    hits[8u * photon + 1u] = triangle_ids[triangle];
    hits[8u * photon + 2u] = floatBitsToUint(weight.x);
    hits[8u * photon + 3u] = floatBitsToUint(weight.y);
    for (uint k = 0u; k < 3u; ++k) {
        hits[8u * photon + 4u + k] = floatBitsToUint(normal[k]);
    }
    hits[8u * photon + 7u] = 0u;
}
