/* SPDX-License-Identifier: MIT */
/* The grid by kernels: the same steps and the same bytes as grid.c on the host. */
#ifndef SVO_LIB_PLAN_DEVICE_GRID_H
#define SVO_LIB_PLAN_DEVICE_GRID_H

#include "plan/device_mesh.h"

/* Sums of signed hashes of a mesh's edges: see kernels/plan/closed.cl. Those of several meshes add up, modulo 2^64. */
typedef struct svo_i_edge_sums {
    uint64_t words[2];
} svo_i_edge_sums;

/* Whether the edges of a mesh with these sums do not cancel. */
static inline bool svo_i_edges_are_open(const svo_i_edge_sums *sums)
{
    return (sums->words[0] | sums->words[1]) != 0;
}

/* What the steps share besides the plan's buffers. */
typedef struct svo_i_grid_run {
    svo_plan *plan;
    svo_i_device_work *work;
    const svo_i_device_mesh *mesh;
    svo_plan_params params;
    cl_mem used; /* per vertex: whether an accepted triangle uses it */
    cl_mem kept; /* per vertex: whether a kept triangle does */
    cl_mem fates, fragments; /* per triangle */
    cl_mem partials; /* a row per work-group */
    cl_mem large, large_count; /* NULL: large triangles are not listed */
    cl_mem edges; /* svo_i_edge_sums, a row per work-group; NULL: not wanted */
    uint64_t totals[SVO_PLAN_SUMS];
} svo_i_grid_run;

/* Makes params for a mesh whose positions are floats or doubles. */
void svo_i_grid_begin(svo_i_grid_run *r, uint64_t triangles, bool is_double);
/* Copies the grid that the plan has to params. */
void svo_i_grid_place(svo_i_grid_run *r);
/* Makes used, fates, fragments, partials and the plan's vertices. */
svo_status svo_i_grid_alloc(svo_i_grid_run *r);
/* The steps, each after the one before. They launch and read nothing back; snap leaves a column of largest numbers in
   the partials, classify SVO_PLAN_SUMS columns of sums, which svo_i_run_reduce must have reduced before keep. */
svo_status svo_i_grid_accept(svo_i_grid_run *r);
svo_status svo_i_grid_snap(svo_i_grid_run *r);
svo_status svo_i_grid_classify(svo_i_grid_run *r);
svo_status svo_i_grid_keep(svo_i_grid_run *r);
svo_status svo_i_grid_keep_positions(svo_i_grid_run *r);
/* For projected areas: makes edges, and fills its rows, between classify and keep, which clears vertices. */
svo_status svo_i_grid_alloc_edges(svo_i_grid_run *r);
svo_status svo_i_grid_sum_edges(svo_i_grid_run *r);
/* Releases what svo_i_grid_run owns. */
void svo_i_grid_end(svo_i_grid_run *r);

/* Fills the plan's snapped mesh, draw items and fragment estimate. Its arrays are buffers in plan->memory; the host
   gets the large triangles alone. mesh: has the geometry. */
svo_status svo_i_device_grid(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                             const svo_i_device_mesh *mesh);
/* Work-groups of a launch with a work-item per SVO_SCAN_TILE / SVO_GROUP_ITEMS elements, and its work-items. */
uint32_t svo_i_run_groups(uint64_t elements);
uint64_t svo_i_run_items(uint64_t elements);
/* Reduces the columns that a launch over elements has left in its groups' partials, to totals. */
svo_status svo_i_run_reduce(svo_i_device_work *work, cl_mem partials, uint64_t elements, uint32_t columns, bool largest,
                            cl_mem totals);
/* The same, and reads them. */
svo_status svo_i_run_totals(svo_i_device_work *work, cl_mem partials, uint64_t elements, uint32_t columns, bool largest,
                            uint64_t *out);

#endif
