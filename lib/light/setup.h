/* SPDX-License-Identifier: MIT */
/* What lights a tree. */
#ifndef SVO_LIB_LIGHT_SETUP_H
#define SVO_LIB_LIGHT_SETUP_H

#include "light/handle.h"

/* Errors name svo_light_set_sources. */
svo_status svo_i_light_check_setup(const svo_light *light, const svo_light_setup *setup);
/* Keeps the sky, and copies of sources and finishes, of a setup that has been checked. The light has none yet. */
svo_status svo_i_light_keep_setup(svo_light *light, const char *function, const svo_light_setup *setup);
void svo_i_light_forget_setup(svo_light *light);

#endif
