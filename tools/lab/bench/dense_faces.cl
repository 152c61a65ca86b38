/* SPDX-License-Identifier: MIT */
/*
 * A dense pyramid of six directions, as voxel cone tracing keeps it in textures: RGBA8 without direction on the finest
 * level, RGBA8 for rays along +x, -x, +y, -y, +z, -z on all others. Colors are premultiplied.
 *
 * Launch: one work-item per voxel that is written, one dimension, rounded up. Voxel x, y, z of n^3 is at
 * x + n (y + n z). No atomics, no local memory.
 */

/* leaves: Morton codes, three bits to a level. */
__kernel void place_leaves(__global const ulong *codes, __global const uint *colors, uint leaf_count, uint depth,
                           __global uint *voxels)
{
    const uint item = (uint)get_global_id(0);
    uint cell[3] = {0u, 0u, 0u};
    if (item >= leaf_count) {
        return;
    }
    for (uint level = 0u; level < depth; ++level) {
        for (uint axis = 0u; axis < 3u; ++axis) {
            cell[axis] |= (uint)(codes[item] >> (3u * level + axis) & 1ul) << level;
        }
    }
    voxels[(ulong)cell[0] + (((ulong)cell[1] + ((ulong)cell[2] << depth)) << depth)] = colors[item];
}

static uint4 unpack(uint rgba)
{
    return (uint4)(rgba & 255u, rgba >> 8 & 255u, rgba >> 16 & 255u, rgba >> 24);
}

static uint pack(uint4 color)
{
    return color.x | color.y << 8 | color.z << 16 | color.w << 24;
}

/* The mean over four pairs of front + (1 - alpha of the front) back. corner: of eight voxels in an array of n^3. */
static uint merge(__global const uint *voxels, ulong corner, uint n, uint direction)
{
    const ulong strides[3] = {1ul, n, (ulong)n * n};
    const uint axis = direction >> 1;
    const ulong along = strides[axis];
    const ulong u = strides[(axis + 1u) % 3u];
    const ulong v = strides[(axis + 2u) % 3u];
    const ulong front = (direction & 1u) != 0u ? along : 0ul;
    uint4 sum = (uint4)(0u);
    for (uint pair = 0u; pair < 4u; ++pair) {
        const ulong at = corner + (pair & 1u) * u + (pair >> 1) * v;
        const uint4 first = unpack(voxels[at + front]);
        const uint4 second = unpack(voxels[at + along - front]);
        sum += 255u * first + (255u - first.w) * second;
    }
    return pack((sum + 510u) / 1020u);
}

/* One level from the level below. fine_n: voxels along an axis of the latter, whose directions are faces_apart voxels
   apart: 0 for the finest level, which has one array for all. */
__kernel void merge_level(__global const uint *fine, __global uint *coarse, uint fine_n, ulong faces_apart)
{
    const ulong item = get_global_id(0);
    const ulong n = fine_n >> 1;
    if (item >= n * n * n) {
        return;
    }
    const ulong x = item % n;
    const ulong y = item / n % n;
    const ulong z = item / (n * n);
    const ulong corner = 2ul * (x + fine_n * (y + fine_n * z));
    for (uint direction = 0u; direction < 6u; ++direction) {
        coarse[direction * n * n * n + item] = merge(fine + direction * faces_apart, corner, fine_n, direction);
    }
}
