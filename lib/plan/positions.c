/* SPDX-License-Identifier: MIT */
/*
 * Keeps the mesh's own vertices beside the snapped ones. Voxels are those of the snapped mesh; rays need no integers
 * and meet the mesh as it was given.
 */
#include "plan/positions.h"

#include <string.h>

/* Copies the elements of a vertex for each corner; vertices without a triangle stay 0, since they may not be finite. */
static void copy_used(const svo_plan *plan, const void *from, void *to, size_t vertex_bytes)
{
    for (size_t i = 0; i < (size_t)plan->triangle_count * 3; ++i) {
        const size_t at = plan->indices[i] * vertex_bytes;
        memcpy((char *)to + at, (const char *)from + at, vertex_bytes);
    }
}

svo_status svo_i_plan_positions(svo_plan *plan, const svo_mesh *mesh)
{
    if ((plan->info.need & SVO_NEED_RAYS) == 0 || plan->info.coverage == SVO_COVERAGE_THIN) {
        return SVO_OK;
    }
    const bool is_double = mesh->positions_double != NULL;
    const size_t vertex_bytes = is_double ? 3 * sizeof(double) : 3 * sizeof(float);
    void *copy = svo_i_alloc_zeroed(&plan->device->memory, (size_t)plan->vertex_count + 1, vertex_bytes);
    if (copy == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY,
                                 "svo_plan_create: no memory for the positions of %u vertices", plan->vertex_count);
    }
    if (is_double) {
        plan->positions_double = copy;
        copy_used(plan, mesh->positions_double, copy, vertex_bytes);
    } else {
        plan->positions = copy;
        copy_used(plan, mesh->positions, copy, vertex_bytes);
    }
    return SVO_OK;
}
