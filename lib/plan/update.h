/* SPDX-License-Identifier: MIT */
/*
 * Updatable plans: kernels make them from a mesh that moves (device_plan.c), and the host learns nothing of it. All
 * arrays have room for every triangle, so that counts are needed nowhere before a build has ended.
 */
#ifndef SVO_LIB_PLAN_UPDATE_H
#define SVO_LIB_PLAN_UPDATE_H

#include "core/work.h"
#include "plan/device_plan.h"

/* What kernels count of a mesh. */
typedef struct svo_i_mesh_totals {
    uint64_t sums[SVO_PLAN_SUMS]; /* triangles by fate, the sums of the estimate */
    svo_i_edge_sums edges; /* zero where they are not summed */
} svo_i_mesh_totals;

typedef struct svo_i_update {
    svo_i_grid_run grid;
    svo_i_device_mesh mesh; /* copies of the mesh's arrays, of which updates replace positions and normals */
    svo_i_material_marks marks;
    cl_mem edges; /* svo_i_edge_sums; NULL without projected areas; svo_i_mesh_totals.sums are grid.sums */
    bool sums_edges; /* of each mesh, not only of the first */
    svo_i_in_flight commands; /* that read or write the plan's arrays */
    bool has_mesh; /* the newest update has succeeded */
    /* Of the newest mesh that the host has waited for. */
    uint64_t kept_triangles;
    svo_i_edge_sums edge_sums;
} svo_i_update;

/* Waits for the newest update and takes its totals. For calls that wait. */
svo_status svo_i_update_settle(svo_plan *plan, const char *function, cl_command_queue queue);
/* Takes what the host has read. SVO_CAPACITY_EXCEEDED: the mesh's area is too large for the plan's weights. */
svo_status svo_i_update_take(svo_plan *plan, const char *function, const svo_i_mesh_totals *totals);
/* SVO_CAPACITY_EXCEEDED: a mesh of this area inside the grid, as svo_plan_info has it, is too large for the plan's
   weights. */
svo_status svo_i_update_check_area(const svo_plan *plan, const char *function, double area);
/* Waits and releases everything; NULL allowed. */
void svo_i_update_destroy(svo_i_update *update);

/* Why builds of a plan have no mesh, or front ends cannot read it; NULL: they can. */
const char *svo_i_update_wrong(const svo_plan *plan, bool on_device);

/* Room for the tiles of a chunk's large triangles. */
static inline uint64_t svo_i_update_tiles_max(uint64_t fragment_capacity)
{
    return fragment_capacity / 4 + 256;
}

/* Makes the plan's arrays and plan->update from the input, and waits. mesh receives the input's arrays; the caller
   frees it. */
svo_status svo_i_update_create(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                               svo_i_device_mesh *mesh);

#endif
