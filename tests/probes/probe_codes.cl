/* SPDX-License-Identifier: MIT */
/* Runs kernels/probes/encoding.clh for test_probe_codes: one work-item per value. */
#include "probes/encoding.clh"

/* directions -> the texel of each and the code of it as a normal; and the normal and point that they come back as. */
__kernel void code_directions(__global const float *directions, uint resolution, __global uint *texels,
                              __global uint *normals, __global float *back, __global float *points)
{
    const size_t i = get_global_id(0);
    const float3 direction = vload3(i, directions);
    texels[i] = svo_probe_texel_of(direction, resolution);
    normals[i] = svo_probe_encode_normal(direction);
    vstore3(svo_probe_normal_of(normals[i]), i, back);
    vstore2(svo_octahedral_point(direction), i, points);
}

__kernel void code_vectors(uint resolution, __global int *vectors)
{
    const uint i = (uint)get_global_id(0);
    vstore3(svo_probe_texel_vector(resolution, i % resolution, i / resolution), i, vectors);
}

/* distances, world units -> codes, and back. */
__kernel void code_distances(__global const float *distances, __global const ulong *thresholds,
                             svo_probes_params params, __global uint *codes, __global float *back)
{
    const size_t i = get_global_id(0);
    codes[i] = svo_probe_distance_code(svo_probe_distance_key(distances[i], 1u), thresholds);
    back[i] = svo_probe_distance_of(codes[i], &params);
}

__kernel void code_radiance(__global const float *radiance, __global uint *words, __global float *back)
{
    const size_t i = get_global_id(0);
    words[i] = svo_probe_encode_radiance(vload3(i, radiance));
    vstore3(svo_probe_radiance_of(words[i]), i, back);
}

/* The bits of the double (t |v|)^2, and of squares of scaled coordinates. */
__kernel void make_keys(__global const float *ts, __global const uint *lengths2, int scale_log2, __global ulong *keys,
                        __global ulong *squares)
{
    const size_t i = get_global_id(0);
    keys[i] = svo_probe_distance_key(ts[i], lengths2[i]);
    squares[i] = svo_probe_square_key(ts[i], scale_log2);
}
