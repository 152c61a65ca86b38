/* SPDX-License-Identifier: MIT */
/** \file
 * Records of scenes (scene.h), as they lie in buffers. One text for C, C++, OpenCL C and GLSL; numbers at the front of
 * comments are offsets in bytes.
 */
#ifndef SVOCL_SCENE_TYPES_H
#define SVOCL_SCENE_TYPES_H

#include "svocl/record.h"

#define SVO_NO_INSTANCE 0xffffffffu /**< svo_scene_hit.instance: none */

/** A placed tree. 52 bytes. */
SVO_RECORD(svo_instance)
{
    SVO_U32 tree; /**< 0: into the scene's trees */
    /** 4: 3 x 4 matrix, row by row: world = matrix * (object, 1), where object is in the tree's world coordinates */
    SVO_F32 transform[12];
};

/** The node that a ray hit in a scene: an svo_voxel_hit, and whose it is. 36 bytes. */
SVO_RECORD(svo_scene_hit)
{
    SVO_F32 t; /**< 0: in lengths of the ray's direction; infinity: no hit */
    SVO_U32 node; /**< 4: into the nodes of the instance's tree, or SVO_NO_NODE */
    SVO_U32 level; /**< 8: of the node; a leaf has the tree's depth */
    SVO_U32 face; /**< 12: of the tree's axes, where the ray entered: 2 * axis, plus 1 for the high side; or 6, none */
    SVO_F32 normal[3]; /**< 16: of that face, world coordinates, unit; zero with SVO_FACE_NONE */
    SVO_U32 steps; /**< 28: cells visited in that tree; 0: no hit */
    SVO_U32 instance; /**< 32: into the scene's instances, or SVO_NO_INSTANCE */
};

/** The triangle that a ray hit in a scene: an svo_hit, and whose it is. 32 bytes. */
SVO_RECORD(svo_scene_triangle_hit)
{
    SVO_F32 t; /**< 0: in lengths of the ray's direction; infinity: no hit */
    SVO_U32 triangle; /**< 4: its position in the index array of the tree's mesh, or SVO_NO_TRIANGLE */
    SVO_F32 u; /**< 8: barycentric weight of the triangle's second corner */
    SVO_F32 v; /**< 12: that of the third; the first has 1 - u - v */
    SVO_F32 normal[3]; /**< 16: world coordinates, unit, by the order of the corners in the object; zero without area */
    SVO_U32 instance; /**< 28: into the scene's instances, or SVO_NO_INSTANCE */
};

/** A light from one direction. 32 bytes. */
SVO_RECORD(svo_scene_light)
{
    SVO_F32 direction[3]; /**< 0: towards the light, any length above 0 */
    SVO_U32 shadows; /**< 12: 1: instances cast shadows in it; 0: they do not */
    SVO_F32 color[3]; /**< 16: linear red, green, blue, not negative; 1 lights a white surface that faces it fully */
    SVO_U32 reserved; /**< 28: zero */
};

/** \cond */
#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_instance, 52);
SVO_ASSERT_BYTES(svo_scene_hit, 36);
SVO_ASSERT_BYTES(svo_scene_triangle_hit, 32);
SVO_ASSERT_BYTES(svo_scene_light, 32);
#endif
/** \endcond */

#endif
