/* SPDX-License-Identifier: MIT */
/* Boxes, spheres and capsules against cubes of voxels, in integers. */
#ifndef SVO_LIB_EDIT_SHAPE_H
#define SVO_LIB_EDIT_SHAPE_H

#include <stdint.h>

#include "core/message.h"
#include "svocl/edit.h"

/* A shape in units of 1/256 of a voxel from the least corner of the edit's cube on: 0 .. 2^29. */
typedef struct svo_i_edit_solid {
    svo_edit_shape kind;
    int64_t begin[3];
    int64_t end[3];
    int64_t radius;
    int64_t low[3]; /* bounds of the whole shape */
    int64_t high[3];
} svo_i_edit_solid;

/* Which of a cube's voxels are inside. */
typedef enum svo_i_edit_side {
    SVO_I_EDIT_OUTSIDE = 0, /* none */
    SVO_I_EDIT_INSIDE, /* all */
    SVO_I_EDIT_CROSSING /* perhaps some */
} svo_i_edit_side;

/* Rounds a step's shape. low, high: of the info. Returns SVO_INVALID_ARGUMENT where a number is out of range. */
svo_status svo_i_edit_solid_read(const char *function, const svo_edit_step *step, const svo_edit_info *info,
                                 const int64_t corner[3], svo_i_edit_solid *out, svo_message *message);

/* cell: the least voxel of a cube of 2^level, from the corner on. margin: INSIDE are cubes around which so many more
   voxels are. */
svo_i_edit_side svo_i_edit_solid_side(const svo_i_edit_solid *solid, const uint32_t cell[3], uint32_t level,
                                      uint32_t margin);

/* The voxels of a cube of four that are inside, as bits by Morton code. */
uint64_t svo_i_edit_solid_mask(const svo_i_edit_solid *solid, const uint32_t cell[3]);

/* The normals of those voxels, at their Morton codes: of the shape's surface where a neighbor behind one of the faces
   is outside, else 0. mask: of the above. */
void svo_i_edit_solid_normals(const svo_i_edit_solid *solid, const uint32_t cell[3], uint64_t mask,
                              uint64_t normals[64]);

#endif
