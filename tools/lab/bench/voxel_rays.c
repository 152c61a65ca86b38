/* SPDX-License-Identifier: MIT */
/*
 * svocl bench voxel-rays: rays through the voxels of a tree, beside NanoVDB's hierarchical walk and beside a brickmap
 * of the same voxels. Rays of which two tracers differ are judged by the voxels themselves, in doubles.
 */
#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "bench/nanovdb.h"
#include "bench/subjects.h"
#include "measure/brickmap.h"
#include "measure/ray_sets.h"
#include "measure/spread.h"
#include "reference/oracle.h"
#include "support/info_of.h"

static const char table_id[] = "voxel-rays";

static const char note[] =
    "The first voxel along each ray, from the same single-precision numbers; CPU time of the process, methods "
    "interleaved, each with rays in its own layout. Primary: a camera's, in tiles of 4 x 4. Ratio: svocl's rays per "
    "second to the other's. Wrong: rays that end more than a hundredth of a voxel beside the first voxel, of those of "
    "which two methods differ by that, at most 100.";

typedef enum tracer { TRACER_SVOCL = 0, TRACER_NANOVDB, TRACER_BRICKMAP, TRACER_COUNT } tracer;

static const char *const tracer_names[TRACER_COUNT] = {"svocl", "NanoVDB", "brickmap"};

/* In voxels: how much two methods may differ, and the most rays that are judged. */
#define TOLERANCE  0.01
#define JUDGED_MAX 100u

#define SET_COUNT 2
static const char *const set_names[SET_COUNT] = {"primary", "incoherent"};

typedef struct voxel_bench {
    suite *all;
    const input *source;
    unsigned depth;
    size_t ray_count;
    svo_tree *tree;
    svo_tree_info info;
    uint64_t *codes; /* of the leaves */
    uint32_t (*cells)[3]; /* the same */
    brickmap *bricks;
    nanovdb_voxels *peer; /* NULL: this program has none */
    svo_ray *rays;
    voxel_ray *voxel_rays; /* the same, in voxels */
    svo_voxel_hit *hits;
    float *distances[TRACER_COUNT]; /* in voxels */
    cl_mem device_rays, device_hits;
    double *times[TRACER_COUNT]; /* by round */
    uint64_t wrong[TRACER_COUNT];
} voxel_bench;

/* ---- what is traced ---- */

static svo_status build(voxel_bench *b)
{
    const session *opened = &b->all->opened;
    svo_plan_options asked = SVO_PLAN_OPTIONS_INIT;
    svo_plan *plan = NULL;
    asked.need = SVO_NEED_NONE;
    svo_status status = svo_plan_create(opened->device, b->source->mesh, b->depth, &asked, &plan);
    if (status == SVO_OK) {
        status = svo_build(plan, opened->cl, opened->queue, &b->tree, NULL);
    }
    svo_plan_destroy(&plan);
    if (status == SVO_OK) {
        status = svo_tree_download(b->tree, NULL);
    }
    b->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(b->tree, &b->info);
    return status;
}

static bool make_peers(voxel_bench *b)
{
    const size_t leaves = (size_t)b->info.leaf_count;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    (void)svo_tree_get_arrays(b->tree, &arrays);
    b->codes = malloc(leaves * sizeof *b->codes + 1);
    b->cells = malloc(leaves * sizeof *b->cells + 1);
    if (b->codes == NULL || b->cells == NULL ||
        !oracle_leaf_codes(arrays.child_mask, b->info.inner_count, b->depth, b->info.leaf_count, b->codes)) {
        return false;
    }
    for (size_t i = 0; i < leaves; ++i) {
        svo_code_to_cell(b->codes[i], b->cells[i]);
    }
    b->bricks = brickmap_create(b->codes, leaves, b->depth);
    b->peer = nanovdb_is_there() ? nanovdb_create((const uint32_t(*)[3])b->cells, leaves) : NULL;
    return b->bricks != NULL && (b->peer != NULL || !nanovdb_is_there());
}

static bool make_room(voxel_bench *b)
{
    const cl_context context = info_of_device(b->all->opened.device).context;
    cl_int errors[2] = {CL_SUCCESS, CL_SUCCESS};
    bool worked = true;
    b->rays = calloc(b->ray_count, sizeof *b->rays);
    b->voxel_rays = calloc(b->ray_count, sizeof *b->voxel_rays);
    b->hits = calloc(b->ray_count, sizeof *b->hits);
    for (tracer i = 0; i < TRACER_COUNT; ++i) {
        b->distances[i] = calloc(b->ray_count, sizeof *b->distances[i]);
        b->times[i] = calloc(b->all->repeats, sizeof *b->times[i]);
        worked = worked && b->distances[i] != NULL && b->times[i] != NULL;
    }
    b->device_rays = clCreateBuffer(context, CL_MEM_READ_ONLY, b->ray_count * sizeof(svo_ray), NULL, &errors[0]);
    b->device_hits = clCreateBuffer(context, CL_MEM_WRITE_ONLY, b->ray_count * sizeof(svo_voxel_hit), NULL, &errors[1]);
    return worked && b->rays != NULL && b->voxel_rays != NULL && b->hits != NULL && errors[0] == CL_SUCCESS &&
           errors[1] == CL_SUCCESS;
}

/* The rays of a set, and the same in voxels. */
static void make_rays(voxel_bench *b, size_t set)
{
    const double scale = (double)(1u << b->depth) / b->info.edge;
    double high[3];
    for (int axis = 0; axis < 3; ++axis) {
        high[axis] = b->info.origin[axis] + b->info.edge;
    }
    if (set == 0) {
        svo_camera camera = {.vertical_fov = 0};
        (void)svo_camera_fit(svo_tree_target(b->tree), 1.0f, &camera);
        ray_set_primary(&camera, 4, b->ray_count, b->rays);
    } else {
        ray_set_incoherent(b->info.origin, high, b->ray_count, b->rays);
    }
    for (size_t i = 0; i < b->ray_count; ++i) {
        voxel_ray *to = &b->voxel_rays[i];
        const float *d = b->rays[i].direction;
        const double length = sqrt((double)d[0] * d[0] + (double)d[1] * d[1] + (double)d[2] * d[2]);
        b->rays[i].t_max = INFINITY;
        to->range = 1e6F;
        for (int axis = 0; axis < 3; ++axis) {
            to->origin[axis] = (float)(((double)b->rays[i].origin[axis] - b->info.origin[axis]) * scale);
            to->direction[axis] = (float)(d[axis] / length);
        }
    }
}

/* ---- the measurement ---- */

static bool trace_svocl(voxel_bench *b)
{
    return svo_trace_voxels(svo_tree_target(b->tree), svo_in_buffer(b->device_rays), svo_in_buffer(b->device_hits),
                            b->ray_count, 0.0f, 0, NULL) == SVO_OK;
}

/* Traces once; CPU milliseconds, below 0 on failure. */
static double trace(voxel_bench *b, tracer by)
{
    const double start_ms = input_cpu_ms();
    bool worked = true;
    if (by == TRACER_SVOCL) {
        worked = trace_svocl(b);
    } else if (by == TRACER_BRICKMAP) {
        brickmap_trace(b->bricks, b->voxel_rays, b->distances[by], b->ray_count);
    } else if (b->peer != NULL) {
        nanovdb_trace(b->peer, b->voxel_rays, b->distances[by], b->ray_count);
    }
    return worked ? input_cpu_ms() - start_ms : -1.0;
}

/* Svocl's hits as distances in voxels. */
static bool read_hits(voxel_bench *b)
{
    const double scale = (double)(1u << b->depth) / b->info.edge;
    const bool worked = clEnqueueReadBuffer(b->all->opened.queue, b->device_hits, CL_TRUE, 0,
                                            b->ray_count * sizeof *b->hits, b->hits, 0, NULL, NULL) == CL_SUCCESS;
    for (size_t i = 0; i < b->ray_count && worked; ++i) {
        const float *d = b->rays[i].direction;
        const double length = sqrt((double)d[0] * d[0] + (double)d[1] * d[1] + (double)d[2] * d[2]);
        b->distances[TRACER_SVOCL][i] = (float)(b->hits[i].t * length * scale);
    }
    return worked;
}

/* Interleaves the methods; the first round warms up and does not count. */
static bool measure(voxel_bench *b)
{
    bool worked = clEnqueueWriteBuffer(b->all->opened.queue, b->device_rays, CL_TRUE, 0, b->ray_count * sizeof *b->rays,
                                       b->rays, 0, NULL, NULL) == CL_SUCCESS;
    for (size_t round = 0; round <= b->all->repeats && worked; ++round) {
        for (tracer i = 0; i < TRACER_COUNT && worked; ++i) {
            const double ms = trace(b, i);
            worked = ms >= 0;
            if (round > 0) {
                b->times[i][round - 1] = ms;
            }
        }
    }
    return worked && read_hits(b);
}

/* ---- wrong rays ---- */

static bool differ(double a, double b)
{
    return isinf(a) || isinf(b) ? isinf(a) != isinf(b) : fabs(a - b) > TOLERANCE;
}

/* Where the ray is inside a voxel that grows by so much on all sides: entry and exit. */
static void cross_voxel(const voxel_ray *ray, const uint32_t *cell, double grown, double *entry, double *exit)
{
    *entry = 0.0;
    *exit = (double)ray->range;
    for (int k = 0; k < 3; ++k) {
        const double low = (cell[k] - grown - ray->origin[k]) / ray->direction[k];
        const double high = (cell[k] + 1.0 + grown - ray->origin[k]) / ray->direction[k];
        *entry = fmax(*entry, fmin(low, high));
        *exit = fmin(*exit, fmax(low, high));
    }
}

/* Counts the methods that are wrong of a ray: behind the first voxel that it crosses for more than the tolerance, or at
   no voxel, not even one that is larger by it. */
static void judge(voxel_bench *b, size_t index)
{
    const voxel_ray *ray = &b->voxel_rays[index];
    double first = INFINITY;
    bool at_voxel[TRACER_COUNT] = {false, false, false};
    for (size_t i = 0; i < (size_t)b->info.leaf_count; ++i) {
        double entry = 0.0;
        double exit = 0.0;
        cross_voxel(ray, b->cells[i], TOLERANCE, &entry, &exit);
        if (entry > exit) {
            continue;
        }
        for (tracer by = 0; by < TRACER_COUNT; ++by) {
            const double t = b->distances[by][index];
            at_voxel[by] = at_voxel[by] || (t >= entry - TOLERANCE && t <= exit);
        }
        cross_voxel(ray, b->cells[i], 0.0, &entry, &exit);
        first = exit - entry > TOLERANCE ? fmin(first, entry) : first;
    }
    for (tracer by = 0; by < TRACER_COUNT; ++by) {
        const double t = b->distances[by][index];
        const bool right = isinf(t) ? isinf(first) : at_voxel[by] && t <= first + TOLERANCE;
        b->wrong[by] += right ? 0 : 1;
    }
}

static void judge_all(voxel_bench *b)
{
    size_t judged = 0;
    for (tracer by = 0; by < TRACER_COUNT; ++by) {
        b->wrong[by] = 0;
    }
    for (size_t i = 0; i < b->ray_count && judged < JUDGED_MAX; ++i) {
        const double own = b->distances[TRACER_SVOCL][i];
        if (differ(own, b->distances[TRACER_BRICKMAP][i]) ||
            (b->peer != NULL && differ(own, b->distances[TRACER_NANOVDB][i]))) {
            judge(b, i);
            ++judged;
        }
    }
}

/* ---- the table ---- */

static int begin(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Rays through voxels, beside NanoVDB and a brickmap", note);
    if (nanovdb_is_there()) {
        result_extend_note(
            table,
            "NanoVDB %s: firstActive on a grid of Fp4, which goes on by a whole voxel after each step, so "
            "that its rays may end a voxel too late.",
            nanovdb_version());
    } else {
        result_extend_note(table, "Without NanoVDB: this program was built without libnanovdb-dev.");
    }
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "voxels", "");
    result_add_column(table, "rays", "");
    for (tracer i = 0; i < TRACER_COUNT; ++i) {
        char wrong[32];
        (void)snprintf(wrong, sizeof wrong, "%s wrong", tracer_names[i]);
        result_add_column(table, tracer_names[i], "M/s");
        result_add_column(table, wrong, "");
        if (i != TRACER_SVOCL) {
            char ratio[32];
            (void)snprintf(ratio, sizeof ratio, "ratio to %s", tracer_names[i]);
            spread_add_columns(table, ratio, "");
        }
    }
    return PROGRAM_DONE;
}

static void add_tracer(result_table *table, voxel_bench *b, tracer by, double *scratch)
{
    const size_t rounds = b->all->repeats;
    const bool present = by != TRACER_NANOVDB || b->peer != NULL;
    for (size_t i = 0; i < rounds; ++i) {
        scratch[i] = b->times[by][i];
    }
    if (present) {
        result_add_number(table, (double)b->ray_count / spread_of(scratch, rounds).median * 1e-3);
        result_add_number(table, (double)b->wrong[by]);
    } else {
        result_add_absent(table);
        result_add_absent(table);
    }
    for (size_t i = 0; i < rounds; ++i) {
        scratch[i] = b->times[by][i] / b->times[TRACER_SVOCL][i];
    }
    if (by != TRACER_SVOCL) {
        spread_add(table, present ? spread_of(scratch, rounds) : spread_none());
    }
}

static bool add_row(voxel_bench *b, size_t set)
{
    result_table *table = result_find(b->all->results, table_id);
    double *scratch = calloc(b->all->repeats, sizeof *scratch);
    if (scratch == NULL) {
        return false;
    }
    result_add_text(table, "%s", suite_scene_name(b->source));
    result_add_number(table, b->depth);
    result_add_number(table, (double)b->info.leaf_count);
    result_add_text(table, "%s", set_names[set]);
    for (tracer i = 0; i < TRACER_COUNT; ++i) {
        add_tracer(table, b, i, scratch);
    }
    free(scratch);
    return true;
}

/* ---- the subject ---- */

static void release(voxel_bench *b)
{
    for (tracer i = 0; i < TRACER_COUNT; ++i) {
        free(b->distances[i]);
        free(b->times[i]);
    }
    if (b->device_rays != NULL) {
        clReleaseMemObject(b->device_rays);
    }
    if (b->device_hits != NULL) {
        clReleaseMemObject(b->device_hits);
    }
    nanovdb_destroy(&b->peer);
    brickmap_destroy(&b->bricks);
    svo_tree_destroy(&b->tree);
    free(b->codes);
    free(b->cells);
    free(b->rays);
    free(b->voxel_rays);
    free(b->hits);
}

static int run(suite *all, const input *source, unsigned depth)
{
    const size_t asked = (size_t)all->state->options.ray_count;
    voxel_bench b = {.all = all, .source = source, .depth = depth, .ray_count = all->quick ? (asked + 7) / 8 : asked};
    int exit_code = PROGRAM_DONE;
    if (depth < BRICKMAP_DEPTH_MIN) {
        exit_code =
            program_fail(all->state, PROGRAM_WRONG_USAGE, "voxel-rays: depth %u is below %u, where a brickmap begins",
                         depth, BRICKMAP_DEPTH_MIN);
    } else if (build(&b) != SVO_OK) {
        exit_code = program_fail_library(all->state, svo_device_message(all->opened.device));
    } else if (!make_peers(&b) || !make_room(&b)) {
        exit_code = program_fail(all->state, PROGRAM_FAILED, "out of memory for the voxels of depth %u", depth);
    }
    for (size_t set = 0; set < SET_COUNT && exit_code == PROGRAM_DONE; ++set) {
        make_rays(&b, set);
        if (!measure(&b)) {
            exit_code = program_fail_library(all->state, svo_device_message(all->opened.device));
            break;
        }
        judge_all(&b);
        exit_code = add_row(&b, set) ? PROGRAM_DONE : program_fail(all->state, PROGRAM_FAILED, "out of memory");
    }
    release(&b);
    return exit_code;
}

const suite_subject bench_voxel_rays = {
    .words = &subject_table[SUBJECT_VOXEL_RAYS],
    .full = {.scenes = {"statue", "atrium"}, .depths = {9, 10}},
    .quick = {.scenes = {"atrium:17000"}, .depths = {7}},
    .begin = begin,
    .run = run,
};
