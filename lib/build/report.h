/* SPDX-License-Identifier: MIT */
/* Reports of builds, as large as the caller has them. */
#ifndef SVO_LIB_BUILD_REPORT_H
#define SVO_LIB_BUILD_REPORT_H

#include "core/device.h"
#include "svocl/build.h"

/* Whether a report, NULL allowed, can be written; and writes it. */
svo_status svo_i_report_check(svo_device *device, const char *function, const svo_build_report *report);
void svo_i_report_write(const svo_build_report *made, svo_build_report *report);

#endif
