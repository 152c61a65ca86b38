/* SPDX-License-Identifier: MIT */
/* Compiles and runs the stages that the plan needs. */
#include "build/order.h"

#include <stdlib.h>

#include "plan/configuration.h"
#include "stages/surface.h"

svo_status svo_i_order_get_programs(svo_i_build *build, svo_i_warm_up *warm_up)
{
    static const svo_i_program_kind kinds[] = {SVO_I_PROGRAM_BUILD, SVO_I_PROGRAM_SORT};
    const svo_plan *plan = build->commands.plan;
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        char defines[SVO_I_DEFINES_BYTES];
        bool fresh = false;
        if (svo_i_plan_needs_program(plan, kinds[i])) {
            svo_i_plan_defines(plan, kinds[i], defines, sizeof defines);
            SVO_I_TRY(
                svo_i_program_get(plan->device, SVO_I_BUILD, kinds[i], defines, &build->programs[kinds[i]], &fresh));
        }
        if (fresh) {
            svo_i_warm_up_add_program(warm_up, build->programs[kinds[i]]);
        }
    }
    return SVO_OK;
}

svo_status svo_i_order_run(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    for (size_t i = 0; i < plan->stage_count; ++i) {
        if (plan->stages[i].run != NULL && plan->stages[i].runs(plan)) {
            SVO_I_TRY(plan->stages[i].run(build));
        }
    }
    return SVO_OK;
}

void svo_i_order_release_scratch(svo_i_build *build)
{
    for (uint32_t i = 0; build->cursors != NULL && i < build->list.chunk_count; ++i) {
        svo_i_commands_free(&build->commands, &build->cursors[i]);
    }
    free(build->cursors);
    svo_i_surface_free(build);
    svo_i_commands_free(&build->commands, &build->state);
    svo_i_commands_free(&build->commands, &build->partials);
    svo_i_build_release_list(build);
}
