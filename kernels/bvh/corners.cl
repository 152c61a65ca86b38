/* SPDX-License-Identifier: MIT */
/*
 * The corners of triangles for leaves whose floats are in grid units, on devices with fp64: as floats, and as doubles
 * in world units.
 *
 * Launch: one work-item per coordinate, one dimension, rounded up to whole groups. Reads the mesh's vertices, of a kind
 * that svo_positions (tree.h) names. No atomics, no local memory.
 */
#include "bvh/boxes.clh"

#ifdef cl_khr_fp64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

/* grid: its origin, and grid units per world unit. kind: 0: snapped vertices, 1: floats, 2: doubles. */
__kernel void svo_k_bvh_corners(__global const void *vertices, __global float *floats, __global double *doubles,
                                double4 grid, uint kind, uint count)
{
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    const double origin = i % 3u == 0u ? grid.x : i % 3u == 1u ? grid.y : grid.z;
    double at;
    if (kind == 0u) {
        at = origin + (double)((__global const int *)vertices)[i] / grid.w;
    } else if (kind == 1u) {
        at = (double)((__global const float *)vertices)[i];
    } else {
        at = ((__global const double *)vertices)[i];
    }
    doubles[i] = at;
    floats[i] = (float)((at - origin) * grid.w);
}

#endif
