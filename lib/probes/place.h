/* SPDX-License-Identifier: MIT */
/* Where probes are: those in bad places are moved or switched off. */
#ifndef SVO_LIB_PROBES_PLACE_H
#define SVO_LIB_PROBES_PLACE_H

#include "probes/handle.h"

/* Finds a place for each probe, writes SVO_PROBES_PLACES, and counts moved ones, those switched off and rays in info.
   keep: all stay where the grid has them. */
svo_status svo_i_probes_place(svo_i_probe_bands *bands, bool keep);

#endif
