/* SPDX-License-Identifier: MIT */
/* Keeps what lights a tree, for the direct light of pictures. */
#ifndef SVO_LIB_LIGHT_SETUP_H
#define SVO_LIB_LIGHT_SETUP_H

#include "light/state.h"

/* Copies sources and finishes of a setup that has been checked. The light has none yet. */
svo_status svo_i_light_keep_setup(svo_light *light, const char *function, const svo_light_setup *setup);
/* Releases them. */
void svo_i_light_forget_setup(svo_light *light);

#endif
