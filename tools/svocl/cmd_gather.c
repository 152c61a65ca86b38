/* SPDX-License-Identifier: MIT */
/* svocl gather: ambient occlusion, direct, indirect and specular light at points, and a path-traced reference. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "path/path.h"
#include "support/info_of.h"
#include "support/light_points.h"
#include "support/lighting.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/table.h"
#include "svocl/commands.h"

/* The exponent of the specular cones: points have no material. */
#define SPECULAR_EXPONENT 64.0F

typedef struct gathering {
    program *state;
    job done;
    lighting lit;
    svo_light_setup setup;
    point_table at;
    svo_gather_result *results;
    path_result *paths; /* NULL without --reference */
    double gather_ms, trace_ms;
    double range; /* of ambient occlusion; 0: any distance */
    size_t left_out; /* points outside the grid or without a normal */
    double openness; /* mean over the others */
    double openness_error, irradiance_error; /* root of the mean square against the paths, over the others */
} gathering;

/* ---- points ---- */

/* Mirrors the way from the camera at the normal; without a camera specular cones go along the normal. */
static void reflect(const gathering *work, svo_gather_point *point)
{
    float along[3];
    float projected = 0;
    float squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
        along[axis] = point->position[axis] - work->lit.file.camera.eye[axis];
        projected += along[axis] * point->normal[axis];
        squared += point->normal[axis] * point->normal[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        const float mirrored = along[axis] - (squared > 0 ? 2 * projected / squared * point->normal[axis] : 0);
        point->reflected[axis] = work->lit.file.has_camera ? mirrored : point->normal[axis];
    }
    point->exponent = SPECULAR_EXPONENT;
}

static bool is_left_out(const svo_tree_info *info, const svo_gather_point *point)
{
    bool has_normal = false;
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) {
        const double from_corner = (double)point->position[axis] - info->origin[axis];
        inside = inside && from_corner >= 0 && from_corner <= info->edge;
        has_normal = has_normal || point->normal[axis] != 0.0F;
    }
    return !inside || !has_normal;
}

/* ---- light ---- */

static int gather_into(const gathering *work, const svo_gather_options *asked, svo_gather_result *results)
{
    return svo_gather(work->lit.light, svo_in_host(work->at.points), svo_in_host(results), work->at.count, asked,
                      &(svo_submit){.queue = work->done.opened.queue}) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(work->state, svo_device_message(work->done.opened.device));
}

/* Occlusion of the range that is chosen where none is given: cones that end there bring no light from beyond, so they
   are others than those of light. */
static int gather_occlusion(gathering *work)
{
    svo_gather_options asked = lighting_gather(&work->state->options);
    svo_gather_result *open = calloc(work->at.count + 1, sizeof *open);
    if (open == NULL) {
        return program_fail(work->state, PROGRAM_FAILED, "out of memory for %zu points", work->at.count);
    }
    asked.range = (float)work->range;
    asked.no_light = 1;
    const int exit_code = gather_into(work, &asked, open);
    for (size_t i = 0; i < work->at.count && exit_code == PROGRAM_DONE; ++i) {
        work->results[i].openness = open[i].openness;
    }
    free(open);
    return exit_code;
}

static int gather(gathering *work)
{
    program *state = work->state;
    svo_gather_options asked = lighting_gather(&state->options);
    const bool by_cones = asked.method == SVO_GATHER_CONES || asked.cones != 0;
    work->range = lighting_occlusion_range(&state->options, work->done.result.tree);
    work->results = calloc(work->at.count + 1, sizeof *work->results);
    if (work->results == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu points", work->at.count);
    }
    for (size_t i = 0; i < work->at.count; ++i) {
        reflect(work, &work->at.points[i]);
    }
    progress_step(state->progress, "gathering light");
    const double started_ms = input_now_ms();
    asked.range = by_cones ? asked.range : (float)work->range;
    int exit_code = gather_into(work, &asked, work->results);
    if (exit_code == PROGRAM_DONE && by_cones && !options_is_given(&state->options, "range")) {
        exit_code = gather_occlusion(work);
    }
    work->gather_ms = input_now_ms() - started_ms;
    return exit_code;
}

static int trace_paths(gathering *work)
{
    program *state = work->state;
    const options *given = &state->options;
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    const path_scene paths = {.tree = work->done.result.tree,
                              .mesh = work->done.source.mesh,
                              .queue = work->done.opened.queue,
                              .setup = &work->setup,
                              .range = work->range,
                              .falloff = given->falloff,
                              .bounces = (unsigned)given->bounces,
                              .threads = given->threads != 0 ? (unsigned)given->threads
                                         : online > 0        ? (unsigned)online
                                                             : 1};
    progress_step(state->progress, "tracing paths");
    work->paths = calloc(work->at.count + 1, sizeof *work->paths);
    if (work->paths == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu points", work->at.count);
    }
    const double started_ms = input_now_ms();
    const svo_status status =
        path_trace(&paths, work->at.points, work->at.count, path_sample_count((unsigned)given->reference),
                   (uint32_t)given->seed, work->paths);
    work->trace_ms = input_now_ms() - started_ms;
    if (status == SVO_OK) {
        return PROGRAM_DONE;
    }
    return status == SVO_OUT_OF_HOST_MEMORY ? program_fail(state, PROGRAM_FAILED, "out of memory for paths")
                                            : program_fail_library(state, svo_device_message(work->done.opened.device));
}

static void compare(gathering *work)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(work->done.result.tree, &info);
    size_t count = 0;
    for (size_t i = 0; i < work->at.count; ++i) {
        if (is_left_out(&info, &work->at.points[i])) {
            ++work->left_out;
            continue;
        }
        const svo_gather_result *result = &work->results[i];
        ++count;
        work->openness += (double)result->openness;
        if (work->paths != NULL) {
            const double difference = (double)result->openness - work->paths[i].openness;
            work->openness_error += difference * difference;
            for (int channel = 0; channel < 3; ++channel) {
                const double off = (double)result->irradiance[channel] - work->paths[i].irradiance[channel];
                work->irradiance_error += off * off / 3;
            }
        }
    }
    if (count > 0) {
        work->openness /= (double)count;
        work->openness_error = sqrt(work->openness_error / (double)count);
        work->irradiance_error = sqrt(work->irradiance_error / (double)count);
    }
}

/* ---- results ---- */

static void write_floats(output_file *file, const float *numbers, size_t count, const char *end)
{
    char text[32];
    for (size_t i = 0; i < count; ++i) {
        const int length = snprintf(text, sizeof text, "%.9g%s", (double)numbers[i], i + 1 < count ? "," : end);
        output_write(file, text, (size_t)length);
    }
}

static void write_point(const gathering *work, size_t index, output_file *file)
{
    const svo_gather_point *point = &work->at.points[index];
    const svo_gather_result *result = &work->results[index];
    write_floats(file, point->position, 3, ",");
    write_floats(file, point->normal, 3, ",");
    write_floats(file, &result->openness, 1, ",");
    write_floats(file, result->irradiance, 3, ",");
    write_floats(file, result->specular, 3, ",");
    write_floats(file, result->direct, 3, ",");
    const float errors[2] = {result->openness_error, result->irradiance_error};
    write_floats(file, errors, 2, work->paths != NULL ? "," : "\n");
    if (work->paths != NULL) {
        const path_result *path = &work->paths[index];
        const float reference[4] = {(float)path->openness, (float)path->irradiance[0], (float)path->irradiance[1],
                                    (float)path->irradiance[2]};
        write_floats(file, reference, 4, "\n");
    }
}

static int write_results(const gathering *work)
{
    static const char heading[] = "x,y,z,nx,ny,nz,ao,r,g,b,specular_r,specular_g,specular_b,"
                                  "direct_r,direct_g,direct_b,ao_error,light_error";
    static const char reference[] = ",reference_ao,reference_r,reference_g,reference_b";
    output_file file;
    progress_step(work->state->progress, "writing the light");
    const int exit_code = output_open(work->state, work->state->options.output_path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    output_write(&file, heading, sizeof heading - 1);
    if (work->paths != NULL) {
        output_write(&file, reference, sizeof reference - 1);
    }
    output_write(&file, "\n", 1);
    for (size_t i = 0; i < work->at.count; ++i) {
        write_point(work, i, &file);
    }
    return output_commit(work->state, &file);
}

static int report_json(const gathering *work)
{
    const options *given = &work->state->options;
    cJSON *document = json_document();
    json_add_text(document, "input", given->input);
    json_add_text(document, "file", given->output_path);
    json_add_text(document, "method", lighting_method(given));
    json_add_count(document, "points", work->at.count);
    json_add_count(document, "left_out", work->left_out);
    cJSON_AddNumberToObject(document, "ao", work->openness);
    cJSON_AddNumberToObject(document, "range", work->range);
    if (work->paths != NULL) {
        cJSON_AddNumberToObject(document, "ao_rmse", work->openness_error);
        cJSON_AddNumberToObject(document, "irradiance_rmse", work->irradiance_error);
        cJSON_AddNumberToObject(document, "trace_ms", work->trace_ms);
    }
    lighting_report_scene_json(document, &work->lit, &work->done);
    lighting_report_json(document, &work->lit);
    cJSON_AddNumberToObject(document, "gather_ms", work->gather_ms);
    json_add_text(document, "device", info_of_device(work->done.opened.device).name);
    return json_print(work->state, document);
}

static int report(const gathering *work)
{
    const options *given = &work->state->options;
    if (given->json) {
        return report_json(work);
    }
    if (given->quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(work->state->progress);
    table_line("%s: %s points of %s by %s in %s; light in %s", output_name(given->output_path),
               figure_count(work->at.count).text, given->input, lighting_method(given), figure_ms(work->gather_ms).text,
               figure_ms(work->lit.light_ms).text);
    lighting_report_range(given, work->range);
    lighting_report_scene(&work->lit, &work->done);
    if (work->paths != NULL) {
        table_line("against %u paths a point, in %s: RMSE of ambient occlusion %.4f, of irradiance %.4f",
                   path_sample_count((unsigned)given->reference), figure_ms(work->trace_ms).text, work->openness_error,
                   work->irradiance_error);
    }
    if (work->left_out > 0) {
        table_line("%s points lie outside the grid or have no normal: open and dark",
                   figure_count(work->left_out).text);
    }
    return PROGRAM_DONE;
}

/* ---- the command ---- */

static int run(gathering *work)
{
    program *state = work->state;
    int exit_code = light_points_make(state, work->done.source.mesh, &work->at);
    work->setup = lighting_setup(&work->lit, &work->done);
    if (exit_code == PROGRAM_DONE) {
        exit_code = lighting_make(state, &work->done, &work->setup, &work->lit);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = gather(work);
    }
    if (exit_code == PROGRAM_DONE && state->options.reference > 0) {
        exit_code = trace_paths(work);
    }
    if (exit_code == PROGRAM_DONE) {
        compare(work);
        exit_code = write_results(work);
    }
    return exit_code == PROGRAM_DONE ? report(work) : exit_code;
}

static int check_options(program *state)
{
    static const char *const random[] = {"seed", NULL};
    const options *given = &state->options;
    if (light_points_check(state) != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    if (light_points_are_read(state) && given->reference == 0 &&
        options_refuse(state, random, "to points of a file without --reference") != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    if (given->output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
    }
    return given->reference > 0 && input_is_tree(state)
               ? program_fail(state, PROGRAM_WRONG_USAGE,
                              "%s is a finished tree: --reference needs the mesh and its colors", given->input)
               : output_check(state, given->output_path);
}

int command_gather(program *state)
{
    gathering work = {.state = state};
    int exit_code = check_options(state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = lighting_open(state, &work.lit);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = lighting_tree(state, 4, &work.lit, &work.done);
    if (exit_code == PROGRAM_DONE && state->options.reference > 0 && work.done.source.mesh == NULL) {
        exit_code = program_fail(state, PROGRAM_WRONG_USAGE, "%s is no mesh: --reference needs triangles",
                                 state->options.input);
        job_release(&work.done);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = run(&work);
        svo_light_destroy(&work.lit.light);
        job_release(&work.done);
    }
    point_table_free(&work.at);
    free(work.results);
    free(work.paths);
    lighting_close(&work.lit);
    return exit_code;
}
