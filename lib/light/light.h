/* SPDX-License-Identifier: MIT */
/* Lights that are made in place of earlier ones. */
#ifndef SVO_LIB_LIGHT_LIGHT_H
#define SVO_LIB_LIGHT_LIGHT_H

#include "light/state.h"

/* Makes a light of a tree with its opacity. before: NULL: from nothing. */
svo_status svo_i_light_create(svo_tree *tree, const char *function, const svo_light_options *options,
                              svo_i_light_before *before, cl_command_queue queue, svo_light **out);

#endif
