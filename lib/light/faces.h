/* SPDX-License-Identifier: MIT */
/* Six opacities and covers for each node. */
#ifndef SVO_LIB_LIGHT_FACES_H
#define SVO_LIB_LIGHT_FACES_H

#include "light/state.h"

/* SVO_LIGHT_FACES: makes SVO_LIGHT_OPACITY, as extinctions, and SVO_LIGHT_COVER. */
svo_status svo_i_light_faces(svo_i_device_work *work, svo_light *light);

#endif
