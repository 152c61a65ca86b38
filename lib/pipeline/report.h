/* SPDX-License-Identifier: MIT */
/* Writing build reports to the caller's struct, which may be of an earlier version. */
#ifndef SVO_LIB_PIPELINE_REPORT_H
#define SVO_LIB_PIPELINE_REPORT_H

#include "core/device.h"
#include "svocl/build.h"

/* Checks struct_size of a report; NULL is allowed. */
svo_status svo_i_report_check(svo_device *device, const char *function, const svo_build_report *report);
/* Copies the fields that the caller's report has; NULL is allowed. */
void svo_i_report_write(const svo_build_report *made, svo_build_report *report);

#endif
