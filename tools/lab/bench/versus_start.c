/* SPDX-License-Identifier: MIT */
/* Processes that build one tree: with empty and with full caches of kernels and shaders. */
#include "bench/versus_start.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/child.h"
#include "support/input.h"

#define ROUNDS_MAX     5u
#define TEXT(number)   #number
#define TEXT_OF(macro) TEXT(macro)
#define HYBRID_COLUMNS TEXT_OF(VERSUS_HYBRID_COLUMNS)
#define CHILD_LIMIT    120u /* seconds */

/* The columns of the table of starts. */
enum { START_PATH, START_LIST, START_SHARE, START_BUILDER, START_CACHES, START_PROCESS, START_REASON = 10 };
#define FACTS (START_REASON - START_PROCESS)

/* ---- processes ---- */

static void add_option(child_arguments *arguments, const char *option, const char *value)
{
    child_add(arguments, option);
    child_add(arguments, value);
}

/* Texts that arguments borrow. */
typedef struct start_texts {
    suite_input source;
    char depth[24], threads[24];
} start_texts;

static void make_arguments(const program *state, const versus_data *data, size_t cell, const start_texts *texts,
                           child_arguments *arguments)
{
    const char *list = versus_text(data, cell, VERSUS_LIST);
    const char *share = versus_text(data, cell, VERSUS_SHARE);
    const bool in_gl = strcmp(list, "cl") != 0;
    *arguments = (child_arguments){.count = 0};
    child_add(arguments, "build");
    child_add(arguments, texts->source.text);
    child_add(arguments, "--json");
    add_option(arguments, "-d", texts->depth);
    add_option(arguments, "--need", versus_text(data, cell, VERSUS_NEED));
    add_option(arguments, "--weights", versus_text(data, cell, VERSUS_WEIGHTS));
    add_option(arguments, "--coverage", versus_text(data, cell, VERSUS_COVERAGE));
    add_option(arguments, "--frontend", list);
    add_option(arguments, "--builder", versus_text(data, cell, VERSUS_BUILDER));
    if (strcmp(list, "gl-hybrid") == 0) {
        add_option(arguments, "--hybrid-columns", HYBRID_COLUMNS);
    }
    if (strcmp(share, "none") != 0) {
        add_option(arguments, "--share", share);
    }
    if (state->options.path == SVO_PATH_AUTO) {
        add_option(arguments, "--path", versus_text(data, cell, VERSUS_PATH));
    }
    if (state->options.threads > 0) {
        add_option(arguments, "--threads", texts->threads);
    }
    child_add_device(arguments, &state->options, in_gl);
}

static double number_of(const cJSON *document, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(document, name);
    return cJSON_IsNumber(item) ? item->valuedouble : (double)NAN;
}

static void add_row(result_table *table, const versus_data *data, size_t cell, const char *caches,
                    const child_answer *answer)
{
    for (versus_column i = VERSUS_PATH; i <= VERSUS_BUILDER; ++i) {
        result_add_text(table, "%s", versus_text(data, cell, i));
    }
    result_add_text(table, "%s", caches);
    result_add_number(table, answer->well ? answer->ms : (double)NAN);
    result_add_number(table, number_of(answer->document, "first_compile_ms"));
    result_add_number(table, number_of(answer->document, "wall_ms"));
    result_add_number(table, number_of(answer->document, "peak_resident_bytes"));
    result_add_number(table, number_of(answer->document, "peak_bytes"));
    result_add_text(table, "%s", answer->reason);
}

/* One process with an empty cache, and one with what it left there. */
static bool start_twice(const child_arguments *arguments, const versus_data *data, size_t cell, result_table *table)
{
    static const char *const caches[] = {"cold", "warm"};
    child_cache cache;
    if (!child_cache_create(&cache)) {
        return false;
    }
    for (size_t i = 0; i < 2; ++i) {
        child_answer answer;
        child_ask(arguments, &cache, CHILD_LIMIT, &answer);
        add_row(table, data, cell, caches[i], &answer);
        cJSON_Delete(answer.document);
    }
    child_cache_remove(&cache);
    return true;
}

int versus_start(program *state, const versus_data *data, const char *name, double seconds, result_set *results)
{
    result_table *table = result_find(results, VERSUS_STARTS_ID);
    size_t kinds[VERSUS_KINDS_MAX];
    start_texts texts;
    const bool is_quick = state->options.quick != 0;
    const size_t all_count = versus_kinds(data, kinds);
    const size_t kind_count = is_quick && all_count > 1 ? 1 : all_count;
    const size_t rounds = is_quick ? 1 : ROUNDS_MAX;
    const double end_ms = input_now_ms() + 1e3 * seconds;
    const int exit_code = suite_name(state, name, &texts.source);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    snprintf(texts.depth, sizeof texts.depth, "%.0f", versus_number(data, 0, VERSUS_DEPTH));
    snprintf(texts.threads, sizeof texts.threads, "%u", (unsigned)state->options.threads);
    for (size_t i = 0; i < rounds * kind_count && (i < kind_count || input_now_ms() < end_ms); ++i) {
        const size_t cell = kinds[i % kind_count];
        child_arguments arguments;
        make_arguments(state, data, cell, &texts, &arguments);
        if (input_now_ms() > end_ms) {
            add_row(table, data, cell, "cold", &(child_answer){.reason = "not measured: the time was over"});
        } else if (!start_twice(&arguments, data, cell, table)) {
            return program_fail(state, PROGRAM_FAILED, "no folder for caches of compiled kernels");
        }
    }
    return PROGRAM_DONE;
}

/* ---- the table ---- */

static const char note[] =
    "`svocl build` of the central tree as processes, medians with 95 % intervals. Cold: the drivers' caches of kernels "
    "and shaders are empty; warm: as the cold process left them. Build: the first one, by the wall clock, with "
    "compile. "
    "Resident: host memory of the process, in which software renderers and CPU devices have their buffers; peak: the "
    "OpenCL buffers that the plan counts, without those of OpenGL.";

static bool is_same(const result_table *starts, size_t a, size_t b)
{
    bool same = true;
    for (size_t i = START_PATH; i <= START_CACHES; ++i) {
        same = same && strcmp(result_cell_at(starts, a, i)->text, result_cell_at(starts, b, i)->text) == 0;
    }
    return same;
}

/* The finite numbers of a fact in all rows like this one. Returns how many. */
static size_t collect(const result_table *starts, size_t row, size_t fact, double values[BOOTSTRAP_ROUNDS_MAX])
{
    size_t count = 0;
    for (size_t i = 0; i < result_row_count(starts) && count < BOOTSTRAP_ROUNDS_MAX; ++i) {
        const result_cell *cell = result_cell_at(starts, i, START_PROCESS + fact);
        if (is_same(starts, i, row) && cell->kind == RESULT_NUMBER) {
            values[count++] = cell->number;
        }
    }
    return count;
}

static bool is_first(const result_table *starts, size_t row)
{
    size_t i = 0;
    while (!is_same(starts, i, row)) {
        ++i;
    }
    return i == row;
}

void versus_add_starts(const result_set *measured, result_set *into)
{
    static const char *const names[FACTS] = {"process", "compile", "build", "resident", "peak"};
    const result_table *starts = result_find(measured, VERSUS_STARTS_ID);
    result_table *table = result_add_table(into, "gl-vs-cl-start", "Starts", note);
    static const char *const texts[] = {"path", "list", "share", "builder", "caches", "runs"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        result_add_column(table, texts[i], "");
    }
    for (size_t i = 0; i < FACTS; ++i) {
        if (i < 3) {
            interval_add_columns(table, names[i], "ms");
        } else {
            result_add_column(table, names[i], "B");
        }
    }
    result_add_column(table, "reason", "");
    for (size_t row = 0; row < result_row_count(starts); ++row) {
        double values[BOOTSTRAP_ROUNDS_MAX];
        for (size_t i = START_PATH; i <= START_CACHES && is_first(starts, row); ++i) {
            result_add_text(table, "%s", result_cell_at(starts, row, i)->text);
        }
        for (size_t i = 0; i < FACTS && is_first(starts, row); ++i) {
            const size_t count = collect(starts, row, i, values);
            if (i == 0) {
                result_add_number(table, (double)count);
            }
            if (i < 3) {
                interval_add(table, versus_interval_of(values, count));
            } else {
                result_add_number(table, bootstrap_median(values, count));
            }
        }
        if (is_first(starts, row)) {
            result_add_text(table, "%s", result_cell_at(starts, row, START_REASON)->text);
        }
    }
}
