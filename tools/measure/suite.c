/* SPDX-License-Identifier: MIT */
/* Reads the options, opens the session and each scene, and calls the subjects for each depth. */
#include "measure/suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "measure/instruction_set.h"
#include "support/devices.h"
#include "svocl/version.h"

#define REPEATS       11
#define QUICK_REPEATS 3

/* ---- options ---- */

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
        all->scenes[count++] = name;
        name = comma;
    }
    return PROGRAM_DONE;
}

static int read_depths(suite *all, const char *list)
{
    size_t count = 0;
    for (const char *text = list; *text != '\0';) {
        char *end = NULL;
        const unsigned long depth = strtoul(text, &end, 10);
        const bool is_number = *text >= '0' && *text <= '9' && depth >= SVO_DEPTH_MIN && depth <= SVO_DEPTH_MAX;
        const bool more = *end == ',' && end[1] != '\0';
        if (!is_number || (*end != '\0' && !more) || count + 1 == SUITE_LIST_MAX) {
            return program_fail(all->state, PROGRAM_WRONG_USAGE,
                                "--depths '%s' is not a list of 1 to %d depths, %d to %d", list, SUITE_LIST_MAX - 1,
                                SVO_DEPTH_MIN, SVO_DEPTH_MAX);
        }
        all->depths[count++] = (unsigned)depth;
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
        exit_code = read_depths(all, given->depths);
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
    char *text = devices_text(svo_device_cl_device(all->opened.device), NULL, which);
    result_set_fact(all->results, fact, text != NULL ? text : "");
    free(text);
}

static void describe_machine(suite *all)
{
    result_machine *machine = &all->results->machine;
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    const options *given = &all->state->options;
    result_set_fact(all->results, &machine->device, svo_device_name(all->opened.device));
    keep_device_fact(all, CL_DRIVER_VERSION, &machine->driver);
    keep_device_fact(all, CL_DEVICE_VERSION, &machine->platform);
    result_set_fact(all->results, &machine->renderer,
                    all->opened.gl != NULL ? opengl_renderer(all->opened.gl) : "none");
    snprintf(machine->svocl, sizeof machine->svocl, "%s", svo_version_string());
    snprintf(machine->instruction_set, sizeof machine->instruction_set, "%s", instruction_set_name(given->isa));
    machine->cpu_threads = given->threads != 0 ? (unsigned)given->threads : online > 0 ? (unsigned)online : 1;
}

/* ---- the run ---- */

/* Puts "scene:" before a name that begins with that of a scene. */
static void complete_name(const char *name, char *text, size_t text_bytes)
{
    bool is_scene = false;
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        const char *known = scene_describe(i)->name;
        const size_t length = strlen(known);
        is_scene = is_scene || (strncmp(name, known, length) == 0 && (name[length] == '\0' || name[length] == ':'));
    }
    snprintf(text, text_bytes, "%s%s", is_scene ? "scene:" : "", name);
}

/* One scene at every depth. */
static int run_scene(suite *all, const suite_subject *subject, const char *name, const unsigned *depths)
{
    char text[1024];
    input source;
    complete_name(name, text, sizeof text);
    all->state->options.input = text;
    progress_hold(all->state->progress, true);
    int exit_code = input_open(all->state, &source);
    progress_hold(all->state->progress, false);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    for (size_t i = 0; depths[i] != 0 && exit_code == PROGRAM_DONE; ++i) {
        progress_step(all->state->progress, subject->name);
        exit_code = subject->run(all, &source, depths[i]);
    }
    input_close(&source);
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
    return strcmp(wanted, subject->group) == 0 || strcmp(wanted, subject->name) == 0;
}

static int run_wanted(suite *all, const suite_subject *const *subjects, const char *wanted)
{
    unsigned steps = 0;
    for (size_t i = 0; subjects[i] != NULL; ++i) {
        steps += suite_is_wanted(subjects[i], wanted) ? count_steps(all, subjects[i]) : 0;
    }
    program_begin_progress(all->state, steps);
    int exit_code = session_open_both(all->state, &all->opened);
    if (exit_code != PROGRAM_DONE) {
        goto cleanup;
    }
    describe_machine(all);
    for (size_t i = 0; subjects[i] != NULL; ++i) {
        exit_code = suite_is_wanted(subjects[i], wanted) ? run_subject(all, subjects[i]) : PROGRAM_DONE;
        if (exit_code != PROGRAM_DONE) {
            goto cleanup;
        }
    }
    if (!result_is_whole(all->results)) {
        exit_code = program_fail(all->state, PROGRAM_FAILED, "out of memory for the tables");
    }
cleanup:
    session_close(&all->opened);
    return exit_code;
}

int suite_collect(program *state, const suite_subject *const *subjects, const char *wanted, result_set *results)
{
    suite all = {.state = state, .results = results};
    const options given = state->options; /* a subject may change them for its own work */
    int exit_code = read_options(&all);
    if (exit_code == PROGRAM_DONE) {
        exit_code = run_wanted(&all, subjects, wanted);
    }
    progress_destroy(&state->progress);
    state->options = given;
    free(all.scene_text);
    return exit_code;
}
