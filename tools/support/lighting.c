/* SPDX-License-Identifier: MIT */
/* Makes the light of a tree. */
#include "support/lighting.h"

#include <math.h>
#include <stdlib.h>

#include "support/picture.h"
#include "support/table.h"
#include "support/viewpoint.h"

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
    light_file *file = &out->file;
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

const float lighting_sky[3] = {0.42F, 0.52F, 0.66F};

int lighting_open(program *state, lighting *out)
{
    *out = (lighting){.light = NULL};
    int exit_code = state->options.lights_path != NULL ? light_file_open(state, state->options.lights_path, &out->file)
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
    light_file_close(&work->file);
    scene_input_close(&work->placed);
    scene_file_close(&work->scene);
}

uint32_t lighting_need(const options *given, const input *source)
{
    const uint32_t of_picture = picture_need(source, given->need);
    if (source->mesh == NULL || given->need != (uint32_t)SVO_NEED_DEFAULT) {
        return of_picture;
    }
    return of_picture | (uint32_t)SVO_NEED_RAYS |
           (given->opacity == SVO_OPACITY_AREA ? (uint32_t)SVO_NEED_PROJECTED_AREA : 0u) |
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

int lighting_tree(program *state, unsigned further_steps, lighting *work, job *done)
{
    const double started_ms = input_now_ms();
    if (input_is_tree(state)) {
        return job_load(state, further_steps, done);
    }
    int exit_code = work->scene.tree_count > 0 ? open_scene(state, further_steps, work, done)
                                               : job_open(state, state->options.need, further_steps, done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = job_build(state, lighting_need(&state->options, &done->source), done);
    if (exit_code != PROGRAM_DONE) {
        job_release(done);
    }
    work->tree_ms = input_now_ms() - started_ms;
    return exit_code;
}

svo_light_setup lighting_setup(const lighting *work, const input *source)
{
    const bool has_finishes = source->mesh != NULL && source->mesh->finishes != NULL;
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = work->file.sources;
    setup.source_count = work->file.source_count;
    setup.finishes = has_finishes ? source->mesh->finishes : NULL;
    setup.finish_count = has_finishes ? source->mesh->material_count : 0;
    for (int channel = 0; channel < 3; ++channel) {
        setup.sky[channel] = work->file.sky[channel];
    }
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
    work->info.node_map_items = counted.node_map_items;
    return PROGRAM_DONE;
}

int lighting_make(program *state, const job *done, const svo_light_setup *setup, lighting *work)
{
    const svo_light_options light_options = {.struct_size = sizeof light_options,
                                             .form = (svo_light_form)state->options.light_form,
                                             .opacity = (svo_opacity)state->options.opacity};
    svo_light_setup shining = *setup;
    shining.no_photons = state->options.photons == 0;
    progress_step(state->progress, "spreading the light");
    const double started_ms = input_now_ms();
    if (svo_light_create(done->result.tree, &light_options, done->opened.queue, &work->light) != SVO_OK ||
        svo_light_set_sources(work->light, &shining, done->opened.queue) != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    work->light_ms = input_now_ms() - started_ms;
    work->info = (svo_light_info)SVO_LIGHT_INFO_INIT;
    (void)svo_light_get_info(work->light, &work->info);
    const bool counts = state->options.json && shining.source_count > 0;
    return counts ? count_missed(state, done, &shining, work) : PROGRAM_DONE;
}

int lighting_place_camera(program *state, const lighting *work, const svo_tree *tree, svo_camera *camera)
{
    const viewpoint_subject shown = {
        .camera = work->file.has_camera ? &work->file.camera : NULL, .tree = tree, .aspect = viewpoint_aspect(state)};
    return viewpoint_place(state, &shown, camera);
}

svo_light_source lighting_sun(const svo_camera *camera)
{
    float away[3];
    svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .value = {3.0F, 2.8F, 2.5F}};
    float length = 0;
    for (int axis = 0; axis < 3; ++axis) {
        away[axis] = camera->target[axis] - camera->eye[axis];
        length += away[axis] * away[axis];
    }
    length = sqrtf(length);
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3;
        const int last = (axis + 2) % 3;
        const float right = away[next] * camera->up[last] - away[last] * camera->up[next];
        sun.direction[axis] = 0.38F * away[axis] - 0.5F * right - 0.85F * length * camera->up[axis];
    }
    return sun;
}

svo_light_setup lighting_setup_for_picture(const program *state, const lighting *work, const input *source,
                                           const svo_camera *camera, svo_light_source *sun)
{
    svo_light_setup setup = lighting_setup(work, source);
    if (state->options.lights_path == NULL) {
        *sun = lighting_sun(camera);
        setup.sources = setup.source_count > 0 ? setup.sources : sun;
        setup.source_count = setup.source_count > 0 ? setup.source_count : 1;
        for (int channel = 0; channel < 3; ++channel) {
            setup.sky[channel] = lighting_sky[channel];
        }
    }
    return setup;
}

int lighting_make_for_picture(program *state, const job *done, const svo_camera *camera, lighting *work)
{
    svo_light_source sun;
    const svo_light_setup setup = lighting_setup_for_picture(state, work, &done->source, camera, &sun);
    return lighting_make(state, done, &setup, work);
}

svo_gather_options lighting_gather(const options *given)
{
    return (svo_gather_options){.struct_size = sizeof(svo_gather_options),
                                .cones = (uint32_t)given->cones,
                                .range = (float)given->range,
                                .falloff = (float)given->falloff,
                                .no_light = given->gi == 0};
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

void lighting_report_json(cJSON *document, const lighting *work)
{
    cJSON *stages = cJSON_CreateObject();
    json_add_text(document, "form", svo_light_form_name(work->info.form));
    json_add_text(document, "opacity", work->info.opacity == SVO_OPACITY_AREA ? "area" : "full");
    json_add_count(document, "light_bytes", work->info.total_bytes);
    json_add_count(document, "photons", work->info.photons);
    json_add_count(document, "photon_hits", work->info.photon_hits);
    json_add_count(document, "lit_leaves", work->info.lit_leaves);
    json_add_count(document, "lit_nodes", work->info.lit_nodes);
    json_add_count(document, "node_map_items", work->info.node_map_items);
    json_add_count(document, "missed_leaves", work->info.missed_leaves);
    cJSON_AddNumberToObject(document, "lost_flux", work->info.lost_flux);
    cJSON_AddNumberToObject(document, "light_ms", work->light_ms);
    for (int i = 0; i < (int)SVO_LIGHT_STAGE_COUNT; ++i) {
        cJSON_AddNumberToObject(stages, svo_light_stage_name((svo_light_stage)i), work->info.stage_ms[i]);
    }
    cJSON_AddItemToObject(document, "light_stages", stages);
}
