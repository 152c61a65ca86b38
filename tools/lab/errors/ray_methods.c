/* SPDX-License-Identifier: MIT */
/* Sets up every method, times them interleaved, and compares their hits with the exact ones. */
#include "errors/ray_methods.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors/ray_tests.h"
#include "errors/voxel_cast.h"
#include "measure/embree.h"
#include "measure/interleave.h"
#include "measure/ray_judge.h"
#include "support/input.h"

#define SOME_VOXEL    (SVO_NO_TRIANGLE - 1) /* a hit without a triangle */
#define PERTURBATION  0x1p-30
#define PERTURBATIONS 8

typedef struct ray_bench ray_bench;

typedef struct ray_method {
    ray_bench *bench;
    const char *name;
    double (*work_ms)(void *user);
    bvh_test *test; /* of a float32 method */
    embree *embree_scene; /* of Embree's */
    voxel_cast *cast; /* of "voxels alone" */
    svo_hit *hits; /* of the last round */
} ray_method;

struct ray_bench {
    error_run *run;
    const ray_case *given;
    svo_plan_options grid;
    svo_tree *tree;
    svo_tree_info info;
    svo_tree_arrays arrays;
    oracle_ray_scene exact_mesh; /* the input's triangles */
    float *vertices; /* of the input, rounded to float */
    bvh *host_bvh;
    cl_mem rays, hits; /* on the device */
    svo_hit *found; /* of all methods, one after the other */
    svo_hit *exact;
    double *exact_ts; /* infinity: no hit */
    ray_method methods[RAY_METHODS_MAX];
    size_t method_count;
};

/* ---- the methods ---- */

static double run_ours(void *user)
{
    const ray_method *method = user;
    const ray_bench *bench = method->bench;
    cl_command_queue queue = bench->run->opened.queue;
    const double started_ms = input_now_ms();
    const bool worked = svo_tree_trace_enqueue(bench->tree, bench->rays, bench->hits, bench->given->ray_count,
                                               SVO_TRACE_CLOSEST, queue, 0, NULL, NULL) == SVO_OK &&
                        clFinish(queue) == CL_SUCCESS;
    return worked ? input_now_ms() - started_ms : -1.0;
}

static double run_voxels(void *user)
{
    const ray_method *method = user;
    return voxel_cast_run(method->cast);
}

static double run_bvh(void *user)
{
    const ray_method *method = user;
    const ray_bench *bench = method->bench;
    const float_triangles triangles = {bench->vertices, bench->arrays.indices};
    return bvh_trace(bench->host_bvh, method->test, &triangles, bench->given->rays, method->hits,
                     bench->given->ray_count, bench->run->threads);
}

static double run_embree(void *user)
{
    const ray_method *method = user;
    return embree_trace(method->embree_scene, EMBREE_INTERSECT1, method->bench->given->rays, method->hits,
                        method->bench->given->ray_count, method->bench->run->threads);
}

static ray_method *add_method(ray_bench *bench, const char *name, double (*work_ms)(void *))
{
    ray_method *method = &bench->methods[bench->method_count++];
    *method = (ray_method){.bench = bench,
                           .name = name,
                           .work_ms = work_ms,
                           .hits = bench->found + (bench->method_count - 1) * bench->given->ray_count};
    return method;
}

static bool add_embree(ray_bench *bench, const char *name, bool robust)
{
    if (!embree_is_there()) {
        return true;
    }
    ray_method *method = add_method(bench, name, run_embree);
    method->embree_scene = embree_create(bench->vertices, (size_t)bench->info.vertex_count, bench->arrays.indices,
                                         (size_t)bench->info.list_triangle_count, &(embree_options){.robust = robust});
    return method->embree_scene != NULL;
}

static bool add_voxels(ray_bench *bench)
{
    static const char *const names[RAY_LEVELS_MAX] = {"voxels alone, coarse", "voxels alone, medium",
                                                      "voxels alone, fine"};
    bool worked = true;
    for (size_t i = 0; i < RAY_LEVELS_MAX && bench->given->levels[i] != 0 && worked; ++i) {
        ray_method *method = add_method(bench, names[i], run_voxels);
        method->cast = voxel_cast_create(&bench->run->opened, bench->given->mesh, bench->given->levels[i], &bench->grid,
                                         bench->given->rays, bench->given->ray_count);
        worked = method->cast != NULL;
    }
    return worked;
}

static bool list_methods(ray_bench *bench)
{
    bench->found = calloc(RAY_METHODS_MAX * bench->given->ray_count + 1, sizeof *bench->found);
    if (bench->found == NULL) {
        return false;
    }
    add_method(bench, "svocl", run_ours);
    add_method(bench, "Möller-Trumbore, float32", run_bvh)->test = ray_test_moller_trumbore;
    add_method(bench, "watertight, float32", run_bvh)->test = ray_test_watertight;
    bool worked =
        add_embree(bench, "Embree, fast", false) && add_embree(bench, "Embree, robust", true) && add_voxels(bench);
    for (size_t i = 0; i < bench->method_count; ++i) {
        worked = worked && bench->methods[i].hits != NULL;
    }
    return worked;
}

/* ---- the scene ---- */

static bool build_tree(ray_bench *bench)
{
    const session *opened = &bench->run->opened;
    svo_plan_options for_rays = bench->grid;
    svo_plan *plan = NULL;
    for_rays.need = SVO_NEED_RAYS;
    bool worked = svo_plan_create(opened->device, bench->given->mesh, 6, &for_rays, &plan) == SVO_OK;
    if (worked) {
        const unsigned depth = svo_plan_ray_depth(plan);
        svo_plan_destroy(&plan);
        worked = svo_plan_create(opened->device, bench->given->mesh, depth, &for_rays, &plan) == SVO_OK &&
                 svo_build(plan, opened->frontend, opened->queue, &bench->tree, NULL) == SVO_OK &&
                 svo_tree_download(bench->tree, opened->queue) == SVO_OK;
    }
    svo_plan_destroy(&plan);
    if (worked) {
        bench->info = (svo_tree_info)SVO_TREE_INFO_INIT;
        svo_tree_get_info(bench->tree, &bench->info);
        bench->arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
        svo_tree_get_arrays(bench->tree, &bench->arrays);
        bench->exact_mesh = (oracle_ray_scene){.positions = bench->arrays.positions,
                                               .positions_double = bench->arrays.positions_double,
                                               .indices = bench->arrays.indices,
                                               .triangle_count = (size_t)bench->info.list_triangle_count};
    }
    return worked;
}

/* The input's vertices as the other methods get them, and their BVH with bounds that allow for rounding to float. */
static bool make_bvh(ray_bench *bench)
{
    const size_t count = (size_t)bench->info.vertex_count * 3;
    double *positions = calloc(count + 1, sizeof *positions);
    double largest = 0.0;
    bench->vertices = calloc(count + 1, sizeof *bench->vertices);
    if (positions != NULL && bench->vertices != NULL) {
        for (size_t i = 0; i < count; ++i) {
            positions[i] = bench->arrays.positions != NULL ? (double)bench->arrays.positions[i]
                                                           : bench->arrays.positions_double[i];
            bench->vertices[i] = (float)positions[i];
            largest = fmax(largest, fabs(positions[i]));
        }
        bench->host_bvh =
            bvh_create(positions, bench->arrays.indices, (size_t)bench->info.list_triangle_count, largest * 0x1p-22);
    }
    free(positions);
    return bench->host_bvh != NULL;
}

static bool upload_rays(ray_bench *bench)
{
    cl_context context = svo_device_cl_context(bench->run->opened.device);
    const size_t count = bench->given->ray_count;
    bench->rays = clCreateBuffer(context, CL_MEM_READ_ONLY, count * sizeof(svo_ray), NULL, NULL);
    bench->hits = clCreateBuffer(context, CL_MEM_WRITE_ONLY, count * sizeof(svo_hit), NULL, NULL);
    return bench->rays != NULL && bench->hits != NULL &&
           clEnqueueWriteBuffer(bench->run->opened.queue, bench->rays, CL_TRUE, 0, count * sizeof(svo_ray),
                                bench->given->rays, 0, NULL, NULL) == CL_SUCCESS;
}

/* The exact hits: the BVH finds candidates, long double decides. */
static bool find_exact(ray_bench *bench)
{
    const size_t count = bench->given->ray_count;
    const exact_triangles triangles = {.mesh = &bench->exact_mesh};
    bench->exact = calloc(count + 1, sizeof *bench->exact);
    bench->exact_ts = calloc(count + 1, sizeof *bench->exact_ts);
    if (bench->exact == NULL || bench->exact_ts == NULL ||
        bvh_trace(bench->host_bvh, ray_test_exact, &triangles, bench->given->rays, bench->exact, count,
                  bench->run->threads) < 0.0) {
        return false;
    }
    for (size_t i = 0; i < count; ++i) {
        const oracle_ray wide = ray_widen(&bench->given->rays[i]);
        bench->exact_ts[i] = (double)INFINITY;
        if (bench->exact[i].triangle != SVO_NO_TRIANGLE) {
            oracle_ray_meets(&bench->exact_mesh, bench->exact[i].triangle, &wide, &bench->exact_ts[i]);
        }
    }
    return true;
}

/* ---- comparison ---- */

/* Reads ts, and triangles as indices into the tree's list. */
static bool fetch(ray_bench *bench, ray_method *method)
{
    const size_t count = bench->given->ray_count;
    if (method->cast != NULL) {
        float *ts = calloc(count + 1, sizeof *ts);
        const bool worked = ts != NULL && voxel_cast_read(method->cast, ts);
        for (size_t i = 0; i < count && worked; ++i) {
            method->hits[i] = (svo_hit){.t = ts[i], .triangle = isinf(ts[i]) ? SVO_NO_TRIANGLE : SOME_VOXEL};
        }
        free(ts);
        return worked;
    }
    if (method->work_ms != run_ours) {
        return true;
    }
    if (clEnqueueReadBuffer(bench->run->opened.queue, bench->hits, CL_TRUE, 0, count * sizeof(svo_hit), method->hits, 0,
                            NULL, NULL) != CL_SUCCESS) {
        return false;
    }
    uint32_t last = 0; /* triangle_ids ascend: the index of an ID is at most the ID */
    for (size_t i = 0; i < count; ++i) {
        svo_hit *hit = &method->hits[i];
        last = hit->triangle < bench->info.list_triangle_count ? hit->triangle
                                                               : (uint32_t)bench->info.list_triangle_count - 1;
        while (hit->triangle != SVO_NO_TRIANGLE && bench->arrays.triangle_ids[last] > hit->triangle) {
            --last;
        }
        hit->triangle = hit->triangle == SVO_NO_TRIANGLE ? hit->triangle : last;
    }
    return true;
}

/* Whether the result is correct for the ray with its direction perturbed by far less than a float resolves: a ray that
   only touches a silhouette may count as a hit or as a miss. */
static bool is_right_when_perturbed(const ray_bench *bench, size_t index, const svo_hit *hit)
{
    for (int side = 0; side < PERTURBATIONS; ++side) {
        exact_triangles triangles = {.mesh = &bench->exact_mesh};
        svo_hit exact = {0};
        for (int k = 0; k < 3; ++k) {
            triangles.perturbation[k] = (side >> k & 1) != 0 ? PERTURBATION : -PERTURBATION;
        }
        bvh_trace(bench->host_bvh, ray_test_exact, &triangles, &bench->given->rays[index], &exact, 1, 1);
        if (exact.triangle == hit->triangle ||
            (exact.triangle != SVO_NO_TRIANGLE && hit->triangle != SVO_NO_TRIANGLE &&
             (hit->triangle == SOME_VOXEL || ray_ties((double)hit->t, (double)exact.t)))) {
            return true;
        }
    }
    return false;
}

/* Whether the ray touches the triangle that the hit names, and meets no other before. */
static bool touches_nearest(const ray_bench *bench, size_t index, const svo_hit *hit)
{
    const oracle_ray wide = ray_widen(&bench->given->rays[index]);
    return hit->triangle < bench->info.list_triangle_count &&
           oracle_ray_touches(&bench->exact_mesh, hit->triangle, &wide) &&
           !ray_judge_t(&bench->exact_mesh, hit->triangle, &wide, hit->t, bench->exact_ts[index]).beyond;
}

static void judge_one(const ray_bench *bench, size_t index, const svo_hit *hit, ray_method_result *result)
{
    const double exact = bench->exact_ts[index];
    const bool met = hit->triangle != SVO_NO_TRIANGLE;
    const bool named =
        hit->triangle == SOME_VOXEL || hit->triangle == bench->exact[index].triangle || ray_ties((double)hit->t, exact);
    if (met && !isinf(exact) && named) {
        const double error = exact > 0.0 ? fabs((double)hit->t - exact) / exact : 0.0;
        result->t_error_mean += error;
        result->t_error_max = fmax(result->t_error_max, error);
        ++result->compared;
    } else if ((met || !isinf(exact)) && !touches_nearest(bench, index, hit) &&
               !is_right_when_perturbed(bench, index, hit)) {
        ++*(met ? &result->wrong : &result->missed);
    }
}

/* Adds how a hit's t compares with the exact one of the triangle that it names, in ulps of float. */
static void judge_t(const ray_bench *bench, size_t index, const svo_hit *hit, ray_method_result *result)
{
    const oracle_ray wide = ray_widen(&bench->given->rays[index]);
    const ray_t_error error = ray_judge_t(&bench->exact_mesh, hit->triangle, &wide, hit->t, bench->exact_ts[index]);
    result->named += 1;
    result->beyond += error.beyond;
    result->rounded += error.ulps <= 0.5;
    result->ulps_max = fmax(result->ulps_max, error.ulps);
}

static void judge(const ray_bench *bench, const ray_method *method, ray_method_result *result)
{
    for (size_t i = 0; i < result->rays; ++i) {
        judge_one(bench, i, &method->hits[i], result);
        if (method->hits[i].triangle < bench->info.list_triangle_count) {
            judge_t(bench, i, &method->hits[i], result);
        }
    }
    result->t_error_mean /= result->compared > 0 ? (double)result->compared : 1.0;
}

static bool measure(ray_bench *bench, ray_method_result *results)
{
    interleaved_method timed[RAY_METHODS_MAX];
    for (size_t i = 0; i < bench->method_count; ++i) {
        timed[i] = (interleaved_method){.work_ms = bench->methods[i].work_ms, .user = &bench->methods[i]};
    }
    bool worked = interleave_measure(timed, bench->method_count, bench->run->rounds);
    for (size_t i = 0; i < bench->method_count && worked; ++i) {
        results[i] = (ray_method_result){
            .method = bench->methods[i].name, .ms = timed[i].median_ms, .rays = bench->given->ray_count};
        worked = fetch(bench, &bench->methods[i]);
        if (worked) {
            judge(bench, &bench->methods[i], &results[i]);
        }
    }
    return worked;
}

static void release(ray_bench *bench)
{
    for (size_t i = 0; i < bench->method_count; ++i) {
        embree_destroy(&bench->methods[i].embree_scene);
        voxel_cast_destroy(&bench->methods[i].cast);
    }
    if (bench->rays != NULL) {
        clReleaseMemObject(bench->rays);
    }
    if (bench->hits != NULL) {
        clReleaseMemObject(bench->hits);
    }
    bvh_destroy(&bench->host_bvh);
    svo_tree_destroy(&bench->tree);
    free(bench->vertices);
    free(bench->found);
    free(bench->exact);
    free(bench->exact_ts);
}

int ray_methods_measure(error_run *run, const ray_case *given, ray_method_result *results, size_t *result_count)
{
    ray_bench bench = {.run = run, .given = given};
    bench.grid = (svo_plan_options){.struct_size = sizeof bench.grid, .edge = given->edge};
    memcpy(bench.grid.origin, given->origin, sizeof bench.grid.origin);
    const bool worked = build_tree(&bench) && make_bvh(&bench) && upload_rays(&bench) && find_exact(&bench) &&
                        list_methods(&bench) && measure(&bench, results);
    *result_count = bench.method_count;
    release(&bench);
    return worked ? PROGRAM_DONE : errors_fail(run);
}

double ray_method_error(const ray_method_result *result)
{
    return result->rays > 0 ? (double)(result->missed + result->wrong) / (double)result->rays : 0.0;
}
