/* SPDX-License-Identifier: MIT */
/* Hands the newest event from one piece of an update to the next. */
#include "moving/chain.h"

#include <stdio.h>

#include "commands/commands.h"
#include "plan/configuration.h"

svo_status svo_i_moving_program(const svo_moving *moving, const char *function, cl_program *out)
{
    char of_filter[SVO_I_DEFINES_BYTES] = "";
    char defines[SVO_I_DEFINES_BYTES + 16];
    svo_i_plan_defines(&moving->whole, SVO_I_PROGRAM_FILTER, of_filter, sizeof of_filter);
    (void)snprintf(defines, sizeof defines, " -DSVO_SORT%s", of_filter);
    return svo_i_program_get(moving->device, function, SVO_I_PROGRAM_MOVING, defines, out, NULL);
}

svo_status svo_i_chain_begin(svo_i_chain *chain, const svo_moving *moving, svo_i_device_work *work)
{
    SVO_I_TRY(svo_i_work_begin(moving->device, chain->function, chain->queue, work));
    SVO_I_TRY(svo_i_moving_program(moving, chain->function, &work->program));
    work->last = chain->last;
    chain->last = NULL;
    return SVO_OK;
}

svo_status svo_i_chain_end(svo_i_chain *chain, svo_i_device_work *work, svo_status status)
{
    if (status == SVO_OK && chain->waits) {
        status = svo_i_work_wait(work);
    }
    if (status == SVO_OK && !chain->waits) {
        svo_i_work_leave(work, &chain->last);
    } else {
        svo_i_work_end(work);
    }
    return status;
}

svo_i_commands svo_i_chain_begin_commands(svo_i_chain *chain, svo_plan *plan, svo_build_report *report)
{
    svo_i_commands commands = svo_i_commands_begin(plan, chain->queue, report);
    commands.mode = chain->waits ? SVO_I_MODE_RUN : SVO_I_MODE_ENQUEUE;
    commands.untimed = true;
    commands.last = chain->last;
    chain->last = NULL;
    return commands;
}

void svo_i_chain_end_commands(svo_i_chain *chain, svo_i_commands *commands, svo_status status)
{
    if (status == SVO_OK && !chain->waits) {
        chain->last = commands->last;
        commands->last = NULL;
    }
    svo_i_commands_end(commands);
    svo_i_stage_collect(commands);
}

void svo_i_chain_settle(svo_i_chain *chain)
{
    if (chain->last != NULL) {
        (void)svo_i_event_settle(chain->last);
        clReleaseEvent(chain->last);
        chain->last = NULL;
    }
}
