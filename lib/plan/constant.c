/* SPDX-License-Identifier: MIT */
/*
 * Payload that is the same in the whole scene. It is stored once instead of per node, and no kernel computes it. The
 * mean of equal values, rounded half up, is that value, so every node would have had the stored one.
 */
#include <string.h>

#include "plan/constant.h"

/* Whether visit returns true for every corner of the kept triangles. first: the first corner's vertex. */
static bool every_corner(const svo_plan *plan, bool (*visit)(const svo_plan *plan, uint32_t vertex, uint32_t first))
{
    const size_t corners = (size_t)plan->triangle_count * 3;
    for (size_t i = 0; i < corners; ++i) {
        if (!visit(plan, plan->indices[i], plan->indices[0])) {
            return false;
        }
    }
    return true;
}

static bool same_color(const svo_plan *plan, uint32_t vertex, uint32_t first)
{
    return plan->colors[vertex] == plan->colors[first];
}

static bool same_normal(const svo_plan *plan, uint32_t vertex, uint32_t first)
{
    const size_t bytes = 4 * sizeof(int16_t);
    return memcmp(plan->normals + (size_t)vertex * 4, plan->normals + (size_t)first * 4, bytes) == 0;
}

/* a * b / 255 per channel, rounded half up, as in kernels/stages/attribute.clh. */
static uint32_t modulate(uint32_t a, uint32_t b)
{
    uint32_t product = 0;
    for (unsigned shift = 0; shift < 32; shift += 8) {
        product |= (2u * (a >> shift & 255u) * (b >> shift & 255u) + 255u) / 510u << shift;
    }
    return product;
}

void svo_i_plan_fold_colors(svo_plan *plan)
{
    if (plan->colors == NULL || !every_corner(plan, same_color)) {
        return;
    }
    for (uint32_t i = 0; i < plan->material_count && plan->triangle_count > 0; ++i) {
        plan->materials[i].rgba = modulate(plan->materials[i].rgba, plan->colors[plan->indices[0]]);
    }
    svo_i_free(plan->colors);
    plan->colors = NULL;
}

void svo_i_plan_fold_normals(svo_plan *plan)
{
    static const int16_t none[4] = {0};
    if (plan->normals == NULL || !every_corner(plan, same_normal)) {
        return;
    }
    if (plan->triangle_count > 0) {
        const int16_t *normal = plan->normals + (size_t)plan->indices[0] * 4;
        plan->one_normal = memcmp(normal, none, sizeof none) != 0; /* zero normals stand for the triangle's own */
        memcpy(plan->work.constant_normal, normal, sizeof plan->work.constant_normal);
    }
    svo_i_free(plan->normals);
    plan->normals = NULL;
}

static bool has_one_color(const svo_plan *plan)
{
    if (plan->colors != NULL || plan->texels != NULL) {
        return false;
    }
    const uint32_t color = plan->materials[plan->records[0].material].rgba;
    for (uint32_t t = 0; t < plan->triangle_count; ++t) {
        if (plan->materials[plan->records[t].material].rgba != color) {
            return false;
        }
    }
    return true;
}

static bool same_own_normal(const svo_triangle_record *a, const svo_triangle_record *b)
{
    return a->normal_xy == b->normal_xy && (a->normal_z_flags & 0xffffu) == (b->normal_z_flags & 0xffffu);
}

/* Whether the mesh has no vertex normals and all triangles have the same normal. */
static bool has_one_own_normal(const svo_plan *plan)
{
    for (uint32_t t = 0; t < plan->triangle_count && plan->normals == NULL; ++t) {
        if (!same_own_normal(&plan->records[t], &plan->records[0])) {
            return false;
        }
    }
    return plan->normals == NULL;
}

static void free_colors(svo_plan *plan)
{
    svo_i_free(plan->materials);
    svo_i_free(plan->uvs);
    plan->materials = NULL;
    plan->uvs = NULL;
}

void svo_i_plan_find_constants(svo_plan *plan)
{
    svo_i_work *work = &plan->work;
    const svo_triangle_record *first = &plan->records[0]; /* all zero without triangles, like the payload */
    if ((plan->info.need & SVO_NEED_COLOR) != 0 && has_one_color(plan)) {
        work->constant |= SVO_NEED_COLOR;
        work->constant_color = plan->triangle_count > 0 ? plan->materials[first->material].rgba : 0;
        free_colors(plan);
    }
    if ((plan->info.need & SVO_NEED_NORMAL) != 0 && !plan->one_normal && has_one_own_normal(plan)) {
        plan->one_normal = true;
        work->constant_normal[0] = (int16_t)(first->normal_xy & 0xffffu);
        work->constant_normal[1] = (int16_t)(first->normal_xy >> 16);
        work->constant_normal[2] = (int16_t)(first->normal_z_flags & 0xffffu);
    }
    work->constant |= plan->one_normal ? (uint32_t)SVO_NEED_NORMAL : 0u;
    if ((plan->info.need & SVO_NEED_MATERIAL) != 0 && !plan->materials_vary) {
        work->constant |= SVO_NEED_MATERIAL;
        work->constant_material = (uint16_t)first->material;
    }
    plan->info.constant = work->constant;
}
