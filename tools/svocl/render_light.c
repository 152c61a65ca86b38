/* SPDX-License-Identifier: MIT */
/* svocl render --view ao, direct, gi, specular, full: exact rays for first hits and shadows, cones for the rest. */
#include "svocl/render_light.h"

#include <stdlib.h>

#include "support/lighting.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/table.h"

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
        cJSON *document = picture_document(work->state);
        lighting_report_scene_json(document, &work->lit, &work->done);
        lighting_report_json(document, &work->lit);
        return picture_print_document(work->state, document, work->render_ms, work->done.opened.device, &work->camera);
    }
    if (!given->quiet) {
        progress_hide(work->state->progress);
        table_line("%s: %ux%u pixels of %s in %s; light in %s", output_name(given->output_path), given->width,
                   given->height, given->input, figure_ms(work->render_ms).text, figure_ms(work->lit.light_ms).text);
        lighting_report_scene(&work->lit, &work->done);
    }
    return PROGRAM_DONE;
}

static int render(light_render *work)
{
    int exit_code = lighting_place_camera(work->state, &work->lit, work->done.result.tree, &work->camera);
    if (exit_code == PROGRAM_DONE) {
        exit_code = lighting_make_for_picture(work->state, &work->done, &work->camera, &work->lit);
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
    exit_code = lighting_tree(state, 3, &work.lit, &work.done);
    if (exit_code == PROGRAM_DONE) {
        exit_code = render(&work);
        svo_light_destroy(&work.lit.light);
        job_release(&work.done);
    }
    lighting_close(&work.lit);
    return exit_code;
}
