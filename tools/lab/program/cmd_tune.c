/* SPDX-License-Identifier: MIT */
/* svocl tune: the settings that suit a mesh, by time, memory and error against its exact reference. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measure/result_text.h"
#include "program/commands.h"
#include "support/info_of.h"
#include "support/job.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/table.h"
#include "tune/answer.h"
#include "tune/answer_page.h"
#include "tune/state.h"

#define USUAL_DEPTHS    5u
#define MOST_FRAGMENTS  4e6 /* of the deepest of the usual depths */
#define LIGHT_QUERIES   100000u
#define FIRST_OF_DEPTHS 4u

void command_tune_print_measures(void)
{
    table *rows = table_create("lll");
    for (size_t i = 0; i < tune_measure_count(); ++i) {
        const tune_measure *one = tune_measure_at(i);
        table_cell(rows, "%s", one->name);
        table_cell(rows, "%s", one->unit);
        table_cell(rows, "%s", one->meaning);
    }
    table_gap();
    table_heading("MEASURES of --error");
    table_print_wrapped(rows, TABLE_HELP_WIDTH);
}

/* ---- wishes ---- */

static int read_bounds(program *state, tune_bounds *bounds)
{
    const options *given = &state->options;
    const int exit_code = tune_bounds_read(state, given->error_list, bounds);
    bounds->time_ms = given->time_bound > 0 ? 1e3 * given->time_bound : INFINITY;
    bounds->bytes = given->memory_bound > 0 ? (double)given->memory_bound : INFINITY;
    return exit_code;
}

/* The deepest at which the mesh has not too many fragments, and those above. */
static void usual_depths(const session *opened, const svo_mesh *mesh, unsigned depths[USUAL_DEPTHS + 1])
{
    unsigned last = FIRST_OF_DEPTHS;
    for (unsigned depth = FIRST_OF_DEPTHS; depth <= 12 && last + 1 >= depth; ++depth) {
        svo_plan *plan = NULL;
        if (svo_plan_create(opened->device, mesh, depth, NULL, &plan) == SVO_OK &&
            info_of_plan(plan).expected_fragments <= MOST_FRAGMENTS) {
            last = depth;
        }
        svo_plan_destroy(&plan);
    }
    const unsigned first = last > FIRST_OF_DEPTHS + USUAL_DEPTHS - 1 ? last - USUAL_DEPTHS + 1 : FIRST_OF_DEPTHS;
    for (unsigned i = 0; i < USUAL_DEPTHS + 1; ++i) {
        depths[i] = first + i <= last ? first + i : 0;
    }
    depths[USUAL_DEPTHS] = 0;
}

static tune_wish wish_for_light(const program *state, const tune_bounds *bounds)
{
    static const char *const names[] = {"cones", "rays", "probes"};
    const char *text = state->options.free_list;
    tune_wish wish = tune_bounds_ask(bounds, KIND_LIGHT) ? WISH_GATHER : WISH_NONE;
    for (size_t i = 0; i < sizeof names / sizeof names[0] && text != NULL; ++i) {
        wish = strstr(text, names[i]) != NULL ? WISH_GATHER : wish;
    }
    for (size_t i = 0; tune_bounds_at(bounds, i) != NULL; ++i) {
        wish = tune_bounds_at(bounds, i)->quantity == QUANTITY_LIGHT ? WISH_LIGHT : wish;
    }
    return state->options.lights_path != NULL && !tune_bounds_ask(bounds, KIND_LIGHT) ? WISH_LIGHT : wish;
}

/* What all trees hold: what --need names, or what `svocl build` chooses and what bounds ask for. */
static uint32_t common_need(const sweep *all)
{
    const uint32_t named = all->state->options.need;
    if (named != (uint32_t)SVO_NEED_DEFAULT) {
        return named & SVO_NEED_ALL;
    }
    uint32_t need = all->usual_need;
    for (size_t i = 0; tune_bounds_at(&all->bounds, i) != NULL; ++i) {
        need |= quantity_need(tune_bounds_at(&all->bounds, i)->quantity);
    }
    return need;
}

/* Fails where no setting can have a value of a bound. */
static int check_bounds(const sweep *all)
{
    text_list need;
    const sampler *made = all->made;
    for (size_t i = 0; tune_bounds_at(&all->bounds, i) != NULL; ++i) {
        const tune_measure *one = tune_bounds_at(&all->bounds, i);
        const uint32_t asked = quantity_need(one->quantity);
        tune_need_names(asked, &need);
        if ((asked & ~made->measured) != 0) {
            return program_fail(all->state, PROGRAM_WRONG_USAGE, "--error %s asks for %s, which --need leaves out",
                                one->name, need.text);
        }
        if (asked == SVO_NEED_COLOR && !made->has_colors) {
            return program_fail(all->state, PROGRAM_FAILED, "--error %s: %s has no colors", one->name,
                                made->source->name);
        }
        if (one->quantity == QUANTITY_ENCLOSED && !(made->volume > 0)) {
            return program_fail(all->state, PROGRAM_FAILED, "--error %s: %s is not closed", one->name,
                                made->source->name);
        }
    }
    return PROGRAM_DONE;
}

static void set_needs(sweep *all)
{
    const svo_mesh *mesh = all->made->source->mesh;
    const uint32_t common = common_need(all);
    const bool names = all->state->options.need != (uint32_t)SVO_NEED_DEFAULT || common != all->usual_need;
    for (size_t i = 0; i < all->count; ++i) {
        tune_setting *one = &all->settings[i].setting;
        one->need = common | tune_gather_need(one->values[DIMENSION_GATHER], mesh);
        one->names_need = names;
        all->made->has_probes = all->made->has_probes || gather_how(one->values[DIMENSION_GATHER]) == GATHER_PROBES;
    }
}

static int list_settings(sweep *all, const session *opened)
{
    unsigned depths[USUAL_DEPTHS + 1];
    tune_setting *list = calloc(TUNE_SETTINGS_MAX, sizeof *list);
    usual_depths(opened, all->made->source->mesh, depths);
    all->settings = calloc(TUNE_SETTINGS_MAX, sizeof *all->settings);
    int exit_code = list != NULL && all->settings != NULL
                        ? tune_space_read(all->state, depths, wish_for_light(all->state, &all->bounds), &all->space)
                        : program_fail(all->state, PROGRAM_FAILED, "out of memory");
    if (exit_code == PROGRAM_DONE) {
        exit_code = tune_space_list(all->state, &all->space, list, &all->count);
    }
    for (size_t i = 0; i < all->count; ++i) {
        all->settings[i].setting = list[i];
    }
    set_needs(all);
    free(list);
    return exit_code;
}

/* ---- results ---- */

static int write_file(const sweep *all, const result_set *tables, const char *path, bool is_page)
{
    output_file file;
    int exit_code = path != NULL ? output_open(all->state, path, &file) : PROGRAM_DONE;
    if (path == NULL || exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (is_page) {
        exit_code = answer_page(all, tables, file.stream);
    } else {
        result_write_csv(result_find(tables, "tune-rounds"), file.stream);
    }
    if (exit_code != PROGRAM_DONE) {
        output_abandon(&file);
        return exit_code;
    }
    return output_commit(all->state, &file);
}

static int show(const sweep *all)
{
    const options *given = &all->state->options;
    result_set *tables = answer_tables(all);
    if (tables == NULL || !result_is_whole(tables)) {
        result_destroy(&tables);
        return program_fail(all->state, PROGRAM_FAILED, "out of memory for tables");
    }
    int exit_code = write_file(all, tables, given->page_path, true);
    if (exit_code == PROGRAM_DONE) {
        exit_code = write_file(all, tables, given->csv_path, false);
    }
    if (exit_code == PROGRAM_DONE && given->json) {
        exit_code = json_print(all->state, answer_to_json(all, tables));
    } else if (exit_code == PROGRAM_DONE && !given->quiet) {
        progress_hide(all->state->progress);
        answer_print(all);
    }
    result_destroy(&tables);
    return exit_code;
}

/* ---- the command ---- */

static int run(program *state, job *done, const tune_bounds *bounds)
{
    const options *given = &state->options;
    sampler made;
    trials runs = {.state = state};
    sweep all = {.state = state,
                 .made = &made,
                 .runs = &runs,
                 .bounds = *bounds,
                 .seed = (uint32_t)given->seed,
                 .exhaustive = given->exhaustive != 0,
                 .save = state_save};
    progress_step(state->progress, "the reference");
    int exit_code = sampler_open(state, &done->source, &done->opened, &made);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const bool light = wish_for_light(state, bounds) != WISH_NONE;
    const uint64_t queries = given->queries > 0 || !light ? given->queries : LIGHT_QUERIES;
    all.usual_need = SVO_NEED_NORMAL | (made.has_colors ? (uint32_t)SVO_NEED_COLOR : 0);
    made.measured = given->need == (uint32_t)SVO_NEED_DEFAULT ? (uint32_t)SVO_NEED_ALL : given->need;
    exit_code = check_bounds(&all);
    exit_code = exit_code == PROGRAM_DONE ? list_settings(&all, &done->opened) : exit_code;
    if (exit_code == PROGRAM_DONE && (!trials_open(state, &made, queries, queries > 0, &runs) || !sweep_begin(&all))) {
        exit_code = program_fail(state, PROGRAM_FAILED, "out of memory for %zu settings", all.count);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = state_resume(&all);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = sweep_run(&all);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = show(&all);
    }
    sweep_end(&all);
    trials_close(&runs);
    sampler_close(&made);
    return exit_code;
}

static int check_files(program *state)
{
    const options *given = &state->options;
    const char *const paths[] = {given->page_path, given->csv_path, given->resume_path};
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; i < 3 && exit_code == PROGRAM_DONE; ++i) {
        exit_code = paths[i] != NULL ? output_check(state, paths[i]) : PROGRAM_DONE;
    }
    return exit_code;
}

int command_tune(program *state)
{
    static const char *const others[] = {"tune", "hybrid-columns", "voxel-size", NULL};
    tune_bounds bounds;
    job done = {.source = {.name = NULL}};
    int exit_code = options_refuse(state, others, "to tune");
    if (exit_code == PROGRAM_DONE && input_is_tree(state)) {
        exit_code = program_fail(state, PROGRAM_WRONG_USAGE, "%s is a finished tree: tune needs the mesh",
                                 state->options.input);
    }
    exit_code = exit_code == PROGRAM_DONE ? read_bounds(state, &bounds) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? check_files(state) : exit_code;
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    program_begin_progress(state, 2 + SWEEP_RUNGS + 1);
    exit_code = input_open(state, &done.source);
    if (exit_code == PROGRAM_DONE) {
        const options kept = state->options;
        state->options.frontend = OPTION_FRONTEND_CL;
        state->options.share = SVO_GL_SHARE_AUTO;
        state->options.builder = SVO_BUILDER_CL;
        exit_code = session_open(state, &done.opened);
        state->options = kept;
        exit_code = exit_code == PROGRAM_DONE ? run(state, &done, &bounds) : exit_code;
        job_release(&done);
    }
    return exit_code;
}
