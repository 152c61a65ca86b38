/* SPDX-License-Identifier: MIT */
/* The programs of kernels/bvh and kernels/rays. */
#ifndef SVO_LIB_RAYS_PROGRAMS_H
#define SVO_LIB_RAYS_PROGRAMS_H

#include "core/device.h"
#include "core/program.h"
#include "shared/layout.h"

extern const svo_i_program svo_i_program_bvh;
extern const svo_i_program svo_i_program_trace;
extern const svo_i_program svo_i_program_trace_voxels;
extern const svo_i_program svo_i_program_cast;
extern const svo_i_program svo_i_program_view;

/* What selects the kernels of svo_i_program_bvh for a device: its sort, and kernels/bvh/lanes.clh. */
static inline const char *svo_i_bvh_defines(const svo_device *device)
{
    return device->cpu_path ? " -DSVO_SORT -DSVO_SORT_SERIAL -DSVO_BVH_SERIAL" : " -DSVO_SORT";
}

/* SVO_BVH_LANES of its kernels. */
static inline size_t svo_i_bvh_lanes(const svo_device *device)
{
    return device->cpu_path ? 1 : SVO_GROUP_ITEMS;
}

#endif
