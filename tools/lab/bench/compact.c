/* SPDX-License-Identifier: MIT */
/*
 * svocl bench compact: the built tree and its compact forms, bytes of their nodes and rays through their voxels; and
 * how much of a tree SVO_FORM_SHARED stores once, with and without merged leaves, and SVO_FORM_MIRRORED. compact_packed
 * has the part on packed payload.
 */
#include <stdlib.h>

#include "bench/compact_packed.h"
#include "bench/subjects.h"
#include "measure/ray_sets.h"
#include "measure/spread.h"
#include "measure/suite.h"
#include "support/info_of.h"

/* ---- all forms ---- */

static const char table_id[] = "compact";

/* The first is the one that the others are compared with. */
static const struct {
    const char *name;
    svo_form form;
    uint32_t directory_step_log2;
} forms[] = {
    {"built", SVO_FORM_COUNT, 0},         {"descriptor", SVO_FORM_DESCRIPTOR, 0}, {"implied, 16", SVO_FORM_IMPLIED, 4},
    {"implied, 32", SVO_FORM_IMPLIED, 5}, {"implied, 64", SVO_FORM_IMPLIED, 6},   {"shared", SVO_FORM_SHARED, 0},
    {"mirrored", SVO_FORM_MIRRORED, 0},
};
#define FORM_COUNT (sizeof forms / sizeof forms[0])
#define SHARED     5u /* their places */
#define MIRRORED   6u
#define SET_COUNT  2

static const char note[] =
    "Nodes without payload; rays against voxels, as a camera's and between random points, run interleaved. Made: from "
    "the built tree, time of all processors together. Far: far words among all words. Ratio: rays per second, relative "
    "to the built tree within each round.";

typedef struct compact_bench {
    suite *all;
    const input *source;
    unsigned depth;
    size_t ray_count;
    svo_tree *tree;
    svo_tree_info info;
    svo_compact *made[FORM_COUNT]; /* NULL for the built tree */
    double made_ms[FORM_COUNT];
    svo_ray *rays;
    cl_mem device_rays, device_hits;
    double *times; /* by set, form, round */
    double *scratch; /* by round */
} compact_bench;

static void compact_begin(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Compact trees: bytes and rays per second", note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "leaves", "");
    result_add_column(table, "form", "");
    result_add_column(table, "made", "ms");
    result_add_column(table, "far", "%");
    result_add_column(table, "nodes", "B");
    result_add_column(table, "per leaf", "B");
    result_add_column(table, "primary", "M/s");
    spread_add_columns(table, "primary ratio", "");
    result_add_column(table, "incoherent", "M/s");
    spread_add_columns(table, "incoherent ratio", "");
}

/* ---- trees ---- */

static svo_status build(compact_bench *bench, uint32_t need)
{
    const session *opened = &bench->all->opened;
    svo_plan_options asked = SVO_PLAN_OPTIONS_INIT;
    svo_plan *plan = NULL;
    asked.need = need;
    svo_status status =
        bench->source->mesh != NULL
            ? svo_plan_create(opened->device, bench->source->mesh, bench->depth, &asked, &plan)
            : voxel_input_plan(bench->all->state, opened->device, &bench->source->voxels, &asked, &plan);
    if (status == SVO_OK) {
        status = svo_build(plan, opened->cl, opened->queue, &bench->tree, NULL);
    }
    svo_plan_destroy(&plan);
    if (status != SVO_OK) {
        return status;
    }
    bench->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    return svo_tree_get_info(bench->tree, &bench->info);
}

/* Each is made twice, since the first call compiles. */
static svo_status make_forms(compact_bench *bench)
{
    const session *opened = &bench->all->opened;
    for (size_t i = 1; i < FORM_COUNT; ++i) {
        svo_compact_options asked = SVO_COMPACT_OPTIONS_INIT;
        asked.form = forms[i].form;
        asked.directory_step_log2 = forms[i].directory_step_log2;
        for (int turn = 0; turn < 2; ++turn) {
            svo_compact_destroy(&bench->made[i]);
            const double start_ms = input_cpu_ms();
            const svo_status status =
                svo_compact_create(opened->device, bench->tree, &asked, opened->queue, &bench->made[i]);
            bench->made_ms[i] = input_cpu_ms() - start_ms;
            if (status != SVO_OK) {
                return status;
            }
        }
    }
    return SVO_OK;
}

/* ---- rays ---- */

static bool make_room(compact_bench *bench)
{
    const cl_context context = info_of_device(bench->all->opened.device).context;
    cl_int errors[2] = {CL_SUCCESS, CL_SUCCESS};
    bench->rays = calloc(bench->ray_count, sizeof *bench->rays);
    bench->times = calloc(SET_COUNT * FORM_COUNT * bench->all->repeats, sizeof *bench->times);
    bench->scratch = calloc(bench->all->repeats + 1, sizeof *bench->scratch);
    bench->device_rays =
        clCreateBuffer(context, CL_MEM_READ_ONLY, bench->ray_count * sizeof(svo_ray), NULL, &errors[0]);
    bench->device_hits =
        clCreateBuffer(context, CL_MEM_WRITE_ONLY, bench->ray_count * sizeof(svo_voxel_hit), NULL, &errors[1]);
    return bench->rays != NULL && bench->times != NULL && bench->scratch != NULL && errors[0] == CL_SUCCESS &&
           errors[1] == CL_SUCCESS;
}

static void make_rays(compact_bench *bench, size_t set)
{
    if (set == 0) {
        svo_camera camera = {.vertical_fov = 0};
        (void)svo_camera_fit(svo_tree_target(bench->tree), 1.0f, &camera);
        ray_set_primary(&camera, 1, bench->ray_count, bench->rays);
        return;
    }
    double high[3];
    for (int axis = 0; axis < 3; ++axis) {
        high[axis] = bench->info.origin[axis] + bench->info.edge;
    }
    ray_set_incoherent(bench->info.origin, high, bench->ray_count, bench->rays);
}

/* Milliseconds of one pass; below 0 on failure. */
static double trace(const compact_bench *bench, size_t form)
{
    cl_command_queue queue = bench->all->opened.queue;
    cl_event done = NULL;
    const double start_ms = input_now_ms();
    const svo_status status =
        bench->made[form] == NULL
            ? svo_trace_voxels(svo_tree_target(bench->tree), svo_in_buffer(bench->device_rays),
                               svo_in_buffer(bench->device_hits), bench->ray_count, 0.0f, 0,
                               &(svo_submit){.queue = queue, .event = &done})
            : svo_trace_voxels(svo_compact_target(bench->made[form]), svo_in_buffer(bench->device_rays),
                               svo_in_buffer(bench->device_hits), bench->ray_count, 0.0f, 0,
                               &(svo_submit){.queue = queue, .event = &done});
    if (status != SVO_OK) {
        return -1.0;
    }
    const cl_int error = clWaitForEvents(1, &done);
    const double ms = input_now_ms() - start_ms;
    clReleaseEvent(done);
    return error == CL_SUCCESS ? ms : -1.0;
}

static double *times_of(const compact_bench *bench, size_t set, size_t form)
{
    return bench->times + (set * FORM_COUNT + form) * bench->all->repeats;
}

/* Interleaves the forms; the first round warms up and does not count. */
static bool measure_set(compact_bench *bench, size_t set)
{
    make_rays(bench, set);
    bool worked = clEnqueueWriteBuffer(bench->all->opened.queue, bench->device_rays, CL_TRUE, 0,
                                       bench->ray_count * sizeof(svo_ray), bench->rays, 0, NULL, NULL) == CL_SUCCESS;
    for (size_t round = 0; round <= bench->all->repeats && worked; ++round) {
        for (size_t form = 0; form < FORM_COUNT && worked; ++form) {
            const double ms = trace(bench, form);
            worked = ms >= 0;
            if (round > 0) {
                times_of(bench, set, form)[round - 1] = ms;
            }
        }
    }
    return worked;
}

/* ---- rows ---- */

static double median(const compact_bench *bench, const double *times)
{
    return spread_median(times, bench->all->repeats, bench->scratch);
}

static void add_ratio(result_table *table, const compact_bench *bench, const double *other, const double *times)
{
    spread_add_ratio(table, other, times, bench->all->repeats, bench->scratch);
}

static void add_row(result_table *table, const compact_bench *bench, size_t form)
{
    const double leaves = (double)bench->info.leaf_count;
    double bytes = (double)bench->info.inner_count * 5;
    result_add_text(table, "%s", suite_scene_name(bench->source));
    result_add_number(table, bench->depth);
    result_add_number(table, leaves);
    result_add_text(table, "%s", forms[form].name);
    if (bench->made[form] == NULL) {
        result_add_absent(table);
        result_add_absent(table);
    } else {
        svo_compact_info info = SVO_COMPACT_INFO_INIT;
        svo_compact_get_info(bench->made[form], &info);
        bytes = (double)info.total_bytes;
        result_add_number(table, bench->made_ms[form]);
        if (info.form == SVO_FORM_DESCRIPTOR) {
            result_add_number(table, 100.0 * (double)info.far_count / (double)info.stored_count);
        } else {
            result_add_absent(table);
        }
    }
    result_add_number(table, bytes);
    result_add_number(table, bytes / leaves);
    for (size_t set = 0; set < SET_COUNT; ++set) {
        const double *times = times_of(bench, set, form);
        result_add_number(table, (double)bench->ray_count / median(bench, times) * 1e-3);
        add_ratio(table, bench, times_of(bench, set, 0), times);
    }
}

static void add_rows(const compact_bench *bench)
{
    for (size_t form = 0; form < FORM_COUNT; ++form) {
        add_row(result_find(bench->all->results, table_id), bench, form);
    }
}

/* ---- what is stored once ---- */

static const char shared_id[] = "compact-shared";

static const char shared_note[] =
    "Without payload. Records: nodes that are stored, out of the inner nodes; the deepest of these have no record. "
    "Merged: full leaves first. Mirrored: subtrees that are equal up to reflections, without merged leaves; their "
    "share of the bytes that shared ones take, and their rays per second relative to those of shared ones within "
    "each round. Made: from the built tree, time of all processors together. Published for other scenes: 0.40 bit "
    "per voxel at 128K^3 (Kampe, Sintorn and Assarsson, High Resolution Sparse Voxel DAGs, 2013), 0.123 at 64K^3 "
    "with mirrored subtrees shared too (Villanueva, Marton and Gobbetti, SSVDAGs, 2016). Bits per voxel fall with "
    "depth.";

/* Adds the table without rows. */
static void compact_shared_begin(suite *all)
{
    result_table *table = suite_add_table(all, shared_id, "Shared subtrees: bits per voxel", shared_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "voxels", "");
    result_add_column(table, "inner nodes", "");
    result_add_column(table, "records", "");
    result_add_column(table, "nodes", "B");
    result_add_column(table, "per voxel", "bit");
    result_add_column(table, "made", "ms");
    result_add_column(table, "merged nodes", "");
    result_add_column(table, "merged leaves", "");
    result_add_column(table, "merged per voxel", "bit");
    result_add_column(table, "merged made", "ms");
    result_add_column(table, "mirrored records", "");
    result_add_column(table, "mirrored nodes", "B");
    result_add_column(table, "mirrored per voxel", "bit");
    result_add_column(table, "mirrored made", "ms");
    result_add_column(table, "mirrored share", "");
    spread_add_columns(table, "mirrored primary ratio", "");
    spread_add_columns(table, "mirrored incoherent ratio", "");
}

static svo_status make(const session *opened, const svo_tree *tree, const svo_compact_options *asked,
                       svo_compact_info *info, double *ms)
{
    svo_compact *made = NULL;
    const double start_ms = input_cpu_ms();
    svo_status status = svo_compact_create(opened->device, tree, asked, opened->queue, &made);
    *ms = input_cpu_ms() - start_ms;
    if (status == SVO_OK) {
        status = svo_compact_get_info(made, info);
    }
    svo_compact_destroy(&made);
    return status;
}

static double bits_per_voxel(const svo_compact_info *info)
{
    return 8.0 * (double)info->total_bytes / (double)info->voxel_count;
}

/* Adds a row, after the rays. Returns what a call of the library returned. */
static svo_status compact_shared_run(const compact_bench *bench)
{
    static const struct {
        svo_form form;
        bool merged;
    } ways[3] = {{SVO_FORM_SHARED, false}, {SVO_FORM_SHARED, true}, {SVO_FORM_MIRRORED, false}};
    svo_compact_info infos[3] = {SVO_COMPACT_INFO_INIT, SVO_COMPACT_INFO_INIT, SVO_COMPACT_INFO_INIT};
    double ms[3] = {0, 0, 0};
    /* Twice: the first turn compiles. */
    for (size_t turn = 0; turn < 6; ++turn) {
        const size_t i = turn % 3;
        svo_compact_options asked = SVO_COMPACT_OPTIONS_INIT;
        asked.form = ways[i].form;
        asked.minimize = ways[i].merged;
        asked.leave_out = SVO_NEED_ALL;
        const svo_status status = make(&bench->all->opened, bench->tree, &asked, &infos[i], &ms[i]);
        if (status != SVO_OK) {
            return status;
        }
    }
    result_table *table = result_find(bench->all->results, shared_id);
    result_add_text(table, "%s", suite_scene_name(bench->source));
    result_add_number(table, infos[0].depth);
    result_add_number(table, (double)infos[0].voxel_count);
    result_add_number(table, (double)infos[0].inner_count);
    result_add_number(table, (double)infos[0].shared_count);
    result_add_number(table, (double)infos[0].total_bytes);
    result_add_number(table, bits_per_voxel(&infos[0]));
    result_add_number(table, ms[0]);
    result_add_number(table, (double)infos[1].inner_count);
    result_add_number(table, (double)infos[1].leaf_count);
    result_add_number(table, bits_per_voxel(&infos[1]));
    result_add_number(table, ms[1]);
    result_add_number(table, (double)infos[2].shared_count);
    result_add_number(table, (double)infos[2].total_bytes);
    result_add_number(table, bits_per_voxel(&infos[2]));
    result_add_number(table, ms[2]);
    result_add_number(table, (double)infos[2].total_bytes / (double)infos[0].total_bytes);
    for (size_t set = 0; set < SET_COUNT; ++set) {
        add_ratio(table, bench, times_of(bench, set, SHARED), times_of(bench, set, MIRRORED));
    }
    return SVO_OK;
}

/* ---- the subject ---- */

static void release_trees(compact_bench *bench)
{
    for (size_t i = 0; i < FORM_COUNT; ++i) {
        svo_compact_destroy(&bench->made[i]);
    }
    svo_tree_destroy(&bench->tree);
}

static void release(compact_bench *bench)
{
    release_trees(bench);
    if (bench->device_rays != NULL) {
        clReleaseMemObject(bench->device_rays);
    }
    if (bench->device_hits != NULL) {
        clReleaseMemObject(bench->device_hits);
    }
    free(bench->rays);
    free(bench->times);
    free(bench->scratch);
}

static int fail_library(const compact_bench *bench)
{
    return program_fail_library(bench->all->state, svo_device_message(bench->all->opened.device));
}

/* Of a tree with payload, in place of the other. */
static int run_packed(compact_bench *bench)
{
    const bool of_mesh = bench->source->mesh != NULL;
    const uint32_t need = (uint32_t)SVO_NEED_COLOR | (of_mesh ? (uint32_t)SVO_NEED_NORMAL : 0);
    release_trees(bench);
    return build(bench, need) == SVO_OK ? compact_packed_run(bench->all, bench->source, bench->tree)
                                        : fail_library(bench);
}

static int run_forms(compact_bench *bench)
{
    if (build(bench, SVO_NEED_NONE) != SVO_OK || make_forms(bench) != SVO_OK) {
        return fail_library(bench);
    }
    if (!make_room(bench)) {
        return program_fail(bench->all->state, PROGRAM_FAILED, "out of memory for %zu rays", bench->ray_count);
    }
    if (!measure_set(bench, 0) || !measure_set(bench, 1) || compact_shared_run(bench) != SVO_OK) {
        return fail_library(bench);
    }
    add_rows(bench);
    return PROGRAM_DONE;
}

static int run(suite *all, const input *source, unsigned depth)
{
    const size_t asked = (size_t)all->state->options.ray_count;
    compact_bench bench = {
        .all = all, .source = source, .depth = depth, .ray_count = all->quick ? (asked + 7) / 8 : asked};
    int exit_code = run_forms(&bench);
    if (exit_code == PROGRAM_DONE && depth <= COMPACT_PACKED_DEPTH_MAX) {
        exit_code = run_packed(&bench);
    }
    release(&bench);
    return exit_code;
}

static int begin(suite *all)
{
    compact_begin(all);
    compact_shared_begin(all);
    compact_packed_begin(all);
    return PROGRAM_DONE;
}

const suite_subject bench_compact = {
    .words = &subject_table[SUBJECT_COMPACT],
    .full = {.scenes = {"atrium", "statue"}, .depths = {8, 9, 10}},
    .quick = {.scenes = {"atrium:17000"}, .depths = {7}},
    .takes_voxels = true,
    .begin = begin,
    .run = run,
};
