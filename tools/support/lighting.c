/* SPDX-License-Identifier: MIT */
/* Lights trees by files of lights and by the options. */
#include "support/lighting.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/info_of.h"
#include "support/options_parse.h"
#include "support/picture.h"
#include "support/table.h"
#include "support/tree_mesh.h"
#include "support/viewpoint.h"
#include "svocl/io.h"

/* ---- lit trees ---- */

#define PI 3.14159265F

/* A light of a scene: a white surface that faces it shows its color. */
static svo_light_source source_of(const svo_scene_light *light)
{
    svo_light_source source = {.kind = SVO_SOURCE_DIRECTIONAL};
    for (int axis = 0; axis < 3; ++axis) {
        source.direction[axis] = -light->direction[axis];
        source.value[axis] = PI * light->color[axis];
    }
    return source;
}

/* The scene's file says what --lights does not: its camera, and its lights if there is no other file. */
static int take_scene(program *state, lighting *out)
{
    lights_file *file = &out->file;
    int exit_code = scene_file_open(state, state->options.input, &out->scene);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (!file->has_camera && out->scene.has_camera) {
        file->camera = out->scene.camera;
        file->has_camera = true;
    }
    if (state->options.lights_path != NULL || out->scene.light_count == 0) {
        return PROGRAM_DONE;
    }
    file->sources = calloc(out->scene.light_count, sizeof *file->sources);
    if (file->sources == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu lights", out->scene.light_count);
    }
    file->source_count = out->scene.light_count;
    for (size_t i = 0; i < file->source_count; ++i) {
        file->sources[i] = source_of(&out->scene.lights[i]);
    }
    return PROGRAM_DONE;
}

/* Whether the options name cones, or what is stored for them. */
static bool asks_for_cones(const options *given)
{
    return given->gather_method == SVO_GATHER_CONES || given->cones != 0 || options_is_given(given, "form") ||
           options_is_given(given, "opacity") || options_is_given(given, "photons") ||
           options_is_given(given, "sides") || options_is_given(given, "light-file") ||
           options_is_given(given, "emission-photons");
}

int lighting_open(program *state, lighting *out)
{
    *out = (lighting){.for_cones = asks_for_cones(&state->options)};
    int exit_code = state->options.lights_path != NULL ? lights_file_open(state, state->options.lights_path, &out->file)
                                                       : PROGRAM_DONE;
    if (exit_code == PROGRAM_DONE && scene_file_is_input(state)) {
        exit_code = take_scene(state, out);
    }
    if (exit_code != PROGRAM_DONE) {
        lighting_close(out);
    }
    return exit_code;
}

void lighting_close(lighting *work)
{
    svo_light_destroy(&work->light);
    lights_file_close(&work->file);
    scene_input_close(&work->placed);
    scene_file_close(&work->scene);
    input_close(&work->mesh);
}

uint32_t lighting_need(const options *given, const lighting *work, const input *source)
{
    const uint32_t of_picture = picture_need(source, given->need);
    if (source->mesh == NULL || given->need != (uint32_t)SVO_NEED_DEFAULT) {
        return of_picture;
    }
    return of_picture | (uint32_t)SVO_NEED_RAYS |
           (work->for_cones && given->opacity == SVO_OPACITY_AREA ? (uint32_t)SVO_NEED_PROJECTED_AREA : 0u) |
           (source->mesh->finishes != NULL ? (uint32_t)SVO_NEED_MATERIAL : 0u);
}

/* The first part of a job whose source is what a scene places. */
static int open_scene(program *state, unsigned further_steps, lighting *work, job *done)
{
    *done = (job){.source = {.name = state->options.input}};
    program_begin_progress(state,
                           (unsigned)work->scene.tree_count + 2 * (unsigned)state->options.repeat + further_steps);
    int exit_code = scene_input_open(state, &work->scene, &work->placed);
    if (exit_code == PROGRAM_DONE) {
        done->source.mesh = &work->placed.placed.mesh;
        exit_code = session_open(state, &done->opened);
    }
    if (exit_code != PROGRAM_DONE) {
        job_release(done);
    }
    return exit_code;
}

/* A stored tree, and its mesh if that is given. */
static int load_tree(program *state, unsigned further_steps, lighting *work, job *done)
{
    const bool has_mesh = state->options.mesh_path != NULL;
    int exit_code = job_load(state, further_steps + (has_mesh ? 1 : 0), done);
    if (exit_code == PROGRAM_DONE && has_mesh) {
        exit_code = tree_mesh_open(state, done->result.tree, &work->mesh);
        if (exit_code != PROGRAM_DONE) {
            job_release(done);
        }
    }
    return exit_code;
}

int lighting_tree(program *state, unsigned further_steps, lighting *work, job *done)
{
    const double started_ms = input_now_ms();
    if (input_is_tree(state)) {
        return load_tree(state, further_steps, work, done);
    }
    if (state->options.mesh_path != NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--mesh is for a finished tree; %s has a mesh of its own or none", state->options.input);
    }
    int exit_code = work->scene.tree_count > 0 ? open_scene(state, further_steps, work, done)
                                               : job_open(state, state->options.need, further_steps, done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = job_build(state, lighting_need(&state->options, work, &done->source), done);
    if (exit_code != PROGRAM_DONE) {
        job_release(done);
    }
    work->tree_ms = input_now_ms() - started_ms;
    return exit_code;
}

/* The mesh of a tree that was built here or that --mesh names; else NULL. */
static const svo_mesh *mesh_of(const lighting *work, const input *source)
{
    return work->mesh.mesh != NULL ? work->mesh.mesh : source->mesh;
}

svo_light_setup lighting_setup(const lighting *work, const job *done)
{
    const svo_mesh *mesh = mesh_of(work, &done->source);
    const bool has_materials = (info_of_tree(done->result.tree).need & SVO_NEED_MATERIAL) != 0;
    const bool has_finishes = mesh != NULL && mesh->finishes != NULL && (has_materials || work->mesh.mesh == NULL);
    svo_light_setup setup = lights_file_setup(&work->file);
    setup.finishes = has_finishes ? mesh->finishes : NULL;
    setup.finish_count = has_finishes ? mesh->material_count : 0;
    return setup;
}

/* Lights the tree once more for what only --json prints, so that the times are those without it. */
static int count_missed(program *state, const job *done, const svo_light_setup *shining, lighting *work)
{
    svo_light_setup counting = *shining;
    svo_light_info counted = SVO_LIGHT_INFO_INIT;
    counting.diagnose = 1;
    if (svo_light_set_sources(work->light, &counting, done->opened.queue) != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    (void)svo_light_get_info(work->light, &counted);
    work->info.missed_leaves = counted.missed_leaves;
    return PROGRAM_DONE;
}

svo_status lighting_give_mesh(const job *done, const lighting *work)
{
    const svo_mesh *mesh = mesh_of(work, &done->source);
    const svo_tree_info info = info_of_tree(done->result.tree);
    const bool has_rays = (info.need & SVO_NEED_RAYS) != 0 && info.coverage != (uint32_t)SVO_COVERAGE_THIN;
    return mesh != NULL && has_rays && (mesh->material_count > 0 || mesh->colors != NULL || mesh->normals != NULL)
               ? svo_light_set_mesh(work->light, mesh, done->opened.queue)
               : SVO_OK;
}

/* Whether light is gathered by cones. */
static bool gathers_by_cones(const options *given)
{
    return given->gather_method == SVO_GATHER_CONES || given->cones != 0;
}

const char *lighting_method(const options *given)
{
    return gathers_by_cones(given) ? "cones" : "rays";
}

void lighting_set_photons(const options *given, svo_light_setup *setup)
{
    setup->no_photons = given->photons == 0;
    setup->emission_photons = (uint32_t)given->emission_photons;
    setup->bounces = gathers_by_cones(given) ? (uint32_t)given->bounces : 0;
    setup->photon_alpha = 1;
}

int lighting_make(program *state, const job *done, const svo_light_setup *setup, lighting *work)
{
    const svo_light_options light_options = {.struct_size = sizeof light_options,
                                             .form = (svo_light_form)state->options.light_form,
                                             .opacity = (svo_opacity)state->options.opacity,
                                             .one_side = (uint32_t)state->options.one_side,
                                             .no_cones = !work->for_cones};
    svo_light_setup shining = *setup;
    lighting_set_photons(&state->options, &shining);
    progress_step(state->progress, "spreading the light");
    const double started_ms = input_now_ms();
    if (svo_light_create(done->result.tree, &light_options, done->opened.queue, &work->light) != SVO_OK ||
        svo_light_set_sources(work->light, &shining, done->opened.queue) != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    if (lighting_give_mesh(done, work) != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    work->light_ms = input_now_ms() - started_ms;
    work->info = (svo_light_info)SVO_LIGHT_INFO_INIT;
    (void)svo_light_get_info(work->light, &work->info);
    const bool counts = state->options.json && shining.source_count > 0;
    return counts ? count_missed(state, done, &shining, work) : PROGRAM_DONE;
}

int lighting_place_camera(program *state, const lighting *work, svo_tree *tree, svo_camera *camera)
{
    const viewpoint_subject shown = {.camera = work->file.has_camera ? &work->file.camera : NULL,
                                     .target = svo_tree_target(tree),
                                     .aspect = viewpoint_aspect(state)};
    return viewpoint_place(state, &shown, camera);
}

int lighting_setup_for_picture(program *state, const job *done, const svo_camera *camera, lighting *work,
                               svo_light_setup *setup)
{
    default_lights *chosen = &work->chosen;
    *setup = lighting_setup(work, done);
    if (state->options.lights_path != NULL) {
        return PROGRAM_DONE;
    }
    const bool is_lit = setup->source_count > 0; /* by a scene's own lights */
    const int exit_code =
        is_lit ? PROGRAM_DONE
               : default_lights_choose(state, done, camera, state->options.width, state->options.height, chosen);
    setup->sources = is_lit ? setup->sources : &chosen->source;
    setup->source_count = is_lit ? setup->source_count : chosen->source_count;
    memcpy(setup->sky, default_lights_sky, sizeof setup->sky);
    return exit_code;
}

/* ---- light that is kept in a file ---- */

/* A light in a file has its own of these. */
static int refuse_beside_file(program *state)
{
    static const char *const names[] = {"lights", "form", "opacity", "sides", "photons", "emission-photons"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (options_is_given(&state->options, names[i])) {
            return program_fail(state, PROGRAM_WRONG_USAGE, "--%s has no effect: '%s' holds the light", names[i],
                                state->options.light_file);
        }
    }
    return PROGRAM_DONE;
}

static int load_light(program *state, const job *done, lighting *work)
{
    svo_message message = {""};
    int exit_code = refuse_beside_file(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    progress_step(state->progress, "reading the light");
    const double started_ms = input_now_ms();
    if (svo_light_load(done->result.tree, svo_from_path(state->options.light_file), NULL, done->opened.queue,
                       &work->light, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    if (lighting_give_mesh(done, work) != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    work->light_ms = input_now_ms() - started_ms;
    work->info = (svo_light_info)SVO_LIGHT_INFO_INIT;
    (void)svo_light_get_info(work->light, &work->info);
    return PROGRAM_DONE;
}

static int save_light(program *state, const job *done, const lighting *work)
{
    const svo_save_options packed = {.struct_size = sizeof packed, .compress = 1};
    const svo_sink sink = svo_to_path(state->options.light_file);
    svo_message message = {""};
    if (svo_light_save(work->light, sink, &packed, done->opened.queue, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    return PROGRAM_DONE;
}

/* Whether --light-file names a file that is there. */
static bool light_is_kept(const options *given)
{
    FILE *file = given->light_file != NULL ? fopen(given->light_file, "rb") : NULL;
    if (file != NULL) {
        (void)fclose(file);
    }
    return file != NULL;
}

int lighting_make_for_picture(program *state, const job *done, const svo_camera *camera, lighting *work)
{
    svo_light_setup setup;
    if (state->options.light_file != NULL && svo_tree_download(done->result.tree, done->opened.queue) != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    if (light_is_kept(&state->options)) {
        return load_light(state, done, work);
    }
    int exit_code = lighting_setup_for_picture(state, done, camera, work, &setup);
    if (exit_code == PROGRAM_DONE) {
        exit_code = lighting_make(state, done, &setup, work);
    }
    return exit_code == PROGRAM_DONE && state->options.light_file != NULL ? save_light(state, done, work) : exit_code;
}

svo_gather_options lighting_gather(const options *given)
{
    return (svo_gather_options){.struct_size = sizeof(svo_gather_options),
                                .cones = (uint32_t)given->cones,
                                .range = (float)given->range,
                                .falloff = (float)given->falloff,
                                .no_light = given->gi == 0,
                                .method = (svo_gather_method)given->gather_method,
                                .paths = (uint32_t)given->paths,
                                .bounces = gathers_by_cones(given) ? 0 : (uint32_t)given->bounces,
                                .error = (float)given->error_goal};
}

double lighting_occlusion_range(const options *given, const svo_tree *tree)
{
    return options_is_given(given, "range") ? given->range : figure_rounded(info_of_tree(tree).edge / 10);
}

/* Bytes of the tree on the device, without what building it took besides. */
static uint64_t tree_bytes(const build_result *built)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < built->buffer_count; ++i) {
        bytes += built->buffers[i].persistent != 0 ? built->buffers[i].bytes : 0;
    }
    return bytes;
}

void lighting_report_scene(const lighting *work, const job *done)
{
    if (work->scene.tree_count > 0) {
        table_line("a tree of all %s instances: %s triangles, depth %u, %s, made in %s",
                   figure_count(work->scene.instance_count).text, figure_count(done->source.mesh->triangle_count).text,
                   done->result.info.depth, figure_bytes(tree_bytes(&done->result)).text,
                   figure_ms(work->tree_ms).text);
    }
}

void lighting_report_scene_json(cJSON *document, const lighting *work, const job *done)
{
    if (work->scene.tree_count > 0) {
        json_add_count(document, "trees", work->scene.tree_count);
        json_add_count(document, "instances", work->scene.instance_count);
        json_add_count(document, "triangles", done->source.mesh->triangle_count);
        json_add_count(document, "depth", done->result.info.depth);
        json_add_count(document, "tree_bytes", tree_bytes(&done->result));
        cJSON_AddNumberToObject(document, "tree_ms", work->tree_ms);
    }
}

void lighting_report_chosen(const lighting *work)
{
    if (work->chosen.kind != DEFAULT_LIGHT_NONE) {
        table_line("%s", default_lights_describe(&work->chosen).text);
    }
}

void lighting_report_chosen_json(cJSON *document, const lighting *work)
{
    if (work->chosen.kind != DEFAULT_LIGHT_NONE) {
        json_add_text(document, "lit_by", default_lights_name(work->chosen.kind));
    }
    if (work->chosen.kind == DEFAULT_LIGHT_SUN_BEHIND || work->chosen.kind == DEFAULT_LIGHT_SUN_ELSEWHERE) {
        cJSON_AddItemToObject(document, "sun", cJSON_CreateFloatArray(work->chosen.source.direction, 3));
    }
}

void lighting_report_range(const options *given, double range)
{
    if (range > 0) {
        table_line("ambient occlusion reaches %.6g%s", range,
                   options_is_given(given, "range") ? "" : ", a tenth of the grid's width; --range sets it");
    } else {
        table_line("ambient occlusion reaches any distance");
    }
}

void lighting_report_json(cJSON *document, const lighting *work)
{
    cJSON *stages = cJSON_CreateObject();
    json_add_text(document, "form", svo_name(SVO_NAME_LIGHT_FORM, work->info.form));
    json_add_text(document, "opacity", work->info.opacity == SVO_OPACITY_AREA ? "area" : "full");
    json_add_count(document, "light_bytes", work->info.total_bytes);
    json_add_count(document, "photons", work->info.photons);
    json_add_count(document, "photon_hits", work->info.photon_hits);
    json_add_count(document, "sent_photons", work->info.sent_photons);
    json_add_count(document, "lit_leaves", work->info.lit_leaves);
    json_add_count(document, "lit_nodes", work->info.lit_nodes);
    json_add_count(document, "missed_leaves", work->info.missed_leaves);
    cJSON_AddNumberToObject(document, "lost_flux", work->info.lost_flux);
    cJSON_AddNumberToObject(document, "light_ms", work->light_ms);
    for (int i = 0; i < (int)SVO_LIGHT_STAGE_COUNT; ++i) {
        cJSON_AddNumberToObject(stages, svo_name(SVO_NAME_LIGHT_STAGE, (svo_light_stage)i), work->info.stage_ms[i]);
    }
    cJSON_AddItemToObject(document, "light_stages", stages);
}
