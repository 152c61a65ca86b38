/* SPDX-License-Identifier: MIT */
/* svocl trace: traces rays from a file or a camera against the triangles of a tree and writes the hits to a file. */
#include <stdlib.h>

#include "support/info_of.h"
#include "support/job.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/query_table.h"
#include "support/table.h"
#include "svocl/commands.h"

static int write_hits(program *state, const svo_hit *hits, size_t count)
{
    output_file file;
    progress_step(state->progress, "writing the hits");
    const int exit_code = output_open(state, state->options.output_path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    ray_table_write_hits(&file, hits, count);
    return output_commit(state, &file);
}

static int report(program *state, const session *opened, const svo_tree *tree, const svo_hit *hits, size_t count,
                  double trace_ms)
{
    size_t met = 0;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_get_info(tree, &info);
    for (size_t i = 0; i < count; ++i) {
        met += hits[i].triangle != SVO_NO_TRIANGLE;
    }
    if (state->options.json) {
        cJSON *document = json_document();
        json_add_text(document, "input", state->options.input);
        json_add_text(document, "file", state->options.output_path);
        json_add_count(document, "rays", count);
        json_add_count(document, "hits", met);
        json_add_count(document, "depth", info.depth);
        cJSON_AddNumberToObject(document, "trace_ms", trace_ms);
        json_add_text(document, "device", info_of_device(opened->device).name);
        return json_print(state, document);
    }
    if (state->options.quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(state->progress);
    table_line("%s: %s of %s rays hit %s at depth %u, in %s", output_name(state->options.output_path),
               figure_count(met).text, figure_count(count).text, state->options.input, info.depth,
               figure_ms(trace_ms).text);
    return PROGRAM_DONE;
}

static int make_rays(program *state, svo_tree *tree, ray_table *out)
{
    const options *given = &state->options;
    if (given->rays_path != NULL) {
        return ray_table_read(state, given->rays_path, out);
    }
    svo_camera framed = {.vertical_fov = 0};
    svo_camera camera;
    (void)svo_camera_fit(svo_tree_target(tree), (float)given->width / (float)given->height, &framed);
    if (!ray_table_parse_camera(given->camera, &framed, &camera)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--camera '%s' is neither auto nor 6, 9 or 10 numbers",
                            given->camera);
    }
    return ray_table_from_camera(state, &camera, given->width, given->height, NULL, out);
}

/* tree: on the device, with its arrays on the host. */
static int trace(program *state, const session *opened, svo_tree *tree)
{
    ray_table cast = {0};
    progress_step(state->progress, "tracing rays");
    int exit_code = make_rays(state, tree, &cast);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    svo_hit *hits = calloc(cast.count + 1, sizeof *hits);
    if (hits == NULL) {
        exit_code = program_fail(state, PROGRAM_FAILED, "out of memory for %zu rays", cast.count);
        ray_table_free(&cast);
        return exit_code;
    }
    const double started_ms = input_now_ms();
    if (svo_trace_triangles(svo_tree_target(tree), svo_in_host(cast.rays), svo_in_host(hits), cast.count,
                            SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened->queue}) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(opened->device));
    }
    const double trace_ms = input_now_ms() - started_ms;
    if (exit_code == PROGRAM_DONE) {
        exit_code = write_hits(state, hits, cast.count);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, opened, tree, hits, cast.count, trace_ms);
    }
    free(hits);
    ray_table_free(&cast);
    return exit_code;
}

static int make_tree(program *state, job *done)
{
    if (input_is_tree(state)) {
        return job_load(state, 2, done);
    }
    state->options.depth_for_rays = !state->options.has_depth;
    return job_run(state, SVO_NEED_RAYS, 2, done);
}

int command_trace(program *state)
{
    const options *given = &state->options;
    if ((given->rays_path != NULL) == (given->camera != NULL)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "exactly one of --rays FILE and --camera VIEW is required, got %s",
                            given->camera != NULL ? "both" : "neither");
    }
    static const char *const of_pictures[] = {"size", NULL};
    static const char *const of_payload[] = {"need", "weights", "drop-alpha", NULL};
    if ((given->rays_path != NULL && options_refuse(state, of_pictures, "with --rays") != PROGRAM_DONE) ||
        options_refuse(state, of_payload, "to rays") != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    if (given->rays_path != NULL && state->piped.name != NULL && piped_is_standard_input(given->rays_path)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "INPUT and --rays both read standard input");
    }
    if (given->output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
    }
    job done;
    int exit_code = output_check(state, given->output_path);
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_tree(state, &done);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = trace(state, &done.opened, done.result.tree);
        job_release(&done);
    }
    return exit_code;
}
