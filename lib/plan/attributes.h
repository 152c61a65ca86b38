/* SPDX-License-Identifier: MIT */
/*
 * The payload inputs: colors, normals, texture coordinates and materials of the kept triangles; payload that is the
 * same in every node.
 */
#ifndef SVO_LIB_PLAN_ATTRIBUTES_H
#define SVO_LIB_PLAN_ATTRIBUTES_H

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

/* Resolves SVO_NEED_DEFAULT, fills the payload inputs and finds constant payload, on the host. */
svo_status svo_i_plan_attributes(svo_plan *plan, const svo_mesh *mesh);

/* Fills the payload inputs alone. found: all zero but for material_used, which has a byte for each material. */
svo_status svo_i_plan_find(svo_plan *plan, const svo_mesh *mesh, svo_i_findings *found);
/* Whether two triangles have the same normal of their own. */
static inline bool svo_i_same_own_normal(const svo_triangle_record *a, const svo_triangle_record *b)
{
    return a->normal_xy == b->normal_xy && (a->normal_z_flags & 0xffffu) == (b->normal_z_flags & 0xffffu);
}

/* Parts that do not depend on where the mesh is. has_colors, has_uvs: whether the mesh has them. */

void svo_i_plan_resolve_need(svo_plan *plan, const svo_mesh *mesh, bool has_colors);
/* Whether a material names a texture that can be sampled. */
bool svo_i_material_is_textured(const svo_mesh *mesh, bool has_uvs, size_t material);
/* Copies the materials, and the textures of used ones. */
svo_status svo_i_plan_copy_materials(svo_plan *plan, const svo_mesh *mesh, bool has_uvs, const uint8_t *material_used);
/* Where the plan drops pairs by alpha: finds whether there may be any, and what each material shows at least. Frees the
   inputs of colors if there are none and no color is asked for. material_used: a byte for each; unused
   in updatable plans, whose triangles may have any. */
void svo_i_plan_find_dropped(svo_plan *plan, const uint8_t *material_used);
/* The finest unit of weight that suits triangles of that largest area and a sum of projected areas, both in square grid
   units: the weight of a voxel's face, as a power of two. */
uint32_t svo_i_plan_choose_weight_log2(const svo_plan *plan, double largest_area, double total_area);
/* Finds what is constant, and chooses the unit of weights. SVO_INVALID_ARGUMENT: the one asked for is too fine. */
svo_status svo_i_plan_conclude(svo_plan *plan, const svo_i_findings *found);

#endif
