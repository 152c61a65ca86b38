/* SPDX-License-Identifier: MIT */
/* Where a plan is made: on the host (grid.c, attributes.c) or by kernels (device_grid.c, device_attributes.c). */
#ifndef SVO_LIB_PLAN_PLACE_H
#define SVO_LIB_PLAN_PLACE_H

#include "plan/device_mesh.h"

/* Plans of fewer triangles are made on the host: launches would take longer. */
#define SVO_I_KERNEL_TRIANGLES_MIN 4096u
/* A handle loads the plan's kernels when its plans had so many triangles in all: until then the host takes about as
   long as loading. So neither one small mesh nor many of them pay much for nothing. */
#define SVO_I_LOAD_TRIANGLES 131072u

/* Takes the mesh into a plan: the grid, the draw items, the payload inputs. The bytes are the same in both places. */
svo_status svo_i_plan_take_mesh(svo_plan *plan, const svo_i_plan_input *input);

#endif
