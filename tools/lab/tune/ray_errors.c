/* SPDX-License-Identifier: MIT */
/*
 * Voxels are compared with the first triangle of the truth's rays. Triangles and their t are compared with every
 * triangle of the mesh in long double (oracle_rays.h), which takes so long that meshes of many triangles have fewer of
 * these rays. Both truths are kept until the seed changes.
 */
#include "tune/ray_errors.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measure/ray_sets.h"
#include "path/threads.h"
#include "scenes/maths.h"
#include "support/info_of.h"

#define EXACT_TESTS 4e7 /* of rays against triangles */
#define EXACT_RAYS  64u /* at least */
#define CHUNK_RAYS  4u

/* From a sphere around the grid to random points in the bounds of the surface: other rays for each seed. */
static void make_rays(const svo_tree_info *grid, size_t count, uint32_t seed, svo_ray *rays)
{
    random_stream random = {.state = seed};
    const double half = grid->edge / 2;
    for (size_t i = 0; i < count; ++i) {
        const vector3 way = random_direction(&random);
        const vector3 aim = vector_scale(random_direction(&random), half * random_between(&random, 0, 1));
        const vector3 from = vector_scale(way, 3 * half);
        const vector3 along = vector_normalize(vector_subtract(aim, from));
        const double start[3] = {from.x, from.y, from.z};
        const double direction[3] = {along.x, along.y, along.z};
        rays[i] = (svo_ray){.t_max = INFINITY};
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = (float)(grid->origin[axis] + half + start[axis]);
            rays[i].direction[axis] = (float)direction[axis];
        }
    }
}

/* ---- truth ---- */

typedef struct exact_work {
    oracle_ray_scene scene;
    ray_truth *truth;
} exact_work;

static void find_exact(void *user, unsigned thread_index, size_t begin, size_t end)
{
    const exact_work *work = user;
    (void)thread_index;
    for (size_t i = begin; i < end; ++i) {
        const oracle_ray ray = ray_widen(&work->truth->rays[i]);
        work->truth->exact[i] = oracle_ray_closest(&work->scene, &ray);
    }
}

void ray_truth_clear(ray_truth *truth)
{
    free(truth->rays);
    free(truth->hits);
    free(truth->exact);
    truth->rays = NULL;
    truth->hits = NULL;
    truth->exact = NULL;
    truth->count = truth->exact_count = 0;
}

static bool allocate(ray_truth *truth, size_t count)
{
    ray_truth_clear(truth);
    truth->rays = calloc(count, sizeof *truth->rays);
    truth->hits = calloc(count, sizeof *truth->hits);
    truth->exact = calloc(count, sizeof *truth->exact);
    return truth->rays != NULL && truth->hits != NULL && truth->exact != NULL;
}

static bool find_truth(ray_truth *truth, size_t count, uint32_t seed)
{
    const svo_tree_info info = info_of_tree(truth->tree);
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    if (truth->count == count && truth->seed == seed) {
        return true;
    }
    if (!allocate(truth, count)) {
        return false;
    }
    svo_tree_get_arrays(truth->tree, &arrays);
    exact_work work = {.scene = {.positions = arrays.positions,
                                 .positions_double = arrays.positions_double,
                                 .indices = arrays.indices,
                                 .triangle_count = (size_t)info.list_triangle_count},
                       .truth = truth};
    const double affordable = EXACT_TESTS / (double)(work.scene.triangle_count + 1);
    truth->exact_count = affordable > (double)count ? count : affordable > EXACT_RAYS ? (size_t)affordable : EXACT_RAYS;
    make_rays(&info, count, seed, truth->rays);
    (void)threads_run(truth->threads, truth->exact_count, CHUNK_RAYS, find_exact, &work);
    truth->count = count;
    truth->seed = seed;
    return svo_trace_triangles(svo_tree_target(truth->tree), svo_in_host(truth->rays), svo_in_host(truth->hits), count,
                               SVO_TRACE_CLOSEST, &(svo_submit){.queue = truth->opened->queue}) == SVO_OK;
}

/* ---- comparison ---- */

static void add_voxels(const ray_truth *truth, const svo_voxel_hit *found, tune_errors *errors)
{
    for (size_t i = 0; i < truth->count; ++i) {
        const bool of_triangle = isfinite(truth->hits[i].t);
        const bool of_voxel = isfinite(found[i].t);
        if (of_triangle || of_voxel) {
            samples_add(&errors->of[QUANTITY_SILHOUETTE], i, of_triangle != of_voxel);
        }
        if (of_triangle && of_voxel) {
            samples_add(&errors->of[QUANTITY_DEPTH], i,
                        fabs((double)truth->hits[i].t - (double)found[i].t) / errors->voxel);
        }
    }
}

static void add_triangles(const ray_truth *truth, const svo_hit *found, tune_errors *errors)
{
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_arrays(truth->tree, &arrays);
    for (size_t i = 0; i < truth->exact_count; ++i) {
        const oracle_ray_hit *exact = &truth->exact[i];
        const tune_hit of_truth = {exact->hit ? arrays.triangle_ids[exact->triangle] : SVO_NO_TRIANGLE, exact->t};
        samples_add_hit(errors, i, of_truth, (tune_hit){found[i].triangle, (double)found[i].t});
    }
}

static bool compare_voxels(const ray_truth *truth, const tune_setting *setting, svo_tree *tree, tune_errors *errors)
{
    const svo_submit submit = {.queue = truth->opened->queue};
    const int form = setting->values[DIMENSION_FORM];
    const svo_compact_options asked = {.struct_size = sizeof asked, .form = (svo_form)(form - 1)};
    svo_voxel_hit *found = calloc(truth->count, sizeof *found);
    svo_compact *compact = NULL;
    bool worked = found != NULL && (form == 0 || svo_compact_create(truth->opened->device, tree, &asked,
                                                                    truth->opened->queue, &compact) == SVO_OK);
    worked = worked &&
             svo_trace_voxels(form == 0 ? svo_tree_target(tree) : svo_compact_target(compact), svo_in_host(truth->rays),
                              svo_in_host(found), truth->count, 0, SVO_TRACE_CLOSEST, &submit) == SVO_OK;
    if (worked) {
        add_voxels(truth, found, errors);
    }
    svo_compact_destroy(&compact);
    free(found);
    return worked;
}

static bool compare_triangles(const ray_truth *truth, svo_tree *tree, tune_errors *errors)
{
    svo_hit *found = calloc(truth->exact_count, sizeof *found);
    const bool worked = found != NULL && svo_trace_triangles(svo_tree_target(tree), svo_in_host(truth->rays),
                                                             svo_in_host(found), truth->exact_count, SVO_TRACE_CLOSEST,
                                                             &(svo_submit){.queue = truth->opened->queue}) == SVO_OK;
    if (worked) {
        add_triangles(truth, found, errors);
    }
    free(found);
    return worked;
}

bool ray_errors_add(ray_truth *truth, const tune_setting *setting, svo_tree *tree, uint32_t need, size_t count,
                    uint32_t seed, tune_errors *errors)
{
    const svo_tree_info info = info_of_tree(tree);
    const bool has_triangles = tune_setting_lacks(setting, QUANTITY_TRIANGLE) == NULL && (need & SVO_NEED_RAYS) != 0;
    if (info.leaf_count == 0) {
        return true;
    }
    errors->voxel = ldexp(info.edge, -(int)info.depth);
    errors->voxels = info.leaf_count;
    return find_truth(truth, count, seed) && compare_voxels(truth, setting, tree, errors) &&
           (!has_triangles || compare_triangles(truth, tree, errors));
}
