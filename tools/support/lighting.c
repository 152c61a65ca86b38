/* SPDX-License-Identifier: MIT */
/* Makes the light of a tree. */
#include "support/lighting.h"

#include <math.h>

#include "support/picture.h"

const float lighting_sky[3] = {0.42F, 0.52F, 0.66F};

int lighting_open(program *state, lighting *out)
{
    *out = (lighting){.light = NULL};
    return state->options.lights_path != NULL ? light_file_open(state, state->options.lights_path, &out->file)
                                              : PROGRAM_DONE;
}

void lighting_close(lighting *work)
{
    svo_light_destroy(&work->light);
    light_file_close(&work->file);
}

uint32_t lighting_need(const input *source, uint32_t asked)
{
    const uint32_t of_picture = picture_need(source, asked);
    if (source->mesh == NULL || asked != (uint32_t)SVO_NEED_DEFAULT) {
        return of_picture;
    }
    return of_picture | (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_PROJECTED_AREA |
           (source->mesh->finishes != NULL ? (uint32_t)SVO_NEED_MATERIAL : 0u);
}

int lighting_tree(program *state, unsigned further_steps, job *done)
{
    if (input_is_tree(state)) {
        return job_load(state, further_steps, done);
    }
    int exit_code = job_open(state, state->options.need, further_steps, done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = job_build(state, lighting_need(&done->source, state->options.need), done);
    if (exit_code != PROGRAM_DONE) {
        job_release(done);
    }
    return exit_code;
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

int lighting_make(program *state, const job *done, const svo_light_setup *setup, lighting *work)
{
    const svo_light_options light_options = {.struct_size = sizeof light_options,
                                             .form = (svo_light_form)state->options.light_form};
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
    return PROGRAM_DONE;
}

svo_gather_options lighting_gather(const options *given)
{
    return (svo_gather_options){.struct_size = sizeof(svo_gather_options),
                                .cones = (uint32_t)given->cones,
                                .range = (float)given->range,
                                .falloff = (float)given->falloff,
                                .no_light = given->gi == 0};
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
    cJSON_AddNumberToObject(document, "lost_flux", work->info.lost_flux);
    cJSON_AddNumberToObject(document, "light_ms", work->light_ms);
    for (int i = 0; i < (int)SVO_LIGHT_STAGE_COUNT; ++i) {
        cJSON_AddNumberToObject(stages, svo_light_stage_name((svo_light_stage)i), work->info.stage_ms[i]);
    }
    cJSON_AddItemToObject(document, "light_stages", stages);
}
