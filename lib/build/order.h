/* SPDX-License-Identifier: MIT */
/* What builds of every mode have in common: kernels are compiled, and the stages run in the order of their table. */
#ifndef SVO_LIB_BUILD_ORDER_H
#define SVO_LIB_BUILD_ORDER_H

#include "stages/build_state.h"

/* The programs of the plan's stages, compiled unless the device has them; fresh ones are added to warm_up. */
svo_status svo_i_order_get_programs(svo_i_build *build, svo_i_warm_up *warm_up);
/* Everything after the list, by OpenCL. */
svo_status svo_i_order_run(svo_i_build *build);
/* Releases everything but the tree, none of it in use any more. */
void svo_i_order_release_scratch(svo_i_build *build);

#endif
