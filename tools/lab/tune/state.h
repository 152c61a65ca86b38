/* SPDX-License-Identifier: MIT */
/* The state of a sweep in a file, from which an interrupted run goes on. */
#ifndef SVOCL_TOOLS_TUNE_STATE_H
#define SVOCL_TOOLS_TUNE_STATE_H

#include <cjson/cJSON.h>

#include "tune/sweep.h"

/* All that is measured, as JSON. NULL when out of memory. */
cJSON *state_to_json(const sweep *all);
/* Reads the file of --resume, if it is there. Returns the exit code. */
int state_resume(sweep *all);
/* Writes it, if --resume is given. */
int state_save(const sweep *all);

#endif
