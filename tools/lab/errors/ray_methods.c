/* SPDX-License-Identifier: MIT */
/* Sets up every method, times them interleaved, and compares their hits with the exact ones. The common ray-triangle
   tests in float32 and the exact one, each of one ray with one triangle, are for the BVH of bvh.h. */
#include "errors/ray_methods.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors/bvh.h"
#include "errors/voxel_cast.h"
#include "measure/embree.h"
#include "measure/ray_sets.h"
#include "measure/spread.h"
#include "reference/oracle_rays.h"
#include "support/info_of.h"
#include "support/input.h"

/* ---- ray tests ---- */

/* Triangles in world coordinates, rounded to float32. */
typedef struct float_triangles {
    const float *vertices; /* three per vertex */
    const uint32_t *indices; /* three per triangle */
} float_triangles;

/* The triangles, and what is added to the rays' directions, in units of their longest component. */
typedef struct exact_triangles {
    const oracle_ray_scene *mesh;
    double perturbation[3];
} exact_triangles;

static const float *corner_of(const float_triangles *from, size_t triangle, size_t corner)
{
    return from->vertices + (size_t)from->indices[3 * triangle + corner] * 3;
}

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Moller and Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997, two-sided, without an epsilon.
   triangles: a float_triangles. */
static bool ray_test_moller_trumbore(const void *triangles, size_t triangle, const svo_ray *ray, svo_hit *hit)
{
    const float *a = corner_of(triangles, triangle, 0);
    const float *b = corner_of(triangles, triangle, 1);
    const float *c = corner_of(triangles, triangle, 2);
    float first[3];
    float second[3];
    float start[3];
    for (int k = 0; k < 3; ++k) {
        first[k] = b[k] - a[k];
        second[k] = c[k] - a[k];
        start[k] = ray->origin[k] - a[k];
    }
    float across[3];
    cross(ray->direction, second, across);
    const float determinant = dot(first, across);
    if (determinant == 0.0f) {
        return false;
    }
    const float inverse = 1.0f / determinant;
    const float u = dot(start, across) * inverse;
    if (!(u >= 0.0f && u <= 1.0f)) {
        return false;
    }
    float down[3];
    cross(start, first, down);
    const float v = dot(ray->direction, down) * inverse;
    const float t = dot(second, down) * inverse;
    if (!(v >= 0.0f && u + v <= 1.0f && t >= ray->t_min && t <= hit->t)) {
        return false;
    }
    hit->t = t;
    hit->u = u;
    hit->v = v;
    return true;
}

/* The ray's longest axis last; the order of the others keeps the winding. */
static void order_axes(const svo_ray *ray, int axes[3])
{
    const float *d = ray->direction;
    axes[2] = fabsf(d[0]) > fabsf(d[1]) ? (fabsf(d[0]) > fabsf(d[2]) ? 0 : 2) : (fabsf(d[1]) > fabsf(d[2]) ? 1 : 2);
    axes[0] = (axes[2] + 1) % 3;
    axes[1] = (axes[2] + 2) % 3;
    if (d[axes[2]] < 0.0f) {
        const int kept = axes[0];
        axes[0] = axes[1];
        axes[1] = kept;
    }
}

static float edge_function(const float p[3], const float q[3])
{
    return p[0] * q[1] - p[1] * q[0];
}

static float edge_function_in_double(const float p[3], const float q[3])
{
    return (float)((double)p[0] * (double)q[1] - (double)p[1] * (double)q[0]);
}

/* Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", 2013: edge functions in ray space, again in double
   where one of them is 0. triangles: a float_triangles. */
static bool ray_test_watertight(const void *triangles, size_t triangle, const svo_ray *ray, svo_hit *hit)
{
    int axes[3];
    order_axes(ray, axes);
    const float shear[3] = {ray->direction[axes[0]] / ray->direction[axes[2]],
                            ray->direction[axes[1]] / ray->direction[axes[2]], 1.0f / ray->direction[axes[2]]};
    float at[3][3];
    for (size_t i = 0; i < 3; ++i) {
        const float *corner = corner_of(triangles, triangle, i);
        const float along = corner[axes[2]] - ray->origin[axes[2]];
        at[i][0] = corner[axes[0]] - ray->origin[axes[0]] - shear[0] * along;
        at[i][1] = corner[axes[1]] - ray->origin[axes[1]] - shear[1] * along;
        at[i][2] = shear[2] * along;
    }
    float u = edge_function(at[2], at[1]);
    float v = edge_function(at[0], at[2]);
    float w = edge_function(at[1], at[0]);
    if (u == 0.0f || v == 0.0f || w == 0.0f) {
        u = edge_function_in_double(at[2], at[1]);
        v = edge_function_in_double(at[0], at[2]);
        w = edge_function_in_double(at[1], at[0]);
    }
    const float determinant = u + v + w;
    if (((u < 0.0f || v < 0.0f || w < 0.0f) && (u > 0.0f || v > 0.0f || w > 0.0f)) || determinant == 0.0f) {
        return false;
    }
    const float t = (u * at[0][2] + v * at[1][2] + w * at[2][2]) / determinant;
    if (!(t >= ray->t_min && t <= hit->t)) {
        return false;
    }
    hit->t = t;
    hit->u = v / determinant;
    hit->v = w / determinant;
    return true;
}

/* In long double. triangles: an exact_triangles. */
static bool ray_test_exact(const void *triangles, size_t triangle, const svo_ray *ray, svo_hit *hit)
{
    const exact_triangles *exact = triangles;
    oracle_ray wide = ray_widen(ray);
    const double longest = fmax(fabs(wide.direction[0]), fmax(fabs(wide.direction[1]), fabs(wide.direction[2])));
    double t = 0.0;
    for (int k = 0; k < 3; ++k) {
        wide.direction[k] += longest * exact->perturbation[k];
    }
    if (!oracle_ray_meets(exact->mesh, triangle, &wide, &t) || t > (double)hit->t) {
        return false;
    }
    hit->t = (float)t;
    return true;
}

/* ---- what is compared ---- */

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
    const bool worked =
        svo_trace_triangles(svo_tree_target(bench->tree), svo_in_buffer(bench->rays), svo_in_buffer(bench->hits),
                            bench->given->ray_count, SVO_TRACE_CLOSEST, &(svo_submit){.queue = queue}) == SVO_OK &&
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
        const unsigned depth = info_of_plan(plan).ray_depth;
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
    cl_context context = info_of_device(bench->run->opened.device).context;
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
