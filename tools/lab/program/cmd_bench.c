/* SPDX-License-Identifier: MIT */
/* svocl bench: runs measurements and writes them as tables or JSON. The subjects are in bench/ and errors/. */
#include <string.h>

#include "bench/child.h"
#include "bench/gpu.h"
#include "bench/openvdb.h"
#include "bench/rays.h"
#include "bench/versus.h"
#include "measure/embree.h"
#include "measure/host.h"
#include "measure/result_json.h"
#include "measure/result_text.h"
#include "program/commands.h"
#include "program/subjects.h"
#include "support/json.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/suggest.h"
#include "support/table.h"

static bool is_in(size_t index, const char *group)
{
    return index < SUBJECT_COUNT && strcmp(subject_table[index].group, group) == 0;
}

static size_t add_subjects(table *rows, size_t index, const char *group)
{
    for (; is_in(index, group); ++index) {
        table_cell(rows, "%s", subject_table[index].name);
        table_cell(rows, "%s", subject_table[index].summary);
    }
    return index;
}

void command_bench_print_subjects(void)
{
    table *rows = table_create("ll");
    const size_t first_experiment = add_subjects(rows, 0, "all");
    table_cell(rows, "all");
    table_cell(rows, "all of these; rays alone takes INPUT and the options of a build");
    add_subjects(rows, first_experiment, "errors");
    table_cell(rows, "errors");
    table_cell(rows, "e1 to e5, e7 and e8");
    table_cell(rows, BENCH_GPU_NAME);
    table_cell(rows, BENCH_GPU_SUMMARY);
    table_cell(rows, BENCH_VERSUS_NAME);
    table_cell(rows, BENCH_VERSUS_SUMMARY);
    table_gap();
    table_heading("SUBJECT");
    table_print_wrapped(rows, TABLE_HELP_WIDTH);
}

/* "voxelize, build, ..., all, errors, e1 to e5, e7, e8, gpu, gl-vs-cl" */
static void list_subjects(char *text, size_t text_bytes)
{
    size_t used = 0;
    for (size_t i = 0; is_in(i, "all") && used < text_bytes; ++i) {
        used += (size_t)snprintf(text + used, text_bytes - used, "%s, ", subject_table[i].name);
    }
    if (used < text_bytes) {
        snprintf(text + used, text_bytes - used,
                 "all, errors, e1 to e5, e7, e8, " BENCH_GPU_NAME ", " BENCH_VERSUS_NAME);
    }
}

static bool is_gpu(const program *state)
{
    return strcmp(state->options.subject, BENCH_GPU_NAME) == 0;
}

static bool is_versus(const program *state)
{
    return strcmp(state->options.subject, BENCH_VERSUS_NAME) == 0;
}

static int check_subject(program *state)
{
    const options *given = &state->options;
    char known[320];
    list_subjects(known, sizeof known);
    if (given->subject == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "SUBJECT is missing, one of %s", known);
    }
    if (!is_gpu(state) && !is_versus(state) && !subjects_know(given->subject)) {
        suggestion near = suggestion_begin(given->subject, strlen(given->subject));
        for (size_t i = 0; i < SUBJECT_COUNT; ++i) {
            suggestion_offer(&near, subject_table[i].name);
        }
        suggestion_offer(&near, BENCH_GPU_NAME);
        suggestion_offer(&near, BENCH_VERSUS_NAME);
        return program_fail(state, PROGRAM_WRONG_USAGE, "SUBJECT '%s' is none of %s%s", given->subject, known,
                            suggestion_end(&near).text);
    }
    return PROGRAM_DONE;
}

/* Whether --scenes changes a subject that is asked for; with depths: whether --depths does. */
static bool has_scenes(const char *wanted, bool depths)
{
    bool found = false;
    for (size_t i = 0; subjects[i] != NULL; ++i) {
        const suite_subject *one = subjects[i];
        found = found || (suite_is_wanted(one, wanted) && !one->fixed &&
                          (one->run_all == NULL || (one->takes_scenes && !depths)));
    }
    return found;
}

/* Whether it casts as many rays as --ray-count says. */
static bool has_ray_count(const char *wanted)
{
    static const char *const names[] = {"rays", "compact", "e8", "all", "errors"};
    bool found = false;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        found = found || strcmp(wanted, names[i]) == 0;
    }
    return found;
}

static const char *const of_builds[] = {"need",   "coverage", "weights",    "builder",    "frontend", "share",
                                        "origin", "edge",     "voxel-size", "drop-alpha", NULL};
static const char *const of_versus[] = {"processes", "time", "full", "seed", "from", "page", "csv", NULL};

/* Options of builds and of measurements that the subject does not take. */
static int check_table_options(program *state)
{
    static const char *const of_scenes[] = {"scenes", NULL};
    static const char *const of_depths[] = {"depths", NULL};
    static const char *const of_rays[] = {"ray-count", NULL};
    static const char *const of_runs[] = {"repeat", NULL};
    const char *subject = state->options.subject;
    char where[64];
    (void)snprintf(where, sizeof where, "to bench %s", subject);
    int exit_code = options_refuse(state, of_builds, where);
    if (exit_code == PROGRAM_DONE) {
        exit_code = options_refuse(state, of_versus, where);
    }
    if (exit_code == PROGRAM_DONE && !has_scenes(subject, false)) {
        exit_code = options_refuse(state, of_scenes, where);
    }
    if (exit_code == PROGRAM_DONE && !has_scenes(subject, true)) {
        exit_code = options_refuse(state, of_depths, where);
    }
    if (exit_code == PROGRAM_DONE && !has_ray_count(subject)) {
        exit_code = options_refuse(state, of_rays, where);
    }
    return exit_code == PROGRAM_DONE && is_gpu(state) ? options_refuse(state, of_runs, where) : exit_code;
}

/* Subjects have scenes, depths, needs and methods of their own; only `bench rays` takes the options of a build. */
static int check_options(program *state)
{
    const options *given = &state->options;
    if (given->input != NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "unexpected argument '%s', bench %s takes --scenes",
                            given->input, given->subject);
    }
    if (given->has_depth) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "bench %s takes --depths in place of -d", given->subject);
    }
    const bool has_parts = strcmp(given->subject, "parts") == 0 || strcmp(given->subject, "all") == 0;
    if (given->workers != NULL && !has_parts) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --workers does not apply to bench %s", given->subject);
    }
    static const char *const rivals[] = {
        [OPTION_VERSUS_EMBREE] = "embree", [OPTION_VERSUS_OPENVDB] = "openvdb", [OPTION_VERSUS_GRID] = "grid"};
    static const char *const whose[] = {
        [OPTION_VERSUS_EMBREE] = "rays", [OPTION_VERSUS_OPENVDB] = "solid", [OPTION_VERSUS_GRID] = ""};
    if (given->versus != 0 && strcmp(given->subject, whose[given->versus]) != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --vs %s does not apply to bench %s",
                            rivals[given->versus], given->subject);
    }
    if (given->versus == OPTION_VERSUS_EMBREE && !embree_is_there()) {
        return program_fail(state, PROGRAM_FAILED, "--vs embree: %s", embree_lack());
    }
    if (given->versus == OPTION_VERSUS_OPENVDB && !openvdb_is_there()) {
        return program_fail(state, PROGRAM_FAILED, "--vs openvdb: this program was built without libopenvdb-dev");
    }
    return check_table_options(state);
}

static void print_tables(const result_set *results)
{
    result_print_machine(results);
    for (size_t i = 0; i < results->table_count; ++i) {
        if (!bench_versus_is_raw(results->tables[i])) {
            table_gap();
            result_print(results->tables[i]);
        }
    }
}

/* Saves the results, then prints them as JSON or as tables. */
static int show(program *state, const result_set *results)
{
    const options *given = &state->options;
    cJSON *document = result_to_json(results);
    if (given->output_path != NULL) {
        const int exit_code = json_save(state, given->output_path, document);
        if (exit_code != PROGRAM_DONE) {
            cJSON_Delete(document);
            return exit_code;
        }
    }
    if (given->json) {
        return json_print(state, document);
    }
    cJSON_Delete(document);
    if (given->output_path == NULL || !given->quiet) {
        print_tables(results);
    }
    return PROGRAM_DONE;
}

static int run_subjects(program *state)
{
    bench_gpu_verdicts verdicts = {0};
    size_t failed_count = 0;
    result_set *results = result_create();
    if (results == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    int exit_code = is_gpu(state)      ? bench_gpu(state, results, &verdicts)
                    : is_versus(state) ? bench_versus(state, results)
                                       : suite_collect(state, subjects, state->options.subject, results, &failed_count);
    if (exit_code == PROGRAM_DONE && is_versus(state)) {
        exit_code = bench_versus_write(state, results);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = show(state, results);
    }
    if (exit_code == PROGRAM_DONE && verdicts.wrong_count + verdicts.failed_count > 0) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%zu rows are wrong and %zu failed, the first: %s",
                                 verdicts.wrong_count, verdicts.failed_count, verdicts.first.text);
    }
    if (exit_code == PROGRAM_DONE && failed_count > 0) {
        exit_code =
            program_fail(state, PROGRAM_FAILED, "%zu subjects failed; the tables have the reasons", failed_count);
    }
    result_destroy(&results);
    return exit_code;
}

/* It varies what builds have, and its scenes are its INPUTs. */
static int check_versus(program *state)
{
    static const char *const others[] = {"scenes", "ray-count", "workers", "vs", NULL};
    const options *given = &state->options;
    int exit_code = options_refuse(state, of_builds, "to bench " BENCH_VERSUS_NAME);
    if (exit_code == PROGRAM_DONE) {
        exit_code = options_refuse(state, others, "to bench " BENCH_VERSUS_NAME);
    }
    if (exit_code == PROGRAM_DONE && given->page_path != NULL) {
        exit_code = output_check(state, given->page_path);
    }
    if (exit_code == PROGRAM_DONE && given->csv_path != NULL) {
        exit_code = output_check(state, given->csv_path);
    }
    return exit_code;
}

static int measure(program *state)
{
    const options *given = &state->options;
    if (is_versus(state)) {
        const int refused = check_versus(state);
        return refused == PROGRAM_DONE ? run_subjects(state) : refused;
    }
    if (given->further_count > 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "unexpected argument '%s'", given->further_inputs[0]);
    }
    if (strcmp(given->subject, "rays") == 0 && given->scenes == NULL && given->depths == NULL) {
        static const char *const others[] = {"workers", "need", "weights", "drop-alpha", NULL};
        int refused = options_refuse(state, others, "to bench rays");
        refused = refused == PROGRAM_DONE ? options_refuse(state, of_versus, "to bench rays") : refused;
        return refused == PROGRAM_DONE ? bench_rays_alone(state) : refused;
    }
    const int exit_code = check_options(state);
    return exit_code != PROGRAM_DONE ? exit_code : run_subjects(state);
}

/* With an instruction set of the caller's choice, and a cache of kernels that no other run shares. */
static int measure_with_isa(program *state)
{
    const char *isa = state->options.isa;
    child_cache cache;
    if (!instruction_set_is_there(isa)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--isa '%s' is none of sse2, avx2 and avx512, or this processor lacks it", isa);
    }
    if (!child_cache_create(&cache)) {
        return program_fail(state, PROGRAM_FAILED, "--isa %s: no folder for compiled kernels", isa);
    }
    const int exit_code = instruction_set_choose(isa, cache.path)
                              ? measure(state)
                              : program_fail(state, PROGRAM_FAILED, "--isa %s: out of memory", isa);
    child_cache_remove(&cache);
    return exit_code;
}

int command_bench(program *state)
{
    const options *given = &state->options;
    int exit_code = check_subject(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = given->output_path != NULL ? output_check(state, given->output_path) : PROGRAM_DONE;
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    return given->isa != NULL ? measure_with_isa(state) : measure(state);
}
