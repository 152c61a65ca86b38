/* SPDX-License-Identifier: MIT */
/*
 * From the start of a process to its first tree, and to the first tree of other needs in a process that built already.
 * The program starts anew for each run, first with empty caches of compiled kernels and shaders, then with warm ones.
 */
#include "bench/subjects.h"

#include <stdio.h>
#include <string.h>

#include "bench/child.h"
#include "bench/series.h"

static const char table_id[] = "startup";
static const char needs_id[] = "startup-needs";

/* The methods and their options. */
static const struct {
    const char *name, *option, *value;
} forms[] = {
    {"cl", "--frontend", "cl"},
    {"gl-expand", "--frontend", "gl-expand"},
    {"gl-compute", "--builder", "gl-compute"},
};
#define FORM_COUNT (sizeof forms / sizeof forms[0])

#define COLD_RUNS_MAX       101
#define WARM_PER_COLD       1
#define QUICK_WARM_PER_COLD 3
#define WARM_RUNS_MAX       (COLD_RUNS_MAX * QUICK_WARM_PER_COLD)

/* Milliseconds of one method's processes, and of compiling in them. */
typedef struct start_times {
    double cold[COLD_RUNS_MAX], cold_compile[COLD_RUNS_MAX];
    double warm[WARM_RUNS_MAX], warm_compile[WARM_RUNS_MAX];
    size_t cold_count, warm_count;
    bool failed;
} start_times;

static const char note[] =
    "Wall clock of `svocl build --weights uniform`: medians and quartiles (q1, q3). Methods run interleaved. Cold: the "
    "drivers' caches of kernels and shaders are empty. Warm: after the cold run has filled them. Compile: kernels and "
    "shaders, as the build reports it.";

static const char needs_note[] =
    "`svocl bench leaving-out` as a process of its own, once with empty caches and once with those that it filled. Its "
    "first tree has all needs; the rows are the trees after it, each with the kernels that it adds: from the mesh to "
    "the tree, with compilation. One run each.";

static void begin_needs(suite *all)
{
    result_table *table = result_add_table(all->results, needs_id, "The first tree of other needs", needs_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "need", "");
    result_add_column(table, "cold", "ms");
    result_add_column(table, "warm", "ms");
}

static int begin(suite *all)
{
    result_table *table = result_add_table(all->results, table_id, "Process start to exit, building one tree", note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "method", "");
    result_add_column(table, "cold runs", "");
    spread_add_columns(table, "cold", "ms");
    spread_add_columns(table, "cold compile", "ms");
    result_add_column(table, "warm runs", "");
    spread_add_columns(table, "warm", "ms");
    spread_add_columns(table, "warm compile", "ms");
    begin_needs(all);
    return PROGRAM_DONE;
}

/* The command line of one build, with the device and the context of this process. */
static void make_arguments(const suite *all, const input *source, const char *depth, size_t form,
                           child_arguments *arguments)
{
    const char *const always[] = {"build",   source->name,       "--json",         "-d", depth, "--weights",
                                  "uniform", forms[form].option, forms[form].value};
    *arguments = (child_arguments){.count = 0};
    for (size_t i = 0; i < sizeof always / sizeof always[0]; ++i) {
        child_add(arguments, always[i]);
    }
    child_add_device(arguments, &all->state->options, form > 0);
}

/* One process. Returns its milliseconds, below 0 on failure. */
static double start_once(const char *const arguments[], const child_cache *cache, double *compile_ms)
{
    cJSON *document = NULL;
    const double ms = child_run(arguments, cache, &document);
    const cJSON *compile = cJSON_GetObjectItemCaseSensitive(document, "first_compile_ms");
    *compile_ms = cJSON_IsNumber(compile) ? compile->valuedouble : 0.0;
    const bool told = cJSON_IsNumber(compile);
    cJSON_Delete(document);
    return told ? ms : -1.0;
}

static void run_round(const suite *all, const char *const arguments[], start_times *times)
{
    child_cache cache = {""};
    const size_t warm = all->quick ? QUICK_WARM_PER_COLD : WARM_PER_COLD;
    if (!child_cache_create(&cache)) {
        times->failed = true;
        return;
    }
    double compile_ms = 0.0;
    double ms = start_once(arguments, &cache, &compile_ms);
    if (ms >= 0.0) {
        times->cold[times->cold_count] = ms;
        times->cold_compile[times->cold_count++] = compile_ms;
    }
    for (size_t i = 0; i < warm && ms >= 0.0; ++i) {
        ms = start_once(arguments, &cache, &compile_ms);
        times->warm[times->warm_count] = ms;
        times->warm_compile[times->warm_count++] = compile_ms;
    }
    times->failed = ms < 0.0;
    child_cache_remove(&cache);
}

static void add_row(result_table *table, const input *source, unsigned depth, const char *method, start_times *times)
{
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, depth);
    result_add_text(table, "%s", method);
    result_add_number(table, (double)times->cold_count);
    spread_add(table, spread_of(times->cold, times->cold_count));
    spread_add(table, spread_of(times->cold_compile, times->cold_count));
    result_add_number(table, (double)times->warm_count);
    spread_add(table, spread_of(times->warm, times->warm_count));
    spread_add(table, spread_of(times->warm_compile, times->warm_count));
}

/* The rows and, by its name, a column of the first table in a document. */
static const cJSON *rows_of(const cJSON *document, const char *name, int *column)
{
    const cJSON *table = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(document, "tables"), 0);
    const cJSON *columns = cJSON_GetObjectItemCaseSensitive(table, "columns");
    for (*column = 0; *column < cJSON_GetArraySize(columns); ++*column) {
        const cJSON *one = cJSON_GetArrayItem(columns, *column);
        const char *found = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(one, "name"));
        if (found != NULL && strcmp(found, name) == 0) {
            return cJSON_GetObjectItemCaseSensitive(table, "rows");
        }
    }
    return NULL;
}

static void add_needs(result_table *table, const input *source, unsigned depth, const cJSON *cold, const cJSON *warm)
{
    int need = 0;
    int first = 0;
    const cJSON *cold_rows = rows_of(cold, "first", &first);
    const cJSON *warm_rows = rows_of(warm, "need", &need);
    for (int i = 1; i < cJSON_GetArraySize(cold_rows) && i < cJSON_GetArraySize(warm_rows); ++i) {
        const cJSON *cold_row = cJSON_GetArrayItem(cold_rows, i);
        const cJSON *warm_row = cJSON_GetArrayItem(warm_rows, i);
        const char *name = cJSON_GetStringValue(cJSON_GetArrayItem(warm_row, need));
        result_add_text(table, "%s", suite_scene_name(source));
        result_add_number(table, depth);
        result_add_text(table, "%s", name != NULL ? name : "");
        result_add_number(table, cJSON_GetNumberValue(cJSON_GetArrayItem(cold_row, first)));
        result_add_number(table, cJSON_GetNumberValue(cJSON_GetArrayItem(warm_row, first)));
    }
}

/* The trees of other needs in one process, with empty and with filled caches. */
static int run_needs(suite *all, const input *source, unsigned depth, const char *depth_text)
{
    const char *const always[] = {"bench",    "leaving-out", "--scenes", source->name, "--depths",
                                  depth_text, "--repeat",    "1",        "--json"};
    child_arguments arguments = {.count = 0};
    child_cache cache = {""};
    cJSON *cold = NULL;
    cJSON *warm = NULL;
    for (size_t i = 0; i < sizeof always / sizeof always[0]; ++i) {
        child_add(&arguments, always[i]);
    }
    child_add_device(&arguments, &all->state->options, false);
    const bool ran = child_cache_create(&cache) && child_run(arguments.list, &cache, &cold) >= 0.0 &&
                     child_run(arguments.list, &cache, &warm) >= 0.0;
    if (ran) {
        add_needs(result_find(all->results, needs_id), source, depth, cold, warm);
    }
    cJSON_Delete(cold);
    cJSON_Delete(warm);
    child_cache_remove(&cache);
    return ran ? PROGRAM_DONE
               : program_fail(all->state, PROGRAM_FAILED, "'svocl bench leaving-out --scenes %s' failed as a child",
                              source->name);
}

static int run(suite *all, const input *source, unsigned depth)
{
    start_times times[FORM_COUNT];
    memset(times, 0, sizeof times);
    const size_t asked = all->quick && !all->state->options.has_repeat ? 1 : all->repeats;
    const size_t round_count = asked < COLD_RUNS_MAX ? asked : COLD_RUNS_MAX;
    char depth_text[16];
    snprintf(depth_text, sizeof depth_text, "%u", depth);
    for (size_t round = 0; round < round_count; ++round) {
        for (size_t form = 0; form < FORM_COUNT; ++form) {
            child_arguments arguments;
            make_arguments(all, source, depth_text, form, &arguments);
            if (!times[form].failed) {
                run_round(all, arguments.list, &times[form]);
            }
        }
    }
    result_table *table = result_find(all->results, table_id);
    for (size_t form = 0; form < FORM_COUNT; ++form) {
        if (!times[form].failed) {
            add_row(table, source, depth, forms[form].name, &times[form]);
        } else if (form == 0) {
            return program_fail(all->state, PROGRAM_FAILED, "'svocl build %s --frontend cl' failed as a child",
                                source->name);
        } else {
            result_extend_note(table, "%s does not work here.", forms[form].name);
        }
    }
    return run_needs(all, source, depth, depth_text);
}

const suite_subject bench_startup = {
    .words = &subject_table[SUBJECT_STARTUP],
    .full = {.scenes = {"knot:8000"}, .depths = {8}},
    .quick = {.scenes = {"knot:8000"}, .depths = {7}},
    .begin = begin,
    .run = run,
};
