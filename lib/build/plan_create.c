/* SPDX-License-Identifier: MIT */
/* svo_plan_create: creates a plan and predicts what its build allocates. */
#include "build/measure.h"
#include "build/stage_table.h"
#include "plan/plan.h"
#include "plan/progress.h"

svo_status svo_plan_create(svo_device *device, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                           svo_plan **out)
{
    size_t stage_count = 0;
    const svo_i_stage *stages = svo_i_stage_table(&stage_count);
    svo_plan *plan = NULL;
    SVO_I_TRY(svo_i_plan_new(device, mesh, depth, options, stages, stage_count, out != NULL ? &plan : NULL));
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_progress_reach(plan, SVO_STAGE_GRID, 1.0));
    SVO_I_TRY_CLEANUP(svo_i_predict(plan));
    SVO_I_TRY_CLEANUP(svo_i_progress_end(plan, SVO_STAGE_GRID));
    *out = plan;
    return SVO_OK;
cleanup:
    svo_plan_destroy(&plan);
    return status;
}
