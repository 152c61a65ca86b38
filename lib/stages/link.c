/* SPDX-License-Identifier: MIT */
/* Launches kernels/stages/link.cl for one chunk. */
#include "stages/link.h"

svo_status svo_i_link(svo_i_build *build, cl_kernel kernel, uint32_t chunk, cl_mem heads, svo_filter_params params)
{
    svo_i_commands *commands = &build->commands;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->cursors[chunk]), SVO_I_ARGUMENT(heads),
                                        SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(params)};
    svo_i_stage_begin(commands);
    SVO_I_TRY(svo_i_commands_fill_zero(commands, heads, params.leaf_count * UINT64_C(4)));
    SVO_I_TRY(svo_i_commands_launch(commands, kernel, SVO_I_ARGUMENTS(arguments), params.fragment_count));
    return svo_i_stage_end(commands, SVO_STAGE_LINK);
}
