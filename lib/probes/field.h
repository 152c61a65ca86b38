/* SPDX-License-Identifier: MIT */
/* The field: which probes see a cell. */
#ifndef SVO_LIB_PROBES_FIELD_H
#define SVO_LIB_PROBES_FIELD_H

#include "probes/bands.h"

/* SVO_PROBES_FIELD, of places and texels. */
svo_status svo_i_probes_field(const svo_i_probe_bands *bands);

#endif
