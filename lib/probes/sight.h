/* SPDX-License-Identifier: MIT */
/* What probes look at: a tree's triangles or voxels, or those of a scene. */
#ifndef SVO_LIB_PROBES_SIGHT_H
#define SVO_LIB_PROBES_SIGHT_H

#include "core/work.h"
#include "probes/state.h"

/* A tree or a scene; the other is NULL. */
typedef struct svo_i_sight {
    const svo_tree *tree;
    const svo_scene *scene;
} svo_i_sight;

/* Where it lies. */
typedef struct svo_i_sight_box {
    double low[3], high[3], leaf_edge;
} svo_i_sight_box;

/* NULL: not on a device. */
svo_device *svo_i_sight_device(const svo_i_sight *sight);
/* Refuses what rays cannot be traced against. */
svo_status svo_i_sight_check(const svo_i_sight *sight, const char *function);
void svo_i_sight_get_box(const svo_i_sight *sight, svo_i_sight_box *box);

/* Words of a record of a hit, which begins with t and has the normal in words 4 .. 6. */
uint32_t svo_i_sight_hit_words(const svo_i_sight *sight);
/* Traces so many svo_ray against what the probes see, after the work's newest command. */
svo_status svo_i_sight_trace(svo_probes *probes, svo_i_device_work *work, cl_mem rays, cl_mem hits, size_t ray_count);

#endif
