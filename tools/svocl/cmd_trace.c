/* SPDX-License-Identifier: MIT */
/* svocl trace: traces rays from a file or a camera against the triangles or the voxels of a tree, or the voxels of a
   compact tree, and writes the hits to a file. */
#include <math.h>
#include <stdlib.h>

#include "support/info_of.h"
#include "support/job.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/query_table.h"
#include "support/table.h"
#include "support/tree_form.h"
#include "svocl/commands.h"

/* Rays, what they meet, and their hits: of triangles or of voxels. */
typedef struct ray_run {
    program *state;
    const session *opened;
    svo_target target;
    unsigned depth;
    ray_table cast;
    svo_hit *hits; /* NULL: rays meet voxels */
    svo_voxel_hit *voxel_hits;
    double trace_ms;
} ray_run;

/* Compact trees have no triangles. */
static bool meets_voxels(const program *state)
{
    const options *given = &state->options;
    return given->meets == OPTION_MEETS_VOXELS || given->tree_form != 0 || input_is_compact(state);
}

static int write_hits(const ray_run *run)
{
    program *state = run->state;
    output_file file;
    progress_step(state->progress, "writing the hits");
    const int exit_code = output_open(state, state->options.output_path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (run->hits != NULL) {
        ray_table_write_hits(&file, run->hits, run->cast.count);
    } else {
        ray_table_write_voxel_hits(&file, run->voxel_hits, run->cast.count);
    }
    return output_commit(state, &file);
}

static size_t count_met(const ray_run *run)
{
    size_t met = 0;
    for (size_t i = 0; i < run->cast.count; ++i) {
        met += run->hits != NULL ? run->hits[i].triangle != SVO_NO_TRIANGLE : !isinf(run->voxel_hits[i].t);
    }
    return met;
}

static int report(const ray_run *run)
{
    program *state = run->state;
    const size_t count = run->cast.count;
    const size_t met = count_met(run);
    if (state->options.json) {
        cJSON *document = json_document();
        json_add_text(document, "input", state->options.input);
        json_add_text(document, "file", state->options.output_path);
        json_add_text(document, "meet", run->hits != NULL ? "triangles" : "voxels");
        json_add_count(document, "rays", count);
        json_add_count(document, "hits", met);
        json_add_count(document, "depth", run->depth);
        cJSON_AddNumberToObject(document, "trace_ms", run->trace_ms);
        json_add_text(document, "device", info_of_device(run->opened->device).name);
        return json_print(state, document);
    }
    if (state->options.quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(state->progress);
    table_line("%s: %s of %s rays hit %s of %s at depth %u, in %s", output_name(state->options.output_path),
               figure_count(met).text, figure_count(count).text, run->hits != NULL ? "triangles" : "voxels",
               state->options.input, run->depth, figure_ms(run->trace_ms).text);
    return PROGRAM_DONE;
}

static int make_rays(program *state, svo_target target, ray_table *out)
{
    const options *given = &state->options;
    if (given->rays_path != NULL) {
        return ray_table_read(state, given->rays_path, out);
    }
    svo_camera framed = {.vertical_fov = 0};
    svo_camera camera;
    (void)svo_camera_fit(target, (float)given->width / (float)given->height, &framed);
    if (!ray_table_parse_camera(given->camera, &framed, &camera)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--camera '%s' is neither auto nor 6, 9 or 10 numbers",
                            given->camera);
    }
    return ray_table_from_camera(state, &camera, given->width, given->height, NULL, out);
}

static int allocate_hits(ray_run *run)
{
    const size_t count = run->cast.count + 1;
    if (meets_voxels(run->state)) {
        run->voxel_hits = calloc(count, sizeof *run->voxel_hits);
    } else {
        run->hits = calloc(count, sizeof *run->hits);
    }
    return run->hits != NULL || run->voxel_hits != NULL
               ? PROGRAM_DONE
               : program_fail(run->state, PROGRAM_FAILED, "out of memory for %zu rays", run->cast.count);
}

static int trace(ray_run *run)
{
    const svo_submit submit = {.queue = run->opened->queue};
    const svo_array rays = svo_in_host(run->cast.rays);
    const double started_ms = input_now_ms();
    const svo_status status = run->hits != NULL ? svo_trace_triangles(run->target, rays, svo_in_host(run->hits),
                                                                      run->cast.count, SVO_TRACE_CLOSEST, &submit)
                                                : svo_trace_voxels(run->target, rays, svo_in_host(run->voxel_hits),
                                                                   run->cast.count, 0.0F, 0, &submit);
    run->trace_ms = input_now_ms() - started_ms;
    if (status != SVO_OK) {
        return program_fail_library(run->state, svo_device_message(run->opened->device));
    }
    const int exit_code = write_hits(run);
    return exit_code == PROGRAM_DONE ? report(run) : exit_code;
}

static int trace_target(program *state, const session *opened, svo_target target, unsigned depth)
{
    ray_run run = {.state = state, .opened = opened, .target = target, .depth = depth};
    progress_step(state->progress, "tracing rays");
    int exit_code = make_rays(state, target, &run.cast);
    if (exit_code == PROGRAM_DONE) {
        exit_code = allocate_hits(&run);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = trace(&run);
    }
    free(run.hits);
    free(run.voxel_hits);
    ray_table_free(&run.cast);
    return exit_code;
}

/* Of the tree, or of the compact tree in its place. */
static int trace_either(program *state, job *done, svo_compact *compact)
{
    svo_compact_info form = SVO_COMPACT_INFO_INIT;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    if (compact != NULL) {
        (void)svo_compact_get_info(compact, &form);
        return trace_target(state, &done->opened, svo_compact_target(compact), form.depth);
    }
    (void)svo_tree_get_info(done->result.tree, &info);
    return trace_target(state, &done->opened, svo_tree_target(done->result.tree), info.depth);
}

static int make_tree(program *state, unsigned further_steps, job *done)
{
    const bool voxels = meets_voxels(state);
    if (input_is_tree(state)) {
        return job_load(state, further_steps, done);
    }
    state->options.depth_for_rays = !voxels && !state->options.has_depth;
    return job_run(state, voxels ? SVO_NEED_NONE : SVO_NEED_RAYS, further_steps, done);
}

static int check_options(program *state)
{
    const options *given = &state->options;
    static const char *const of_pictures[] = {"size", NULL};
    static const char *const of_payload[] = {"need", "weights", NULL};
    static const char *const of_voxels[] = {"drop-alpha", NULL};
    if ((given->rays_path != NULL) == (given->camera != NULL)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "exactly one of --rays FILE and --camera VIEW is required, got %s",
                            given->camera != NULL ? "both" : "neither");
    }
    if ((given->rays_path != NULL && options_refuse(state, of_pictures, "with --rays") != PROGRAM_DONE) ||
        options_refuse(state, of_payload, "to rays") != PROGRAM_DONE ||
        (!meets_voxels(state) && options_refuse(state, of_voxels, "to rays") != PROGRAM_DONE)) {
        return PROGRAM_WRONG_USAGE;
    }
    if (given->meets == OPTION_MEETS_TRIANGLES && meets_voxels(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--meet triangles: compact trees have none, rays meet voxels");
    }
    if (given->rays_path != NULL && state->piped.name != NULL && piped_is_standard_input(given->rays_path)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "INPUT and --rays both read standard input");
    }
    return given->output_path != NULL ? output_check(state, given->output_path)
                                      : program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
}

int command_trace(program *state)
{
    const unsigned further_steps = state->options.tree_form != 0 ? 3 : 2;
    job done;
    svo_compact *compact = NULL;
    int exit_code = check_options(state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = input_is_compact(state) ? tree_form_load(state, further_steps, &done, &compact)
                                            : make_tree(state, further_steps, &done);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (compact == NULL) {
        exit_code = tree_form_take(state, &done, &compact);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = trace_either(state, &done, compact);
    }
    svo_compact_destroy(&compact);
    job_release(&done);
    return exit_code;
}
