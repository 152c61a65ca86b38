/* SPDX-License-Identifier: MIT */
/* Light that pictures and commands use: lights from files and options, and what is made of them. */
#ifndef SVOCL_TOOLS_SUPPORT_LIGHTING_H
#define SVOCL_TOOLS_SUPPORT_LIGHTING_H

#include "support/job.h"
#include "support/program.h"
#include "support/scene_input.h"
#include "svocl/light.h"
#include "svocl/light_types.h"
#include "svocl/trace.h"

/* ---- files of lights ---- */

/* Most lights of a file. */
#define LIGHT_FILE_SOURCES_MAX 1024

typedef struct light_file {
    svo_light_source *sources; /* NULL: none */
    size_t source_count;
    float sky[3]; /* radiance; zero: not given */
    svo_camera camera;
    bool has_camera;
} light_file;

/* ---- lit trees ---- */

typedef struct lighting {
    light_file file; /* of --lights; without, what a scene says of lights; its camera where --lights has none */
    scene_file scene; /* INPUT, if that is one; else without trees */
    scene_input placed; /* what it places */
    double tree_ms; /* wall-clock time of reading and building the tree */
    svo_light *light;
    svo_light_info info;
    double light_ms; /* wall-clock time of opacity, photons and all stages between */
} lighting;

/* Reads and checks --lights, if it is given, and INPUT, if it is the file of a scene. Returns the exit code; on failure
   nothing stays open. */
int lighting_open(program *state, lighting *out);
void lighting_close(lighting *work);

/* The svo_need bits of a tree that is lit: what --need says, or else all that makes light exact. */
uint32_t lighting_need(const options *given, const input *source);

/* Loads or builds the tree to be lit: with what --need says, or else all that makes light exact. A scene becomes one
   tree of all that it places, of --depth. Begins the progress bar, as job_run does. Returns the exit code; on failure
   nothing is left to release. */
int lighting_tree(program *state, unsigned further_steps, lighting *work, job *done);

/* Without --lights: radiance from outside, and a sun high over the right shoulder of the viewer. */
extern const float lighting_sky[3];
svo_light_source lighting_sun(const svo_camera *camera);

/* What lights the source's tree: the file, and the finishes of the mesh if there is one. Borrows from both. */
svo_light_setup lighting_setup(const lighting *work, const input *source);

/* Makes the light of a tree on the device, by --form, --opacity and --photons; one step of the progress bar. */
int lighting_make(program *state, const job *done, const svo_light_setup *setup, lighting *work);

/* Where a picture of --size is taken from: the file's camera, or one that frames the tree, moved by the options.
   Returns the exit code. */
int lighting_place_camera(program *state, const lighting *work, svo_tree *tree, svo_camera *camera);

/* The same for a picture: without --lights and a scene's lights by a sun behind the camera and a sky. sun: receives the
   sun, which the setup borrows. */
svo_light_setup lighting_setup_for_picture(const program *state, const lighting *work, const input *source,
                                           const svo_camera *camera, svo_light_source *sun);

/* lighting_make for a picture: by --lights, or else by a sun behind the camera and a sky. */
int lighting_make_for_picture(program *state, const job *done, const svo_camera *camera, lighting *work);

/* --cones, --range, --lambda, and what gather has besides. */
svo_gather_options lighting_gather(const options *given);

/* Says of a scene what its tree is: a line of text, or members of the document. Nothing of other inputs. */
void lighting_report_scene(const lighting *work, const job *done);
void lighting_report_scene_json(cJSON *document, const lighting *work, const job *done);

/* Adds what the light is: form, opacity, bytes, photons, what they light and miss, times. */
void lighting_report_json(cJSON *document, const lighting *work);

#endif
