/* SPDX-License-Identifier: MIT */
/* Plans by kernels: the same steps and the same bytes as grid.c and attributes.c on the host. */
#ifndef SVO_LIB_PLAN_DEVICE_PLAN_H
#define SVO_LIB_PLAN_DEVICE_PLAN_H

#include "plan/arrays.h"

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
    cl_mem sums; /* of 64 bits: SVO_PLAN_SUMS of the partials, then svo_i_edge_sums, unless those go elsewhere */
    uint64_t totals[SVO_PLAN_SUMS + 2]; /* all of these */
} svo_i_grid_run;

/* A byte per material: whether it has a texture; whether a kept triangle has it, which the kernel sets. */
typedef struct svo_i_material_marks {
    cl_mem textured, used;
} svo_i_material_marks;

/* Fills the plan's snapped mesh, draw items, fragment estimate and payload inputs. Its arrays are buffers in
   plan->memory; the host gets the large triangles alone. Resolves SVO_NEED_DEFAULT and finds constant payload. mesh
   receives the arrays that are read; the caller frees it. */
svo_status svo_i_device_take_mesh(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                                  svo_i_device_mesh *mesh);

/* The same for plans that are updated, in steps. */

/* Makes params, for the plan's grid and a mesh whose positions are floats or doubles. */
void svo_i_grid_begin(svo_i_grid_run *r, uint64_t triangles, bool is_double);
/* Makes used, fates, fragments, partials, the plan's vertices and, for projected areas, edges. */
svo_status svo_i_grid_alloc(svo_i_grid_run *r);
/* Launches the conversion of texture coordinates. */
svo_status svo_i_launch_uvs(svo_i_device_work *work, cl_mem from, cl_mem to, cl_ulong numbers);
/* Launches all other steps, for arrays with room for every triangle, and reads nothing back. edges: receives
   svo_i_edge_sums; NULL: not wanted. */
svo_status svo_i_device_launch(svo_i_grid_run *r, const svo_i_material_marks *marks, cl_mem edges);
/* Releases what svo_i_grid_run owns. */
void svo_i_grid_end(svo_i_grid_run *r);

#endif
