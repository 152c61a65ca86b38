/* SPDX-License-Identifier: MIT */
/* The time of each stage, from its first to its last command: from OpenCL's events, or from the wall clock. */
#ifndef SVO_LIB_COMMANDS_TIMING_H
#define SVO_LIB_COMMANDS_TIMING_H

#include "commands/commands.h"

SVO_I_SHARED_BEGIN

/* Adds to a stage's time. clock: a static string. */
void svo_i_report_add(svo_build_report *report, svo_stage stage, double ms, const char *clock);

SVO_I_SHARED_END

/* Commands between begin and end are timed as the stage's. A stage may begin several times; its times add up. */
void svo_i_stage_begin(svo_i_commands *commands);
svo_status svo_i_stage_end(svo_i_commands *commands, svo_stage stage);
/* Adds the times of a build that has ended to the report, and releases their events. */
void svo_i_stage_collect(svo_i_commands *commands);

#endif
