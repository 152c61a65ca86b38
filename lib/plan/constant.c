/* SPDX-License-Identifier: MIT */
/*
 * Payload that is the same in the whole scene. It is stored once instead of per node, and no kernel computes it. The
 * mean of equal values, rounded half up, is that value, so every node would have had the stored one.
 */
#include <string.h>

#include "plan/constant.h"
#include "plan/host_copy.h"

/* a * b / 255 per channel, rounded half up, as in kernels/stages/attribute.clh. */
static uint32_t modulate(uint32_t a, uint32_t b)
{
    uint32_t product = 0;
    for (unsigned shift = 0; shift < 32; shift += 8) {
        product |= (2u * (a >> shift & 255u) * (b >> shift & 255u) + 255u) / 510u << shift;
    }
    return product;
}

static void drop(void *host, cl_mem *memory)
{
    svo_i_free(host);
    svo_i_buffer_release(memory);
}

static void fold_colors(svo_plan *plan, const svo_i_findings *found)
{
    if (!svo_i_plan_has(plan->colors, plan->memory.colors) || found->colors_vary) {
        return;
    }
    for (uint32_t i = 0; i < plan->material_count && plan->triangle_count > 0; ++i) {
        plan->materials[i].rgba = modulate(plan->materials[i].rgba, found->first_color);
    }
    drop(plan->colors, &plan->memory.colors);
    plan->colors = NULL;
}

static void fold_normals(svo_plan *plan, const svo_i_findings *found)
{
    static const int16_t none[4] = {0};
    if (!svo_i_plan_has(plan->normals, plan->memory.normals) || found->normals_vary) {
        return;
    }
    if (plan->triangle_count > 0) {
        /* zero normals stand for the triangle's own */
        plan->one_normal = memcmp(found->first_normal, none, sizeof none) != 0;
        memcpy(plan->work.constant_normal, found->first_normal, sizeof plan->work.constant_normal);
    }
    drop(plan->normals, &plan->memory.normals);
    plan->normals = NULL;
}

static bool has_one_color(const svo_plan *plan, const svo_i_findings *found)
{
    if (svo_i_plan_has(plan->colors, plan->memory.colors) || plan->texels != NULL) {
        return false;
    }
    const uint32_t color = plan->materials[found->first_record.material].rgba;
    for (uint32_t i = 0; i < plan->material_count; ++i) {
        if (found->material_used[i] != 0 && plan->materials[i].rgba != color) {
            return false;
        }
    }
    return true;
}

/* Whether the mesh has no vertex normals and all triangles have the same normal. */
static bool has_one_own_normal(const svo_plan *plan, const svo_i_findings *found)
{
    return !svo_i_plan_has(plan->normals, plan->memory.normals) && !found->own_normals_vary;
}

static void free_colors(svo_plan *plan)
{
    svo_i_free(plan->materials);
    drop(plan->uvs, &plan->memory.uvs);
    plan->materials = NULL;
    plan->uvs = NULL;
}

static bool materials_vary(const svo_plan *plan, const svo_i_findings *found)
{
    uint32_t used = 0;
    for (uint32_t i = 0; i < plan->material_count; ++i) {
        used += found->material_used[i] != 0 ? 1u : 0u;
    }
    return used > 1;
}

void svo_i_plan_find_constants(svo_plan *plan, const svo_i_findings *found)
{
    svo_i_work *work = &plan->work;
    const svo_triangle_record *first = &found->first_record; /* all zero without triangles, like the payload */
    fold_colors(plan, found);
    fold_normals(plan, found);
    plan->materials_vary = materials_vary(plan, found);
    if ((plan->info.need & SVO_NEED_COLOR) != 0 && has_one_color(plan, found)) {
        work->constant |= SVO_NEED_COLOR;
        work->constant_color = plan->triangle_count > 0 ? plan->materials[first->material].rgba : 0;
        free_colors(plan);
    }
    if ((plan->info.need & SVO_NEED_NORMAL) != 0 && !plan->one_normal && has_one_own_normal(plan, found)) {
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
