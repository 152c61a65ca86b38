/* SPDX-License-Identifier: MIT */
/* Uploads the snapped mesh, and the vertices that rays meet, to the tree's buffers. */
#include "stages/geometry.h"

#include "plan/arrays.h"
#include "stages/snapped_mesh.h"

static svo_status upload_positions(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    svo_tree *tree = build->tree;
    tree->info.positions = SVO_POSITIONS_SNAPPED;
    if (svo_i_plan_has(plan->positions, plan->memory.positions)) {
        tree->info.positions = SVO_POSITIONS_FLOAT;
        return svo_i_commands_take(&build->commands, "positions", plan->positions, plan->memory.positions,
                                   (uint64_t)plan->vertex_count * 12, &tree->buffers[SVO_TREE_POSITIONS]);
    }
    if (svo_i_plan_has(plan->positions_double, plan->memory.positions_double)) {
        tree->info.positions = SVO_POSITIONS_DOUBLE;
        return svo_i_commands_take(&build->commands, "positions_double", plan->positions_double,
                                   plan->memory.positions_double, (uint64_t)plan->vertex_count * 24,
                                   &tree->buffers[SVO_TREE_POSITIONS_DOUBLE]);
    }
    return SVO_OK;
}

/* Moves the snapped mesh to the tree. */
static svo_status take_mesh(svo_i_build *build)
{
    svo_i_snapped_mesh *mesh = &build->commands.mesh;
    if (build->tree->buffers[SVO_TREE_VERTICES] == NULL) { /* else a front end has them there */
        SVO_I_TRY(svo_i_snapped_vertices(&build->commands, &build->tree->buffers[SVO_TREE_VERTICES]));
        mesh->vertices = NULL;
    }
    SVO_I_TRY(svo_i_snapped_indices(&build->commands, &build->tree->buffers[SVO_TREE_INDICES]));
    mesh->indices = NULL;
    return SVO_OK;
}

svo_status svo_i_geometry_upload(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    svo_i_stage_begin(&build->commands);
    SVO_I_TRY(take_mesh(build));
    SVO_I_TRY(svo_i_commands_take(&build->commands, "triangle_ids", plan->triangle_ids, plan->memory.triangle_ids,
                                  (uint64_t)plan->triangle_count * 4, &build->tree->buffers[SVO_TREE_TRIANGLE_IDS]));
    SVO_I_TRY(upload_positions(build));
    build->tree->info.vertex_count = plan->vertex_count;
    build->tree->info.list_triangle_count = plan->triangle_count;
    return svo_i_stage_end(&build->commands, SVO_STAGE_TRANSFER);
}
