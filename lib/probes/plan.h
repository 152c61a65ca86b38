/* SPDX-License-Identifier: MIT */
/* What probes look at: a tree's triangles or voxels, or those of a scene. Their options, checks, places and sizes. */
#ifndef SVO_LIB_PROBES_PLAN_H
#define SVO_LIB_PROBES_PLAN_H

#include "probes/handle.h"

/* ---- what probes look at ---- */

/* A tree or a scene; the other is NULL. */
typedef struct svo_i_sight {
    const svo_tree *tree;
    const svo_scene *scene;
} svo_i_sight;

/* Words of a record of a hit, which begins with t and has the normal in words 4 .. 6. */
uint32_t svo_i_sight_hit_words(const svo_i_sight *sight);
/* Traces so many svo_ray against what the probes see, after the work's newest command. */
svo_status svo_i_sight_trace(svo_probes *probes, svo_i_device_work *work, cl_mem rays, cl_mem hits, size_t ray_count);

/* ---- plans ---- */

/* Texels along a side of the map by which a place is judged, and of that by which candidates are tried first. */
#define SVO_I_PLACE_RESOLUTION   32u
#define SVO_I_PLACE_TEXELS       ((size_t)SVO_I_PLACE_RESOLUTION * SVO_I_PLACE_RESOLUTION)
#define SVO_I_PLACE_FIRST        8u
#define SVO_I_PLACE_FIRST_TEXELS ((size_t)SVO_I_PLACE_FIRST * SVO_I_PLACE_FIRST)
/* The most cells along a step among which a place is looked for. */
#define SVO_I_PLACE_CELLS 16u

/* Checks options, which have one of tree and scene then, and fills in what the probes will be. */
svo_status svo_i_probes_plan(const char *function, const svo_probe_options *options, svo_probe_options *asked,
                             svo_probe_info *info);

/* Rays of the largest launch. */
static inline uint32_t svo_i_probes_band_rays(const svo_probe_info *info)
{
    const uint32_t most = UINT32_C(1) << 18;
    const uint64_t texels = (uint64_t)info->probe_count * info->resolution * info->resolution;
    return texels < most ? (uint32_t)texels : most;
}

/* The edge of the cells among whose centers a place is looked for. */
double svo_i_place_cell_edge(const svo_probe_info *info);
/* The most such cells for one probe. */
uint64_t svo_i_place_candidates(const svo_probe_info *info);

#endif
