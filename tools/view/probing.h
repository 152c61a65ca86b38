/* SPDX-License-Identifier: MIT */
/* Probes of what is looked at: made as the state asks, lit anew with it, and what the viewer shows of them. */
#ifndef SVOCL_TOOLS_VIEW_PROBING_H
#define SVOCL_TOOLS_VIEW_PROBING_H

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

/* What probes are made of. */
typedef struct probing_source {
    svo_tree *tree; /* NULL: the scene */
    svo_scene *scene;
    svo_light *light; /* of the tree; NULL: none */
    unsigned lightings; /* how often the light was made anew */
    svo_device *device;
    cl_command_queue queue;
} probing_source;

typedef struct probing {
    program *running;
    svo_probes *probes;
    probing_source source; /* of the probes, or of the plan */
    view_probe_grid grid; /* of the probes */
    view_probe_grid planned; /* of the plan; 0 probes: there is none */
    unsigned cones;
    unsigned lightings; /* of the source, when the probes were lit last */
    unsigned version; /* how often probes were made or lit */
    svo_probe_info plan; /* of the probes, before they were made */
    svo_probe *places;
    probe_map map;
} probing;

/* Forgets the probes: what they are made of goes or changes. */
void probing_drop(probing *which, view_state *state);
void probing_close(probing *which);

/* Plans the grid that the panel asks for, and makes and lights the probes that the state shows. What the library
   refuses is not shown, and the log says why. Returns the exit code. */
int probing_update(probing *which, const probing_source *source, view_state *state);

/* Draws through the probes what svocl render would. Returns the exit code. */
int probing_draw(probing *which, view_state *state, unsigned width, unsigned height, cl_mem pixels, cl_event *drawn);

#endif
