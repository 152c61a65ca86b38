/* SPDX-License-Identifier: MIT */
/* Light that pictures and commands use: lights from files and options, and what is made of them. */
#ifndef SVOCL_TOOLS_SUPPORT_LIGHTING_H
#define SVOCL_TOOLS_SUPPORT_LIGHTING_H

#include "support/default_lights.h"
#include "support/job.h"
#include "support/lights_file.h"
#include "support/program.h"
#include "support/scene_input.h"
#include "svocl/light.h"
#include "svocl/light_types.h"
#include "svocl/trace.h"

typedef struct lighting {
    lights_file file; /* of --lights; without, what a scene says of lights; its camera where --lights has none */
    scene_file scene; /* INPUT, if that is one; else without trees */
    scene_input placed; /* what it places */
    input mesh; /* of --mesh, else empty */
    default_lights chosen; /* of a picture that none of them lights */
    bool for_cones; /* as options ask, or a command that needs them sets */
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
uint32_t lighting_need(const options *given, const lighting *work, const input *source);

/* Loads or builds the tree to be lit: with what --need says, or else all that makes light exact. A scene becomes one
   tree of all that it places, of --depth. Begins the progress bar, as job_run does. Returns the exit code; on failure
   nothing is left to release. */
int lighting_tree(program *state, unsigned further_steps, lighting *work, job *done);

/* What lights the tree: the file, and the finishes of the mesh if there is one. Borrows from both. */
svo_light_setup lighting_setup(const lighting *work, const job *done);

/* Makes the light of a tree on the device, by --form, --opacity and --photons; one step of the progress bar. */
int lighting_make(program *state, const job *done, const svo_light_setup *setup, lighting *work);

/* Gives the light the mesh of its tree, if there is one and it looks other than the tree's leaves. */
svo_status lighting_give_mesh(const job *done, const lighting *work);

/* Where a picture of --size is taken from: the file's camera, or one that frames the tree, moved by the options.
   Returns the exit code. */
int lighting_place_camera(program *state, const lighting *work, svo_tree *tree, svo_camera *camera);

/* The same for a picture: without --lights and a scene's lights by default_lights.h, as work->chosen then says, which
   the setup borrows. Returns the exit code. */
int lighting_setup_for_picture(program *state, const job *done, const svo_camera *camera, lighting *work,
                               svo_light_setup *setup);

/* lighting_make for a picture; with --light-file read from there, or written. */
int lighting_make_for_picture(program *state, const job *done, const svo_camera *camera, lighting *work);

/* --photons, --emission-photons and, for cones, --bounces; photons honor alpha. */
void lighting_set_photons(const options *given, svo_light_setup *setup);

/* --cones, --range, --lambda, and what gather has besides; without --range any distance. */
svo_gather_options lighting_gather(const options *given);

/* What --method auto becomes: "cones" or "rays". Follows from the options alone. */
const char *lighting_method(const options *given);

/* How far ambient occlusion reaches: --range, or else a tenth of the grid's width. 0: any distance. */
double lighting_occlusion_range(const options *given, const svo_tree *tree);

/* Says of a scene what its tree is: a line of text, or members of the document. Nothing of other inputs. */
void lighting_report_scene(const lighting *work, const job *done);
void lighting_report_scene_json(cJSON *document, const lighting *work, const job *done);

/* Say by what a picture is lit where nothing was given. */
void lighting_report_chosen(const lighting *work);
void lighting_report_chosen_json(cJSON *document, const lighting *work);

/* Says how far ambient occlusion reaches. */
void lighting_report_range(const options *given, double range);

/* Adds what the light is: form, opacity, bytes, photons, what they light and miss, times. */
void lighting_report_json(cJSON *document, const lighting *work);

#endif
