/* SPDX-License-Identifier: MIT */
/* Probes in trees that show in part (kernels/probes/clear.cl), and in scenes of them. Other probes pay nothing. */
#ifndef SVO_LIB_PROBES_CLEAR_H
#define SVO_LIB_PROBES_CLEAR_H

#include "probes/handle.h"

/* Sets probes->is_clear: whether they are of a tree with colors for all nodes, not all of which are opaque, or of a
   scene with such a tree. */
svo_status svo_i_probes_find_clear(svo_probes *probes, svo_i_device_work *work);
/* Traces the rays of a band as svo_i_sight_trace does, but by alpha. */
svo_status svo_i_clear_trace(const svo_i_probe_bands *bands, uint32_t ray_count);
/* Lets the rays of a band begin right before what their texels have, of probes with light, which is of a tree. */
svo_status svo_i_clear_reach(const svo_i_probe_bands *bands, const svo_probe_step *step);

#endif
