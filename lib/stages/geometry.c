/* SPDX-License-Identifier: MIT */
/* Uploads the snapped mesh to the tree's buffers. */
#include "stages/geometry.h"

svo_status svo_i_geometry_upload(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    svo_i_stage_begin(&build->commands);
    if (build->tree->buffers[SVO_TREE_VERTICES] == NULL) {
        SVO_I_TRY(svo_i_commands_take(&build->commands, "vertices", plan->vertices, plan->memory.vertices,
                                      (uint64_t)plan->vertex_count * 12, &build->tree->buffers[SVO_TREE_VERTICES]));
    }
    SVO_I_TRY(svo_i_commands_take(&build->commands, "indices", plan->indices, plan->memory.indices,
                                  (uint64_t)plan->triangle_count * 12, &build->tree->buffers[SVO_TREE_INDICES]));
    SVO_I_TRY(svo_i_commands_take(&build->commands, "triangle_ids", plan->triangle_ids, plan->memory.triangle_ids,
                                  (uint64_t)plan->triangle_count * 4, &build->tree->buffers[SVO_TREE_TRIANGLE_IDS]));
    build->tree->info.vertex_count = plan->vertex_count;
    build->tree->info.list_triangle_count = plan->triangle_count;
    return svo_i_stage_end(&build->commands, SVO_STAGE_TRANSFER);
}
