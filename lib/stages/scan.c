/* SPDX-License-Identifier: MIT */
/* Scans of list counts and of digit counts. The scans of child masks are in subdivide.c. */
#include "stages/scan.h"

svo_status svo_i_scan_alloc(svo_i_build *build)
{
    return build->partials != NULL
               ? SVO_OK
               : svo_i_commands_alloc(&build->commands, "partials",
                                      build->commands.device->scan_groups * sizeof(cl_uint4), &build->partials);
}

uint32_t svo_i_scan_groups(const svo_device *device, uint64_t numbers)
{
    const uint32_t tile = SVO_SCAN_TILE;
    const uint64_t tiles = (numbers + tile - 1) / tile;
    return (uint32_t)(tiles < 1 ? 1 : tiles > device->scan_groups ? device->scan_groups : tiles);
}

svo_status svo_i_scan_lists(svo_i_build *build, const svo_i_program *program, cl_mem numbers, cl_mem sums, cl_mem state,
                            svo_filter_params params)
{
    svo_i_commands *commands = &build->commands;
    cl_program kernels = svo_i_build_program(build, program);
    params.scan_groups = svo_i_scan_groups(commands->device, params.leaf_count);
    const uint64_t items = (uint64_t)params.scan_groups * SVO_GROUP_ITEMS;
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    const svo_i_argument reduce[] = {SVO_I_ARGUMENT(numbers), SVO_I_ARGUMENT(build->partials), SVO_I_ARGUMENT(state),
                                     SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument partials[] = {SVO_I_ARGUMENT(build->partials), SVO_I_ARGUMENT(sums), SVO_I_ARGUMENT(state),
                                       SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument add[] = {SVO_I_ARGUMENT(numbers), SVO_I_ARGUMENT(build->partials), SVO_I_ARGUMENT(sums),
                                  SVO_I_ARGUMENT(state),   SVO_I_ARGUMENT(params),          scratch};
    SVO_I_TRY(svo_i_commands_run(commands, kernels, "svo_k_scan_lists_reduce", SVO_I_ARGUMENTS(reduce), items));
    SVO_I_TRY(
        svo_i_commands_run(commands, kernels, "svo_k_scan_lists_partials", SVO_I_ARGUMENTS(partials), SVO_GROUP_ITEMS));
    return svo_i_commands_run(commands, kernels, "svo_k_scan_lists_add", SVO_I_ARGUMENTS(add), items);
}
