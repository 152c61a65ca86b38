/* SPDX-License-Identifier: MIT */
/* svocl render --through probes: camera rays meet no triangle and no voxel, only what probes have stored of them. */
#include "svocl/render.h"

#include <string.h>

#include "support/exposure.h"
#include "support/lighting.h"
#include "support/picture.h"
#include "support/probe_picture.h"
#include "support/scene_trees.h"
#include "support/table.h"

typedef struct probe_render {
    program *state;
    job done; /* the tree; a scene's where it is lit */
    lighting lit; /* its light: for shaded pictures alone */
    device_scene placed; /* in place of a tree */
    svo_device *device;
    cl_command_queue queue;
    svo_camera camera;
    exposure exposed; /* of shaded pictures */
    svo_probes *probes;
    svo_probe_info info;
    probe_found found;
    double probes_ms;
} probe_render;

static int fail_device(const probe_render *work)
{
    return program_fail_library(work->state, svo_device_message(work->device));
}

/* ---- probes ---- */

static int make_probes(probe_render *work)
{
    const options *given = &work->state->options;
    svo_probe_options asked = {.struct_size = sizeof asked,
                               .resolution = (uint32_t)given->probe_resolution,
                               .field_size = (uint32_t)given->probe_field,
                               .cones = (uint32_t)given->cones,
                               .light = work->lit.light,
                               .tree = work->placed.scene == NULL ? work->done.result.tree : NULL,
                               .scene = work->placed.scene};
    memcpy(asked.counts, given->probe_counts, sizeof asked.counts);
    progress_step(work->state->progress, "making probes");
    const double started_ms = input_now_ms();
    if (svo_probes_create(&asked, work->queue, &work->probes) != SVO_OK) {
        return fail_device(work);
    }
    work->probes_ms = input_now_ms() - started_ms;
    work->info = (svo_probe_info)SVO_PROBE_INFO_INIT;
    return svo_probes_get_info(work->probes, &work->info) == SVO_OK ? PROGRAM_DONE : fail_device(work);
}

static int draw(void *user, const svo_camera *camera, const svo_picture_output *output, uint8_t *pixels)
{
    probe_render *work = user;
    const options *given = &work->state->options;
    const probe_picture asked = {.camera = *camera,
                                 .width = given->width,
                                 .height = given->height,
                                 .view = (svo_render_view)given->view,
                                 .exposure = (double)work->exposed.value,
                                 .output = *output};
    probe_found found;
    const int exit_code =
        probe_picture_draw(work->state, &asked, work->probes, work->device, work->queue, pixels, &found);
    for (unsigned i = 0; i <= SVO_PROBE_UNKNOWN; ++i) {
        work->found.rays[i] += found.rays[i];
    }
    work->found.trace_ms += found.trace_ms;
    return exit_code;
}

/* ---- the report ---- */

static int report_json(const probe_render *work)
{
    cJSON *document = picture_document(work->state);
    cJSON *counts = cJSON_CreateArray();
    for (int axis = 0; axis < 3; ++axis) {
        cJSON_AddItemToArray(counts, cJSON_CreateNumber((double)work->info.counts[axis]));
    }
    cJSON_AddItemToObject(document, "probes", counts);
    json_add_count(document, "resolution", work->info.resolution);
    json_add_count(document, "moved", work->info.moved);
    json_add_count(document, "off", work->info.off);
    json_add_count(document, "probe_bytes", work->info.total_bytes);
    json_add_count(document, "hits", work->found.rays[SVO_PROBE_HIT]);
    json_add_count(document, "misses", work->found.rays[SVO_PROBE_MISS]);
    json_add_count(document, "unknown", work->found.rays[SVO_PROBE_UNKNOWN]);
    if (work->lit.light != NULL) {
        exposure_report_json(document, &work->exposed);
        lighting_report_chosen_json(document, &work->lit);
    }
    cJSON_AddNumberToObject(document, "probes_ms", work->probes_ms);
    return picture_print_document(work->state, document, work->found.trace_ms, work->device, &work->camera);
}

static void report_text(const probe_render *work)
{
    const options *given = &work->state->options;
    progress_hide(work->state->progress);
    table_line("%s of %s in %s%s", picture_describe(given).text, given->input, figure_ms(work->found.trace_ms).text,
               work->lit.light != NULL ? exposure_describe(&work->exposed).text : "");
    lighting_report_chosen(&work->lit);
    exposure_report_dark(&work->exposed);
    table_line("probes: %u x %u x %u of %u x %u texels, %s, in %s; %s moved, %s off", work->info.counts[0],
               work->info.counts[1], work->info.counts[2], work->info.resolution, work->info.resolution,
               figure_bytes(work->info.total_bytes).text, figure_ms(work->probes_ms).text,
               figure_count(work->info.moved).text, figure_count(work->info.off).text);
    table_line("rays: %.2f %% hit, %.2f %% miss, %.2f %% unknown", probe_found_percent(&work->found, SVO_PROBE_HIT),
               probe_found_percent(&work->found, SVO_PROBE_MISS), probe_found_percent(&work->found, SVO_PROBE_UNKNOWN));
}

static int report(const probe_render *work)
{
    const options *given = &work->state->options;
    if (!given->json && !given->quiet) {
        report_text(work);
    }
    return given->json ? report_json(work) : PROGRAM_DONE;
}

/* ---- both kinds of input ---- */

static int render(probe_render *work)
{
    double draw_ms = 0;
    int exit_code = make_probes(work);
    if (exit_code == PROGRAM_DONE) {
        exit_code = picture_draw(work->state, "tracing probes", &work->camera, draw, work, &draw_ms);
    }
    svo_probes_destroy(&work->probes);
    return exit_code == PROGRAM_DONE ? report(work) : exit_code;
}

/* The exposure of the same picture by rays and cones, which it so compares with. */
static int expose(probe_render *work)
{
    const options *given = &work->state->options;
    const svo_gather_options gather = lighting_gather(given);
    const svo_render_options asked = {.struct_size = sizeof asked,
                                      .width = given->width,
                                      .height = given->height,
                                      .camera = work->camera,
                                      .view = SVO_VIEW_SHADED,
                                      .gather = &gather,
                                      .output = picture_output(given)};
    return exposure_choose(work->state, svo_light_target(work->lit.light), &asked, &work->done.opened, &work->exposed);
}

static int light_tree(probe_render *work)
{
    program *state = work->state;
    work->device = work->done.opened.device;
    work->queue = work->done.opened.queue;
    int exit_code = lighting_place_camera(state, &work->lit, work->done.result.tree, &work->camera);
    if (exit_code == PROGRAM_DONE && state->options.view == SVO_VIEW_SHADED) {
        exit_code = lighting_make_for_picture(state, &work->done, &work->camera, &work->lit);
        exit_code = exit_code == PROGRAM_DONE ? expose(work) : exit_code;
    }
    return exit_code;
}

static int render_tree(probe_render *work)
{
    program *state = work->state;
    int exit_code = lighting_open(state, &work->lit);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    work->lit.for_cones = true; /* which light what probes see */
    exit_code = lighting_tree(state, (state->options.view == SVO_VIEW_SHADED ? 3 : 2) + picture_frames(&state->options),
                              &work->lit, &work->done);
    if (exit_code == PROGRAM_DONE) {
        exit_code = light_tree(work);
        exit_code = exit_code == PROGRAM_DONE ? render(work) : exit_code;
        svo_light_destroy(&work->lit.light);
        job_release(&work->done);
    }
    lighting_close(&work->lit);
    return exit_code;
}

/* Light is of trees, so what shows none is of the scene as it is placed. */
static int render_placed(probe_render *work)
{
    int exit_code = device_scene_open(work->state, 2 + picture_frames(&work->state->options), &work->placed);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    work->device = work->placed.trees.opened.device;
    work->queue = work->placed.trees.opened.queue;
    exit_code = device_scene_camera(work->state, &work->placed, &work->camera);
    exit_code = exit_code == PROGRAM_DONE ? render(work) : exit_code;
    device_scene_close(&work->placed);
    return exit_code;
}

int render_probes(program *state)
{
    probe_render work = {.state = state};
    return scene_file_is_input(state) && state->options.view != SVO_VIEW_SHADED ? render_placed(&work)
                                                                                : render_tree(&work);
}
