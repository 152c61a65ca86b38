/* SPDX-License-Identifier: MIT */
/* The map of one probe as a picture. */
#ifndef SVOCL_TOOLS_VIEW_PROBE_MAP_H
#define SVOCL_TOOLS_VIEW_PROBE_MAP_H

#include "support/program.h"
#include "view/state.h"

/* The map of a probe as it is shown. */
typedef struct probe_map {
    uint32_t *texels; /* two words each */
    uint8_t *rgba;
    unsigned edge; /* texels along a side; 0: there is none */
    uint32_t probe;
    view_map kind;
    float exposure;
    unsigned version; /* of the probes */
    bool is_new; /* its pixels are others than before the last update */
} probe_map;

/* Reads and colors the map of the chosen probe, where the state shows one and it is another than before. version:
   counts up when the probes change. Returns the exit code. */
int probe_map_update(probe_map *map, program *running, const svo_probes *probes, cl_command_queue queue,
                     unsigned version, view_state *state);
void probe_map_free(probe_map *map);

#endif
