/* SPDX-License-Identifier: MIT */
/* svocl reference: the light at points, path-traced against the triangles of a mesh: what cones are compared with. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "path/path.h"
#include "program/commands.h"
#include "support/light_points.h"
#include "support/lighting.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/query_table.h"
#include "support/table.h"

_Static_assert(OPTION_SAMPLES_MAX == PATH_SAMPLES_MAX, "--samples takes what path_trace takes");

typedef struct reference {
    lighting lit; /* its file alone */
    point_table at;
    path_result *results;
    unsigned samples;
    double trace_ms;
    size_t left_out; /* points outside the grid or without a normal */
    double openness_error, largest_openness_error; /* standard errors over all other points: root of the mean square */
    double irradiance_error, irradiance; /* of all three channels: the same, and the mean */
} reference;

/* ---- tracing ---- */

static void sum_errors(reference *work)
{
    size_t count = 0;
    for (size_t i = 0; i < work->at.count; ++i) {
        const path_result *one = &work->results[i];
        count += one->is_gathered;
        work->openness_error += one->openness_error * one->openness_error;
        work->largest_openness_error = fmax(work->largest_openness_error, one->openness_error);
        for (int channel = 0; channel < 3; ++channel) {
            work->irradiance += one->irradiance[channel] / 3;
            work->irradiance_error += one->irradiance_error[channel] * one->irradiance_error[channel] / 3;
        }
    }
    work->left_out = work->at.count - count;
    if (count > 0) {
        work->openness_error = sqrt(work->openness_error / (double)count);
        work->irradiance_error = sqrt(work->irradiance_error / (double)count);
        work->irradiance /= (double)count;
    }
}

static int trace(program *state, job *done, reference *work)
{
    const options *given = &state->options;
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    const svo_light_setup setup = lighting_setup(&work->lit, done);
    const path_scene paths = {.tree = done->result.tree,
                              .mesh = done->source.mesh,
                              .queue = done->opened.queue,
                              .setup = &setup,
                              .range = given->range,
                              .falloff = given->falloff,
                              .bounces = (unsigned)given->bounces,
                              .threads = given->threads != 0 ? (unsigned)given->threads
                                         : online > 0        ? (unsigned)online
                                                             : 1};
    progress_step(state->progress, "tracing paths");
    work->results = calloc(work->at.count + 1, sizeof *work->results);
    if (work->results == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu points", work->at.count);
    }
    const double started_ms = input_now_ms();
    const svo_status status =
        path_trace(&paths, work->at.points, work->at.count, work->samples, (uint32_t)given->seed, work->results);
    work->trace_ms = input_now_ms() - started_ms;
    if (status != SVO_OK) {
        return status == SVO_OUT_OF_HOST_MEMORY ? program_fail(state, PROGRAM_FAILED, "out of memory for paths")
                                                : program_fail_library(state, svo_device_message(done->opened.device));
    }
    sum_errors(work);
    return PROGRAM_DONE;
}

/* ---- results ---- */

static void write_numbers(output_file *file, const double *numbers, size_t count, const char *end)
{
    char text[32];
    for (size_t i = 0; i < count; ++i) {
        const int length = snprintf(text, sizeof text, "%.9g%s", numbers[i], i + 1 < count ? "," : end);
        output_write(file, text, (size_t)length);
    }
}

static void write_point(output_file *file, const svo_gather_point *point, const path_result *result)
{
    const double place[6] = {(double)point->position[0], (double)point->position[1], (double)point->position[2],
                             (double)point->normal[0],   (double)point->normal[1],   (double)point->normal[2]};
    write_numbers(file, place, 6, ",");
    write_numbers(file, &result->openness, 1, ",");
    write_numbers(file, result->irradiance, 3, ",");
    write_numbers(file, result->direct, 3, ",");
    write_numbers(file, &result->openness_error, 1, ",");
    write_numbers(file, result->irradiance_error, 3, "\n");
}

static int write_results(program *state, const reference *work)
{
    static const char heading[] =
        "x,y,z,nx,ny,nz,ao,r,g,b,direct_r,direct_g,direct_b,ao_error,r_error,g_error,b_error\n";
    output_file file;
    progress_step(state->progress, "writing the light");
    const int exit_code = output_open(state, state->options.output_path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    output_write(&file, heading, sizeof heading - 1);
    for (size_t i = 0; i < work->at.count; ++i) {
        write_point(&file, &work->at.points[i], &work->results[i]);
    }
    return output_commit(state, &file);
}

static int report_json(program *state, const reference *work)
{
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "file", state->options.output_path);
    json_add_count(document, "points", work->at.count);
    json_add_count(document, "left_out", work->left_out);
    json_add_count(document, "samples", work->samples);
    cJSON_AddNumberToObject(document, "ao_error", work->openness_error);
    cJSON_AddNumberToObject(document, "largest_ao_error", work->largest_openness_error);
    cJSON_AddNumberToObject(document, "irradiance", work->irradiance);
    cJSON_AddNumberToObject(document, "irradiance_error", work->irradiance_error);
    cJSON_AddNumberToObject(document, "trace_ms", work->trace_ms);
    return json_print(state, document);
}

static int report(program *state, const reference *work)
{
    if (state->options.json) {
        return report_json(state, work);
    }
    if (state->options.quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(state->progress);
    table_line("%s: %s points, %s samples each, in %s", output_name(state->options.output_path),
               figure_count(work->at.count).text, figure_count(work->samples).text, figure_ms(work->trace_ms).text);
    table_line("standard error of ambient occlusion %.4f, largest %.4f; of irradiance %.4f, whose mean is %.4f",
               work->openness_error, work->largest_openness_error, work->irradiance_error, work->irradiance);
    if (work->left_out > 0) {
        table_line("%s points lie outside the grid or have no normal: open and dark",
                   figure_count(work->left_out).text);
    }
    return PROGRAM_DONE;
}

/* ---- the command ---- */

static int run(program *state, job *done)
{
    reference work = {.samples = path_sample_count((unsigned)state->options.samples)};
    int exit_code =
        done->source.mesh != NULL
            ? light_points_make(state, done->source.mesh, &work.at)
            : program_fail(state, PROGRAM_WRONG_USAGE, "%s is no mesh: paths need triangles", state->options.input);
    if (exit_code == PROGRAM_DONE) {
        exit_code = lighting_open(state, &work.lit);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = trace(state, done, &work);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = write_results(state, &work);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, &work);
    }
    lighting_close(&work.lit);
    point_table_free(&work.at);
    free(work.results);
    return exit_code;
}

int command_reference(program *state)
{
    const options *given = &state->options;
    static const char *const of_payload[] = {"need", "weights", "drop-alpha", NULL};
    if (light_points_check(state) != PROGRAM_DONE || options_refuse(state, of_payload, "to paths") != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    if (given->output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
    }
    if (input_is_tree(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s is a finished tree: paths need the mesh and its colors",
                            given->input);
    }
    job done;
    int exit_code = output_check(state, given->output_path);
    if (exit_code == PROGRAM_DONE) {
        state->options.depth_for_rays = !given->has_depth;
        exit_code = job_run(state, SVO_NEED_RAYS, 2, &done);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = run(state, &done);
        job_release(&done);
    }
    return exit_code;
}
