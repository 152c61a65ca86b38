/* SPDX-License-Identifier: MIT */
/*
 * Time and memory of builds in parts beside those in one piece. Each build is a process of its own, since the most
 * memory that a process ever had can be read but not reset. The drivers' caches are warm.
 *
 * Strong scaling: one tree in parts by p workers of one thread each, where a worker is a slot in which one process
 * `svocl parts build` after the other runs, as GNU parallel and Slurm do it. The part with the largest estimate is
 * next. Beside it stands a model from the run of one worker: plan, the parts of the busiest worker, stitch.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/child.h"
#include "bench/series.h"
#include "bench/subjects.h"
#include "measure/suite.h"
#include "svocl/parts.h"

/* ---- workers ---- */

#define WORKERS_MAX 64u
#define COUNTS_MAX  8u
#define RUNS_MAX    101u
#define PATH_BYTES  300

static const char workers_id[] = "parts-workers";

static const char workers_note[] =
    "Wall clock from the start of `svocl parts plan` to the end of `svocl parts stitch`: medians and quartiles (q1, "
    "q3). A worker builds one part after the other, each in a process of one thread, the largest estimate first. "
    "Numbers of workers run interleaved, with warm caches of kernels. Model: plan, the busiest worker's parts and "
    "stitch, by the medians of plan and stitch and the mean times of the parts of one worker. Speedup: over one "
    "worker. Rows without runs are the model's alone.";

/* One tree, planned once a run. */
typedef struct job {
    const suite *all;
    const child_cache *cache;
    const char *mesh;
    char folder[PATH_BYTES], out[PATH_BYTES], depth[16], limit[32];
    size_t *order; /* indices of parts, the largest estimate first */
    double *part_ms; /* by index: sums over the runs of one worker */
    size_t part_count;
    double plan_ms[RUNS_MAX], stitch_ms[RUNS_MAX]; /* of the runs of one worker */
} job;

typedef struct worker_times {
    unsigned workers;
    double ms[RUNS_MAX];
    size_t count;
} worker_times;

/* --workers, with 1 in front: the model needs it. *count: of the list. */
static int read_counts(const suite *all, unsigned counts[COUNTS_MAX], size_t *count)
{
    const char *list = all->state->options.workers != NULL ? all->state->options.workers : "1,2";
    counts[0] = 1;
    *count = 1;
    for (const char *text = list; *text != '\0';) {
        char *end = NULL;
        const unsigned long workers = strtoul(text, &end, 10);
        const bool is_number = *text >= '0' && *text <= '9' && workers >= 1 && workers <= WORKERS_MAX;
        const bool more = *end == ',' && end[1] != '\0';
        if (!is_number || (*end != '\0' && !more) || *count == COUNTS_MAX) {
            return program_fail(all->state, PROGRAM_WRONG_USAGE,
                                "--workers '%s' is not a list of 1 to %u numbers of workers, 1 to %u", list,
                                COUNTS_MAX - 1, WORKERS_MAX);
        }
        counts[*count] = (unsigned)workers;
        *count += workers != 1 ? 1u : 0u;
        text = more ? end + 1 : end;
    }
    return *list != '\0' ? PROGRAM_DONE : program_fail(all->state, PROGRAM_WRONG_USAGE, "--workers is empty");
}

/* Adds the empty table. Returns the exit code, its line printed. */
static int workers_begin(suite *all)
{
    unsigned counts[COUNTS_MAX];
    size_t count = 0;
    result_table *table =
        result_add_table(all->results, workers_id, "Trees built in parts: workers of one thread each", workers_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "parts", "");
    result_add_column(table, "workers", "");
    result_add_column(table, "runs", "");
    spread_add_columns(table, "time", "ms");
    result_add_column(table, "speedup", "");
    result_add_column(table, "model", "ms");
    result_add_column(table, "model speedup", "");
    return read_counts(all, counts, &count);
}

/* ---- processes ---- */

/* "parts ACTION NAME" with what all have. */
static child_arguments arguments_of(const char *action, const char *name)
{
    child_arguments made = {.count = 0};
    child_add(&made, "parts");
    child_add(&made, action);
    child_add(&made, name);
    child_add(&made, "--quiet");
    return made;
}

static void add_device(const job *j, child_arguments *arguments)
{
    child_add(arguments, "--threads");
    child_add(arguments, "1");
    child_add_device(arguments, &j->all->state->options, false);
}

/* Milliseconds; below 0 when the process failed. */
static double plan_parts(const job *j)
{
    child_arguments plan = arguments_of("plan", j->mesh);
    cJSON *document = NULL;
    const char *const rest[] = {"-d", j->depth, "--max-memory", j->limit, "-o", j->out};
    for (size_t i = 0; i < sizeof rest / sizeof rest[0]; ++i) {
        child_add(&plan, rest[i]);
    }
    add_device(j, &plan);
    const double ms = child_run(plan.list, j->cache, &document);
    cJSON_Delete(document);
    return ms;
}

static double run_step(const job *j, const char *action)
{
    const child_arguments step = arguments_of(action, j->folder);
    cJSON *document = NULL;
    const double ms = child_run(step.list, j->cache, &document);
    cJSON_Delete(document);
    return ms;
}

typedef struct slot {
    pid_t process; /* 0: free */
    size_t part;
    double start_ms;
} slot;

static bool start_part(const job *j, slot *free_slot, size_t part)
{
    char name[32];
    (void)snprintf(name, sizeof name, "%zu", part);
    child_arguments build = arguments_of("build", j->folder);
    child_add(&build, "--part");
    child_add(&build, name);
    add_device(j, &build);
    free_slot->part = part;
    free_slot->start_ms = input_now_ms();
    free_slot->process = child_start(&build, j->cache);
    return free_slot->process > 0;
}

/* Waits for one part. Its time is added to sums, unless that is NULL. */
static bool end_part(slot *slots, unsigned workers, double *sums)
{
    bool well = false;
    const pid_t ended = child_wait(&well);
    for (unsigned i = 0; i < workers; ++i) {
        if (ended > 0 && slots[i].process == ended) {
            slots[i].process = 0;
            if (sums != NULL) {
                sums[slots[i].part] += input_now_ms() - slots[i].start_ms;
            }
        }
    }
    return ended > 0 && well;
}

/* After a failure no more parts are started, but those that were are waited for. */
static bool build_parts(const job *j, unsigned workers, double *sums)
{
    slot slots[WORKERS_MAX] = {{0, 0, 0.0}};
    size_t started = 0;
    size_t running = 0;
    bool well = true;
    while (running > 0 || (started < j->part_count && well)) {
        for (unsigned i = 0; i < workers && started < j->part_count && well; ++i) {
            if (slots[i].process == 0) {
                well = start_part(j, &slots[i], j->order[started]);
                started += well ? 1u : 0u;
                running += well ? 1u : 0u;
            }
        }
        if (running > 0) {
            well = end_part(slots, workers, sums) && well;
            --running;
        }
    }
    return well;
}

/* ---- the list of parts ---- */

typedef struct sized_part {
    uint64_t bytes;
    size_t index;
} sized_part;

static int by_size(const void *left, const void *right)
{
    const sized_part *a = left;
    const sized_part *b = right;
    return a->bytes != b->bytes ? (a->bytes < b->bytes ? 1 : -1) : (a->index > b->index) - (a->index < b->index);
}

static int read_list(job *j, const svo_parts *parts)
{
    const size_t count = svo_parts_count(parts);
    sized_part *list = calloc(count + 1, sizeof *list);
    j->order = calloc(count + 1, sizeof *j->order);
    j->part_ms = calloc(count + 1, sizeof *j->part_ms);
    j->part_count = count;
    if (list == NULL || j->order == NULL || j->part_ms == NULL) {
        free(list);
        return program_fail(j->all->state, PROGRAM_FAILED, "out of memory");
    }
    for (size_t i = 0; i < count; ++i) {
        svo_parts_entry entry = SVO_PARTS_ENTRY_INIT;
        (void)svo_parts_get(parts, i, &entry, NULL); /* the index is in range */
        list[i] = (sized_part){entry.expected_bytes, i};
    }
    qsort(list, count, sizeof *list, by_size);
    for (size_t i = 0; i < count; ++i) {
        j->order[i] = list[i].index;
    }
    free(list);
    return PROGRAM_DONE;
}

/* Plans once, to know the parts. */
static int open_job(job *j)
{
    svo_message message;
    svo_parts *parts = NULL;
    if (plan_parts(j) < 0.0) {
        result_extend_note(result_find(j->all->results, workers_id),
                           "%s at depth %s has no rows: no parts of %s bytes.", j->mesh, j->depth, j->limit);
        return PROGRAM_DONE;
    }
    if (svo_parts_open(j->folder, &parts, &message) != SVO_OK) {
        return program_fail_library(j->all->state, message.text);
    }
    const int exit_code = read_list(j, parts);
    svo_parts_close(&parts);
    return exit_code;
}

/* ---- runs and the model ---- */

/* A whole run; it is not counted where times is NULL. */
static int run_once(job *j, unsigned workers, worker_times *times)
{
    const double start_ms = input_now_ms();
    const double plan_ms = plan_parts(j);
    const bool built = plan_ms >= 0.0 && build_parts(j, workers, times != NULL && workers == 1 ? j->part_ms : NULL);
    const double stitch_ms = built ? run_step(j, "stitch") : -1.0;
    const double ms = input_now_ms() - start_ms;
    const bool removed = run_step(j, "remove") >= 0.0;
    if (stitch_ms < 0.0 || !removed) {
        return program_fail(j->all->state, PROGRAM_FAILED, "'svocl parts' of %s failed as a child", j->mesh);
    }
    if (times != NULL && workers == 1) {
        j->plan_ms[times->count] = plan_ms;
        j->stitch_ms[times->count] = stitch_ms;
    }
    if (times != NULL) {
        times->ms[times->count++] = ms;
    }
    return PROGRAM_DONE;
}

/* The busiest of p workers, when each part goes to the one that is free first. */
static double busiest_ms(const job *j, unsigned workers, size_t runs)
{
    double busy[WORKERS_MAX] = {0.0};
    double most = 0.0;
    for (size_t i = 0; i < j->part_count; ++i) {
        unsigned least = 0;
        for (unsigned w = 1; w < workers; ++w) {
            least = busy[w] < busy[least] ? w : least;
        }
        busy[least] += j->part_ms[j->order[i]] / (double)runs;
        most = busy[least] > most ? busy[least] : most;
    }
    return most;
}

static void add_workers_row(const job *j, result_table *table, const input *source, unsigned depth, worker_times *times,
                            const worker_times *one)
{
    double plan_ms[RUNS_MAX], stitch_ms[RUNS_MAX], one_ms[RUNS_MAX];
    memcpy(plan_ms, j->plan_ms, sizeof plan_ms);
    memcpy(stitch_ms, j->stitch_ms, sizeof stitch_ms);
    memcpy(one_ms, one->ms, sizeof one_ms);
    const double fixed_ms = spread_of(plan_ms, one->count).median + spread_of(stitch_ms, one->count).median;
    const double model_ms = fixed_ms + busiest_ms(j, times->workers, one->count);
    const spread ms = times->count > 0 ? spread_of(times->ms, times->count) : spread_none();
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, depth);
    result_add_number(table, (double)j->part_count);
    result_add_number(table, times->workers);
    result_add_number(table, (double)times->count);
    spread_add(table, ms);
    result_add_number(table, spread_of(one_ms, one->count).median / ms.median);
    result_add_number(table, model_ms);
    result_add_number(table, (fixed_ms + busiest_ms(j, 1, one->count)) / model_ms);
}

/* Rows of what was measured, then of the model for more workers. */
static void add_rows(const job *j, const input *source, unsigned depth, worker_times *times, size_t count)
{
    static const unsigned modeled[] = {4, 8, 16};
    result_table *table = result_find(j->all->results, workers_id);
    unsigned most = 0;
    for (size_t i = 0; i < count; ++i) {
        add_workers_row(j, table, source, depth, &times[i], &times[0]);
        most = times[i].workers > most ? times[i].workers : most;
    }
    for (size_t i = 0; i < sizeof modeled / sizeof modeled[0]; ++i) {
        worker_times none = {.workers = modeled[i]};
        if (modeled[i] > most) {
            add_workers_row(j, table, source, depth, &none, &times[0]);
        }
    }
}

/* One run of each number of workers after the other; the first of each is not counted. */
static int run_rounds(job *j, worker_times *times, size_t count)
{
    const size_t rounds = j->all->repeats < RUNS_MAX ? j->all->repeats : RUNS_MAX;
    int exit_code = run_once(j, 1, NULL);
    for (size_t round = 0; round < rounds && exit_code == PROGRAM_DONE; ++round) {
        for (size_t i = 0; i < count && exit_code == PROGRAM_DONE; ++i) {
            exit_code = run_once(j, times[i].workers, &times[i]);
        }
    }
    return exit_code;
}

/* Adds rows for each number of workers of --workers, or for 1 and 2. limit: of a part's memory. cache: warm. */
static int workers_run(suite *all, const input *source, unsigned depth, uint64_t limit, const child_cache *cache)
{
    job j = {.all = all, .cache = cache, .mesh = source->name};
    unsigned counts[COUNTS_MAX];
    size_t count = 0;
    (void)snprintf(j.out, sizeof j.out, "%s/workers.svo", cache->path);
    (void)snprintf(j.folder, sizeof j.folder, "%s/workers.svo.parts", cache->path);
    (void)snprintf(j.depth, sizeof j.depth, "%u", depth);
    (void)snprintf(j.limit, sizeof j.limit, "%" PRIu64, limit);
    worker_times *times = calloc(COUNTS_MAX, sizeof *times);
    int exit_code =
        times == NULL ? program_fail(all->state, PROGRAM_FAILED, "out of memory") : read_counts(all, counts, &count);
    for (size_t i = 0; i < count && times != NULL; ++i) {
        times[i].workers = counts[i];
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = open_job(&j);
    }
    if (exit_code == PROGRAM_DONE && j.part_count > 0) {
        exit_code = run_rounds(&j, times, count);
    }
    if (exit_code == PROGRAM_DONE && j.part_count > 0) {
        add_rows(&j, source, depth, times, count);
    }
    free(times);
    free(j.order);
    free(j.part_ms);
    return exit_code;
}

/* ---- builds in parts ---- */

static const char table_id[] = "parts";

/* Limits of a part, as shares of the buffers of the build in one piece; 0: in one piece. */
static const unsigned shares[] = {0, 4, 16, 64};
#define WORKERS_SHARE 2u /* for workers: parts that take long beside the start of a process */
#define FORM_COUNT    (sizeof shares / sizeof shares[0])

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
