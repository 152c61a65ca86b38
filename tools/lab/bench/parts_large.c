/* SPDX-License-Identifier: MIT */
/*
 * Trees that are larger than the memory that their builds take: `svocl build --max-memory` as a process of its own,
 * with the most memory that it had. parts.c compares smaller ones with builds in one piece.
 */
#include "bench/subjects.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "bench/child.h"

#define MIB ((uint64_t)1 << 20)
/* Edge of a wide grid over the mesh's. The mesh lies in the middle, where the eight parts of the first level meet. */
#define WIDE 32.0

static const char table_id[] = "parts-large";

/* What is built. */
static const struct large_case {
    const char *scene;
    unsigned depth;
    uint64_t limit;
    bool wide;
} cases[] = {
    {"atrium", 12, 880 * MIB, false}, /* below 1 GiB, with the mesh, the driver and all libraries */
    {"terrain", 13, 128 * MIB, false}, /* below 256 MiB, as the others */
    {"needles", 13, 128 * MIB, false}, /* triangles that many parts share */
    {"atrium", 16, 128 * MIB, true}, /* the largest depth */
    {"atrium", 8, 8 * MIB, false}, /* --quick */
};

static const char note[] =
    "`svocl build -o FILE --max-memory LIMIT` as a process of its own: the second of two, with warm caches of kernels. "
    "Time: wall clock, from the start of the process to its exit. Peak: the most memory that the process had resident "
    "(VmHWM), with all libraries. Grid: its edge over the mesh's; 1 is fitted to the mesh.";

static int begin(suite *all)
{
    result_table *table = result_add_table(all->results, table_id, "Trees larger than memory", note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "grid", "");
    result_add_column(table, "limit", "B");
    result_add_column(table, "parts", "");
    result_add_column(table, "leaves", "");
    result_add_column(table, "file", "B");
    result_add_column(table, "time", "ms");
    result_add_column(table, "peak", "B");
    return PROGRAM_DONE;
}

static const struct large_case *find_case(const input *source, unsigned depth)
{
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        if (cases[i].depth == depth && strcmp(cases[i].scene, suite_scene_name(source)) == 0) {
            return &cases[i];
        }
    }
    return NULL;
}

/* Arguments of a grid around the mesh. */
typedef struct grid_texts {
    char origin[96], edge[32];
} grid_texts;

static int find_grid(const suite *all, const input *source, grid_texts *out)
{
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_plan *plan = NULL;
    if (svo_plan_create(all->opened.device, source->mesh, 1, NULL, &plan) != SVO_OK) {
        return program_fail_library(all->state, svo_device_message(all->opened.device));
    }
    (void)svo_plan_get_info(plan, &info); /* the arguments are right */
    svo_plan_destroy(&plan);
    const double before = 0.5 * (WIDE - 1.0) * info.edge;
    (void)snprintf(out->origin, sizeof out->origin, "%.17g,%.17g,%.17g", info.origin[0] - before,
                   info.origin[1] - before, info.origin[2] - before);
    (void)snprintf(out->edge, sizeof out->edge, "%.17g", WIDE * info.edge);
    return PROGRAM_DONE;
}

static double number_of(const cJSON *document, const char *name)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(document, name);
    return cJSON_IsNumber(number) ? number->valuedouble : 0.0;
}

/* A case on its way. */
typedef struct large_run {
    const suite *all;
    const input *source;
    const struct large_case *of;
    child_cache cache;
    grid_texts grid;
    char depth[16], limit[32], path[300];
} large_run;

/* Adds what says which tree, after the command. */
static void add_tree(const large_run *run, child_arguments *arguments)
{
    const char *const list[] = {run->source->name, "-d",       run->depth, "--frontend", "cl",
                                "--max-memory",    run->limit, "-o",       run->path};
    for (size_t i = 0; i < sizeof list / sizeof list[0]; ++i) {
        child_add(arguments, list[i]);
    }
    if (run->of->wide) {
        child_add(arguments, "--origin");
        child_add(arguments, run->grid.origin);
        child_add(arguments, "--edge");
        child_add(arguments, run->grid.edge);
    }
    child_add_device(arguments, &run->all->state->options, false);
}

static void add_row(result_table *table, const struct large_case *of, const child_answer *built,
                    const child_answer *file)
{
    result_add_text(table, "%s", of->scene);
    result_add_number(table, of->depth);
    result_add_number(table, of->wide ? WIDE : 1.0);
    result_add_number(table, (double)of->limit);
    result_add_number(table, number_of(built->document, "parts"));
    result_add_number(table, number_of(file->document, "leaves"));
    result_add_number(table, number_of(file->document, "file_bytes"));
    result_add_number(table, built->ms);
    result_add_number(table, number_of(built->document, "peak_resident_bytes"));
}

/* A build and what its file has. *error: "" after success. */
static void build_once(const large_run *run, child_answer *built, child_answer *file, const char **error)
{
    child_arguments build = {.list = {"build", "--json"}, .count = 2};
    const child_arguments describe = {.list = {"info", run->path, "--json"}, .count = 3};
    add_tree(run, &build);
    child_ask(&build, &run->cache, 0, built);
    child_ask(&describe, &run->cache, 0, file);
    *error = built->well ? file->reason : built->reason;
}

/* The first build, which is not counted, fills the caches. Where the disk is too small there is no row, but a line of
   the note. */
static void run_case(const large_run *run)
{
    result_table *table = result_find(run->all->results, table_id);
    child_answer built, file;
    const char *error = "";
    for (int round = 0; round < 2 && error[0] == '\0'; ++round) {
        build_once(run, &built, &file, &error);
        if (round == 1 && error[0] == '\0') {
            add_row(table, run->of, &built, &file);
        }
        cJSON_Delete(built.document);
        cJSON_Delete(file.document);
    }
    if (error[0] != '\0') {
        result_extend_note(table, "%s at depth %s has no row: %s.", run->of->scene, run->depth, error);
    }
}

static int run(suite *all, const input *source, unsigned depth)
{
    large_run run = {.all = all, .source = source, .of = find_case(source, depth)};
    if (run.of == NULL) {
        return PROGRAM_DONE;
    }
    if (!child_cache_create(&run.cache)) {
        return program_fail(all->state, PROGRAM_FAILED, "no folder for temporary files can be made");
    }
    (void)snprintf(run.depth, sizeof run.depth, "%u", depth);
    (void)snprintf(run.limit, sizeof run.limit, "%" PRIu64, run.of->limit);
    (void)snprintf(run.path, sizeof run.path, "%s/tree.svo", run.cache.path);
    int exit_code = find_grid(all, source, &run.grid);
    if (exit_code == PROGRAM_DONE) {
        run_case(&run);
    }
    child_cache_remove(&run.cache);
    return exit_code;
}

const suite_subject bench_parts_large = {
    .words = &subject_table[SUBJECT_PARTS_LARGE],
    .full = {.scenes = {"atrium", "terrain", "needles"}, .depths = {12, 13, 16}},
    .quick = {.scenes = {"atrium"}, .depths = {8}},
    .fixed = true,
    .begin = begin,
    .run = run,
};
