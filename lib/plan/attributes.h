/* SPDX-License-Identifier: MIT */
/* The payload inputs: colors, normals, texture coordinates and materials of the kept triangles. */
#ifndef SVO_LIB_PLAN_ATTRIBUTES_H
#define SVO_LIB_PLAN_ATTRIBUTES_H

#include "plan/plan_data.h"

/* Resolves SVO_NEED_DEFAULT, fills the payload inputs and finds constant payload. */
svo_status svo_i_plan_attributes(svo_plan *plan, const svo_mesh *mesh);

#endif
