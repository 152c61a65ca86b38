/* SPDX-License-Identifier: MIT */
/* Rays as pictures with indirect light have them, rays without any order, and comparisons with exact ones. */
#include "errors/probe_rays.h"

#include <math.h>
#include <stdlib.h>

#include "errors/hemisphere.h"
#include "measure/ray_sets.h"
#include "measure/spread.h"
#include "svocl/nodes.h"

#define SEED         1u
#define WRONG_LEAVES 2.0
#define SORTED_MAX   65536u /* quantiles are of so many errors, evenly picked */

static const char *const names[PROBE_RAYS_COUNT] = {"primary", "cosine", "random"};

const char *probe_rays_name(probe_ray_kind kind)
{
    return names[kind];
}

/* ---- sets ---- */

static bool trace_exactly(const error_run *run, svo_tree *tree, probe_rays *set)
{
    return svo_trace_triangles(svo_tree_target(tree), svo_in_host(set->rays), svo_in_host(set->exact), set->count,
                               SVO_TRACE_CLOSEST, &(svo_submit){.queue = run->opened.queue}) == SVO_OK;
}

/* Where a ray hit a triangle, with the normal of the side that it met. */
static svo_gather_point point_of(const svo_ray *ray, const svo_hit *hit)
{
    svo_gather_point point = {.exponent = 0};
    double along = 0;
    for (int axis = 0; axis < 3; ++axis) {
        along += (double)ray->direction[axis] * (double)hit->normal[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        point.position[axis] = ray->origin[axis] + hit->t * ray->direction[axis];
        point.normal[axis] = along > 0 ? -hit->normal[axis] : hit->normal[axis];
    }
    return point;
}

/* From the hits of the primary rays, again and again where they are fewer. False where there is none. */
static bool make_cosine(const probe_rays *primary, double leaf_edge, probe_rays *set)
{
    const hemisphere_set one = {.strata = 1, .lift = leaf_edge, .length = INFINITY};
    random_stream seeds = {.state = SEED};
    size_t made = 0;
    for (size_t i = 0, passed = 0; made < set->count && passed < primary->count; i = (i + 1) % primary->count) {
        if (primary->exact[i].triangle == SVO_NO_TRIANGLE) {
            ++passed;
            continue;
        }
        const svo_gather_point point = point_of(&primary->rays[i], &primary->exact[i]);
        hemisphere_set own = one;
        own.seed = random_bits(&seeds);
        passed = 0;
        hemisphere_rays(&own, &point, 1, &set->rays[made++]);
    }
    return made == set->count;
}

static void make_random(const svo_grid *grid, probe_rays *set)
{
    random_stream stream = {.state = SEED};
    const double edge = svo_grid_cell_edge(grid, 0);
    for (size_t i = 0; i < set->count; ++i) {
        svo_ray ray = {.t_max = INFINITY};
        for (int axis = 0; axis < 3; ++axis) {
            ray.origin[axis] = (float)(grid->origin[axis] + edge * random_between(&stream, 0, 1));
        }
        const vector3 direction = random_direction(&stream);
        ray.direction[0] = (float)direction.x;
        ray.direction[1] = (float)direction.y;
        ray.direction[2] = (float)direction.z;
        set->rays[i] = ray;
    }
}

bool probe_rays_make(const error_run *run, svo_tree *tree, const svo_camera *camera, size_t count, probe_rays *sets)
{
    svo_grid grid;
    if (svo_tree_get_grid(tree, &grid) != SVO_OK) {
        return false;
    }
    for (int kind = 0; kind < (int)PROBE_RAYS_COUNT; ++kind) {
        sets[kind] = (probe_rays){.count = count,
                                  .rays = calloc(count, sizeof *sets[kind].rays),
                                  .exact = calloc(count, sizeof *sets[kind].exact)};
        if (sets[kind].rays == NULL || sets[kind].exact == NULL) {
            return false;
        }
    }
    ray_set_primary(camera, 1, count, sets[PROBE_RAYS_PRIMARY].rays);
    make_random(&grid, &sets[PROBE_RAYS_RANDOM]);
    return trace_exactly(run, tree, &sets[PROBE_RAYS_PRIMARY]) &&
           make_cosine(&sets[PROBE_RAYS_PRIMARY], svo_grid_cell_edge(&grid, grid.depth), &sets[PROBE_RAYS_COSINE]) &&
           trace_exactly(run, tree, &sets[PROBE_RAYS_COSINE]) && trace_exactly(run, tree, &sets[PROBE_RAYS_RANDOM]);
}

void probe_rays_free(probe_rays *sets)
{
    for (int kind = 0; kind < (int)PROBE_RAYS_COUNT; ++kind) {
        free(sets[kind].rays);
        free(sets[kind].exact);
        sets[kind] = (probe_rays){.count = 0};
    }
}

/* ---- verdict ---- */

static int compare_doubles(const void *a, const void *b)
{
    const double left = *(const double *)a;
    const double right = *(const double *)b;
    return (left > right) - (left < right);
}

/* Takes the errors of all rays, negative ones left out. */
static void set_quantiles(double *errors, size_t count, probe_verdict *out)
{
    size_t kept = 0;
    size_t sorted = 0;
    out->median = out->p90 = out->p99 = NAN;
    for (size_t i = 0; i < count; ++i) {
        if (errors[i] >= 0) {
            errors[kept++] = errors[i];
        }
    }
    const size_t stride = (kept + SORTED_MAX - 1) / SORTED_MAX;
    for (size_t i = 0; i < kept; i += stride) {
        errors[sorted++] = errors[i];
    }
    if (sorted > 0) {
        qsort(errors, sorted, sizeof *errors, compare_doubles);
        out->median = spread_quantile(errors, sorted, 0.5);
        out->p90 = spread_quantile(errors, sorted, 0.9);
        out->p99 = spread_quantile(errors, sorted, 0.99);
    }
}

bool probe_rays_judge(const probe_rays *set, const svo_probe_hit *hits, double leaf_edge, probe_verdict *out)
{
    const double share = 100.0 / (double)set->count;
    double *errors = calloc(set->count, sizeof *errors);
    *out = (probe_verdict){0};
    for (size_t i = 0; i < set->count && errors != NULL; ++i) {
        const bool is_there = set->exact[i].triangle != SVO_NO_TRIANGLE;
        const bool is_hit = hits[i].state == SVO_PROBE_HIT;
        const bool is_miss = hits[i].state == SVO_PROBE_MISS;
        errors[i] = is_hit && is_there ? fabs((double)hits[i].t - (double)set->exact[i].t) / leaf_edge : -1;
        out->hit += is_hit ? share : 0;
        out->miss += is_miss ? share : 0;
        out->unknown += is_hit || is_miss ? 0 : share;
        out->wrong_hit += is_hit && (!is_there || errors[i] > WRONG_LEAVES) ? share : 0;
        out->wrong_miss += is_miss && is_there ? share : 0;
    }
    if (errors != NULL) {
        set_quantiles(errors, set->count, out);
    }
    free(errors);
    return errors != NULL;
}
