/* SPDX-License-Identifier: MIT */
/* The fragment list of a blocking build. */
#ifndef SVO_LIB_PIPELINE_BUILD_H
#define SVO_LIB_PIPELINE_BUILD_H

#include "commands/frontend.h"
#include "stages/build_state.h"

/* Has the front end draw the list, again with larger chunks until all fragments fit. Sets build->list and
   build->fragment_count. */
svo_status svo_i_list_make(svo_i_build *build);

#endif
