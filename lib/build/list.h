/* SPDX-License-Identifier: MIT */
/* The fragment list of a build that waits: drawn again with more room until it is whole. */
#ifndef SVO_LIB_BUILD_LIST_H
#define SVO_LIB_BUILD_LIST_H

#include "stages/build_state.h"

svo_status svo_i_list_make(svo_i_build *build);

#endif
