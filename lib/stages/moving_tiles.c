/* SPDX-License-Identifier: MIT */
/* Launches kernels/plan/tiles.cl, for each draw of an updatable plan. */
#include "stages/moving_tiles.h"

#include "plan/programs.h"

svo_status svo_i_moving_tiles_make(svo_i_commands *commands, const svo_i_moving_tiles *buffers,
                                   const svo_voxelize_params *params)
{
    cl_program program = NULL;
    const svo_tile_item unused = {commands->plan->class_begin[SVO_I_CLASS_COUNT], 0};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(buffers->vertices),
                                        SVO_I_ARGUMENT(buffers->indices),
                                        SVO_I_ARGUMENT(buffers->items),
                                        SVO_I_ARGUMENT(buffers->tiles),
                                        SVO_I_ARGUMENT(buffers->count),
                                        SVO_I_ARGUMENT(buffers->counters),
                                        SVO_I_ARGUMENT(*params)};
    SVO_I_TRY(svo_i_program_get(commands->device, SVO_I_BUILD, &svo_i_program_plan, "", &program, NULL));
    SVO_I_TRY(svo_i_commands_fill(commands, buffers->tiles, &unused, sizeof unused,
                                  (uint64_t)params->tile_count * sizeof unused));
    SVO_I_TRY(svo_i_commands_fill_zero(commands, buffers->count, sizeof(cl_uint)));
    return svo_i_commands_run(commands, program, "svo_k_plan_tiles", SVO_I_ARGUMENTS(arguments), params->item_count);
}
