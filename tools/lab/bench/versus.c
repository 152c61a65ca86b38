/* SPDX-License-Identifier: MIT */
/* Runs the processes, puts together what they measured, and computes the tables. */
#include "bench/versus.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/child.h"
#include "bench/versus_data.h"
#include "bench/versus_run.h"
#include "bench/versus_start.h"
#include "bench/versus_tables.h"
#include "measure/result_file.h"
#include "measure/result_json.h"
#include "measure/result_text.h"
#include "measure/results_page.h"
#include "support/json.h"
#include "support/output.h"
#include "support/subjects.h"

extern const char versus_template[], versus_script_content[];

#define USUAL_SECONDS   600.0
#define USUAL_PROCESSES 3u
#define START_SHARE     0.2 /* of the time */

/* The steps of the bar, with what is left of the time. */
typedef struct measuring {
    program *state;
    result_set *results;
    double begin_ms, seconds; /* seconds: INFINITY: any */
    char steps[65][64];
} measuring;

static double seconds_left(const measuring *all)
{
    return all->seconds - (input_now_ms() - all->begin_ms) / 1e3;
}

static void show_step(measuring *all, unsigned number, unsigned count)
{
    char *step = all->steps[number];
    const size_t used =
        (size_t)snprintf(step, sizeof all->steps[0], number < count ? "process %u of %u" : "starts", number + 1, count);
    if (isfinite(all->seconds) && used < sizeof all->steps[0]) {
        snprintf(step + used, sizeof all->steps[0] - used, ", about %.0f s left", fmax(seconds_left(all), 0));
    }
    progress_step(all->state->progress, step);
    if (all->state->options.verbose) {
        fprintf(stderr, "svocl: bench: %s\n", step);
    }
}

/* ---- one process ---- */

static void add_option(child_arguments *arguments, const char *option, const char *value)
{
    if (value != NULL) {
        child_add(arguments, option);
        child_add(arguments, value);
    }
}

/* Texts of numbers, which arguments borrow. */
typedef struct number_texts {
    char seconds[32], seed[24], depth[24], repeat[24], threads[24];
} number_texts;

static const char *print_number(char *text, size_t text_bytes, bool is_given, double number)
{
    snprintf(text, text_bytes, "%.3f", number);
    return is_given ? text : NULL;
}

static void make_arguments(const measuring *all, unsigned process, double seconds, number_texts *texts,
                           child_arguments *arguments)
{
    const options *given = &all->state->options;
    *arguments = (child_arguments){.count = 0};
    child_add(arguments, "bench");
    child_add(arguments, BENCH_VERSUS_NAME);
    for (size_t i = 0; given->input != NULL && i <= given->further_count; ++i) {
        child_add(arguments, i == 0 ? given->input : given->further_inputs[i - 1]);
    }
    child_add(arguments, "--json");
    add_option(arguments, "--processes", "1");
    snprintf(texts->seed, sizeof texts->seed, "%llu", (unsigned long long)given->seed + process);
    add_option(arguments, "--seed", texts->seed);
    add_option(arguments, "--time", print_number(texts->seconds, sizeof texts->seconds, isfinite(seconds), seconds));
    snprintf(texts->depth, sizeof texts->depth, "%u", (unsigned)given->depth);
    add_option(arguments, "-d", given->has_depth ? texts->depth : NULL);
    add_option(arguments, "--depths", given->depths);
    snprintf(texts->repeat, sizeof texts->repeat, "%u", (unsigned)given->repeat);
    add_option(arguments, "--repeat", given->has_repeat ? texts->repeat : NULL);
    snprintf(texts->threads, sizeof texts->threads, "%u", (unsigned)given->threads);
    add_option(arguments, "--threads", given->threads > 0 ? texts->threads : NULL);
    add_option(arguments, "--kernels", given->kernels_path);
    if (given->quick) {
        child_add(arguments, "--quick");
    }
    if (given->full) {
        child_add(arguments, "--full");
    }
    child_add_device(arguments, given, true);
}

/* What a process has on standard output. NULL with a line printed. */
static result_set *parse(program *state, const child_answer *answer)
{
    svo_message message = {""};
    char *text = answer->document != NULL ? cJSON_PrintUnformatted(answer->document) : NULL;
    result_set *own = text != NULL && answer->well ? result_parse(text, &message) : NULL;
    if (own == NULL) {
        (void)program_fail(state, PROGRAM_FAILED, "%s", answer->well ? message.text : answer->reason);
    }
    cJSON_free(text);
    return own;
}

static void take_machine(result_set *into, result_set *from)
{
    const result_machine kept = into->machine;
    into->machine = from->machine;
    from->machine = kept;
}

static int run_process(measuring *all, unsigned process, double seconds)
{
    number_texts texts;
    child_arguments arguments;
    child_answer answer;
    make_arguments(all, process, seconds, &texts, &arguments);
    child_ask(&arguments, NULL, 0, &answer);
    result_set *own = parse(all->state, &answer);
    cJSON_Delete(answer.document);
    if (own == NULL) {
        return PROGRAM_FAILED;
    }
    const bool merged = versus_merge(all->results, own, process);
    if (process == 1) {
        take_machine(all->results, own);
    }
    result_destroy(&own);
    return merged ? PROGRAM_DONE
                  : program_fail(all->state, PROGRAM_FAILED, "process %u measured nothing, or out of memory", process);
}

static int run_processes(measuring *all, unsigned count)
{
    int exit_code = PROGRAM_DONE;
    for (unsigned i = 0; i < count && exit_code == PROGRAM_DONE; ++i) {
        show_step(all, i, count);
        const double seconds = (seconds_left(all) - START_SHARE * all->seconds) / (count - i);
        exit_code = run_process(all, i + 1, fmax(seconds, 1));
    }
    return exit_code;
}

/* ---- files ---- */

/* A line for each round, with what its cell is. */
static void write_csv(const result_set *results, FILE *file)
{
    const result_table *cells = result_find(results, VERSUS_CELLS_ID);
    const result_table *rounds = result_find(results, VERSUS_ROUNDS_ID);
    result_set *set = result_create();
    result_table *joined = result_add_table(set, "gl-vs-cl", "", "");
    for (size_t i = 0; i < cells->column_count; ++i) {
        result_add_column(joined, cells->columns[i].name, cells->columns[i].unit);
    }
    for (size_t i = 1; i < rounds->column_count; ++i) {
        result_add_column(joined, rounds->columns[i].name, rounds->columns[i].unit);
    }
    for (size_t row = 0; row < result_row_count(rounds); ++row) {
        for (size_t i = 0; i < cells->column_count; ++i) {
            result_add_cell(joined, result_cell_at(cells, (size_t)result_cell_at(rounds, row, 0)->number, i));
        }
        for (size_t i = 1; i < rounds->column_count; ++i) {
            result_add_cell(joined, result_cell_at(rounds, row, i));
        }
    }
    result_write_csv(joined, file);
    result_destroy(&set);
}

/* ---- all ---- */

static int run_starts(measuring *all, unsigned process_count)
{
    const char *given = all->state->options.input;
    versus_data data;
    int exit_code = versus_open(all->state, all->results, "the processes", &data);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    show_step(all, process_count, process_count);
    if (data.count > 0) {
        const double seconds = isfinite(all->seconds) ? seconds_left(all) : USUAL_SECONDS * START_SHARE;
        exit_code = versus_start(all->state, &data, given != NULL ? given : versus_text(&data, 0, VERSUS_SCENE),
                                 seconds, all->results);
    }
    versus_close(&data);
    return exit_code;
}

static int measure(program *state, result_set *results)
{
    const options *given = &state->options;
    const unsigned count = given->processes > 0 ? (unsigned)given->processes : given->quick ? 1 : USUAL_PROCESSES;
    measuring *all = calloc(1, sizeof *all);
    if (all == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    *all = (measuring){.state = state, .results = results, .begin_ms = input_now_ms()};
    all->seconds = given->time_bound > 0 ? given->time_bound : given->full ? INFINITY : USUAL_SECONDS;
    versus_add_tables(results);
    program_begin_progress(state, count + 1);
    int exit_code =
        count == 1 ? versus_run(state, isfinite(all->seconds) ? all->seconds : 0, results) : run_processes(all, count);
    if (exit_code == PROGRAM_DONE && count > 1) {
        exit_code = run_starts(all, count);
    }
    progress_destroy(&state->progress);
    free(all);
    return exit_code;
}

static int read_file(program *state, result_set *results)
{
    result_set *read = result_file_read(state, state->options.from);
    if (read == NULL) {
        return PROGRAM_FAILED;
    }
    take_machine(results, read);
    result_take(results, read);
    result_destroy(&read);
    return PROGRAM_DONE;
}

/* Tables that an earlier run computed give way. */
static int tabulate(program *state, const versus_data *data, result_set *results)
{
    result_set *computed = result_create();
    if (computed == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the tables");
    }
    versus_tabulate(data, results, computed);
    result_take(results, computed);
    result_destroy(&computed);
    return result_is_whole(results) ? PROGRAM_DONE
                                    : program_fail(state, PROGRAM_FAILED, "out of memory for the tables");
}

int bench_versus(program *state, result_set *results)
{
    const char *from = state->options.from;
    versus_data data;
    int exit_code = from != NULL ? read_file(state, results) : measure(state, results);
    if (exit_code == PROGRAM_DONE) {
        exit_code = versus_open(state, results, from != NULL ? from : "the processes", &data);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = tabulate(state, &data, results);
        versus_close(&data);
    }
    return exit_code;
}

bool bench_versus_is_raw(const result_table *table)
{
    static const char *const ids[] = {VERSUS_CELLS_ID, VERSUS_ROUNDS_ID, VERSUS_STARTS_ID, VERSUS_SERIES_ID};
    bool raw = false;
    for (size_t i = 0; i < sizeof ids / sizeof ids[0]; ++i) {
        raw = raw || strcmp(table->id, ids[i]) == 0;
    }
    return raw;
}

int bench_versus_write(program *state, const result_set *results)
{
    const options *given = &state->options;
    output_file file;
    int exit_code = given->csv_path != NULL ? output_open(state, given->csv_path, &file) : PROGRAM_DONE;
    if (given->csv_path != NULL && exit_code == PROGRAM_DONE) {
        write_csv(results, file.stream);
        exit_code = output_commit(state, &file);
    }
    if (given->page_path == NULL || exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = output_open(state, given->page_path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    cJSON *data = cJSON_CreateObject();
    cJSON_AddStringToObject(data, "origin", "rounds");
    exit_code =
        results_page_write(state, versus_template, "versus.js", versus_script_content, results, data, file.stream);
    if (exit_code != PROGRAM_DONE) {
        output_abandon(&file);
        return exit_code;
    }
    return output_commit(state, &file);
}
