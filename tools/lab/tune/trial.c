/* SPDX-License-Identifier: MIT */
/* Sessions are opened as their first setting runs, and stay open: steady state is what is measured. */
#include "tune/trial.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/info_of.h"
#include "support/job.h"
#include "tune/light_errors.h"

#define RAYS 16384u

/* Builds that are shorter depend on what ran before them. */
#define SHORT_BUILD_MS 50.0

bool trials_open(program *state, sampler *made, uint64_t queries, bool traces, trials *out)
{
    *out = (trials){.state = state, .made = made, .queries = queries, .traces = traces};
    out->gathered = calloc(GATHER_POINTS, sizeof *out->gathered);
    return out->gathered != NULL;
}

void trials_close(trials *all)
{
    for (size_t i = 0; i < all->count; ++i) {
        if (all->list[i].works) {
            session_close(&all->list[i].opened);
        }
    }
    free(all->gathered);
    all->gathered = NULL;
    all->count = 0;
}

/* ---- sessions ---- */

/* Opens by the options of a command line that names the setting. */
static void open_session(trials *all, const tune_setting *setting, trial_session *out)
{
    program *state = all->state;
    const options kept = state->options;
    svo_message *const kept_failure = state->failure;
    state->options.path = setting->values[DIMENSION_PATH];
    state->options.frontend = setting->values[DIMENSION_FRONTEND];
    state->options.share = setting->values[DIMENSION_SHARE];
    state->options.builder = setting->values[DIMENSION_BUILDER];
    state->failure = &out->reason;
    out->works = session_open(state, &out->opened) == PROGRAM_DONE;
    state->failure = kept_failure;
    state->options = kept;
}

static trial_session *find_session(trials *all, const tune_setting *setting)
{
    const int values[4] = {setting->values[DIMENSION_PATH], setting->values[DIMENSION_FRONTEND],
                           setting->values[DIMENSION_SHARE],
                           setting->values[DIMENSION_BUILDER] == OPTION_BUILDER_GL_COMPUTE};
    for (size_t i = 0; i < all->count; ++i) {
        if (memcmp(all->list[i].values, values, sizeof values) == 0) {
            return &all->list[i];
        }
    }
    if (all->count == TRIAL_SESSIONS_MAX) {
        return NULL;
    }
    trial_session *made = &all->list[all->count++];
    memcpy(made->values, values, sizeof values);
    open_session(all, setting, made);
    return made;
}

/* ---- one run ---- */

typedef struct trial {
    trials *all;
    const tune_setting *setting;
    session *opened;
    svo_plan *plan;
    svo_tree *tree;
    svo_compact *form;
    svo_light *light;
    svo_probes *probes;
    trial_times *times;
} trial;

static bool build(trial *run)
{
    const int *at = run->setting->values;
    const bool in_gl = at[DIMENSION_BUILDER] == OPTION_BUILDER_GL_COMPUTE;
    const uint32_t need = run->setting->need;
    svo_plan_options asked = job_plan_options(run->all->state, need != 0 ? need : (uint32_t)SVO_NEED_NONE);
    asked.coverage = (svo_coverage)at[DIMENSION_COVERAGE];
    asked.weights = (svo_weights)at[DIMENSION_WEIGHTS];
    asked.builder = in_gl ? SVO_BUILDER_CL : (svo_builder)at[DIMENSION_BUILDER];
    const double started_ms = input_now_ms();
    if (svo_plan_create(run->opened->device, run->all->made->source->mesh, (unsigned)at[DIMENSION_DEPTH], &asked,
                        &run->plan) != SVO_OK) {
        return false;
    }
    if (at[DIMENSION_FRONTEND] == OPTION_FRONTEND_AUTO && !in_gl) {
        session_choose(run->all->state, run->opened, run->plan);
    }
    const svo_status status = in_gl ? opengl_build(run->opened->gl, run->plan, run->opened->queue, &run->tree, NULL)
                                    : svo_build(run->plan, run->opened->frontend, run->opened->queue, &run->tree, NULL);
    run->times->build_ms = input_now_ms() - started_ms;
    if (status == SVO_OK) {
        const svo_plan_info info = info_of_plan(run->plan);
        run->times->bytes = (double)info.peak_bytes;
        run->times->result_bytes = (double)info.tree_bytes;
    }
    return status == SVO_OK;
}

/* Builds; a short build a second time, which counts, so that each has its own kind before it: the caches and the memory
   that another setting leaves behind would make it slower, and which one that is depends on the sweep. */
static bool build_warm(trial *run)
{
    bool worked = build(run);
    if (worked && run->times->build_ms < SHORT_BUILD_MS) {
        svo_tree_destroy(&run->tree);
        svo_plan_destroy(&run->plan);
        worked = build(run);
    }
    return worked;
}

static bool make_form(trial *run)
{
    const int form = run->setting->values[DIMENSION_FORM];
    const svo_compact_options asked = {.struct_size = sizeof asked, .form = (svo_form)(form - 1)};
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    const double started_ms = input_now_ms();
    if (form == 0) {
        return true;
    }
    if (svo_compact_create(run->opened->device, run->tree, &asked, run->opened->queue, &run->form) != SVO_OK) {
        return false;
    }
    run->times->form_ms = input_now_ms() - started_ms;
    svo_compact_get_info(run->form, &info);
    run->times->bytes = fmax(run->times->bytes, run->times->result_bytes + (double)info.total_bytes);
    run->times->result_bytes = (double)info.total_bytes;
    return true;
}

/* What is left on the device grows by so much, and by scratch while it is made. */
static void count_bytes(trial_times *times, uint64_t kept, uint64_t scratch)
{
    times->result_bytes += (double)kept;
    times->bytes = fmax(times->bytes, times->result_bytes + (double)scratch);
}

static bool make_light(trial *run)
{
    svo_light_info info = SVO_LIGHT_INFO_INIT;
    svo_probe_info of_probes = SVO_PROBE_INFO_INIT;
    const bool has_probes = gather_how(run->setting->values[DIMENSION_GATHER]) == GATHER_PROBES;
    const double started_ms = input_now_ms();
    run->light = sampler_light(run->all->made, run->opened, run->tree, run->setting);
    if (run->light != NULL && has_probes) {
        run->probes = sampler_probes(run->opened, run->tree, run->light, run->setting);
    }
    run->times->light_ms = input_now_ms() - started_ms;
    if (run->light == NULL || svo_light_get_info(run->light, &info) != SVO_OK || (has_probes && run->probes == NULL)) {
        return false;
    }
    count_bytes(run->times, info.total_bytes + info.sky_bytes + info.mesh_bytes, info.scratch_bytes);
    if (has_probes && svo_probes_get_info(run->probes, &of_probes) == SVO_OK) {
        count_bytes(run->times, of_probes.total_bytes, of_probes.scratch_bytes);
    }
    return true;
}

static void count_queries(trial_times *times, double ms, size_t count)
{
    times->once_ms = ms;
    times->query_us = 1e3 * ms / (double)count;
}

static bool gather(trial *run)
{
    if (!make_light(run)) {
        return false;
    }
    const double started_ms = input_now_ms();
    const bool worked =
        sampler_gather(run->all->made, run->opened, run->light, run->probes, run->setting, run->all->gathered);
    count_queries(run->times, input_now_ms() - started_ms, GATHER_POINTS);
    return worked;
}

/* Rays from one side of the grid to the other. */
static bool trace(trial *run)
{
    const svo_tree_info *grid = &run->all->made->grid;
    const svo_target target = run->form != NULL ? svo_compact_target(run->form) : svo_tree_target(run->tree);
    svo_ray *rays = calloc(RAYS, sizeof *rays);
    svo_voxel_hit *hits = calloc(RAYS, sizeof *hits);
    for (size_t i = 0; i < RAYS && rays != NULL; ++i) {
        const size_t row = i / 128;
        const double part[3] = {(double)(i % 128) / 128, (double)row / 128, -0.5};
        const unsigned turn = (unsigned)(i % 3);
        rays[i] = (svo_ray){.t_max = INFINITY};
        for (unsigned axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = (float)(grid->origin[axis] + grid->edge * part[(axis + turn) % 3]);
            rays[i].direction[axis] = (axis + turn) % 3 == 2 ? 1.0F : 0.05F;
        }
    }
    const double started_ms = input_now_ms();
    const bool worked = rays != NULL && hits != NULL &&
                        svo_trace_voxels(target, svo_in_host(rays), svo_in_host(hits), RAYS, 0, SVO_TRACE_CLOSEST,
                                         &(svo_submit){.queue = run->opened->queue}) == SVO_OK;
    count_queries(run->times, input_now_ms() - started_ms, RAYS);
    free(rays);
    free(hits);
    return worked;
}

bool trial_run(trials *all, const tune_setting *setting, trial_times *out, svo_message *reason)
{
    trial_session *with = find_session(all, setting);
    *out = (trial_times){0};
    if (with == NULL || !with->works) {
        (void)snprintf(reason->text, sizeof reason->text, "%s", with != NULL ? with->reason.text : "too many sessions");
        return false;
    }
    trial run = {.all = all, .setting = setting, .opened = &with->opened, .times = out};
    bool worked = build_warm(&run) && make_form(&run);
    if (worked && setting->values[DIMENSION_GATHER] != 0) {
        worked = gather(&run);
    } else if (worked && all->traces) {
        worked = trace(&run);
    }
    out->once_ms += out->build_ms + out->form_ms + out->light_ms;
    out->total_ms = out->build_ms + out->form_ms + out->light_ms + 1e-3 * out->query_us * (double)all->queries;
    if (!worked) {
        (void)snprintf(reason->text, sizeof reason->text, "%s", svo_device_message(with->opened.device));
    }
    svo_probes_destroy(&run.probes);
    svo_light_destroy(&run.light);
    svo_compact_destroy(&run.form);
    svo_tree_destroy(&run.tree);
    svo_plan_destroy(&run.plan);
    return worked;
}
