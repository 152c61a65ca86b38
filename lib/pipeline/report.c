/* SPDX-License-Identifier: MIT */
/* Writing build reports, and reading their stage times. */
#include "pipeline/report.h"

#include "core/struct_size.h"

_Static_assert(SVO_STAGE_COUNT <= SVO_STAGE_CAPACITY, "a report has room for every stage");

const char *svo_stage_name(svo_stage stage)
{
    static const char *const names[SVO_STAGE_COUNT] = {"grid",      "compile", "voxelize", "transfer",
                                                       "subdivide", "pack",    "link",     "filter"};
    return stage < SVO_STAGE_COUNT ? names[stage] : "unknown stage";
}

svo_status svo_i_report_check(svo_device *device, const char *function, const svo_build_report *report)
{
    return report == NULL ? SVO_OK
                          : svo_i_struct_check(&device->message, function, "report", report,
                                               SVO_I_STRUCT_SIZES(svo_build_report, renderer));
}

void svo_i_report_write(const svo_build_report *made, svo_build_report *report)
{
    if (report != NULL) {
        (void)svo_i_struct_write(NULL, "", "report", made, report, SVO_I_STRUCT_SIZES(svo_build_report, renderer));
    }
}

size_t svo_build_report_stage(const svo_build_report *report, size_t index, svo_stage_time *time)
{
    const size_t end_bytes = offsetof(svo_build_report, stage_times) + (index + 1) * sizeof report->stage_times[0];
    const bool known = index < SVO_STAGE_COUNT && end_bytes <= report->struct_size;
    if (time != NULL) {
        *time = known ? report->stage_times[index] : (svo_stage_time){.clock = NULL};
    }
    return SVO_STAGE_COUNT;
}
