/* SPDX-License-Identifier: MIT */
/* Payload that is the same in every node. */
#ifndef SVO_LIB_PLAN_CONSTANT_H
#define SVO_LIB_PLAN_CONSTANT_H

#include "plan/plan_data.h"

/* What the kept triangles tell of the payload; found by the host or by kernels. */
typedef struct svo_i_findings {
    double largest_area; /* of a triangle, square grid units */
    bool colors_vary, normals_vary; /* the vertex attributes at the corners, where the plan has them */
    bool own_normals_vary; /* the triangles' own normals */
    uint32_t first_color; /* of the first corner, where the plan has vertex colors */
    int16_t first_normal[4]; /* likewise */
    svo_triangle_record first_record; /* all zero without triangles */
    uint8_t *material_used; /* one byte per material */
} svo_i_findings;

/* Moves vertex colors that are all equal into the materials, and vertex normals into the plan's constant normal. Finds
   the payload that is the same in every node. Frees the inputs that are not needed for it. */
void svo_i_plan_find_constants(svo_plan *plan, const svo_i_findings *found);

#endif
