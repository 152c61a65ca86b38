/* SPDX-License-Identifier: MIT */
/** \file
 * Records of rays, hits and queries, as they lie in the buffers of trace.h and in kernels of the caller's own. One text
 * for C, C++, OpenCL C and GLSL. Records hold 32-bit integers and floats only, without padding; numbers at the front of
 * comments are offsets in bytes.
 */
#ifndef SVOCL_RAY_TYPES_H
#define SVOCL_RAY_TYPES_H

#include "svocl/record.h"
#include "svocl/tree_types.h"

#define SVO_NO_TRIANGLE 0xffffffffu /**< svo_hit.triangle, svo_nearest.triangle: none */
#define SVO_FACE_NONE   6u /**< svo_voxel_hit.face: the ray begins inside the node */

/** A ray in world coordinates: origin + t * direction for t_min <= t <= t_max. 32 bytes. */
SVO_RECORD(svo_ray)
{
    SVO_F32 origin[3]; /**< 0: world */
    SVO_F32 direction[3]; /**< 12: any length above 0 */
    SVO_F32 t_min; /**< 24: in lengths of direction */
    SVO_F32 t_max; /**< 28: in lengths of direction; infinity allowed */
};

/** The triangle that a ray hit. 32 bytes. */
SVO_RECORD(svo_hit)
{
    SVO_F32 t; /**< 0: in lengths of the ray's direction; infinity: no hit */
    SVO_U32 triangle; /**< 4: its position in the mesh's index array, or SVO_NO_TRIANGLE */
    SVO_F32 u; /**< 8: barycentric weight of the triangle's second corner */
    SVO_F32 v; /**< 12: that of the third; the first has 1 - u - v */
    SVO_F32 normal[3]; /**< 16: unit, by the order of the corners; zero for a triangle without area */
    SVO_U32 count; /**< 28: BVH leaves visited; with SVO_TRACE_COUNT the triangles hit */
};

/** A point whose nearest triangle is asked for. 16 bytes. */
SVO_RECORD(svo_query_point)
{
    SVO_F32 position[3]; /**< 0: world */
    SVO_F32 max_distance; /**< 12: world; triangles farther away are ignored. Infinity allowed */
};

/** The triangle nearest to a point. 32 bytes. */
SVO_RECORD(svo_nearest)
{
    SVO_F32 distance; /**< 0: world; infinity: none */
    SVO_U32 triangle; /**< 4: its position in the mesh's index array, or SVO_NO_TRIANGLE */
    SVO_F32 position[3]; /**< 8: world: the nearest point on it */
    SVO_U32 leaves; /**< 20: BVH leaves visited */
    SVO_U32 reserved[2]; /**< 24: zero */
};

/** The node that a ray hit. 32 bytes. */
SVO_RECORD(svo_voxel_hit)
{
    SVO_F32 t; /**< 0: in lengths of the ray's direction; infinity: no hit */
    SVO_U32 node; /**< 4: into the tree's nodes, or SVO_NO_NODE */
    SVO_U32 level; /**< 8: of the node; a leaf has the tree's depth */
    SVO_U32 face; /**< 12: where the ray entered: 2 * axis, plus 1 for the high side; or SVO_FACE_NONE */
    SVO_F32 normal[3]; /**< 16: of that face, unit; zero with SVO_FACE_NONE */
    SVO_U32 steps; /**< 28: cells visited */
};

/** \cond */
#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_ray, 32);
SVO_ASSERT_BYTES(svo_hit, 32);
SVO_ASSERT_BYTES(svo_query_point, 16);
SVO_ASSERT_BYTES(svo_nearest, 32);
SVO_ASSERT_BYTES(svo_voxel_hit, 32);
#endif
/** \endcond */

#endif
