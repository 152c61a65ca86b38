/* SPDX-License-Identifier: MIT */
/* Renders a .svo file in pages: pictures follow each other until one misses nothing, or nothing more finds room. */
#include "svocl/render.h"

#include <inttypes.h>
#include <stdio.h>

#include "support/input.h"
#include "support/json.h"
#include "support/parts_input.h"
#include "support/picture.h"
#include "support/session.h"
#include "support/table.h"
#include "support/viewpoint.h"
#include "svocl/paged.h"

typedef struct paged_render {
    program *state;
    session opened;
    svo_paged *paged;
    svo_parts_region region; /* of a folder of parts */
    svo_paged_info info;
    svo_paged_counts counts;
    svo_render_options asked;
    double render_ms; /* of all pictures and updates */
} paged_render;

static int fail_library(const paged_render *work, svo_status status)
{
    svo_message message;
    (void)snprintf(message.text, sizeof message.text, "%s", svo_device_message(work->opened.device));
    return input_is_parts(work->state) ? parts_input_fail(work->state, status, &message)
                                       : program_fail_library(work->state, message.text);
}

static int check(program *state)
{
    const options *given = &state->options;
    if (!input_is_tree(state) || input_is_compact(state) || state->piped.name != NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--paged reads a .svo file or a folder of parts, not %s",
                            given->input);
    }
    if ((given->last_level != 0 || given->region != NULL) && !input_is_parts(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s with --paged applies to folders of parts alone",
                            given->region != NULL ? "region" : "levels");
    }
    if (given->view >= (int)SVO_VIEW_TRIANGLES || given->through != 0 ||
        (given->given_groups & ((unsigned)OPTION_LIGHT | (unsigned)OPTION_PROBES)) != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--paged has the views shaded, normal, depth, steps and level alone, without lights");
    }
    return input_refuse_build_options(state);
}

/* The upper levels of what is drawn. */
static int load_coarse(const paged_render *work, svo_tree **coarse)
{
    program *state = work->state;
    const uint32_t levels = work->info.depth < SVO_FRAME_LEVEL_MAX ? work->info.depth : SVO_FRAME_LEVEL_MAX;
    const svo_load_options load_options = {.struct_size = sizeof load_options, .last_level = levels};
    svo_message message = {""};
    if (!input_is_parts(state)) {
        return svo_tree_load(svo_from_path(state->options.input), &load_options, coarse, &message) == SVO_OK
                   ? PROGRAM_DONE
                   : program_fail_library(state, message.text);
    }
    svo_parts_tree *tree = NULL;
    svo_parts_region region = work->region;
    region.last_level = region.level + levels;
    int exit_code = parts_input_open(state, &tree);
    if (exit_code == PROGRAM_DONE) {
        const svo_status status = svo_parts_tree_load(tree, &region, coarse, &message);
        exit_code = status == SVO_OK ? PROGRAM_DONE : parts_input_fail(state, status, &message);
    }
    svo_parts_tree_close(&tree);
    return exit_code;
}

static int place_camera(paged_render *work)
{
    svo_tree *coarse = NULL;
    const int loaded = load_coarse(work, &coarse);
    if (loaded != PROGRAM_DONE) {
        return loaded;
    }
    const viewpoint_subject shown = {.target = svo_tree_target(coarse), .aspect = viewpoint_aspect(work->state)};
    const int exit_code = viewpoint_place(work->state, &shown, &work->asked.camera);
    svo_tree_destroy(&coarse);
    return exit_code;
}

/* Whether another picture would differ from the last one. */
static bool may_improve(const paged_render *work)
{
    return work->counts.missed_pages > 0 && (work->counts.pictures < 2 || work->counts.read_pages > 0);
}

static int draw(void *user, const svo_camera *camera, const svo_picture_output *output, uint8_t *pixels)
{
    paged_render *work = user;
    svo_render_options asked = work->asked;
    asked.camera = *camera;
    asked.output = *output;
    do {
        svo_status status = svo_paged_update(work->paged);
        if (status == SVO_OK) {
            status = svo_paged_render(work->paged, &asked, pixels);
        }
        if (status != SVO_OK) {
            return fail_library(work, status);
        }
        (void)svo_paged_get_counts(work->paged, &work->counts);
    } while (may_improve(work));
    return PROGRAM_DONE;
}

static int report(const paged_render *work)
{
    const options *given = &work->state->options;
    const svo_paged_counts *counts = &work->counts;
    if (given->json) {
        cJSON *document = picture_document(work->state);
        json_add_count(document, "device_bytes", work->info.device_bytes);
        json_add_count(document, "whole_bytes", work->info.whole_bytes);
        json_add_count(document, "file_bytes", work->info.file_bytes);
        json_add_count(document, "pages", work->info.page_count);
        json_add_count(document, "held_pages", counts->held_pages);
        json_add_count(document, "pictures", counts->pictures);
        json_add_count(document, "missed_pages", counts->missed_pages);
        json_add_count(document, "read_bytes", counts->all_read_bytes);
        return picture_print_document(work->state, document, work->render_ms, work->opened.device, &work->asked.camera);
    }
    if (!given->quiet) {
        progress_hide(work->state->progress);
        table_line("%s of %s in %s, %s pictures; %s of %s pages in %s of buffers", picture_describe(given).text,
                   given->input, figure_ms(work->render_ms).text, figure_count(counts->pictures).text,
                   figure_count(counts->held_pages).text, figure_count(work->info.page_count).text,
                   figure_bytes(work->info.device_bytes).text);
        if (counts->missed_pages > 0) {
            table_line("%s pages have no room; coarser nodes stand in", figure_count(counts->missed_pages).text);
        }
    }
    return PROGRAM_DONE;
}

static int render(paged_render *work)
{
    const options *given = &work->state->options;
    svo_paged_options asked = SVO_PAGED_OPTIONS_INIT;
    int exit_code = parts_input_region(work->state, &work->region);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    asked.region = input_is_parts(work->state) ? &work->region : NULL;
    const svo_status status = svo_paged_open(work->opened.device, given->input, given->paged, &asked, &work->paged);
    if (status != SVO_OK) {
        return fail_library(work, status);
    }
    (void)svo_paged_get_info(work->paged, &work->info);
    exit_code = place_camera(work);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    return picture_draw(work->state, "casting rays", &work->asked.camera, draw, work, &work->render_ms);
}

int render_paged(program *state)
{
    const options *given = &state->options;
    paged_render work = {.state = state, .info = SVO_PAGED_INFO_INIT, .counts = SVO_PAGED_COUNTS_INIT};
    work.asked = (svo_render_options){.struct_size = sizeof work.asked,
                                      .width = given->width,
                                      .height = given->height,
                                      .view = (svo_render_view)given->view};
    int exit_code = check(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    program_begin_progress(state, 2 + picture_frames(given));
    progress_step(state->progress, "reading the tree");
    exit_code = session_open_device(state, &work.opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = render(&work);
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(&work);
    }
    svo_paged_close(&work.paged);
    session_close(&work.opened);
    return exit_code;
}
