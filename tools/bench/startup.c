/* SPDX-License-Identifier: MIT */
/*
 * From the start of a process to its first tree. The program starts anew for each run, first with empty caches of
 * compiled kernels and shaders, then with warm ones.
 */
#include "bench/startup.h"

#include <stdio.h>
#include <string.h>

#include "bench/child.h"
#include "bench/series.h"

static const char table_id[] = "startup";

/* The methods and their options. */
static const struct {
    const char *name, *option, *value;
} forms[] = {
    {"cl", "--frontend", "cl"},
    {"gl-expand", "--frontend", "gl-expand"},
    {"gl-compute", "--builder", "gl-compute"},
};
#define FORM_COUNT (sizeof forms / sizeof forms[0])

#define COLD_RUNS_MAX        101
#define WARM_PER_COLD        1
#define QUICK_WARM_PER_COLD  3
#define WARM_RUNS_MAX        (COLD_RUNS_MAX * QUICK_WARM_PER_COLD)
#define COMMAND_ARGUMENT_MAX 20

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
    return PROGRAM_DONE;
}

/* The command line of one build, with the device and the context of this process. */
static void make_arguments(const suite *all, const input *source, const char *depth, size_t form,
                           const char *arguments[COMMAND_ARGUMENT_MAX])
{
    static const char *const contexts[] = {"surfaceless", "egl-device", "osmesa"};
    const options *given = &all->state->options;
    size_t count = 0;
    arguments[count++] = "build";
    arguments[count++] = source->name;
    arguments[count++] = "--json";
    arguments[count++] = "-d";
    arguments[count++] = depth;
    arguments[count++] = "--weights";
    arguments[count++] = "uniform";
    arguments[count++] = forms[form].option;
    arguments[count++] = forms[form].value;
    if (given->device_name != NULL) {
        arguments[count++] = "--device";
        arguments[count++] = given->device_name;
    }
    if (given->path != SVO_PATH_AUTO) {
        arguments[count++] = "--path";
        arguments[count++] = svo_path_name((svo_path)given->path);
    }
    if (form > 0 && given->gl_device != NULL) {
        arguments[count++] = "--gl-device";
        arguments[count++] = given->gl_device;
    } else if (form > 0 && given->context != OPTION_CONTEXT_AUTO) {
        arguments[count++] = "--context";
        arguments[count++] = contexts[given->context];
    }
    arguments[count] = NULL;
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
            const char *arguments[COMMAND_ARGUMENT_MAX];
            make_arguments(all, source, depth_text, form, arguments);
            if (!times[form].failed) {
                run_round(all, arguments, &times[form]);
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
    return PROGRAM_DONE;
}

const suite_subject bench_startup = {
    .name = "startup",
    .group = "all",
    .summary = "process start to first tree, with cold and warm compiler caches",
    .full = {.scenes = {"knot:8000"}, .depths = {8}},
    .quick = {.scenes = {"knot:8000"}, .depths = {7}},
    .begin = begin,
    .run = run,
};
