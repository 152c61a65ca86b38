/* SPDX-License-Identifier: MIT */
/*
 * One column of voxels of one triangle: finds the voxels that pass the test of overlap.clh and appends a fragment
 * (Morton code, triangle) for each. These voxels are consecutive because the triangle is convex. Where one of them is
 * undecided, all of them go to the end of the chunk, backwards, and rasterize.c decides.
 *
 * The chunk's counters keep counting when it is full, so the host learns what capacity suffices. Nothing is written
 * past the end.
 */
layout(std430, binding = 3) buffer Counters
{
    uint counters[]; /* of a chunk: decided fragments, undecided ones */
};
layout(std430, binding = 4) writeonly buffer Fragments
{
    uint fragments[];
};

uniform uint chunk;    /* which counters */
uniform uint capacity; /* fragments the chunk holds */

flat in ivec4 corner_a;
flat in ivec4 corner_b;
flat in ivec4 corner_c;
flat in ivec4 first_voxel;
flat in ivec4 last_voxel;

/* Ten bits, two zero bits after each: ...9..8..7..6..5..4..3..2..1..0 */
uint spread(uint bits)
{
    bits = (bits | bits << 16) & 0x030000ffu;
    bits = (bits | bits << 8) & 0x0300f00fu;
    bits = (bits | bits << 4) & 0x030c30c3u;
    return (bits | bits << 2) & 0x09249249u;
}

/* permuted_voxel: u, v, t */
void append(uint slot, ivec3 permuted_voxel)
{
    uint axis = uint(corner_a.w);
    uint at_u = (axis + 1u) % 3u;
    uint at_v = (axis + 2u) % 3u;
    uvec3 voxel = uvec3(permuted_voxel);
    uvec3 low = voxel & 0x3ffu;
    uint code = spread(low.x) << at_u | spread(low.y) << at_v | spread(low.z) << axis;
#ifdef SVO_CODE48
    uvec3 high = voxel >> 10;
    uint rest = spread(high.x) << at_u | spread(high.y) << at_v | spread(high.z) << axis;
    fragments[slot * 3u] = code | rest << 30;
    fragments[slot * 3u + 1u] = rest >> 2;
    fragments[slot * 3u + 2u] = uint(corner_b.w);
#else
    fragments[slot * 2u] = code;
    fragments[slot * 2u + 1u] = uint(corner_b.w);
#endif
}

#ifdef SVO_POINT

void main()
{
    uint slot = atomicAdd(counters[2u * chunk], 1u);
    if (slot < capacity) {
        append(slot, first_voxel.xyz);
    }
}

#else

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy) + view_origin - first_voxel.xy;
    int w = 1 << corner_c.w;
    int u = pixel.x << corner_c.w;
    int v = pixel.y << corner_c.w;
    svo_point a = svo_make_point(corner_a.x, corner_a.y, corner_a.z);
    svo_point b = svo_make_point(corner_b.x, corner_b.y, corner_b.z);
    svo_point c = svo_make_point(corner_c.x, corner_c.y, corner_c.z);
    svo_overlap overlap = svo_make_overlap(a, b, c, w, open, corner_a.w);

    int first = 0;
    uint count = 0u;
    int touches = SVO_TOUCHES_NOT;
    bool inside = pixel.x >= 0 && pixel.y >= 0 && pixel.x <= last_voxel.x && pixel.y <= last_voxel.y;
    if (inside) {
        touches = svo_overlap_column(overlap, u, v);
    }
    if (touches != SVO_TOUCHES_NOT) {
        float reach = max(float(max(abs(a.u), max(abs(b.u), abs(c.u)))),
                          max(float(max(abs(a.v), max(abs(b.v), abs(c.v)))),
                              float(max(abs(a.t), max(abs(b.t), abs(c.t))))));
        svo_slope slope = svo_slope_of(overlap.plane.nu, overlap.plane.nv, overlap.plane.nt);
        svo_span span = svo_column_span(slope, a, u, v, w, last_voxel.z, reach);
        for (int k = span.first; k <= span.last; ++k) {
            int voxel = svo_overlap_voxel(overlap, u, v, k << corner_c.w);
            if (voxel != SVO_TOUCHES_NOT) {
                touches = min(touches, voxel);
                first = count == 0u ? k : first;
                ++count;
            }
        }
    }
    if (count > 0u) {
        bool decided = touches == SVO_TOUCHES;
        uint slot = atomicAdd(counters[2u * chunk + (decided ? 0u : 1u)], count);
        for (uint k = 0u; k < count; ++k) {
            if (slot + k < capacity) {
                append(decided ? slot + k : capacity - 1u - slot - k, first_voxel.xyz + ivec3(pixel, first + int(k)));
            }
        }
    }
}

#endif
