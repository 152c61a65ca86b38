/* SPDX-License-Identifier: MIT */
/*
 * Times of stages. Where the queue takes them, their events are kept, and svo_i_stage_collect reads them after the
 * build. A blocking build on another queue waits at the end of each stage, if someone asks for its time, and any
 * blocking build does so that has a callback to tell.
 */
#include "commands/timing.h"

void svo_i_report_add(svo_build_report *report, svo_stage stage, double ms, const char *clock)
{
    report->stage_times[stage].ms += ms;
    report->stage_times[stage].clock = clock;
}

void svo_i_stage_begin(svo_i_commands *commands)
{
    if (commands->stage_first != NULL) {
        clReleaseEvent(commands->stage_first);
        commands->stage_first = NULL;
    }
    commands->stage_start_ms = svo_i_now_ms();
}

/* Milliseconds from the start of the first to the end of the last command; negative if profiling has no figures. */
static double event_span_ms(cl_event first, cl_event last)
{
    cl_ulong start = 0;
    cl_ulong end = 0;
    if (clGetEventProfilingInfo(first, CL_PROFILING_COMMAND_START, sizeof start, &start, NULL) != CL_SUCCESS ||
        clGetEventProfilingInfo(last, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL) != CL_SUCCESS || end < start) {
        return -1.0;
    }
    return (double)(end - start) * 1e-6;
}

/* Keeps the current stage's events for svo_i_stage_collect. Where that cannot be, its time is not reported. */
static void keep_span(svo_i_commands *commands, svo_stage stage)
{
    if (commands->span_count < SVO_I_SPANS_MAX && commands->profiling && !commands->untimed &&
        clRetainEvent(commands->last) == CL_SUCCESS) {
        commands->spans[commands->span_count++] = (svo_i_span){stage, commands->stage_first, commands->last};
    } else {
        clReleaseEvent(commands->stage_first);
    }
    commands->stage_first = NULL;
}

void svo_i_stage_collect(svo_i_commands *commands)
{
    for (size_t i = 0; i < commands->span_count; ++i) {
        const svo_i_span *span = &commands->spans[i];
        const double ms = event_span_ms(span->first, span->last);
        if (ms >= 0.0) {
            svo_i_report_add(commands->report, span->stage, ms, "cl-event");
        }
        clReleaseEvent(span->first);
        clReleaseEvent(span->last);
    }
    commands->span_count = 0;
}

/* Takes the time of a stage that has ended now. */
static svo_status end_and_wait(svo_i_commands *commands, svo_stage stage)
{
    SVO_I_TRY(svo_i_commands_wait(commands));
    const double span = commands->profiling ? event_span_ms(commands->stage_first, commands->last) : -1.0;
    if (span >= 0.0) {
        svo_i_report_add(commands->report, stage, span, "cl-event");
    } else {
        svo_i_report_add(commands->report, stage, svo_i_now_ms() - commands->stage_start_ms, "wall");
    }
    clReleaseEvent(commands->stage_first);
    commands->stage_first = NULL;
    return svo_i_commands_tell(commands);
}

svo_status svo_i_stage_end(svo_i_commands *commands, svo_stage stage)
{
    if (commands->stage_first == NULL) {
        return SVO_OK;
    }
    if (commands->mode == SVO_I_MODE_ENQUEUE) {
        keep_span(commands, stage);
        return SVO_OK;
    }
    if (commands->plan->progress.callback != NULL || !(commands->profiling || commands->untimed)) {
        return end_and_wait(commands, stage);
    }
    if (commands->span_count == SVO_I_SPANS_MAX) {
        SVO_I_TRY(svo_i_commands_wait(commands));
        svo_i_stage_collect(commands);
    }
    keep_span(commands, stage);
    return SVO_OK;
}
