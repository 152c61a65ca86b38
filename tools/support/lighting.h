/* SPDX-License-Identifier: MIT */
/* The light of commands that gather it: from --lights and --form to a lit tree. */
#ifndef SVOCL_TOOLS_SUPPORT_LIGHTING_H
#define SVOCL_TOOLS_SUPPORT_LIGHTING_H

#include "support/job.h"
#include "support/light_file.h"
#include "svocl/light.h"

typedef struct lighting {
    light_file file; /* of --lights; empty without */
    svo_light *light;
    svo_light_info info;
    double light_ms; /* wall-clock time of opacity, photons and all stages between */
} lighting;

/* Reads and checks --lights, if it is given. Returns the exit code; on failure nothing stays open. */
int lighting_open(program *state, lighting *out);
void lighting_close(lighting *work);

/* The svo_need bits of a tree that is lit: what is asked for, or else all that makes light exact. */
uint32_t lighting_need(const input *source, uint32_t asked);

/* Loads or builds the tree to be lit: with what --need says, or else all that makes light exact. Begins the progress
   bar, as job_run does. Returns the exit code; on failure nothing is left to release. */
int lighting_tree(program *state, unsigned further_steps, job *done);

/* Without --lights: radiance from outside, and a sun high over the right shoulder of the viewer. */
extern const float lighting_sky[3];
svo_light_source lighting_sun(const svo_camera *camera);

/* What lights the source's tree: the file, and the finishes of the mesh if there is one. Borrows from both. */
svo_light_setup lighting_setup(const lighting *work, const input *source);

/* Makes the light of a tree on the device, by --form and --photons; one step of the progress bar. */
int lighting_make(program *state, const job *done, const svo_light_setup *setup, lighting *work);

/* --cones, --range and --lambda. */
svo_gather_options lighting_gather(const options *given);

/* Adds what the light is: form, opacity, bytes, photons, times. */
void lighting_report_json(cJSON *document, const lighting *work);

#endif
