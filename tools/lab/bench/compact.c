/* SPDX-License-Identifier: MIT */
/*
 * svocl bench compact: the built tree and its compact forms, bytes of their nodes and rays through their voxels; and
 * how much of a tree SVO_FORM_SHARED stores once, with and without merged leaves, and SVO_FORM_MIRRORED; and packed
 * payload.
 */
#include <stdlib.h>
#include <string.h>

#include <zstd.h>

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
    memcpy(bench->scratch, times, bench->all->repeats * sizeof *times);
    return spread_of(bench->scratch, bench->all->repeats).median;
}

/* Rates relative to the other's, round by round. */
static void add_ratio(result_table *table, const compact_bench *bench, const double *other, const double *times)
{
    for (size_t round = 0; round < bench->all->repeats; ++round) {
        bench->scratch[round] = other[round] / times[round];
    }
    spread_add(table, spread_of(bench->scratch, bench->all->repeats));
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

/* ---- packed payload ---- */

static const char packed_id[] = "compact-packed";

#define PACKED_DEPTH_MAX 9u /* zstd -19 takes minutes beyond */
#define ZSTD_LEVEL       19
#define READS            (1u << 20)
#define PICTURE_WIDTH    640u
#define PICTURE_HEIGHT   400u

/* The first of each array is exact. */
static const struct packing {
    svo_compact_buffer buffer;
    svo_need need;
    const char *change;
    uint32_t color_error, normal_bits;
} packings[] = {
    {SVO_COMPACT_COLORS, SVO_NEED_COLOR, "none", 0, 0},     {SVO_COMPACT_COLORS, SVO_NEED_COLOR, "within 4", 4, 0},
    {SVO_COMPACT_COLORS, SVO_NEED_COLOR, "within 8", 8, 0}, {SVO_COMPACT_NORMALS, SVO_NEED_NORMAL, "none", 0, 0},
    {SVO_COMPACT_NORMALS, SVO_NEED_NORMAL, "7 bits", 0, 7},
};
#define PACKING_COUNT (sizeof packings / sizeof packings[0])

static const char packed_note[] =
    "Form shared, to depth 9. Bits are per leaf, those of inner nodes included. Change: most that colors may change, "
    "or the bits of each of two numbers of a normal. zstd: of the plain array, which gives no element before all of "
    "them. Errors: of 255 for colors, of 32767 for normals. Read: elements at random places, one call of "
    "svo_compact_read_payload each. Picture: 640 x 400 pixels with this array alone packed. Times are of all "
    "processors together; ratios are rates relative to the plain array's within each round.";

enum { PLAIN, PACKED, KIND_COUNT };

/* An array, plain and packed. */
typedef struct packed_bench {
    const compact_bench *of;
    svo_compact *made[KIND_COUNT];
    svo_compact_info info[KIND_COUNT];
    double packing_ms;
    size_t zstd_bytes; /* of the plain array */
    uint8_t *pixels;
    double *read_ms[KIND_COUNT], *picture_ms[KIND_COUNT]; /* by round */
} packed_bench;

static void packed_begin(suite *all)
{
    result_table *table = suite_add_table(all, packed_id, "Packed payload: bits per leaf", packed_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "leaves", "");
    result_add_column(table, "array", "");
    result_add_column(table, "change", "");
    result_add_column(table, "plain", "bit");
    result_add_column(table, "zstd -19", "bit");
    result_add_column(table, "packed", "bit");
    result_add_column(table, "largest error", "");
    result_add_column(table, "mean error", "");
    result_add_column(table, "packing", "ms");
    result_add_column(table, "read", "M/s");
    spread_add_columns(table, "read ratio", "");
    result_add_column(table, "picture", "ms");
    spread_add_columns(table, "picture ratio", "");
}

/* To the host, with what describes it. */
static svo_status fetch(packed_bench *b, int kind)
{
    b->info[kind] = (svo_compact_info)SVO_COMPACT_INFO_INIT;
    svo_status status = svo_compact_download(b->made[kind], b->of->all->opened.queue);
    if (status == SVO_OK) {
        status = svo_compact_get_info(b->made[kind], &b->info[kind]);
    }
    return status;
}

static svo_status make_plain(packed_bench *b)
{
    const session *opened = &b->of->all->opened;
    svo_compact_options asked = SVO_COMPACT_OPTIONS_INIT;
    asked.form = SVO_FORM_SHARED;
    svo_status status = svo_compact_create(opened->device, b->of->tree, &asked, opened->queue, &b->made[PLAIN]);
    if (status == SVO_OK) {
        status = fetch(b, PLAIN);
    }
    return status;
}

static svo_status pack(packed_bench *b, const struct packing *how)
{
    const svo_pack_options asked = {.struct_size = sizeof asked,
                                    .leave_out = (uint32_t)SVO_NEED_ALL & ~(uint32_t)how->need,
                                    .color_error = how->color_error,
                                    .normal_bits = how->normal_bits};
    svo_compact_destroy(&b->made[PACKED]);
    const double start_ms = input_cpu_ms();
    svo_status status = svo_compact_pack(b->made[PLAIN], &asked, b->of->all->opened.queue, &b->made[PACKED]);
    b->packing_ms = input_cpu_ms() - start_ms;
    if (status == SVO_OK) {
        status = fetch(b, PACKED);
    }
    return status;
}

/* False: memory runs out. */
static bool press(packed_bench *b, svo_compact_buffer buffer)
{
    svo_compact_arrays arrays = SVO_COMPACT_ARRAYS_INIT;
    (void)svo_compact_get_arrays(b->made[PLAIN], &arrays);
    const void *array = buffer == SVO_COMPACT_COLORS ? (const void *)arrays.colors : (const void *)arrays.normals;
    const size_t bytes = (size_t)b->info[PLAIN].bytes[buffer];
    const size_t room = ZSTD_compressBound(bytes);
    void *pressed = malloc(room);
    b->zstd_bytes = pressed != NULL ? ZSTD_compress(pressed, room, array, bytes, ZSTD_LEVEL) : 0;
    free(pressed);
    return pressed != NULL && ZSTD_isError(b->zstd_bytes) == 0;
}

/* Below 0 on failure. */
static double read_elements(const packed_bench *b, int kind, svo_compact_buffer buffer)
{
    const uint64_t count = b->info[kind].payload_count;
    uint64_t random = 1;
    int16_t element[4];
    bool worked = true;
    const double start_ms = input_cpu_ms();
    for (uint32_t i = 0; i < READS; ++i) {
        random = random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407); /* Knuth's MMIX */
        const uint64_t place = (random >> 32) * count >> 32;
        worked = svo_compact_read_payload(b->made[kind], buffer, place, 1, element) == SVO_OK && worked;
    }
    return worked ? input_cpu_ms() - start_ms : -1.0;
}

static double draw(const packed_bench *b, int kind, const svo_camera *camera)
{
    svo_render_options asked = SVO_RENDER_OPTIONS_INIT;
    asked.width = PICTURE_WIDTH;
    asked.height = PICTURE_HEIGHT;
    asked.camera = *camera;
    const double start_ms = input_cpu_ms();
    const svo_status status = svo_render(svo_compact_target(b->made[kind]), &asked, svo_in_host(b->pixels), NULL);
    return status == SVO_OK ? input_cpu_ms() - start_ms : -1.0;
}

/* The first round warms up and does not count. */
static bool compare(const packed_bench *b, svo_compact_buffer buffer)
{
    svo_camera camera = {.vertical_fov = 0};
    bool worked =
        svo_camera_fit(svo_compact_target(b->made[PLAIN]), (float)PICTURE_WIDTH / PICTURE_HEIGHT, &camera) == SVO_OK;
    for (size_t round = 0; round <= b->of->all->repeats && worked; ++round) {
        for (int kind = PLAIN; kind < KIND_COUNT && worked; ++kind) {
            const size_t at = round > 0 ? round - 1 : 0;
            b->read_ms[kind][at] = read_elements(b, kind, buffer);
            b->picture_ms[kind][at] = draw(b, kind, &camera);
            worked = b->read_ms[kind][at] >= 0 && b->picture_ms[kind][at] >= 0;
        }
    }
    return worked;
}

static void add_packed_row(const packed_bench *b, const struct packing *how)
{
    result_table *table = result_find(b->of->all->results, packed_id);
    const size_t k = (size_t)how->buffer - SVO_COMPACT_COLORS;
    const double leaves = (double)b->info[PLAIN].leaf_count;
    result_add_text(table, "%s", suite_scene_name(b->of->source));
    result_add_number(table, b->info[PLAIN].depth);
    result_add_number(table, leaves);
    result_add_text(table, "%s", svo_name(SVO_NAME_COMPACT_BUFFER, how->buffer));
    result_add_text(table, "%s", how->change);
    result_add_number(table, 8.0 * (double)b->info[PLAIN].bytes[how->buffer] / leaves);
    result_add_number(table, 8.0 * (double)b->zstd_bytes / leaves);
    result_add_number(table, 8.0 * (double)b->info[PACKED].bytes[how->buffer] / leaves);
    result_add_number(table, b->info[PACKED].largest_error[k]);
    result_add_number(table, b->info[PACKED].mean_error[k]);
    result_add_number(table, b->packing_ms);
    result_add_number(table, READS / median(b->of, b->read_ms[PACKED]) * 1e-3);
    add_ratio(table, b->of, b->read_ms[PLAIN], b->read_ms[PACKED]);
    result_add_number(table, median(b->of, b->picture_ms[PACKED]));
    add_ratio(table, b->of, b->picture_ms[PLAIN], b->picture_ms[PACKED]);
}

static bool packed_allocate(packed_bench *b)
{
    bool worked = true;
    b->pixels = malloc((size_t)4 * PICTURE_WIDTH * PICTURE_HEIGHT);
    for (int kind = PLAIN; kind < KIND_COUNT; ++kind) {
        b->read_ms[kind] = calloc(b->of->all->repeats + 1, sizeof(double));
        b->picture_ms[kind] = calloc(b->of->all->repeats + 1, sizeof(double));
        worked = worked && b->read_ms[kind] != NULL && b->picture_ms[kind] != NULL;
    }
    return worked && b->pixels != NULL;
}

static void packed_release(packed_bench *b)
{
    for (int kind = PLAIN; kind < KIND_COUNT; ++kind) {
        svo_compact_destroy(&b->made[kind]);
        free(b->read_ms[kind]);
        free(b->picture_ms[kind]);
    }
    free(b->pixels);
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

/* Whether the tree has the array, not the same in all nodes. */
static bool is_packable(const packed_bench *b, const struct packing *how)
{
    return (b->info[PLAIN].need & (uint32_t)how->need) != 0 && (b->info[PLAIN].constant & (uint32_t)how->need) == 0;
}

static int run_packings(packed_bench *b)
{
    program *state = b->of->all->state;
    if (!packed_allocate(b)) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    if (make_plain(b) != SVO_OK) {
        return fail_library(b->of);
    }
    for (size_t i = 0; i < PACKING_COUNT; ++i) {
        const struct packing *how = &packings[i];
        if (!is_packable(b, how)) {
            continue;
        }
        if (how->color_error == 0 && how->normal_bits == 0 && !press(b, how->buffer)) {
            return program_fail(state, PROGRAM_FAILED, "zstd failed, out of memory");
        }
        if (pack(b, how) != SVO_OK || !compare(b, how->buffer)) {
            return fail_library(b->of);
        }
        add_packed_row(b, how);
    }
    return PROGRAM_DONE;
}

/* Of a tree with payload, in place of the other. */
static int run_packed(compact_bench *bench)
{
    packed_bench packed = {.of = bench};
    const bool of_mesh = bench->source->mesh != NULL;
    const uint32_t need = (uint32_t)SVO_NEED_COLOR | (of_mesh ? (uint32_t)SVO_NEED_NORMAL : 0);
    release_trees(bench);
    const int exit_code = build(bench, need) == SVO_OK ? run_packings(&packed) : fail_library(bench);
    packed_release(&packed);
    return exit_code;
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
    if (exit_code == PROGRAM_DONE && depth <= PACKED_DEPTH_MAX) {
        exit_code = run_packed(&bench);
    }
    release(&bench);
    return exit_code;
}

static int begin(suite *all)
{
    compact_begin(all);
    compact_shared_begin(all);
    packed_begin(all);
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
