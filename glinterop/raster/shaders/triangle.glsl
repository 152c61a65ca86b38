/* SPDX-License-Identifier: MIT */
/*
 * What the vertex and fragment shaders of the raster front end share: uniforms, and the permutation of the axes that
 * puts a triangle's axis of projection last.
 *
 *   axis 2: (u, v, t) = (x, y, z)     axis 0: (y, z, x)     axis 1: (z, x, y)
 *
 * Uniforms: depth (log2 of the voxels per axis), voxel_log2 (log2 of the grid units per voxel), open (1 where a voxel's
 * far faces belong to its neighbors, 0 where coverage is closed), view_origin (the first pixel of this viewport).
 */
#include "shared/span.clh"

uniform int depth;
uniform int voxel_log2;
uniform int open;
uniform ivec2 view_origin;

/* Component k of the permuted p: 0 u, 1 v, 2 t. */
int permuted(ivec3 p, uint axis, int k)
{
    return p[(int(axis) + 1 + k) % 3];
}

svo_point permute(ivec3 p, uint axis)
{
    return svo_make_point(permuted(p, axis, 0), permuted(p, axis, 1), permuted(p, axis, 2));
}
