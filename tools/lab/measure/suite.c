/* SPDX-License-Identifier: MIT */
/* Reads the options, opens the session and each scene, and calls the subjects for each depth. */
#include "measure/suite.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "measure/host.h"
#include "support/devices.h"
#include "support/info_of.h"

#define REPEATS       11
#define QUICK_REPEATS 3

/* ---- options ---- */

/* Whether a name is that of a scene, with "scene:" or without. */
static bool is_scene(const char *name)
{
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        const char *known = scene_describe(i)->name;
        const size_t length = strlen(known);
        if (strncmp(name, known, length) == 0 && (name[length] == '\0' || name[length] == ':')) {
            return true;
        }
    }
    return strncmp(name, "scene:", 6) == 0;
}

static int read_scenes(suite *all, const char *list)
{
    size_t count = 0;
    all->scene_text = strdup(list);
    if (all->scene_text == NULL) {
        return program_fail(all->state, PROGRAM_FAILED, "out of memory");
    }
    for (char *name = all->scene_text; name != NULL;) {
        char *comma = strchr(name, ',');
        if (comma != NULL) {
            *comma++ = '\0';
        }
        if (*name == '\0' || count + 1 == SUITE_LIST_MAX) {
            return program_fail(all->state, PROGRAM_WRONG_USAGE, "--scenes '%s' is not a list of 1 to %d names", list,
                                SUITE_LIST_MAX - 1);
        }
        if (!is_scene(name) && access(name, R_OK) != 0) {
            return program_fail(all->state, PROGRAM_FAILED, "--scenes: %s: %s", name, strerror(errno));
        }
        all->scenes[count++] = name;
        name = comma;
    }
    return PROGRAM_DONE;
}

int suite_read_depths(program *state, const char *list, unsigned depths[SUITE_LIST_MAX])
{
    size_t count = 0;
    for (const char *text = list; *text != '\0';) {
        char *end = NULL;
        const unsigned long depth = strtoul(text, &end, 10);
        const bool is_number = *text >= '0' && *text <= '9' && depth >= SVO_DEPTH_MIN && depth <= SVO_DEPTH_MAX;
        const bool more = *end == ',' && end[1] != '\0';
        if (!is_number || (*end != '\0' && !more) || count + 1 == SUITE_LIST_MAX) {
            return program_fail(state, PROGRAM_WRONG_USAGE, "--depths '%s' is not a list of 1 to %d depths, %d to %d",
                                list, SUITE_LIST_MAX - 1, SVO_DEPTH_MIN, SVO_DEPTH_MAX);
        }
        depths[count++] = (unsigned)depth;
        text = more ? end + 1 : end;
    }
    return PROGRAM_DONE;
}

static int read_options(suite *all)
{
    const options *given = &all->state->options;
    all->quick = given->quick != 0;
    all->repeats = given->has_repeat ? (size_t)given->repeat : all->quick ? QUICK_REPEATS : REPEATS;
    int exit_code = given->scenes != NULL ? read_scenes(all, given->scenes) : PROGRAM_DONE;
    if (exit_code == PROGRAM_DONE && given->depths != NULL) {
        exit_code = suite_read_depths(all->state, given->depths, all->depths);
    }
    return exit_code;
}

static suite_work work_of(const suite *all, const suite_subject *subject)
{
    suite_work work = all->quick ? subject->quick : subject->full;
    if (all->scenes[0] != NULL && !subject->fixed) {
        memcpy(work.scenes, all->scenes, sizeof work.scenes);
    }
    if (all->depths[0] != 0 && !subject->fixed) {
        memcpy(work.depths, all->depths, sizeof work.depths);
    }
    return work;
}

const char *suite_scene_name(const input *source)
{
    const char *slash = strrchr(source->name, '/');
    return slash != NULL ? slash + 1 : strncmp(source->name, "scene:", 6) == 0 ? source->name + 6 : source->name;
}

result_table *suite_add_table(suite *all, const char *id, const char *title, const char *note)
{
    result_table *table = result_add_table(all->results, id, title, note);
    result_set_note(table, "Medians and quartiles (q1, q3) of %zu run%s after a warm-up run. %s", all->repeats,
                    all->repeats == 1 ? "" : "s", note);
    return table;
}

/* ---- the machine ---- */

static void keep_device_fact(suite *all, cl_device_info which, char **fact)
{
    char *text = devices_text(info_of_device(all->opened.device).device, NULL, which);
    result_set_fact(all->results, fact, text != NULL ? text : "");
    free(text);
}

static void describe_machine(suite *all)
{
    result_machine *machine = &all->results->machine;
    host_describe(&all->state->options, machine);
    result_set_fact(all->results, &machine->device, info_of_device(all->opened.device).name);
    keep_device_fact(all, CL_DRIVER_VERSION, &machine->driver);
    keep_device_fact(all, CL_DEVICE_VERSION, &machine->platform);
    result_set_fact(all->results, &machine->renderer,
                    all->opened.gl != NULL ? opengl_renderer(all->opened.gl) : "none");
}

/* ---- the run ---- */

int suite_name(program *state, const char *name, suite_input *out)
{
    const char *prefix = is_scene(name) && strncmp(name, "scene:", 6) != 0 ? "scene:" : "";
    if (snprintf(out->text, sizeof out->text, "%s%s", prefix, name) >= (int)sizeof out->text) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--scenes: '%s' is longer than %zu bytes", name,
                            sizeof out->text - sizeof "scene:");
    }
    return PROGRAM_DONE;
}

static int open_named(program *state, const char *name, bool takes_voxels, suite_input *out)
{
    const int named = suite_name(state, name, out);
    if (named != PROGRAM_DONE) {
        return named;
    }
    state->options.input = out->text;
    progress_hold(state->progress, true);
    const int exit_code =
        takes_voxels ? input_open_any(state, SVO_NEED_NONE, &out->source) : input_open(state, &out->source);
    progress_hold(state->progress, false);
    return exit_code;
}

int suite_open(program *state, const char *name, suite_input *out)
{
    return open_named(state, name, false, out);
}

/* Opens each INPUT of --scenes and closes it again: one that cannot be read fails before anything is measured. */
static int check_scenes(suite *all, const suite_subject *const *subjects, const char *wanted)
{
    const char *kept = all->state->options.input;
    int exit_code = PROGRAM_DONE;
    bool takes_voxels = false;
    for (size_t i = 0; subjects[i] != NULL; ++i) {
        takes_voxels = takes_voxels || (subjects[i]->takes_voxels && suite_is_wanted(subjects[i], wanted));
    }
    for (size_t i = 0; all->scenes[i] != NULL && exit_code == PROGRAM_DONE; ++i) {
        suite_input opened = {.text = ""};
        exit_code = open_named(all->state, all->scenes[i], takes_voxels, &opened);
        if (exit_code == PROGRAM_DONE) {
            input_close(&opened.source);
        }
    }
    all->state->options.input = kept;
    return exit_code;
}

/* One scene at every depth, or voxels at theirs. */
static int run_scene(suite *all, const suite_subject *subject, const char *name, const unsigned *depths)
{
    suite_input opened = {.text = ""};
    int exit_code = open_named(all->state, name, subject->takes_voxels, &opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const unsigned of_voxels[] = {opened.source.voxels.list.depth, 0};
    depths = opened.source.mesh != NULL ? depths : of_voxels;
    for (size_t i = 0; depths[i] != 0 && exit_code == PROGRAM_DONE; ++i) {
        progress_step(all->state->progress, subject->words->name);
        exit_code = subject->run(all, &opened.source, depths[i]);
    }
    input_close(&opened.source);
    return exit_code;
}

static int run_subject(suite *all, const suite_subject *subject)
{
    if (subject->run_all != NULL) {
        return subject->run_all(all);
    }
    const suite_work work = work_of(all, subject);
    int exit_code = subject->begin(all);
    for (size_t i = 0; work.scenes[i] != NULL && exit_code == PROGRAM_DONE; ++i) {
        exit_code = run_scene(all, subject, work.scenes[i], work.depths);
    }
    return exit_code;
}

static unsigned count_steps(const suite *all, const suite_subject *subject)
{
    const suite_work work = work_of(all, subject);
    unsigned scenes = 0;
    unsigned depths = 0;
    while (work.scenes[scenes] != NULL) {
        ++scenes;
    }
    while (work.depths[depths] != 0) {
        ++depths;
    }
    return subject->run_all != NULL ? subject->step_count : scenes * depths;
}

bool suite_is_wanted(const suite_subject *subject, const char *wanted)
{
    return strcmp(wanted, subject->words->group) == 0 || strcmp(wanted, subject->words->name) == 0;
}

/* The steps of the subjects from the first one on. */
static unsigned count_all_steps(const suite *all, const suite_subject *const *subjects, const char *wanted)
{
    unsigned steps = 0;
    for (size_t i = 0; subjects[i] != NULL; ++i) {
        steps += suite_is_wanted(subjects[i], wanted) ? count_steps(all, subjects[i]) : 0;
    }
    return steps;
}

/* Says in the tables that the subject added, from the first on, why there are no more rows. */
static void keep_failure(suite *all, const suite_subject *subject, size_t first_table)
{
    result_set *results = all->results;
    for (size_t i = first_table; i < results->table_count; ++i) {
        result_drop_partial_row(results->tables[i]);
        result_extend_note(results->tables[i], "Not measured to the end: %s.", all->state->last_failure);
    }
    if (results->table_count == first_table) {
        result_table *table = result_add_table(results, subject->words->name, subject->words->summary, "Not measured.");
        result_add_column(table, "reason", "");
        result_add_text(table, "%s", all->state->last_failure);
    }
    ++all->failed_count;
}

static int run_wanted(suite *all, const suite_subject *const *subjects, const char *wanted)
{
    program_begin_progress(all->state, count_all_steps(all, subjects, wanted));
    int exit_code = check_scenes(all, subjects, wanted);
    if (exit_code == PROGRAM_DONE) {
        exit_code = session_open_both(all->state, &all->opened);
    }
    if (exit_code != PROGRAM_DONE) {
        goto cleanup;
    }
    describe_machine(all);
    for (size_t i = 0; subjects[i] != NULL; ++i) {
        const size_t first_table = all->results->table_count;
        exit_code = suite_is_wanted(subjects[i], wanted) ? run_subject(all, subjects[i]) : PROGRAM_DONE;
        if (exit_code != PROGRAM_DONE && strcmp(wanted, subjects[i]->words->name) == 0) {
            goto cleanup;
        }
        if (exit_code != PROGRAM_DONE) {
            keep_failure(all, subjects[i], first_table);
            program_begin_progress(all->state, count_all_steps(all, subjects + i + 1, wanted));
            exit_code = PROGRAM_DONE;
        }
    }
    if (!result_is_whole(all->results)) {
        exit_code = program_fail(all->state, PROGRAM_FAILED, "out of memory for the tables");
    }
cleanup:
    session_close(&all->opened);
    return exit_code;
}

int suite_collect(program *state, const suite_subject *const *subjects, const char *wanted, result_set *results,
                  size_t *failed_count)
{
    suite all = {.state = state, .results = results};
    const options given = state->options; /* a subject may change them for its own work */
    int exit_code = read_options(&all);
    if (exit_code == PROGRAM_DONE) {
        exit_code = run_wanted(&all, subjects, wanted);
    }
    progress_destroy(&state->progress);
    state->options = given;
    *failed_count += all.failed_count;
    free(all.scene_text);
    return exit_code;
}
