/* SPDX-License-Identifier: MIT */
/* Uploads the snapped mesh, and the vertices that rays meet, to the tree's buffers. */
#include "stages/geometry.h"

static svo_status upload_positions(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    svo_tree *tree = build->tree;
    tree->info.positions = SVO_POSITIONS_SNAPPED;
    if (plan->positions != NULL) {
        tree->info.positions = SVO_POSITIONS_FLOAT;
        return svo_i_commands_upload(&build->commands, "positions", plan->positions, (uint64_t)plan->vertex_count * 12,
                                     &tree->buffers[SVO_TREE_POSITIONS]);
    }
    if (plan->positions_double != NULL) {
        tree->info.positions = SVO_POSITIONS_DOUBLE;
        return svo_i_commands_upload(&build->commands, "positions_double", plan->positions_double,
                                     (uint64_t)plan->vertex_count * 24, &tree->buffers[SVO_TREE_POSITIONS_DOUBLE]);
    }
    return SVO_OK;
}

svo_status svo_i_geometry_upload(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    svo_i_stage_begin(&build->commands);
    if (build->tree->buffers[SVO_TREE_VERTICES] == NULL) {
        SVO_I_TRY(svo_i_commands_upload(&build->commands, "vertices", plan->vertices, (uint64_t)plan->vertex_count * 12,
                                        &build->tree->buffers[SVO_TREE_VERTICES]));
    }
    SVO_I_TRY(svo_i_commands_upload(&build->commands, "indices", plan->indices, (uint64_t)plan->triangle_count * 12,
                                    &build->tree->buffers[SVO_TREE_INDICES]));
    SVO_I_TRY(svo_i_commands_upload(&build->commands, "triangle_ids", plan->triangle_ids,
                                    (uint64_t)plan->triangle_count * 4, &build->tree->buffers[SVO_TREE_TRIANGLE_IDS]));
    SVO_I_TRY(upload_positions(build));
    build->tree->info.vertex_count = plan->vertex_count;
    build->tree->info.list_triangle_count = plan->triangle_count;
    return svo_i_stage_end(&build->commands, SVO_STAGE_TRANSFER);
}
