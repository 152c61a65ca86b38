/* SPDX-License-Identifier: MIT */
/* The grid by kernels: the same steps and the same bytes as grid.c on the host. */
#ifndef SVO_LIB_PLAN_DEVICE_GRID_H
#define SVO_LIB_PLAN_DEVICE_GRID_H

#include "plan/device_mesh.h"

/* Fills the plan's snapped mesh, draw items and fragment estimate. Its arrays are buffers in plan->memory; the host
   gets the large triangles alone. mesh: has the geometry. */
svo_status svo_i_device_grid(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                             const svo_i_device_mesh *mesh);
/* Work-groups of a launch with a work-item per SVO_SCAN_TILE / SVO_GROUP_ITEMS elements, and its work-items. */
uint32_t svo_i_run_groups(uint64_t elements);
uint64_t svo_i_run_items(uint64_t elements);
/* Reduces the columns that a launch over elements has left in its groups' partials, and reads them. */
svo_status svo_i_run_totals(svo_i_device_work *work, cl_mem partials, uint64_t elements, uint32_t columns, bool largest,
                            uint64_t *out);

#endif
