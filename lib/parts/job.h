/* SPDX-License-Identifier: MIT */
/* Parts of a folder that are divided into their eight children, and built (svo_parts_build). */
#ifndef SVO_LIB_PARTS_JOB_H
#define SVO_LIB_PARTS_JOB_H

#include "parts/folder.h"

/* Divides the part 0-0, whose triangles are in the folder, until all parts fit, and makes the list. */
svo_status svo_i_parts_divide(svo_parts *parts, svo_device *device, svo_message *message);

#endif
