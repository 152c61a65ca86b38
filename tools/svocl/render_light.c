/* SPDX-License-Identifier: MIT */
/* svocl render --view ao, direct, gi, specular, full: exact rays for first hits and shadows, cones for the rest. */
#include "svocl/render.h"

#include "support/lighting.h"
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

static int draw(void *user, const svo_camera *camera, const svo_picture_output *output, uint8_t *pixels)
{
    const light_render *work = user;
    const options *given = &work->state->options;
    const svo_gather_options gather = lighting_gather(given);
    const svo_render_options asked = {.struct_size = sizeof asked,
                                      .width = given->width,
                                      .height = given->height,
                                      .camera = *camera,
                                      .view = given->view == OPTION_VIEW_FULL ? SVO_VIEW_SHADED
                                                                              : (svo_render_view)given->view,
                                      .gather = &gather,
                                      .exposure = (float)given->exposure,
                                      .output = *output};
    return svo_render(svo_light_target(work->lit.light), &asked, svo_in_host(pixels),
                      &(svo_submit){.queue = work->done.opened.queue}) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(work->state, svo_device_message(work->done.opened.device));
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
        table_line("%s of %s in %s; light in %s", picture_describe(given).text, given->input,
                   figure_ms(work->render_ms).text, figure_ms(work->lit.light_ms).text);
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
        exit_code = picture_draw(work->state, "tracing cones", &work->camera, draw, work, &work->render_ms);
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
    exit_code = lighting_tree(state, 2 + picture_frames(&state->options), &work.lit, &work.done);
    if (exit_code == PROGRAM_DONE) {
        exit_code = render(&work);
        svo_light_destroy(&work.lit.light);
        job_release(&work.done);
    }
    lighting_close(&work.lit);
    return exit_code;
}
