/* SPDX-License-Identifier: MIT */
/* Compiles and runs the stages that the plan needs. */
#include "pipeline/order.h"

#include "plan/configuration.h"
#include "stages/inputs.h"

svo_status svo_i_order_get_programs(svo_i_build *build, svo_i_warm_up *warm_up)
{
    const svo_plan *plan = build->commands.plan;
    for (svo_i_program_kind kind = 0; kind < SVO_I_PROGRAM_STAGE_KINDS; ++kind) {
        char defines[SVO_I_DEFINES_BYTES];
        bool fresh = false;
        if (svo_i_plan_needs_program(plan, kind)) {
            svo_i_plan_defines(plan, kind, defines, sizeof defines);
            SVO_I_TRY(svo_i_program_get(plan->device, SVO_I_BUILD, kind, defines, &build->programs[kind], &fresh));
        }
        if (fresh) {
            SVO_I_TRY(svo_i_warm_up_add_program(warm_up, build->programs[kind]));
        }
    }
    return SVO_OK;
}

svo_status svo_i_order_run(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    for (size_t i = 0; i < plan->stage_count; ++i) {
        const svo_i_stage *stage = &plan->stages[i];
        if (stage->run != NULL && stage->runs(plan)) {
            svo_i_commands_stage(&build->commands, stage->stage, stage->item_ns);
            SVO_I_TRY(stage->run(build));
        }
    }
    return SVO_OK;
}

void svo_i_order_release_scratch(svo_i_build *build)
{
    for (uint32_t i = 0; build->cursors != NULL && i < build->list.chunk_count; ++i) {
        svo_i_commands_free(&build->commands, &build->cursors[i]);
    }
    svo_i_free(build->cursors);
    svo_i_surface_free(build);
    svo_i_commands_free(&build->commands, &build->order);
    svo_i_commands_free(&build->commands, &build->state);
    svo_i_commands_free(&build->commands, &build->partials);
    svo_i_build_release_list(build);
}
