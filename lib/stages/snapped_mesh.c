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

/* Uploads an array of so many threes of words, or takes it from the plan's memory, unless that has been done. */
static svo_status take(svo_i_commands *commands, const char *name, const void *host, cl_mem memory, uint64_t count,
                       cl_mem *taken)
{
    return *taken != NULL ? SVO_OK : svo_i_commands_take(commands, name, host, memory, count * 12, taken);
}

svo_status svo_i_snapped_vertices(svo_i_commands *commands, cl_mem *out)
{
    const svo_plan *plan = commands->plan;
    SVO_I_TRY(take(commands, keeps_vertices(plan) ? "vertices" : "mesh_vertices", plan->vertices, plan->memory.vertices,
                   plan->vertex_count, &commands->mesh.vertices));
    *out = commands->mesh.vertices;
    return SVO_OK;
}

svo_status svo_i_snapped_indices(svo_i_commands *commands, cl_mem *out)
{
    const svo_plan *plan = commands->plan;
    SVO_I_TRY(take(commands, keeps_indices(plan) ? "indices" : "mesh_indices", plan->indices, plan->memory.indices,
                   plan->triangle_count, &commands->mesh.indices));
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
