/* SPDX-License-Identifier: MIT */
/* What is looked at: the tree on the device and its light, a scene of placed trees, or the tree of what moves in it. */
#ifndef SVOCL_TOOLS_VIEW_SUBJECT_H
#define SVOCL_TOOLS_VIEW_SUBJECT_H

#include "support/job.h"
#include "support/lighting.h"
#include "view/brushing.h"
#include "view/placed.h"
#include "view/probing.h"
#include "view/state.h"

typedef struct subject {
    program *running;
    placed *placed; /* what is drawn where the state is a scene */
    film film; /* of it, what moves */
    bool has_tree; /* the fields below are of a tree that can be shown alone */
    job done;
    lighting lit;
    brushing brush; /* edits its voxels */
    unsigned level; /* of the tree's leaves */
    bool is_lit; /* lit.light is that of the fields below */
    svo_light_form form;
    bool photons;
    unsigned lights_revision;
    probing probes;
    unsigned lightings; /* how often sources lit the tree */
    uint64_t boxed; /* what the state's box is of */
    unsigned changes; /* how often a tree, a light or a scene was made */
} subject;

/* Loads or builds INPUT and places the camera as svocl render does. Returns the exit code; on failure nothing stays
   open. */
int subject_open(program *running, view_state *state, subject *out);
void subject_close(subject *which);

/* Makes the tree and the light that the state asks for, as far as its picture shows them. Returns the exit code. */
int subject_update(subject *which, view_state *state);

/* Tells the state the box of what is shown: the occupied part of a tree, or that of all instances. */
void subject_box(subject *which, view_state *state);

/* The tree that is looked at alone: what moves, or INPUT's. NULL: there is none. */
svo_tree *subject_tree(const subject *which, const view_state *state);
/* Where it draws. */
svo_device *subject_device(const subject *which);
cl_command_queue subject_queue(const subject *which);

/* What pictures of the tree alone are drawn of: it, or the brush's edit. */
svo_target subject_target(const subject *which, const view_state *state);

/* Writes what the state's brush has drawn, and what it was drawn on, to a file. Returns the exit code. */
int subject_save_voxels(subject *which, view_state *state, const char *path);

/* Whether a picture shows light that cones gather. */
bool subject_picture_is_lit(view_picture picture);

#endif
