/* SPDX-License-Identifier: MIT */
/* Options, checks, places and sizes of probes. */
#ifndef SVO_LIB_PROBES_PLAN_H
#define SVO_LIB_PROBES_PLAN_H

#include "probes/sight.h"

/* Rays of a launch. */
#define SVO_I_PROBE_BAND_RAYS (UINT32_C(1) << 18)

/* Texels along a side of the map by which a place is judged, and of that by which candidates are tried first. */
#define SVO_I_PLACE_RESOLUTION   32u
#define SVO_I_PLACE_TEXELS       ((size_t)SVO_I_PLACE_RESOLUTION * SVO_I_PLACE_RESOLUTION)
#define SVO_I_PLACE_FIRST        8u
#define SVO_I_PLACE_FIRST_TEXELS ((size_t)SVO_I_PLACE_FIRST * SVO_I_PLACE_FIRST)
/* The most cells along a step among which a place is looked for. */
#define SVO_I_PLACE_CELLS 16u

/* Checks options, and fills in what the probes will be. */
svo_status svo_i_probes_plan(const svo_i_sight *sight, const char *function, const svo_probe_options *options,
                             svo_probe_options *asked, svo_probe_info *info);

/* Rays of the largest launch. */
uint32_t svo_i_probes_band_rays(const svo_probe_info *info);
/* The edge of the cells among whose centers a place is looked for. */
double svo_i_place_cell_edge(const svo_probe_info *info);
/* The most such cells for one probe. */
uint64_t svo_i_place_candidates(const svo_probe_info *info);
/* What kernels know of probes. */
svo_probes_params svo_i_probes_params(const svo_probe_info *info);

#endif
