/* SPDX-License-Identifier: MIT */
/*
 * Time and memory of builds in parts beside those in one piece. Each build is a process of its own, since the most
 * memory that a process ever had can be read but not reset. The drivers' caches are warm. workers.c adds what several
 * processes side by side make of it.
 */
#include "bench/parts.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "bench/child.h"
#include "bench/series.h"
#include "bench/workers.h"

static const char table_id[] = "parts";

/* Limits of a part, as shares of the buffers of the build in one piece; 0: in one piece. */
static const unsigned shares[] = {0, 4, 16, 64};
#define WORKERS_SHARE 2u /* for workers: parts that take long beside the start of a process */
#define FORM_COUNT    (sizeof shares / sizeof shares[0])
#define RUNS_MAX      101
#define PATH_BYTES    300

/* The processes of one form. */
typedef struct form_runs {
    double ms[RUNS_MAX];
    size_t count;
    double parts, peak_bytes, buffer_bytes;
    uint64_t limit; /* 0: in one piece */
    unsigned share; /* the limit is 1/share of the buffers in one piece */
    bool failed;
    char reason[CHILD_REASON_BYTES]; /* why */
} form_runs;

static const char note[] =
    "Wall clock of `svocl build -o FILE` from the start of the process to its exit: medians and quartiles (q1, q3). "
    "Forms run interleaved, with warm caches of kernels. Limit: of `--max-memory`; the form says which share it is "
    "of the OpenCL buffers in one piece. Peak: the most memory that the process had resident (VmHWM), with all "
    "libraries. Ratio: of the medians.";

static int begin(suite *all)
{
    result_table *table = result_add_table(all->results, table_id, "Trees built in parts: time and memory", note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "form", "");
    result_add_column(table, "limit", "B");
    result_add_column(table, "parts", "");
    result_add_column(table, "runs", "");
    spread_add_columns(table, "build", "ms");
    result_add_column(table, "ratio", "");
    result_add_column(table, "peak", "B");
    return workers_begin(all);
}

static double number_of(const cJSON *document, const char *name)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(document, name);
    return cJSON_IsNumber(number) ? number->valuedouble : 0.0;
}

/* One process, whose file goes to the folder of the caches. A failed build leaves parts beside its file, which would
   stand in the way of others. */
static void run_form(const suite *all, const input *source, unsigned depth, const child_cache *cache, form_runs *runs)
{
    child_arguments arguments = {.count = 0};
    child_answer answer;
    char depth_text[16];
    char limit_text[32];
    char path[PATH_BYTES];
    (void)snprintf(depth_text, sizeof depth_text, "%u", depth);
    (void)snprintf(limit_text, sizeof limit_text, "%" PRIu64, runs->limit);
    (void)snprintf(path, sizeof path, "%s/tree_%u.svo", cache->path, runs->share);
    const char *const rest[] = {"build", source->name, "--json", "-d", depth_text, "-o", path, "--frontend", "cl"};
    for (size_t i = 0; i < sizeof rest / sizeof rest[0]; ++i) {
        child_add(&arguments, rest[i]);
    }
    if (runs->limit > 0) {
        child_add(&arguments, "--max-memory");
        child_add(&arguments, limit_text);
    }
    child_add_device(&arguments, &all->state->options, false);
    child_ask(&arguments, cache, 0, &answer);
    runs->failed = !answer.well;
    (void)snprintf(runs->reason, sizeof runs->reason, "%s", answer.reason);
    if (answer.well && runs->count < RUNS_MAX) {
        runs->ms[runs->count++] = answer.ms;
        runs->parts = runs->limit > 0 ? number_of(answer.document, "parts") : 1.0;
        runs->peak_bytes = number_of(answer.document, "peak_resident_bytes");
        runs->buffer_bytes = number_of(answer.document, "peak_bytes");
    }
    cJSON_Delete(answer.document);
}

static void add_row(result_table *table, const input *source, unsigned depth, form_runs *runs, double whole_ms)
{
    const spread ms = spread_of(runs->ms, runs->count);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, depth);
    if (runs->limit > 0) {
        result_add_text(table, "1/%u", runs->share);
        result_add_number(table, (double)runs->limit);
    } else {
        result_add_text(table, "in one piece");
        result_add_absent(table);
    }
    result_add_number(table, runs->parts);
    result_add_number(table, (double)runs->count);
    spread_add(table, ms);
    result_add_number(table, ms.median / whole_ms);
    result_add_number(table, runs->peak_bytes);
}

/* Limits that are too small have no row, but a line of the note. */
static void explain(result_table *table, const input *source, unsigned depth, const form_runs *runs)
{
    result_extend_note(table, "%s at depth %u has no row for 1/%u (%" PRIu64 " bytes): %s.", suite_scene_name(source),
                       depth, runs->share, runs->limit, runs->reason);
}

/* The first round, which is not counted, fills the caches and finds the limits. */
static int warm_up(suite *all, const input *source, unsigned depth, const child_cache *cache, form_runs *runs)
{
    for (size_t form = 0; form < FORM_COUNT; ++form) {
        runs[form].share = shares[form];
        runs[form].limit = form > 0 ? (uint64_t)(runs[0].buffer_bytes / shares[form]) + 1 : 0;
        run_form(all, source, depth, cache, &runs[form]);
        runs[form].count = 0;
        if (form == 0 && runs[0].failed) {
            return program_fail(all->state, PROGRAM_FAILED, "'svocl build %s' failed as a child: %s", source->name,
                                runs[0].reason);
        }
    }
    return PROGRAM_DONE;
}

static int run(suite *all, const input *source, unsigned depth)
{
    form_runs runs[FORM_COUNT];
    child_cache cache = {""};
    memset(runs, 0, sizeof runs);
    if (!child_cache_create(&cache)) {
        return program_fail(all->state, PROGRAM_FAILED, "no folder for temporary files can be made");
    }
    int exit_code = warm_up(all, source, depth, &cache, runs);
    const size_t rounds = all->repeats < RUNS_MAX ? all->repeats : RUNS_MAX;
    for (size_t round = 0; round < rounds && exit_code == PROGRAM_DONE; ++round) {
        for (size_t form = 0; form < FORM_COUNT; ++form) {
            if (!runs[form].failed) {
                run_form(all, source, depth, &cache, &runs[form]);
            }
        }
    }
    if (exit_code == PROGRAM_DONE) {
        const uint64_t limit = (uint64_t)(runs[0].buffer_bytes / WORKERS_SHARE) + 1;
        exit_code = workers_run(all, source, depth, limit, &cache);
    }
    child_cache_remove(&cache);
    result_table *table = result_find(all->results, table_id);
    for (size_t form = 0; form < FORM_COUNT && exit_code == PROGRAM_DONE; ++form) {
        if (runs[form].failed) {
            explain(table, source, depth, &runs[form]);
        } else if (runs[form].count > 0) {
            add_row(table, source, depth, &runs[form], spread_of(runs[0].ms, runs[0].count).median);
        }
    }
    return exit_code;
}

const suite_subject bench_parts = {
    .words = &subject_table[SUBJECT_PARTS],
    .full = {.scenes = {"atrium", "terrain"}, .depths = {10}},
    .quick = {.scenes = {"atrium"}, .depths = {8}},
    .begin = begin,
    .run = run,
};
