/* SPDX-License-Identifier: MIT */
/* From INPUT to a tree in memory, measured: shared by build, hash, verify and render. */
#include "support/job.h"

#include <stdlib.h>
#include <string.h>

#include "support/hybrid.h"
#include "support/info_of.h"

static void keep_buffers(const svo_plan *plan, build_result *result)
{
    const svo_plan_info info = info_of_plan(plan);
    result->peak_bytes = info.peak_bytes;
    free(result->buffers);
    result->buffers = calloc(info.buffer_count + 1, sizeof *result->buffers);
    result->buffer_count = result->buffers != NULL ? info.buffer_count : 0;
    for (size_t i = 0; i < result->buffer_count; ++i) {
        result->buffers[i] = (svo_buffer_info)SVO_BUFFER_INFO_INIT;
        svo_plan_get_buffer(plan, i, &result->buffers[i]);
    }
}

/* A plan at the requested depth, or at the best depth for rays. */
static svo_status make_plan(const program *state, svo_device *device, const input *source,
                            const svo_plan_options *plan_options, svo_plan **out)
{
    const options *given = &state->options;
    const svo_mesh *mesh = source->mesh;
    if (mesh == NULL) {
        return voxel_input_plan(state, device, &source->voxels, plan_options, out);
    }
    svo_status status = svo_plan_create(device, mesh, (unsigned)given->depth, plan_options, out);
    if (status != SVO_OK || !given->depth_for_rays) {
        return status;
    }
    const unsigned depth = info_of_plan(*out).ray_depth;
    if (depth != (unsigned)given->depth) {
        svo_plan_destroy(out);
        status = svo_plan_create(device, mesh, depth, plan_options, out);
    }
    return status;
}

int job_show_progress(void *user, svo_stage stage, double fraction)
{
    progress_part(user, svo_name(SVO_NAME_STAGE, stage), fraction);
    return progress_stops(user) ? 1 : 0;
}

svo_plan_options job_plan_options(const program *state, uint32_t need)
{
    const options *given = &state->options;
    const bool in_gl = given->builder == OPTION_BUILDER_GL_COMPUTE;
    svo_plan_options plan_options = {.struct_size = sizeof plan_options,
                                     .need = need,
                                     .coverage = (svo_coverage)given->coverage,
                                     .weights = (svo_weights)given->weights,
                                     .builder = in_gl ? SVO_BUILDER_CL : (svo_builder)given->builder,
                                     .payload_level = (uint32_t)given->payload_level,
                                     .edge = given->edge,
                                     .drop_alpha = given->drop_alpha};
    memcpy(plan_options.origin, given->origin, sizeof plan_options.origin);
    return plan_options;
}

int job_plan(program *state, svo_device *device, const input *source, uint32_t need, svo_plan **out)
{
    const options *given = &state->options;
    if (source->mesh == NULL && !given->has_depth && given->payload_level > source->voxels.list.depth) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--payload-level %u is above the depth, %u",
                            (unsigned)given->payload_level, source->voxels.list.depth);
    }
    svo_plan_options plan_options = job_plan_options(state, need);
    if (state->progress != NULL && given->repeat == 1) { /* builds that report wait more often: not where times count */
        plan_options.progress = job_show_progress;
        plan_options.progress_user = state->progress;
    }
    return make_plan(state, device, source, &plan_options, out) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(state, svo_device_message(device));
}

/* The status is for programs that run this one. */
static int fail_build(program *state, svo_status status, const char *message)
{
    if (state->options.json) {
        cJSON *document = json_document();
        json_add_text(document, "status", svo_name(SVO_NAME_STATUS, status));
        (void)json_print(state, document);
    }
    return program_fail_library(state, message);
}

/* Builds the tree of a plan and replaces the tree of an earlier build in result. */
static int build_plan(program *state, session *opened, svo_plan *plan, build_result *result)
{
    session_choose(state, opened, plan);
    if (state->options.tune) {
        const int exit_code = hybrid_tune(state, opened->gl, plan, opened->queue, &opened->frontend, &opened->reason);
        state->options.tune = false; /* once for all builds */
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    }
    if (state->options.count_first && svo_plan_count(plan, opened->frontend, opened->queue) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    progress_step(state->progress, "building the tree");
    svo_tree_destroy(&result->tree);
    result->report = (svo_build_report){.struct_size = sizeof result->report};
    const svo_status status = state->options.builder == OPTION_BUILDER_GL_COMPUTE
                                  ? opengl_build(opened->gl, plan, opened->queue, &result->tree, &result->report)
                                  : svo_build(plan, opened->frontend, opened->queue, &result->tree, &result->report);
    if (status != SVO_OK) {
        return fail_build(state, status, svo_device_message(opened->device));
    }
    result->plan = (svo_plan_info)SVO_PLAN_INFO_INIT;
    svo_plan_get_info(plan, &result->plan);
    result->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    svo_tree_get_info(result->tree, &result->info);
    keep_buffers(plan, result);
    return PROGRAM_DONE;
}

/* One build from the source to the tree. */
static int build_once(program *state, session *opened, const input *source, uint32_t need, build_result *result)
{
    svo_plan *plan = NULL;
    cl_calls before;
    const double begun_ms = input_now_ms();
    result->calls_are_counted = cl_calls_count(&before);
    progress_step(state->progress, "rounding to the grid");
    int exit_code = job_plan(state, opened->device, source, need, &plan);
    if (exit_code == PROGRAM_DONE) {
        exit_code = build_plan(state, opened, plan, result);
    }
    result->wall_ms = input_now_ms() - begun_ms;
    result->calls = cl_calls_since(&before);
    svo_plan_destroy(&plan);
    return exit_code;
}

static int compare_doubles(const void *a, const void *b)
{
    const double left = *(const double *)a;
    const double right = *(const double *)b;
    return (left > right) - (left < right);
}

static double median(double *values, size_t count)
{
    qsort(values, count, sizeof *values, compare_doubles);
    return count % 2 == 1 ? values[count / 2] : (values[count / 2 - 1] + values[count / 2]) / 2.0;
}

/* Times of a build: of its stages, and the wall clock's. */
#define TIMES (SVO_STAGE_COUNT + 1)

/* Where a result has a time. */
static double *time_at(build_result *result, size_t index)
{
    return index < SVO_STAGE_COUNT ? &result->report.stage_times[index].ms : &result->wall_ms;
}

/* Replaces the times of the last build by medians over the builds after the first. */
static void take_medians(double *times, size_t repeats, build_result *result)
{
    for (size_t i = 0; i < TIMES && repeats > 1; ++i) {
        *time_at(result, i) = median(times + i * repeats, repeats - 1);
    }
}

static int build_repeatedly(program *state, session *opened, const input *source, uint32_t need, build_result *result)
{
    const size_t repeats = (size_t)state->options.repeat;
    double *times = calloc(repeats * TIMES, sizeof *times); /* of each kind, the builds after the first */
    if (times == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; i < repeats && exit_code == PROGRAM_DONE; ++i) {
        exit_code = build_once(state, opened, source, need, result);
        if (i == 0) {
            result->first_compile_ms = result->report.stage_times[SVO_STAGE_COMPILE].ms;
        }
        for (size_t k = 0; k < TIMES && i > 0; ++k) {
            times[k * repeats + i - 1] = *time_at(result, k);
        }
    }
    take_medians(times, repeats, result);
    free(times);
    if (exit_code == PROGRAM_DONE && svo_tree_download(result->tree, opened->queue) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(opened->device));
    }
    return exit_code;
}

int job_build(program *state, uint32_t need, job *done)
{
    return build_repeatedly(state, &done->opened, &done->source, need, &done->result);
}

int job_open(program *state, uint32_t need, unsigned further_steps, job *done)
{
    *done = (job){0};
    if (state->options.json) {
        cl_calls_keep_kernels();
    }
    program_begin_progress(state, 1 + 2 * (unsigned)state->options.repeat + further_steps);
    int exit_code = input_open_any(state, need, &done->source);
    if (exit_code == PROGRAM_DONE) {
        exit_code = session_open(state, &done->opened);
    }
    if (exit_code != PROGRAM_DONE) {
        job_release(done);
    }
    return exit_code;
}

int job_run(program *state, uint32_t need, unsigned further_steps, job *done)
{
    int exit_code = job_open(state, need, further_steps, done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = job_build(state, need, done);
    if (exit_code != PROGRAM_DONE) {
        job_release(done);
    }
    return exit_code;
}

int job_load(program *state, unsigned further_steps, job *done)
{
    *done = (job){0};
    int exit_code = input_refuse_build_options(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    program_begin_progress(state, 1 + further_steps);
    exit_code = input_load_tree(state, &done->result.tree);
    if (exit_code == PROGRAM_DONE) {
        exit_code = session_open_device(state, &done->opened);
    }
    if (exit_code == PROGRAM_DONE &&
        svo_tree_upload(done->result.tree, done->opened.device, done->opened.queue) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(done->opened.device));
    }
    if (exit_code != PROGRAM_DONE) {
        job_release(done);
    }
    return exit_code;
}

void job_release(job *done)
{
    svo_tree_destroy(&done->result.tree);
    free(done->result.buffers);
    done->result = (build_result){0};
    session_close(&done->opened);
    input_close(&done->source);
}

void job_add_what_ran(cJSON *document, const job *done)
{
    json_add_text(document, "frontend", done->result.report.frontend);
    json_add_text(document, "frontend_reason", done->opened.reason.text);
    json_add_text(document, "share", done->result.report.share);
    json_add_text(document, "builder", done->result.report.builder);
    json_add_text(document, "coverage", svo_name(SVO_NAME_COVERAGE, (svo_coverage)done->result.info.coverage));
    json_add_text(document, "weights", svo_name(SVO_NAME_WEIGHTS, (svo_weights)done->result.info.weights));
    json_add_text(document, "context", session_context(&done->opened));
    json_add_text(document, "device", info_of_device(done->opened.device).name);
    json_add_text(document, "renderer", session_renderer(&done->opened));
    json_add_count(document, "depth", done->result.info.depth);
}
