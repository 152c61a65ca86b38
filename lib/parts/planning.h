/* SPDX-License-Identifier: MIT */
/* A plan on its way into a folder: made beside the one that is there, and put in its place by one rename. */
#ifndef SVO_LIB_PARTS_PLANNING_H
#define SVO_LIB_PARTS_PLANNING_H

#include "parts/folder.h"

/* Takes the planner's lease of the folder and makes the place where the plan's files are written. svo_parts_close
   releases it, and what was not put in its place is gone. */
svo_status svo_i_planning_begin(svo_parts *parts, const svo_device *device, svo_message *message);
/* To be called now and then, so that the lease does not become stale. */
svo_status svo_i_planning_renew(svo_parts *parts, svo_message *message);
/* Puts the plan in the place of the one that is there, and removes the files of that. */
svo_status svo_i_planning_switch(svo_parts *parts, svo_message *message);

#endif
