/* SPDX-License-Identifier: MIT */
/* Options, checks and sizes of lights. */
#ifndef SVO_LIB_LIGHT_PLAN_H
#define SVO_LIB_LIGHT_PLAN_H

#include "core/tree.h"
#include "svocl/light.h"

/* Checks tree and options, and fills in what the light will be: form, opacity and bytes. asked: receives the options,
   with what the caller's struct leaves out. */
svo_status svo_i_light_plan(const svo_tree *tree, const char *function, const svo_light_options *options,
                            svo_light_options *asked, svo_light_info *info);

#endif
