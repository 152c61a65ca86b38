/* SPDX-License-Identifier: MIT */
/*
 * The mesh's attributes on the device, for the stages that make payload of them.
 * Reads: the plan's payload inputs. Writes: build->surface.
 */
#ifndef SVO_LIB_STAGES_SURFACE_H
#define SVO_LIB_STAGES_SURFACE_H

#include "stages/build_state.h"

svo_status svo_i_surface_upload(svo_i_build *build);
/* Also after a failure, and before the tree. */
void svo_i_surface_free(svo_i_build *build);

#endif
