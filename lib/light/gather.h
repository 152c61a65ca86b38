/* SPDX-License-Identifier: MIT */
/* What kernels that gather take. */
#ifndef SVO_LIB_LIGHT_GATHER_H
#define SVO_LIB_LIGHT_GATHER_H

#include "light/state.h"

/* The options, checked, with the defaults for 0. */
svo_status svo_i_gather_params(const svo_light *light, const char *function, const svo_gather_options *options,
                               svo_gather_params *params);

/* The define of the kernels that read the light's form. Static string. */
const char *svo_i_gather_defines(const svo_light *light);

#endif
