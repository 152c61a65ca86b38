/* SPDX-License-Identifier: MIT */
/* Uploads the snapped mesh, under a name that says which stages it is for. */
#include "stages/snapped_mesh.h"

/* Whether a stage after the voxelizer reads the array. */
static bool keeps_vertices(const svo_plan *plan)
{
    return plan->work.lists || (plan->work.surface && plan->work.positions);
}

static bool keeps_indices(const svo_plan *plan)
{
    return plan->work.lists || plan->work.surface;
}

svo_status svo_i_snapped_vertices(svo_i_commands *commands, cl_mem *out)
{
    const svo_plan *plan = commands->plan;
    if (commands->mesh.vertices == NULL) {
        SVO_I_TRY(svo_i_commands_take(commands, keeps_vertices(plan) ? "vertices" : "mesh_vertices", plan->vertices,
                                      plan->memory.vertices, (uint64_t)plan->vertex_count * 12,
                                      &commands->mesh.vertices));
    }
    *out = commands->mesh.vertices;
    return SVO_OK;
}

svo_status svo_i_snapped_indices(svo_i_commands *commands, cl_mem *out)
{
    const svo_plan *plan = commands->plan;
    if (commands->mesh.indices == NULL) {
        SVO_I_TRY(svo_i_commands_take(commands, keeps_indices(plan) ? "indices" : "mesh_indices", plan->indices,
                                      plan->memory.indices, (uint64_t)plan->triangle_count * 12,
                                      &commands->mesh.indices));
    }
    *out = commands->mesh.indices;
    return SVO_OK;
}

void svo_i_snapped_mesh_listed(svo_i_commands *commands)
{
    if (!keeps_vertices(commands->plan)) {
        svo_i_commands_free(commands, &commands->mesh.vertices);
    }
    if (!keeps_indices(commands->plan)) {
        svo_i_commands_free(commands, &commands->mesh.indices);
    }
}

void svo_i_snapped_mesh_free(svo_i_commands *commands)
{
    svo_i_commands_free(commands, &commands->mesh.vertices);
    svo_i_commands_free(commands, &commands->mesh.indices);
}
