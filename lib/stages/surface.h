/* SPDX-License-Identifier: MIT */
/*
 * Uploads the mesh's attributes for the stages that compute payload. Kernels: none; kernels/stages/attribute.clh reads
 * the buffers.
 *
 * Reads: the plan's payload inputs.
 * Writes: build->surface.
 * Needs: geometry before it, where the plan has leaf lists: the tree's vertices and indices are then used in place.
 */
#ifndef SVO_LIB_STAGES_SURFACE_H
#define SVO_LIB_STAGES_SURFACE_H

#include "stages/build_state.h"

svo_status svo_i_surface_upload(svo_i_build *build);
/* Releases build->surface. To be called before the tree is released, also after a failure. */
void svo_i_surface_free(svo_i_build *build);

#endif
