/* SPDX-License-Identifier: MIT */
/*
 * Per-voxel means as older systems compute them, for comparison with svocl: one work-item per sample, one cell per
 * voxel. The result depends on the order of the work-items.
 *
 * average_rgba8: the running mean of Crassin and Hennessy, "Octree-Based Sparse Voxelization Using the GPU Hardware
 * Rasterizer", OpenGL Insights, 2012: three 8-bit channels and an 8-bit count of samples in one word, updated by
 * compare-and-swap. add_float: float sums, with compare-and-swap on their bits.
 *
 * Both loops end: a failed exchange means that another work-item succeeded.
 */

static uint pack_octets(float4 value)
{
    return ((uint)value.x & 255u) | ((uint)value.y & 255u) << 8 | ((uint)value.z & 255u) << 16 |
           ((uint)value.w & 255u) << 24;
}

static float4 unpack_octets(uint packed)
{
    return (float4)((float)(packed & 255u), (float)(packed >> 8 & 255u), (float)(packed >> 16 & 255u),
                    (float)(packed >> 24));
}

/* samples: x, y, z in 0 .. 255. means: zeros at first. */
__kernel void average_rgba8(__global const uint *cells, __global const float4 *samples, __global uint *means,
                            uint count)
{
    const uint i = get_global_id(0);
    if (i >= count) {
        return;
    }
    const float4 sample = samples[i];
    volatile __global uint *mean = means + cells[i];
    uint expected = 0u;
    uint wanted = pack_octets((float4)(sample.xyz, 1.0f));
    for (uint found = atomic_cmpxchg(mean, expected, wanted); found != expected;
         found = atomic_cmpxchg(mean, expected, wanted)) {
        const float4 before = unpack_octets(found);
        const float weight = before.w + 1.0f;
        expected = found;
        wanted = pack_octets((float4)((before.xyz * before.w + sample.xyz) / weight, weight));
    }
}

static void add_one(volatile __global uint *sum, float value)
{
    uint expected = *sum;
    for (uint found = atomic_cmpxchg(sum, expected, as_uint(as_float(expected) + value)); found != expected;
         found = atomic_cmpxchg(sum, expected, as_uint(as_float(expected) + value))) {
        expected = found;
    }
}

/* sums: four floats per cell, zeros at first; the fourth counts. */
__kernel void add_float(__global const uint *cells, __global const float4 *samples, __global uint *sums, uint count)
{
    const uint i = get_global_id(0);
    if (i >= count) {
        return;
    }
    const float4 sample = samples[i];
    volatile __global uint *sum = sums + 4u * cells[i];
    add_one(sum, sample.x);
    add_one(sum + 1, sample.y);
    add_one(sum + 2, sample.z);
    add_one(sum + 3, 1.0f);
}
