/* SPDX-License-Identifier: MIT */
/* svocl render --view ao, direct, gi, specular, full: exact rays, and cones where they are asked for. */
#include "svocl/render.h"

#include "support/exposure.h"
#include "support/lighting.h"
#include "support/picture.h"
#include "support/table.h"

typedef struct light_render {
    program *state;
    job done;
    lighting lit;
    svo_gather_options gather;
    svo_render_options asked; /* without what frames differ in */
    exposure exposed; /* of views of light */
    double render_ms;
} light_render;

bool render_light_is_asked(const options *given)
{
    return given->view >= OPTION_VIEW_LIGHT;
}

/* ---- the picture ---- */

static bool shows_occlusion(const light_render *work)
{
    return work->asked.view == SVO_VIEW_AO;
}

static void ask(light_render *work)
{
    const options *given = &work->state->options;
    work->gather = lighting_gather(given);
    work->asked.struct_size = sizeof work->asked;
    work->asked.width = given->width;
    work->asked.height = given->height;
    work->asked.view = given->view == OPTION_VIEW_FULL ? SVO_VIEW_SHADED : (svo_render_view)given->view;
    work->asked.gather = &work->gather;
    work->asked.output = picture_output(given);
    if (shows_occlusion(work)) {
        work->gather.range = (float)lighting_occlusion_range(given, work->done.result.tree);
    }
}

static int draw(void *user, const svo_camera *camera, const svo_picture_output *output, uint8_t *pixels)
{
    const light_render *work = user;
    svo_render_options asked = work->asked;
    asked.camera = *camera;
    asked.output = *output;
    asked.exposure = work->exposed.value;
    return svo_render(svo_light_target(work->lit.light), &asked, svo_in_host(pixels),
                      &(svo_submit){.queue = work->done.opened.queue}) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(work->state, svo_device_message(work->done.opened.device));
}

/* ---- the report ---- */

static int report_json(const light_render *work)
{
    cJSON *document = picture_document(work->state);
    json_add_text(document, "method", lighting_method(&work->state->options));
    if (shows_occlusion(work)) {
        cJSON_AddNumberToObject(document, "range", (double)work->gather.range);
    } else {
        exposure_report_json(document, &work->exposed);
        lighting_report_chosen_json(document, &work->lit);
    }
    lighting_report_scene_json(document, &work->lit, &work->done);
    lighting_report_json(document, &work->lit);
    return picture_print_document(work->state, document, work->render_ms, work->done.opened.device,
                                  &work->asked.camera);
}

static void report_text(const light_render *work)
{
    const options *given = &work->state->options;
    progress_hide(work->state->progress);
    table_line("%s of %s by %s in %s; light in %s%s", picture_describe(given).text, given->input,
               lighting_method(given), figure_ms(work->render_ms).text, figure_ms(work->lit.light_ms).text,
               shows_occlusion(work) ? "" : exposure_describe(&work->exposed).text);
    if (shows_occlusion(work)) {
        lighting_report_range(given, (double)work->gather.range);
    } else {
        lighting_report_chosen(&work->lit);
        exposure_report_dark(&work->exposed);
    }
    lighting_report_scene(&work->lit, &work->done);
}

static int report(const light_render *work)
{
    const options *given = &work->state->options;
    if (!given->json && !given->quiet) {
        report_text(work);
    }
    return given->json ? report_json(work) : PROGRAM_DONE;
}

/* ---- all of it ---- */

static int render(light_render *work)
{
    program *state = work->state;
    svo_camera *camera = &work->asked.camera;
    ask(work);
    int exit_code = lighting_place_camera(state, &work->lit, work->done.result.tree, camera);
    if (exit_code == PROGRAM_DONE) {
        exit_code = lighting_make_for_picture(state, &work->done, camera, &work->lit);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code =
            exposure_choose(state, svo_light_target(work->lit.light), &work->asked, &work->done.opened, &work->exposed);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = picture_draw(state, "drawing", camera, draw, work, &work->render_ms);
    }
    return exit_code == PROGRAM_DONE ? report(work) : exit_code;
}

int render_light(program *state)
{
    light_render work = {.state = state};
    state->wants_normal_maps = true;
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
