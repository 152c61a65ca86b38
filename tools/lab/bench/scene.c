/* SPDX-License-Identifier: MIT */
/*
 * Instances of one tree, a grid's width apart, from one to a hundred thousand: time of the hierarchy, rays per second.
 * Where they are few, one tree of the same voxels and Embree's instances of the voxels as boxes trace the same rays,
 * interleaved.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/subjects.h"
#include "measure/embree.h"
#include "measure/ray_sets.h"
#include "measure/spread.h"
#include "measure/suite.h"
#include "support/info_of.h"

/* ---- peers: one tree of the same voxels, and Embree's instances of the voxels as boxes ---- */

/* A tree, and where its copies are: edge of them along each axis, a grid's width apart. */
typedef struct lattice {
    const suite *all;
    const svo_mesh *mesh;
    svo_tree *tree; /* with host arrays */
    svo_tree_info info;
    double width; /* of its grid, world */
} lattice;

/* ---- one tree ---- */

/* The mesh's vertices once for each copy, moved. */
static double *copy_positions(const lattice *of, unsigned edge)
{
    const size_t vertices = of->mesh->vertex_count;
    const size_t copies = (size_t)edge * edge * edge;
    double *positions = calloc(copies * vertices * 3 + 1, sizeof *positions);
    for (size_t i = 0; positions != NULL && i < copies * vertices * 3; ++i) {
        const size_t copy = i / (vertices * 3);
        const size_t cell[3] = {copy % edge, copy / edge % edge, copy / edge / edge};
        const size_t from = i % (vertices * 3);
        const double at =
            of->mesh->positions_double != NULL ? of->mesh->positions_double[from] : (double)of->mesh->positions[from];
        positions[i] = at + of->width * (double)cell[i % 3];
    }
    return positions;
}

static uint32_t *copy_indices(const lattice *of, unsigned edge)
{
    const size_t corners = of->mesh->triangle_count * 3;
    const size_t copies = (size_t)edge * edge * edge;
    uint32_t *indices = calloc(copies * corners + 1, sizeof *indices);
    for (size_t i = 0; indices != NULL && i < copies * corners; ++i) {
        const size_t from = i % corners;
        const size_t vertex = of->mesh->indices != NULL ? of->mesh->indices[from] : from;
        indices[i] = (uint32_t)(i / corners * of->mesh->vertex_count + vertex);
    }
    return indices;
}

static svo_tree *build_merged(const lattice *of, const svo_mesh *mesh, unsigned edge_log2)
{
    const session *opened = &of->all->opened;
    svo_plan_options asked = {
        .struct_size = sizeof asked, .need = SVO_NEED_NONE, .edge = of->width * (double)(1u << edge_log2)};
    svo_plan *plan = NULL;
    svo_tree *merged = NULL;
    memcpy(asked.origin, of->info.origin, sizeof asked.origin);
    if (svo_plan_create(opened->device, mesh, of->info.depth + edge_log2, &asked, &plan) == SVO_OK) {
        (void)svo_build(plan, opened->cl, opened->queue, &merged, NULL);
    }
    svo_plan_destroy(&plan);
    return merged;
}

/* One tree of edge^3 copies; edge is 2^edge_log2. NULL on failure, which the device's message explains. */
static svo_tree *lattice_merge(const lattice *of, unsigned edge_log2)
{
    const unsigned edge = 1u << edge_log2;
    const size_t copies = (size_t)edge * edge * edge;
    double *positions = copy_positions(of, edge);
    uint32_t *indices = copy_indices(of, edge);
    svo_tree *merged = NULL;
    if (positions != NULL && indices != NULL) {
        const svo_mesh mesh = {.struct_size = sizeof mesh,
                               .positions_double = positions,
                               .vertex_count = copies * of->mesh->vertex_count,
                               .indices = indices,
                               .triangle_count = copies * of->mesh->triangle_count};
        merged = build_merged(of, &mesh, edge_log2);
    }
    free(positions);
    free(indices);
    return merged;
}

/* ---- boxes ---- */

#define BOX_CORNERS   8
#define BOX_TRIANGLES 12

typedef struct boxes {
    const svo_tree_arrays *arrays;
    const svo_tree_info *info;
    double width; /* of a voxel */
    float *vertices;
    uint32_t *indices;
    size_t count;
} boxes;

/* Corner k has x, y and z high where bits 0, 1 and 2 are set. */
static void add_box(boxes *to, const uint32_t cell[3])
{
    static const uint32_t corners[3 * BOX_TRIANGLES] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                                        2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    for (uint32_t k = 0; k < BOX_CORNERS; ++k) {
        for (uint32_t axis = 0; axis < 3; ++axis) {
            const double at = to->info->origin[axis] + to->width * (double)(cell[axis] + (k >> axis & 1));
            to->vertices[(to->count * BOX_CORNERS + k) * 3 + axis] = (float)at;
        }
    }
    for (size_t k = 0; k < sizeof corners / sizeof corners[0]; ++k) {
        to->indices[to->count * 3 * BOX_TRIANGLES + k] = (uint32_t)(to->count * BOX_CORNERS) + corners[k];
    }
    ++to->count;
}

static void add_leaves(boxes *to, uint32_t node, uint32_t level, const uint32_t cell[3])
{
    if (level == to->info->depth) {
        add_box(to, cell);
        return;
    }
    uint32_t child = to->arrays->first_child[node];
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((to->arrays->child_mask[node] >> octant & 1) != 0) {
            const uint32_t inner[3] = {2 * cell[0] + (octant & 1), 2 * cell[1] + (octant >> 1 & 1),
                                       2 * cell[2] + (octant >> 2)};
            add_leaves(to, child++, level + 1, inner);
        }
    }
}

/* The tree's leaves as boxes, placed by the matrices. NULL on failure, or without Embree. */
static embree *lattice_boxes(const lattice *of, const float (*matrices)[12], size_t matrix_count)
{
    const size_t leaves = (size_t)of->info.leaf_count;
    const uint32_t root[3] = {0, 0, 0};
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_arrays(of->tree, &arrays);
    boxes made = {.arrays = &arrays, .info = &of->info, .width = of->width / (double)(1u << of->info.depth)};
    embree *peer = NULL;
    made.vertices = calloc(leaves * BOX_CORNERS * 3 + 1, sizeof *made.vertices);
    made.indices = calloc(leaves * BOX_TRIANGLES * 3 + 1, sizeof *made.indices);
    if (made.vertices != NULL && made.indices != NULL && leaves > 0) {
        add_leaves(&made, 0, 0, root);
        peer = embree_create_placed(made.vertices, made.count * BOX_CORNERS, made.indices, made.count * BOX_TRIANGLES,
                                    matrices, matrix_count);
    }
    free(made.vertices);
    free(made.indices);
    return peer;
}

/* ---- triangles ---- */

/* The mesh's triangles, placed by the matrices. NULL on failure, or without Embree. */
static embree *lattice_triangles(const lattice *of, const float (*matrices)[12], size_t matrix_count)
{
    const svo_mesh *mesh = of->mesh;
    float *vertices = calloc(mesh->vertex_count * 3 + 1, sizeof *vertices);
    uint32_t *indices = calloc(mesh->triangle_count * 3 + 1, sizeof *indices);
    embree *peer = NULL;
    if (vertices != NULL && indices != NULL) {
        for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
            vertices[i] = mesh->positions_double != NULL ? (float)mesh->positions_double[i] : mesh->positions[i];
        }
        for (size_t i = 0; i < mesh->triangle_count * 3; ++i) {
            indices[i] = mesh->indices != NULL ? mesh->indices[i] : (uint32_t)i;
        }
        peer =
            embree_create_placed(vertices, mesh->vertex_count, indices, mesh->triangle_count, matrices, matrix_count);
    }
    free(vertices);
    free(indices);
    return peer;
}

/* ---- instances ---- */

static const char table_id[] = "scene";

static const char note[] =
    "Instances in a lattice, a grid's width apart. Build: svo_scene_rebuild; refit: svo_scene_set_transforms of all "
    "instances. Rays against voxels, as a camera's and between random points, run interleaved with one tree of all "
    "voxels (merged) and with rtcIntersect1 against Embree's instances of the voxels as boxes, on as many threads; "
    "rays "
    "against the triangles with rtcIntersect1 against Embree's instances of the same triangles. "
    "Same: the share of random rays that meet the merged tree at the same t.";

/* Lattices of these are compared with one tree, up to the edge, and with Embree, up to the count. */
#define MERGED_EDGE_LOG2_MAX 3u
#define EMBREE_COUNT_MAX     4096u
#define SET_COUNT            2
#define METHOD_COUNT         5

static const uint32_t counts[] = {1, 8, 64, 512, 4096, 32768, 100000};
#define QUICK_COUNTS 4

typedef struct scene_bench {
    suite *all;
    lattice model;
    size_t ray_count;
    unsigned threads;
    uint32_t count;
    svo_instance *instances;
    float (*matrices)[12];
    svo_scene *scene;
    svo_scene_info info;
    svo_tree *merged; /* NULL: none */
    embree *peer, *triangles_peer; /* NULL: none */
    svo_ray *rays;
    svo_hit *peer_hits;
    cl_mem device_rays, device_hits;
    spread build_ms, refit_ms;
    /* Of the scene, the merged tree, Embree, and of triangles of the scene and Embree; NAN: not measured. */
    double rates[SET_COUNT][METHOD_COUNT];
    double same;
} scene_bench;

static int begin(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Scenes: instances beside one tree and beside Embree", note);
    result_add_column(table, "model", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "instances", "");
    result_add_column(table, "per instance", "B");
    spread_add_columns(table, "build", "ms");
    spread_add_columns(table, "refit", "ms");
    result_add_column(table, "primary", "M/s");
    result_add_column(table, "merged primary", "M/s");
    result_add_column(table, "Embree primary", "M/s");
    result_add_column(table, "triangles primary", "M/s");
    result_add_column(table, "Embree triangles primary", "M/s");
    result_add_column(table, "incoherent", "M/s");
    result_add_column(table, "merged incoherent", "M/s");
    result_add_column(table, "Embree incoherent", "M/s");
    result_add_column(table, "triangles incoherent", "M/s");
    result_add_column(table, "Embree triangles incoherent", "M/s");
    result_add_column(table, "Embree build", "ms");
    result_add_column(table, "same", "%");
    return PROGRAM_DONE;
}

/* ---- the scene ---- */

static bool build_model(scene_bench *bench, const input *source, unsigned depth)
{
    const session *opened = &bench->all->opened;
    const svo_plan_options asked = {.struct_size = sizeof asked, .need = SVO_NEED_RAYS};
    svo_plan *plan = NULL;
    lattice *model = &bench->model;
    const bool built = svo_plan_create(opened->device, source->mesh, depth, &asked, &plan) == SVO_OK &&
                       svo_build(plan, opened->cl, opened->queue, &model->tree, NULL) == SVO_OK &&
                       svo_tree_download(model->tree, opened->queue) == SVO_OK;
    svo_plan_destroy(&plan);
    if (built) {
        model->info = (svo_tree_info)SVO_TREE_INFO_INIT;
        svo_tree_get_info(model->tree, &model->info);
        model->width = (double)(UINT64_C(1) << model->info.snap_bits) / model->info.scale;
    }
    return built;
}

static bool make_scene(scene_bench *bench)
{
    const session *opened = &bench->all->opened;
    const uint32_t edge = (uint32_t)ceil(cbrt(bench->count) - 1e-9);
    for (uint32_t i = 0; i < bench->count; ++i) {
        const uint32_t cell[3] = {i % edge, i / edge % edge, i / edge / edge};
        bench->instances[i] = (svo_instance){0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
        for (int axis = 0; axis < 3; ++axis) {
            bench->instances[i].transform[4 * axis + 3] = (float)(bench->model.width * cell[axis]);
        }
        memcpy(bench->matrices[i], bench->instances[i].transform, sizeof bench->matrices[i]);
    }
    const svo_scene_options asked = {.struct_size = sizeof asked,
                                     .trees = &bench->model.tree,
                                     .instances = bench->instances,
                                     .tree_count = 1,
                                     .instance_count = bench->count,
                                     .need = SVO_NEED_RAYS};
    bench->info = (svo_scene_info)SVO_SCENE_INFO_INIT;
    return svo_scene_create(opened->device, &asked, opened->queue, &bench->scene) == SVO_OK &&
           svo_scene_get_info(bench->scene, &bench->info) == SVO_OK;
}

static bool make_peers(scene_bench *bench)
{
    for (unsigned log2 = 0; log2 <= MERGED_EDGE_LOG2_MAX; ++log2) {
        if (bench->count == 1u << 3 * log2) {
            bench->merged = lattice_merge(&bench->model, log2);
            if (bench->merged == NULL) {
                return false;
            }
        }
    }
    if (bench->count <= EMBREE_COUNT_MAX && embree_is_there()) {
        bench->peer = lattice_boxes(&bench->model, (const float(*)[12])bench->matrices, bench->count);
        bench->triangles_peer = lattice_triangles(&bench->model, (const float(*)[12])bench->matrices, bench->count);
    }
    return true;
}

/* ---- times ---- */

static bool measure_hierarchy(scene_bench *bench)
{
    cl_command_queue queue = bench->all->opened.queue;
    const size_t rounds = bench->all->repeats;
    double *times = calloc(2 * rounds + 1, sizeof *times);
    bool worked = times != NULL;
    for (size_t round = 0; round <= rounds && worked; ++round) { /* the first one warms up */
        const double start_ms = input_now_ms();
        worked = svo_scene_rebuild(bench->scene, queue) == SVO_OK;
        const double built_ms = input_now_ms();
        worked = worked && svo_scene_set_transforms(bench->scene, 0, bench->count, bench->matrices[0], queue) == SVO_OK;
        if (round > 0) {
            times[round - 1] = built_ms - start_ms;
            times[rounds + round - 1] = input_now_ms() - built_ms;
        }
    }
    if (worked) {
        bench->build_ms = spread_of(times, rounds);
        bench->refit_ms = spread_of(times + rounds, rounds);
    }
    free(times);
    return worked;
}

static double wait_ms(svo_status status, cl_event *done, double start_ms)
{
    if (status != SVO_OK) {
        return -1.0;
    }
    const cl_int error = clWaitForEvents(1, done);
    clReleaseEvent(*done);
    return error == CL_SUCCESS ? input_now_ms() - start_ms : -1.0;
}

static double trace_scene(void *user)
{
    const scene_bench *bench = user;
    cl_event done = NULL;
    const double start_ms = input_now_ms();
    const svo_status status = svo_trace_voxels(
        svo_scene_target(bench->scene), svo_in_buffer(bench->device_rays), svo_in_buffer(bench->device_hits),
        bench->ray_count, 0.0F, SVO_SCENE_CLOSEST, &(svo_submit){.queue = bench->all->opened.queue, .event = &done});
    return wait_ms(status, &done, start_ms);
}

static double trace_merged(void *user)
{
    const scene_bench *bench = user;
    cl_event done = NULL;
    const double start_ms = input_now_ms();
    const svo_status status = svo_trace_voxels(svo_tree_target(bench->merged), svo_in_buffer(bench->device_rays),
                                               svo_in_buffer(bench->device_hits), bench->ray_count, 0.0F, 0,
                                               &(svo_submit){.queue = bench->all->opened.queue, .event = &done});
    return wait_ms(status, &done, start_ms);
}

static double trace_embree(void *user)
{
    const scene_bench *bench = user;
    return embree_trace(bench->peer, EMBREE_INTERSECT1, bench->rays, bench->peer_hits, bench->ray_count,
                        bench->threads);
}

static double trace_triangles(void *user)
{
    const scene_bench *bench = user;
    cl_event done = NULL;
    const double start_ms = input_now_ms();
    const svo_status status = svo_trace_triangles(
        svo_scene_target(bench->scene), svo_in_buffer(bench->device_rays), svo_in_buffer(bench->device_hits),
        bench->ray_count, SVO_SCENE_CLOSEST, &(svo_submit){.queue = bench->all->opened.queue, .event = &done});
    return wait_ms(status, &done, start_ms);
}

static double trace_embree_triangles(void *user)
{
    const scene_bench *bench = user;
    return embree_trace(bench->triangles_peer, EMBREE_INTERSECT1, bench->rays, bench->peer_hits, bench->ray_count,
                        bench->threads);
}

static void make_rays(scene_bench *bench, int set)
{
    if (set == 0) {
        svo_camera camera = {.vertical_fov = 0};
        (void)svo_camera_fit(svo_scene_target(bench->scene), 1.0F, &camera);
        ray_set_primary(&camera, 1, bench->ray_count, bench->rays);
    } else {
        ray_set_incoherent(bench->info.low, bench->info.high, bench->ray_count, bench->rays);
    }
}

static bool measure_rays(scene_bench *bench, int set)
{
    interleaved_method methods[METHOD_COUNT] = {{trace_scene, bench, NAN},
                                                {trace_merged, bench, NAN},
                                                {trace_embree, bench, NAN},
                                                {trace_triangles, bench, NAN},
                                                {trace_embree_triangles, bench, NAN}};
    const bool there[METHOD_COUNT] = {true, bench->merged != NULL, bench->peer != NULL, true,
                                      bench->triangles_peer != NULL};
    interleaved_method asked[METHOD_COUNT];
    size_t count = 0;
    make_rays(bench, set);
    if (clEnqueueWriteBuffer(bench->all->opened.queue, bench->device_rays, CL_TRUE, 0,
                             bench->ray_count * sizeof(svo_ray), bench->rays, 0, NULL, NULL) != CL_SUCCESS) {
        return false;
    }
    for (int i = 0; i < METHOD_COUNT; ++i) {
        if (there[i]) {
            asked[count++] = methods[i];
        }
    }
    if (!interleave_measure(asked, count, bench->all->repeats)) {
        return false;
    }
    for (int i = 0, k = 0; i < METHOD_COUNT; ++i) {
        bench->rates[set][i] = there[i] ? (double)bench->ray_count / asked[k++].median_ms * 1e-3 : (double)NAN;
    }
    return true;
}

/* How many of the last rays meet the merged tree where they meet the scene, in percent. */
static bool compare_hits(scene_bench *bench)
{
    cl_command_queue queue = bench->all->opened.queue;
    svo_scene_hit *hits = calloc(bench->ray_count, sizeof *hits);
    svo_voxel_hit *merged = calloc(bench->ray_count, sizeof *merged);
    size_t same = 0;
    const bool worked =
        hits != NULL && merged != NULL &&
        svo_trace_voxels(svo_scene_target(bench->scene), svo_in_host(bench->rays), svo_in_host(hits), bench->ray_count,
                         0.0F, SVO_SCENE_CLOSEST, &(svo_submit){.queue = queue}) == SVO_OK &&
        svo_trace_voxels(svo_tree_target(bench->merged), svo_in_host(bench->rays), svo_in_host(merged),
                         bench->ray_count, 0.0F, 0, &(svo_submit){.queue = queue}) == SVO_OK;
    for (size_t i = 0; i < bench->ray_count && worked; ++i) {
        const double apart = fabs((double)hits[i].t - (double)merged[i].t);
        same += hits[i].node == SVO_NO_NODE ? merged[i].node == SVO_NO_NODE : apart < 1e-5;
    }
    bench->same = 100.0 * (double)same / (double)bench->ray_count;
    free(hits);
    free(merged);
    return worked;
}

/* ---- rows ---- */

static void add_row(result_table *table, const scene_bench *bench, const input *source)
{
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, bench->model.info.depth);
    result_add_number(table, bench->count);
    result_add_number(table, (double)(bench->info.total_bytes - bench->info.tree_bytes) / bench->count);
    spread_add(table, bench->build_ms);
    spread_add(table, bench->refit_ms);
    for (int set = 0; set < SET_COUNT; ++set) {
        for (int i = 0; i < METHOD_COUNT; ++i) {
            result_add_number(table, bench->rates[set][i]);
        }
    }
    result_add_number(table, bench->peer != NULL ? embree_build_ms(bench->peer) : (double)NAN);
    result_add_number(table, bench->merged != NULL ? bench->same : (double)NAN);
}

static void release_scene(scene_bench *bench)
{
    svo_scene_destroy(&bench->scene);
    svo_tree_destroy(&bench->merged);
    embree *peers[] = {bench->peer, bench->triangles_peer};
    for (size_t i = 0; i < sizeof peers / sizeof peers[0]; ++i) {
        if (peers[i] != NULL) {
            embree_destroy(&peers[i]);
        }
    }
    bench->peer = bench->triangles_peer = NULL;
}

/* ---- the subject ---- */

static bool measure_count(scene_bench *bench)
{
    return make_scene(bench) && make_peers(bench) && measure_hierarchy(bench) && measure_rays(bench, 0) &&
           measure_rays(bench, 1) && (bench->merged == NULL || compare_hits(bench));
}

static bool make_room(scene_bench *bench, uint32_t most)
{
    const cl_context context = info_of_device(bench->all->opened.device).context;
    cl_int errors[2] = {CL_SUCCESS, CL_SUCCESS};
    bench->instances = calloc(most, sizeof *bench->instances);
    bench->matrices = calloc(most, sizeof *bench->matrices);
    bench->rays = calloc(bench->ray_count, sizeof *bench->rays);
    bench->peer_hits = calloc(bench->ray_count, sizeof *bench->peer_hits);
    bench->device_rays =
        clCreateBuffer(context, CL_MEM_READ_ONLY, bench->ray_count * sizeof(svo_ray), NULL, &errors[0]);
    bench->device_hits =
        clCreateBuffer(context, CL_MEM_WRITE_ONLY, bench->ray_count * sizeof(svo_scene_hit), NULL, &errors[1]);
    return bench->instances != NULL && bench->matrices != NULL && bench->rays != NULL && bench->peer_hits != NULL &&
           errors[0] == CL_SUCCESS && errors[1] == CL_SUCCESS;
}

static void release(scene_bench *bench)
{
    const cl_mem buffers[] = {bench->device_rays, bench->device_hits};
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        if (buffers[i] != NULL) {
            clReleaseMemObject(buffers[i]);
        }
    }
    svo_tree_destroy(&bench->model.tree);
    free(bench->instances);
    free(bench->matrices);
    free(bench->rays);
    free(bench->peer_hits);
}

static unsigned count_threads(const options *given)
{
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return given->threads != 0 ? (unsigned)given->threads : online > 0 ? (unsigned)online : 1;
}

static int run(suite *all, const input *source, unsigned depth)
{
    const options *given = &all->state->options;
    const size_t rows = all->quick ? QUICK_COUNTS : sizeof counts / sizeof counts[0];
    scene_bench bench = {.all = all,
                         .model = {.all = all, .mesh = source->mesh},
                         .ray_count = (size_t)given->ray_count,
                         .threads = count_threads(given)};
    int exit_code = PROGRAM_DONE;
    if (!make_room(&bench, counts[rows - 1])) {
        exit_code = program_fail(all->state, PROGRAM_FAILED, "out of memory for %zu rays", bench.ray_count);
    } else if (!build_model(&bench, source, depth)) {
        exit_code = program_fail_library(all->state, svo_device_message(all->opened.device));
    }
    for (size_t i = 0; i < rows && exit_code == PROGRAM_DONE; ++i) {
        bench.count = counts[i];
        if (measure_count(&bench)) {
            add_row(result_find(all->results, table_id), &bench, source);
        } else {
            exit_code = program_fail_library(all->state, svo_device_message(all->opened.device));
        }
        release_scene(&bench);
    }
    release(&bench);
    return exit_code;
}

const suite_subject bench_scene = {
    .words = &subject_table[SUBJECT_SCENE],
    .full = {.scenes = {"knot:2000"}, .depths = {6}},
    .quick = {.scenes = {"knot:500"}, .depths = {5}},
    .begin = begin,
    .run = run,
};
