/* SPDX-License-Identifier: MIT */
/* Parts of a folder that are planned, divided into their eight children, and built (svo_parts_build). */
#ifndef SVO_LIB_PARTS_JOB_H
#define SVO_LIB_PARTS_JOB_H

#include "parts/cut.h"

/* Makes the list of the parts of a cut, whose triangles are in the folder. Those that may not fit are planned, and
   divided until they do. */
svo_status svo_i_parts_divide(svo_parts *parts, const svo_i_cut *cut, svo_device *device, svo_message *message);

#endif
