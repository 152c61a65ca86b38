/* SPDX-License-Identifier: MIT */
/* The arguments of kernels that use probes. */
#ifndef SVO_LIB_PROBES_SOURCE_H
#define SVO_LIB_PROBES_SOURCE_H

#include "probes/state.h"
#include "rays/batch.h"

/* Probes as the target of batches. */
svo_i_ray_target svo_i_probes_target(svo_probes *probes);

#endif
