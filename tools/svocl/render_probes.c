/* SPDX-License-Identifier: MIT */
/* svocl render --through probes: camera rays meet no triangle and no voxel, only what probes have stored of them. */
#include "svocl/render_probes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/lighting.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/probe_colors.h"
#include "support/ray_table.h"
#include "support/table.h"
#include "svocl/probes.h"

typedef struct probe_render {
    program *state;
    job done;
    lighting lit; /* its light: for shaded pictures alone */
    svo_camera camera;
    svo_probes *probes;
    svo_probe_info info;
    ray_table rays; /* one a pixel */
    svo_probe_hit *hits;
    size_t found[SVO_PROBE_UNKNOWN + 1]; /* rays by their outcome */
    double probes_ms, render_ms;
} probe_render;

static int fail_device(const probe_render *work)
{
    return program_fail_library(work->state, svo_device_message(work->done.opened.device));
}

/* ---- probes ---- */

static int make_probes(probe_render *work)
{
    const options *given = &work->state->options;
    svo_probe_options asked = {.struct_size = sizeof asked,
                               .resolution = (uint32_t)given->probe_resolution,
                               .field_size = (uint32_t)given->probe_field,
                               .cones = (uint32_t)given->cones,
                               .light = work->lit.light};
    memcpy(asked.counts, given->probe_counts, sizeof asked.counts);
    progress_step(work->state->progress, "making probes");
    const double started_ms = input_now_ms();
    if (svo_probes_create(work->done.result.tree, &asked, work->done.opened.queue, &work->probes) != SVO_OK) {
        return fail_device(work);
    }
    work->probes_ms = input_now_ms() - started_ms;
    work->info = (svo_probe_info)SVO_PROBE_INFO_INIT;
    return svo_probes_get_info(work->probes, &work->info) == SVO_OK ? PROGRAM_DONE : fail_device(work);
}

static int trace(probe_render *work)
{
    const options *given = &work->state->options;
    const svo_probe_trace_options how = {.struct_size = sizeof how, .choice = (svo_probe_choice)given->probe_choice};
    const int exit_code = ray_table_from_camera(work->state, &work->camera, given->width, given->height, &work->rays);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    work->hits = calloc(work->rays.count, sizeof *work->hits);
    if (work->hits == NULL) {
        return program_fail(work->state, PROGRAM_FAILED, "out of memory for %zu rays", work->rays.count);
    }
    progress_step(work->state->progress, "tracing probes");
    const double started_ms = input_now_ms();
    if (svo_probes_trace(work->probes, work->rays.rays, work->hits, work->rays.count, &how, work->done.opened.queue) !=
        SVO_OK) {
        return fail_device(work);
    }
    work->render_ms = input_now_ms() - started_ms;
    return PROGRAM_DONE;
}

/* ---- the picture ---- */

/* The tree's bounding sphere has white in front and nearly black at its back. */
static probe_colors colors_of(const probe_render *work)
{
    const options *given = &work->state->options;
    svo_grid grid;
    double squared = 0;
    probe_colors shown = {
        .view = (svo_render_view)given->view, .farthest = 1, .exposure = given->exposure > 0 ? given->exposure : 1};
    if (svo_tree_get_grid(work->done.result.tree, &grid) == SVO_OK) {
        const double edge = svo_grid_cell_edge(&grid, 0);
        for (int axis = 0; axis < 3; ++axis) {
            const double apart = (double)work->camera.eye[axis] - (grid.origin[axis] + 0.5 * edge);
            squared += apart * apart;
        }
        shown.nearest = fmax(sqrt(squared) - 0.87 * edge, 0);
        shown.farthest = sqrt(squared) + 0.87 * edge;
    }
    return shown;
}

static int draw(probe_render *work)
{
    const probe_colors shown = colors_of(work);
    uint8_t *rgba = malloc(4 * work->rays.count);
    if (rgba == NULL) {
        return program_fail(work->state, PROGRAM_FAILED, "out of memory for the picture");
    }
    for (size_t i = 0; i < work->rays.count; ++i) {
        probe_colors_pixel(&shown, &work->hits[i], rgba + 4 * i);
        ++work->found[work->hits[i].state];
    }
    const int exit_code = picture_write(work->state, rgba);
    free(rgba);
    return exit_code;
}

/* ---- the report ---- */

static double percent_of(const probe_render *work, unsigned outcome)
{
    return 100.0 * (double)work->found[outcome] / (double)work->rays.count;
}

static int report_json(const probe_render *work)
{
    const options *given = &work->state->options;
    cJSON *document = json_document();
    json_add_text(document, "input", given->input);
    json_add_text(document, "file", given->output_path);
    json_add_count(document, "width", given->width);
    json_add_count(document, "height", given->height);
    cJSON *counts = cJSON_CreateArray();
    for (int axis = 0; axis < 3; ++axis) {
        cJSON_AddItemToArray(counts, cJSON_CreateNumber((double)work->info.counts[axis]));
    }
    cJSON_AddItemToObject(document, "probes", counts);
    json_add_count(document, "resolution", work->info.resolution);
    json_add_count(document, "moved", work->info.moved);
    json_add_count(document, "off", work->info.off);
    json_add_text(document, "choice", svo_probe_choice_name((svo_probe_choice)given->probe_choice));
    json_add_count(document, "probe_bytes", work->info.total_bytes);
    json_add_count(document, "hits", work->found[SVO_PROBE_HIT]);
    json_add_count(document, "misses", work->found[SVO_PROBE_MISS]);
    json_add_count(document, "unknown", work->found[SVO_PROBE_UNKNOWN]);
    cJSON_AddNumberToObject(document, "probes_ms", work->probes_ms);
    cJSON_AddNumberToObject(document, "render_ms", work->render_ms);
    json_add_text(document, "device", svo_device_name(work->done.opened.device));
    cJSON_AddItemToObject(document, "eye", cJSON_CreateFloatArray(work->camera.eye, 3));
    cJSON_AddItemToObject(document, "target", cJSON_CreateFloatArray(work->camera.target, 3));
    return json_print(work->state, document);
}

static int report(const probe_render *work)
{
    const options *given = &work->state->options;
    if (given->json) {
        return report_json(work);
    }
    if (given->quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(work->state->progress);
    table_line("%s: %ux%u pixels of %s in %s", output_name(given->output_path), given->width, given->height,
               given->input, figure_ms(work->render_ms).text);
    table_line("probes: %u x %u x %u of %u x %u texels, %s, in %s; %s moved, %s off", work->info.counts[0],
               work->info.counts[1], work->info.counts[2], work->info.resolution, work->info.resolution,
               figure_bytes(work->info.total_bytes).text, figure_ms(work->probes_ms).text,
               figure_count(work->info.moved).text, figure_count(work->info.off).text);
    table_line("rays: %.2f %% hit, %.2f %% miss, %.2f %% unknown", percent_of(work, SVO_PROBE_HIT),
               percent_of(work, SVO_PROBE_MISS), percent_of(work, SVO_PROBE_UNKNOWN));
    return PROGRAM_DONE;
}

static int render(probe_render *work)
{
    program *state = work->state;
    int exit_code = lighting_place_camera(state, &work->lit, work->done.result.tree, &work->camera);
    if (exit_code == PROGRAM_DONE && state->options.view == SVO_VIEW_SHADED) {
        exit_code = lighting_make_for_picture(state, &work->done, &work->camera, &work->lit);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_probes(work);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = trace(work);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = draw(work);
    }
    return exit_code == PROGRAM_DONE ? report(work) : exit_code;
}

int render_probes(program *state)
{
    probe_render work = {.state = state};
    int exit_code = lighting_open(state, &work.lit);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const unsigned steps = state->options.view == SVO_VIEW_SHADED ? 4 : 3;
    exit_code = lighting_tree(state, steps, &work.lit, &work.done);
    if (exit_code == PROGRAM_DONE) {
        exit_code = render(&work);
        ray_table_free(&work.rays);
        free(work.hits);
        svo_probes_destroy(&work.probes);
        svo_light_destroy(&work.lit.light);
        job_release(&work.done);
    }
    lighting_close(&work.lit);
    return exit_code;
}
