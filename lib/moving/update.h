/* SPDX-License-Identifier: MIT */
/* Updates. */
#ifndef SVO_LIB_MOVING_UPDATE_H
#define SVO_LIB_MOVING_UPDATE_H

#include "moving/handle.h"

/* Brings the tree up to date, and waits. No update may be in flight. */
svo_status svo_i_moving_update(svo_moving *moving, cl_command_queue queue);

#endif
