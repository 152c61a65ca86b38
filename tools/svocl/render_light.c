/* SPDX-License-Identifier: MIT */
/* svocl render --view ao, direct, gi, specular, full: exact rays for first hits and shadows, cones for the rest. */
#include "svocl/render_light.h"

#include <stdlib.h>

#include "support/lighting.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/table.h"
#include "support/viewpoint.h"

typedef struct light_render {
    program *state;
    job done;
    lighting lit;
    svo_camera camera;
    double render_ms;
} light_render;

bool render_light_is_asked(const options *given)
{
    return given->view >= OPTION_VIEW_LIGHT;
}

/* ---- tree and camera ---- */

static int place_camera(light_render *work)
{
    const options *given = &work->state->options;
    if (work->lit.file.has_camera) {
        work->camera = work->lit.file.camera;
    } else {
        svo_camera_frame(work->done.result.tree, (float)given->width / (float)given->height, &work->camera);
    }
    return viewpoint_apply(work->state, !work->lit.file.has_camera, &work->camera);
}

/* ---- light ---- */

static int make_light(light_render *work)
{
    svo_light_setup setup = lighting_setup(&work->lit, &work->done.source);
    const svo_light_source sun = lighting_sun(&work->camera);
    if (work->state->options.lights_path == NULL) {
        setup.sources = &sun;
        setup.source_count = 1;
        for (int channel = 0; channel < 3; ++channel) {
            setup.sky[channel] = lighting_sky[channel];
        }
    }
    return lighting_make(work->state, &work->done, &setup, &work->lit);
}

/* ---- the picture ---- */

static int draw(light_render *work)
{
    program *state = work->state;
    const options *given = &state->options;
    const svo_light_picture asked = {.struct_size = sizeof asked,
                                     .width = given->width,
                                     .height = given->height,
                                     .camera = work->camera,
                                     .view = (svo_light_view)(given->view - OPTION_VIEW_LIGHT),
                                     .gather = lighting_gather(given),
                                     .exposure = (float)given->exposure};
    uint8_t *rgba = malloc((size_t)given->width * given->height * 4);
    if (rgba == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %ux%u pixels", given->width, given->height);
    }
    progress_step(state->progress, "tracing cones");
    const double started_ms = input_now_ms();
    int exit_code = PROGRAM_DONE;
    if (svo_light_render(work->lit.light, &asked, work->done.opened.queue, rgba) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(work->done.opened.device));
    }
    work->render_ms = input_now_ms() - started_ms;
    if (exit_code == PROGRAM_DONE) {
        exit_code = picture_write(state, rgba);
    }
    free(rgba);
    return exit_code;
}

static int report(const light_render *work)
{
    const options *given = &work->state->options;
    if (given->json) {
        cJSON *document = json_document();
        json_add_text(document, "input", given->input);
        json_add_text(document, "file", given->output_path);
        json_add_count(document, "width", given->width);
        json_add_count(document, "height", given->height);
        lighting_report_json(document, &work->lit);
        cJSON_AddNumberToObject(document, "render_ms", work->render_ms);
        json_add_text(document, "device", svo_device_name(work->done.opened.device));
        cJSON_AddItemToObject(document, "eye", cJSON_CreateFloatArray(work->camera.eye, 3));
        cJSON_AddItemToObject(document, "target", cJSON_CreateFloatArray(work->camera.target, 3));
        return json_print(work->state, document);
    }
    if (!given->quiet) {
        progress_hide(work->state->progress);
        table_line("%s: %ux%u pixels of %s in %s; light in %s", output_name(given->output_path), given->width,
                   given->height, given->input, figure_ms(work->render_ms).text, figure_ms(work->lit.light_ms).text);
    }
    return PROGRAM_DONE;
}

static int render(light_render *work)
{
    int exit_code = place_camera(work);
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_light(work);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = draw(work);
    }
    return exit_code == PROGRAM_DONE ? report(work) : exit_code;
}

int render_light(program *state)
{
    light_render work = {.state = state};
    int exit_code = lighting_open(state, &work.lit);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = lighting_tree(state, 3, &work.done);
    if (exit_code == PROGRAM_DONE) {
        exit_code = render(&work);
        svo_light_destroy(&work.lit.light);
        job_release(&work.done);
    }
    lighting_close(&work.lit);
    return exit_code;
}
