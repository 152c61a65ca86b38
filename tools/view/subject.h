/* SPDX-License-Identifier: MIT */
/* What is looked at: the tree on the device, its light, and what the library draws of them. */
#ifndef SVOCL_TOOLS_VIEW_SUBJECT_H
#define SVOCL_TOOLS_VIEW_SUBJECT_H

#include "support/job.h"
#include "support/lighting.h"
#include "view/state.h"

typedef struct subject {
    program *running;
    job done;
    lighting lit;
    unsigned level; /* of the tree's leaves */
    bool is_lit; /* lit.light is that of the fields below */
    svo_light_form form;
    bool photons;
    unsigned lights_revision;
} subject;

/* Loads or builds INPUT and places the camera as svocl render does. Returns the exit code; on failure nothing stays
   open. */
int subject_open(program *running, view_state *state, subject *out);
void subject_close(subject *which);

/* Makes the tree and the light that the state asks for, as far as its picture shows them. Returns the exit code. */
int subject_update(subject *which, view_state *state);

/* Draws what the state shows with so many pixels: what svocl render writes. Returns the exit code. */
int subject_draw(subject *which, const view_state *state, unsigned width, unsigned height, uint8_t *rgba);

/* Whether a picture shows light that cones gather. */
bool subject_picture_is_lit(view_picture picture);

#endif
