/* SPDX-License-Identifier: MIT */
/* Writes what rays read of BVHs whose shape is made: leaves, and nodes with their boxes. */
#ifndef SVO_LIB_RAYS_BVH_FIT_H
#define SVO_LIB_RAYS_BVH_FIT_H

#include "core/work.h"
#include "rays/bvh_data.h"

/* Makes the tables of BVHs, which must know where they lie; waits for nothing. *out is all zero on failure. */
svo_status svo_i_bvh_tables_make(svo_device *device, const char *function, const svo_i_device_bvh *const *bvhs,
                                 uint32_t count, svo_i_bvh_tables *out);
void svo_i_bvh_tables_free(svo_i_bvh_tables *tables);
/* Enqueues the fit of BVHs to their triangles of a mesh, all in one set of launches of a work that uses the program
   svo_i_program_bvh. They have their records in the same buffers, and their shapes too: those of any of them. */
svo_status svo_i_bvh_fit(svo_i_device_work *work, const svo_i_bvh_mesh *mesh, const svo_i_device_bvh *any,
                         const svo_i_bvh_tables *tables);
/* Enqueues the fit of a BVH, made with can_refit, to vertices that have moved inside the grid: its nodes keep their
   children. *extent is received with the event. wait: NULL allowed. */
svo_status svo_i_bvh_refit(svo_device *device, const char *function, cl_command_queue queue, const svo_i_bvh_mesh *mesh,
                           const svo_i_device_bvh *bvh, cl_event wait, svo_bvh_extent *extent, cl_event *event);
/* Says where the records of a BVH without any are to lie; svo_i_bvh_fit writes them. It keeps the buffers alive. */
svo_status svo_i_bvh_place(svo_device *device, const char *function, svo_i_device_bvh *bvh, cl_mem nodes, cl_mem leaves,
                           uint32_t node_begin, uint32_t leaf_begin);

#endif
