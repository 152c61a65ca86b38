/* SPDX-License-Identifier: MIT */
/* svo_device_warm: compiles what builds of a plan need, before the first of them. */
#include "pipeline/default_frontend.h"
#include "pipeline/measure.h"
#include "plan/accounts.h"

svo_status svo_device_warm(svo_device *device, svo_plan *plan)
{
    static const char function[] = "svo_device_warm";
    if (device == NULL || plan == NULL || plan->device != device) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s", function,
                                 device == NULL ? "device is NULL"
                                 : plan == NULL ? "plan is NULL"
                                                : "plan is of another device");
    }
    svo_status status = SVO_OK;
    svo_frontend *frontend = NULL;
    cl_command_queue queue = NULL;
    svo_build_report discarded = {0};
    SVO_I_TRY(svo_i_default_frontend(device, NULL, &frontend));
    SVO_I_TRY(svo_i_device_queue(device, function, NULL, &queue));
    svo_i_build build = {.commands = svo_i_commands_begin(plan, queue, &discarded), .frontend = frontend};
    build.commands.untimed = true;
    SVO_I_TRY_CLEANUP(svo_i_progress_begin(plan, function, SVO_I_STAGE_BIT(SVO_STAGE_COMPILE)));
    SVO_I_TRY_CLEANUP(svo_i_compile(&build));
    SVO_I_TRY_CLEANUP(svo_i_progress_end(plan, SVO_STAGE_COMPILE));
cleanup:
    svo_i_commands_end(&build.commands);
    return status;
}
