/* SPDX-License-Identifier: MIT */
/*
 * svocl bench rays: millions of rays per second against the triangles of a tree, interleaved with Embree at its best,
 * or with a grid of the tree's leaf lists. ray_run.c measures; this shows one input by itself, or the rows of a suite.
 */
#include "bench/rays.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/child.h"
#include "bench/ray_run.h"
#include "measure/host.h"
#include "support/info_of.h"
#include "support/json.h"
#include "support/options_parse.h"
#include "support/table.h"

#define DEFAULT_INPUT   "scene:statue:120000"
#define QUICK_INPUT     "scene:knot:8000"
#define DEFAULT_REPEATS 7u
#define QUICK_REPEATS   3u
#define CALL_BYTES      32

/* ---- one input: JSON ---- */

/* What --vs names. */
static const char *rival_name(const ray_run *run)
{
    return run->peers[0] != NULL ? "embree" : run->grid != NULL ? "grid" : NULL;
}

static void add_rival_number(cJSON *to, const ray_run *run, const char *name, double number)
{
    char key[32];
    (void)snprintf(key, sizeof key, "%s_%s", rival_name(run), name);
    cJSON_AddNumberToObject(to, key, number);
}

static cJSON *rival_to_json(const ray_run *run, const ray_rival *rival)
{
    char call[CALL_BYTES];
    cJSON *one = cJSON_CreateObject();
    ray_rival_call(rival, call, sizeof call);
    json_add_text(one, "build", rival->build);
    json_add_text(one, "call", call);
    cJSON_AddBoolToObject(one, "coherent", rival->call.coherent);
    cJSON_AddNumberToObject(one, "mrays", ray_run_rate(run, rival->ms.median));
    cJSON_AddNumberToObject(one, "ratio", rival->ratio.median);
    return one;
}

static cJSON *set_to_json(const ray_run *run, const ray_set *set)
{
    cJSON *one = cJSON_CreateObject();
    json_add_text(one, "name", set->name);
    json_add_count(one, "rays", run->ray_count);
    json_add_count(one, "hits", set->verdict.hits);
    cJSON_AddNumberToObject(one, "leaves_per_ray", set->verdict.leaves);
    cJSON_AddNumberToObject(one, "ours_mrays", ray_run_rate(run, set->ours_ms.median));
    if (ray_run_has_rivals(run)) {
        const ray_rival *best = &set->rivals[set->best];
        add_rival_number(one, run, "mrays", ray_run_rate(run, best->ms.median));
        cJSON_AddNumberToObject(one, "ratio", best->ratio.median);
        json_add_count(one, "wrong_ids", set->verdict.wrong_ids);
        json_add_count(one, "missed", set->verdict.missed);
        json_add_count(one, "differing", set->verdict.differing);
        json_add_count(one, "tied", set->verdict.tied);
        add_rival_number(one, run, "wrong_ids", (double)set->verdict.their_wrong_ids);
        add_rival_number(one, run, "missed", (double)set->verdict.their_missed);
        cJSON *rivals = cJSON_AddArrayToObject(one, "calls");
        for (size_t i = 0; i < set->rival_count; ++i) {
            cJSON_AddItemToArray(rivals, rival_to_json(run, &set->rivals[i]));
        }
    }
    return one;
}

/* "1, 4, 8, 16" */
static void list_native_widths(const embree *peer, char *text, size_t text_bytes)
{
    static const unsigned widths[] = {1, 4, 8, 16};
    int used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < sizeof widths / sizeof widths[0]; ++i) {
        if (embree_is_native(peer, widths[i]) && used >= 0 && (size_t)used < text_bytes) {
            used += snprintf(text + used, text_bytes - (size_t)used, "%s%u", used > 0 ? ", " : "", widths[i]);
        }
    }
}

static cJSON *to_json(const ray_run *run)
{
    cJSON *document = json_document();
    json_add_text(document, "input", run->work.source.name);
    job_add_what_ran(document, &run->work);
    json_add_count(document, "triangles", run->work.result.info.list_triangle_count);
    json_add_count(document, "threads", run->threads);
    json_add_count(document, "repeats", run->repeats);
    json_add_text(document, "instruction_set", instruction_set_name(run->state->options.isa));
    json_add_text(document, "vs", rival_name(run));
    json_add_text(document, "embree_version", run->peers[0] != NULL ? embree_version(run->peers[0]) : NULL);
    if (run->peers[0] != NULL) {
        char native[CALL_BYTES];
        list_native_widths(run->peers[0], native, sizeof native);
        json_add_text(document, "embree_native_widths", native);
    }
    json_add_count(document, "ours_bytes", info_of_tree(run->work.result.tree).ray_bytes);
    if (run->grid != NULL) {
        json_add_count(document, "grid_bytes", grid_rays_bytes(run->grid));
        json_add_count(document, "grid_cell_bytes", grid_rays_cell_bytes(run->grid));
    }
    cJSON *sets = cJSON_AddArrayToObject(document, "sets");
    for (int k = 0; k < RAY_SETS; ++k) {
        if (run->sets[k].is_measured) {
            cJSON_AddItemToArray(sets, set_to_json(run, &run->sets[k]));
        }
    }
    return document;
}

/* ---- one input: tables ---- */

/* Rates of all rivals, and svocl's over the best one's. */
static void print_rates(const ray_run *run)
{
    table *rows = table_create("lrrrrrrrr");
    table_cell(rows, "rays");
    table_cell(rows, "svocl");
    const ray_set *first = &run->sets[RAY_SET_PRIMARY];
    for (size_t i = 0; i < RAY_RIVALS_MAX; ++i) {
        const ray_rival *rival = &first->rivals[i];
        if (i >= first->rival_count) {
            table_cell(rows, "%s", "");
        } else if (rival->peer == NULL) {
            table_cell(rows, "grid");
        } else if (rival->width != 0) {
            table_cell(rows, "Embree, %u", rival->width);
        } else {
            table_cell(rows, "%s", rival->build);
        }
    }
    table_cell(rows, ray_run_has_rivals(run) ? "ratio" : "");
    for (int k = 0; k < RAY_SETS; ++k) {
        const ray_set *set = &run->sets[k];
        if (!set->is_measured) {
            continue;
        }
        table_cell(rows, "%s", set->name);
        table_cell(rows, "%s", figure_rate(ray_run_rate(run, set->ours_ms.median) * 1e6).text);
        for (size_t i = 0; i < RAY_RIVALS_MAX; ++i) {
            const bool there = i < set->rival_count;
            table_cell(rows, "%s", there ? figure_rate(ray_run_rate(run, set->rivals[i].ms.median) * 1e6).text : "");
        }
        if (set->rival_count > 0) {
            table_cell(rows, "%.2f", set->rivals[set->best].ratio.median);
        } else {
            table_cell(rows, "%s", "");
        }
    }
    table_print(rows);
}

static void print_verdicts(const ray_run *run)
{
    table *rows = table_create("lrrrr");
    table_cell(rows, "rays");
    table_cell(rows, "differing");
    table_cell(rows, "tied");
    table_cell(rows, "wrong");
    table_cell(rows, "%s wrong", run->grid != NULL ? "grid" : "Embree");
    for (int k = 0; k < RAY_SETS; ++k) {
        const ray_verdict *verdict = &run->sets[k].verdict;
        if (run->sets[k].is_measured) {
            table_cell(rows, "%s", run->sets[k].name);
            table_cell(rows, "%zu", verdict->differing);
            table_cell(rows, "%zu", verdict->tied);
            table_cell(rows, "%zu", verdict->wrong_ids + verdict->missed);
            table_cell(rows, "%zu", verdict->their_wrong_ids + verdict->their_missed);
        }
    }
    table_print(rows);
}

static void print_tables(const ray_run *run)
{
    progress_hide(run->state->progress);
    table_line("%s: %s triangles at depth %u, %s rays per set, medians of %zu rounds, %s", run->work.source.name,
               figure_count(run->work.result.info.list_triangle_count).text, run->work.result.info.depth,
               figure_count(run->ray_count).text, run->repeats, instruction_set_name(run->state->options.isa));
    if (run->grid != NULL) {
        table_line("svocl's BVH %s; grid %s, of which bricks and cells %s",
                   figure_bytes(info_of_tree(run->work.result.tree).ray_bytes).text,
                   figure_bytes(grid_rays_bytes(run->grid)).text, figure_bytes(grid_rays_cell_bytes(run->grid)).text);
    }
    if (run->peers[0] != NULL) {
        char native[CALL_BYTES];
        list_native_widths(run->peers[0], native, sizeof native);
        table_line("Embree %s, native widths %s: calls with its medium build, then other builds by their fastest call",
                   embree_version(run->peers[0]), native);
    }
    print_rates(run);
    if (ray_run_has_rivals(run)) {
        table_gap();
        print_verdicts(run);
    }
}

/* ---- the command ---- */

static unsigned count_threads(const options *given)
{
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return given->threads != 0 ? (unsigned)given->threads : online > 0 ? (unsigned)online : 1;
}

/* Saves, and prints as JSON or as tables. */
static int show(const ray_run *run)
{
    const options *given = &run->state->options;
    cJSON *document = to_json(run);
    if (given->output_path != NULL) {
        const int exit_code = json_save(run->state, given->output_path, document);
        if (exit_code != PROGRAM_DONE) {
            cJSON_Delete(document);
            return exit_code;
        }
    }
    if (given->json) {
        return json_print(run->state, document);
    }
    cJSON_Delete(document);
    if (given->output_path == NULL || !given->quiet) {
        print_tables(run);
    }
    return PROGRAM_DONE;
}

int bench_rays_alone(program *state)
{
    options *given = &state->options;
    if (given->versus == OPTION_VERSUS_OPENVDB) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --vs openvdb does not apply to bench rays");
    }
    if (given->versus == OPTION_VERSUS_EMBREE && !embree_is_there()) {
        return program_fail(state, PROGRAM_FAILED, "--vs embree: %s", embree_lack());
    }
    given->input = given->input != NULL ? given->input : given->quick ? QUICK_INPUT : DEFAULT_INPUT;
    ray_run run = {.state = state,
                   .threads = count_threads(given),
                   .ray_count = (size_t)given->ray_count,
                   .repeats = given->has_repeat ? (size_t)given->repeat
                              : given->quick    ? QUICK_REPEATS
                                                : DEFAULT_REPEATS};
    given->repeat = 1; /* builds */
    given->depth_for_rays = !given->has_depth;
    program_begin_progress(state, 3 + RAY_SETS);
    int exit_code = ray_run_all(&run);
    if (exit_code == PROGRAM_DONE) {
        exit_code = show(&run);
    }
    ray_run_release(&run);
    return exit_code;
}

/* ---- the subject ---- */

static const char table_id[] = "rays";
static const char calls_id[] = "ray-calls";

static const char note[] =
    "Wall clock, on the rounded mesh, interleaved, each run after one that does not count, on as many threads. "
    "Primary: "
    "tiles of 4 x 4 pixels, which packets of 16 are; by rows: the same picture row by row; close up: from a quarter of "
    "the distance. Shadow, diffuse bounce and ambient occlusion (within a twentieth of the box's diagonal) start where "
    "primary rays hit; shadow and occlusion ask for any hit. Misses through the box: the incoherent rays that miss; "
    "misses: rays away from it. Embree: the fastest of rtcIntersect1, 8 and 16, or of rtcOccluded, with its medium "
    "build, in place on packets that are laid out before the clock starts, hits taken out of them after it. Ratio: "
    "svocl's rays per second to Embree's, within each round; below 1 Embree leads. Wrong: "
    "another triangle than the reference, or none.";

static const char calls_note[] =
    "The same runs, call by call: Embree's medium build with rtcIntersect1, 8 and 16 (for shadow and occlusion "
    "rtcOccluded), "
    "each with the faster of its flags for coherent and for incoherent rays; low, high and robust: its other builds "
    "by their fastest call. Native widths: packets that Embree does not divide. Best: the fastest of all of these, and "
    "svocl's rays per second to its.";

static void add_calls_table(suite *all)
{
    result_table *calls = suite_add_table(all, calls_id, "Rays against triangles, Embree call by call", calls_note);
    result_add_column(calls, "scene", "");
    result_add_column(calls, "instruction set", "");
    result_add_column(calls, "native widths", "");
    result_add_column(calls, "rays", "");
    result_add_column(calls, "svocl", "M/s");
    result_add_column(calls, "1 ray", "M/s");
    result_add_column(calls, "8 rays", "M/s");
    result_add_column(calls, "16 rays", "M/s");
    result_add_column(calls, "low", "M/s");
    result_add_column(calls, "high", "M/s");
    result_add_column(calls, "robust", "M/s");
    result_add_column(calls, "best", "");
    spread_add_columns(calls, "ratio", "");
    if (!embree_is_there()) {
        result_extend_note(calls, "Empty: %s.", embree_lack());
    }
}

static int begin(suite *all)
{
    result_table *results = suite_add_table(all, table_id, "Rays against triangles", note);
    if (!embree_is_there()) {
        result_extend_note(results, "Without Embree: %s.", embree_lack());
    }
    result_add_column(results, "scene", "");
    result_add_column(results, "triangles", "");
    result_add_column(results, "depth", "");
    result_add_column(results, "rays", "");
    result_add_column(results, "count", "");
    result_add_column(results, "hits", "");
    spread_add_columns(results, "svocl time", "ms");
    result_add_column(results, "svocl", "M/s");
    spread_add_columns(results, "Embree time", "ms");
    result_add_column(results, "Embree", "M/s");
    spread_add_columns(results, "ratio", "");
    result_add_column(results, "wrong", "");
    result_add_column(results, "Embree wrong", "");
    result_add_column(results, "Embree call", "");
    result_add_column(results, "instruction set", "");
    add_calls_table(all);
    return PROGRAM_DONE;
}

static void add_row(result_table *results, const ray_run *run, const ray_set *set)
{
    const bool compared = set->rival_count > 0;
    const ray_rival *best = &set->rivals[set->best];
    char call[CALL_BYTES] = "";
    if (compared) {
        ray_rival_call(best, call, sizeof call);
    }
    result_add_text(results, "%s", suite_scene_name(&run->work.source));
    result_add_number(results, (double)run->work.result.info.list_triangle_count);
    result_add_number(results, run->work.result.info.depth);
    result_add_text(results, "%s", set->name);
    result_add_number(results, (double)run->ray_count);
    result_add_number(results, (double)set->verdict.hits);
    spread_add(results, set->ours_ms);
    result_add_number(results, ray_run_rate(run, set->ours_ms.median));
    spread_add(results, compared ? best->ms : spread_none());
    result_add_number(results, compared ? ray_run_rate(run, best->ms.median) : (double)NAN);
    spread_add(results, compared ? best->ratio : spread_none());
    result_add_number(results, compared ? (double)(set->verdict.wrong_ids + set->verdict.missed) : (double)NAN);
    result_add_number(results,
                      compared ? (double)(set->verdict.their_wrong_ids + set->verdict.their_missed) : (double)NAN);
    result_add_text(results, "%s", call);
    result_add_text(results, "%s", instruction_set_name(run->state->options.isa));
}

static void add_calls_row(result_table *results, const ray_run *run, const ray_set *set)
{
    const ray_rival *best = &set->rivals[0];
    char call[CALL_BYTES];
    char native[CALL_BYTES];
    list_native_widths(run->peers[0], native, sizeof native);
    result_add_text(results, "%s", suite_scene_name(&run->work.source));
    result_add_text(results, "%s", instruction_set_name(run->state->options.isa));
    result_add_text(results, "%s", native);
    result_add_text(results, "%s", set->name);
    result_add_number(results, ray_run_rate(run, set->ours_ms.median));
    for (size_t i = 0; i < set->rival_count; ++i) {
        result_add_number(results, ray_run_rate(run, set->rivals[i].ms.median));
        best = set->rivals[i].ms.median < best->ms.median ? &set->rivals[i] : best;
    }
    ray_rival_call(best, call, sizeof call);
    result_add_text(results, "%s, %s", call, best->build);
    spread_add(results, best->ratio);
}

static void add_rows(suite *all, const ray_run *run)
{
    for (int k = 0; k < RAY_SETS; ++k) {
        if (run->sets[k].is_measured) {
            add_row(result_find(all->results, table_id), run, &run->sets[k]);
        }
        if (run->sets[k].is_measured && run->sets[k].rival_count > 0) {
            add_calls_row(result_find(all->results, calls_id), run, &run->sets[k]);
        }
    }
}

/* Appends the rows of the calls' table from the document of a child process. */
static bool take_calls(suite *all, const cJSON *document)
{
    result_table *into = result_find(all->results, calls_id);
    const cJSON *from = NULL;
    cJSON_ArrayForEach(from, cJSON_GetObjectItemCaseSensitive(document, "tables"))
    {
        const cJSON *id = cJSON_GetObjectItemCaseSensitive(from, "id");
        if (!cJSON_IsString(id) || strcmp(id->valuestring, calls_id) != 0) {
            continue;
        }
        const cJSON *row = NULL;
        cJSON_ArrayForEach(row, cJSON_GetObjectItemCaseSensitive(from, "rows"))
        {
            const cJSON *cell = NULL;
            cJSON_ArrayForEach(cell, row)
            {
                if (cJSON_IsString(cell)) {
                    result_add_text(into, "%s", cell->valuestring);
                } else {
                    result_add_number(into, cJSON_IsNumber(cell) ? cell->valuedouble : (double)NAN);
                }
            }
        }
        return true;
    }
    return false;
}

/* Whether a full run on AVX-512 adds rows for AVX2. */
static bool wants_narrower(const suite *all)
{
    const options *given = &all->state->options;
    return given->isa == NULL && !all->quick && embree_is_there() && instruction_set_is_there("avx512");
}

/* "bench rays" of one scene with AVX2, on the device and the threads of this process. */
static bool measure_narrower(const suite *all, const input *source, unsigned depth, const child_cache *cache,
                             cJSON **document)
{
    const options *given = &all->state->options;
    char ray_count[24], repeats[24], depth_text[24], threads[24];
    snprintf(ray_count, sizeof ray_count, "%zu", (size_t)given->ray_count);
    snprintf(repeats, sizeof repeats, "%zu", all->repeats);
    snprintf(depth_text, sizeof depth_text, "%u", depth);
    snprintf(threads, sizeof threads, "%zu", (size_t)given->threads);
    const char *const always[] = {"bench",      "rays",        "--isa",   "avx2",     "--json", "--scenes",
                                  source->name, "--ray-count", ray_count, "--repeat", repeats};
    child_arguments arguments = {.count = 0};
    for (size_t i = 0; i < sizeof always / sizeof always[0]; ++i) {
        child_add(&arguments, always[i]);
    }
    if (depth != SUITE_DEPTH_FOR_RAYS) {
        child_add(&arguments, "--depths");
        child_add(&arguments, depth_text);
    }
    if (given->threads != 0) {
        child_add(&arguments, "--threads");
        child_add(&arguments, threads);
    }
    child_add_device(&arguments, given, true);
    return child_run(arguments.list, cache, document) >= 0;
}

/* The calls with AVX2: PoCL and Embree choose their instruction set when they start, so a child process measures. */
static int run_narrower(suite *all, const input *source, unsigned depth)
{
    child_cache cache = {.path = ""};
    cJSON *document = NULL;
    if (!child_cache_create(&cache)) {
        return program_fail(all->state, PROGRAM_FAILED, "bench rays: no folder for compiled kernels");
    }
    const bool taken = measure_narrower(all, source, depth, &cache, &document) && take_calls(all, document);
    cJSON_Delete(document);
    child_cache_remove(&cache);
    if (!taken) {
        result_extend_note(result_find(all->results, calls_id), "AVX2 could not be measured.");
    }
    return PROGRAM_DONE;
}

/* Opens a device handle of its own and reads the input again, because the mesh is snapped. */
static int run(suite *all, const input *source, unsigned depth)
{
    options *given = &all->state->options;
    const options before = *given;
    given->input = source->name;
    given->frontend = options_ask_for_gl(given) ? given->frontend : OPTION_FRONTEND_CL;
    given->repeat = 1; /* builds */
    given->depth_for_rays = depth == SUITE_DEPTH_FOR_RAYS;
    given->depth = given->depth_for_rays ? OPTION_DEFAULT_DEPTH : depth;
    given->versus = embree_is_there() ? OPTION_VERSUS_EMBREE : 0;
    ray_run made = {.state = all->state,
                    .threads = count_threads(given),
                    .ray_count = (size_t)given->ray_count,
                    .repeats = all->repeats};
    progress_hold(all->state->progress, true);
    const int exit_code = ray_run_all(&made);
    progress_hold(all->state->progress, false);
    if (exit_code == PROGRAM_DONE) {
        add_rows(all, &made);
    }
    ray_run_release(&made);
    *given = before;
    return exit_code == PROGRAM_DONE && wants_narrower(all) ? run_narrower(all, source, depth) : exit_code;
}

const suite_subject bench_rays = {
    .words = &subject_table[SUBJECT_RAYS],
    .full = {.scenes = {"statue:120000", "atrium", "terrain"}, .depths = {SUITE_DEPTH_FOR_RAYS}},
    .quick = {.scenes = {"knot:8000"}, .depths = {SUITE_DEPTH_FOR_RAYS}},
    .begin = begin,
    .run = run,
};
