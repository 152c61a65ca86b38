/* SPDX-License-Identifier: MIT */
/*
 * Points are traced in groups whose rays fit a batch. Of each group: rays into the hemisphere above each point, with a
 * density in proportion to the cosine, so that means over rays are the integrals; what they meet; the sources' light
 * there, one batch of shadow rays for each source; means over the rays of each set. Light falls off with the inverse
 * square, and spots have a soft edge. Rays of paths go through what shows in part by chance, as its alpha at the point
 * tells; those to sources bring what all layers let through.
 */
#include "path/path.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "path/albedo.h"
#include "path/outside.h"
#include "path/threads.h"
#include "scenes/maths.h"
#include "svocl/nodes.h"

/* ---- a source ---- */

static vector3 vector_of(const float numbers[3])
{
    return vector((double)numbers[0], (double)numbers[1], (double)numbers[2]);
}

/* 1 inside the inner angle, 0 outside the outer one; between them smooth in the cosine. */
static double spot_share(const svo_light_source *source, vector3 towards)
{
    const vector3 axis = vector_normalize(vector_of(source->direction));
    return smooth_ramp(cos((double)source->outer_angle), cos((double)source->inner_angle), -vector_dot(axis, towards));
}

bool path_source_view(const svo_light_source *source, vector3 place, source_view *view)
{
    if (source->kind == SVO_SOURCE_DIRECTIONAL) {
        const vector3 axis = vector_normalize(vector_of(source->direction));
        *view = (source_view){.direction = vector_scale(axis, -1), .distance = INFINITY, .strength = 1};
        return true;
    }
    const vector3 towards = vector_subtract(vector_of(source->position), place);
    view->distance = vector_length(towards);
    if (!(view->distance > 0)) {
        return false;
    }
    view->direction = vector_scale(towards, 1 / view->distance);
    view->strength = 1 / vector_dot(towards, towards);
    if (source->kind == SVO_SOURCE_SPOT) {
        view->strength *= spot_share(source, view->direction);
    } else if (source->kind == SVO_SOURCE_DISK) {
        const vector3 axis = vector_normalize(vector_of(source->direction));
        view->strength *= fmax(-vector_dot(axis, view->direction), 0);
    }
    return view->strength > 0;
}

#define BATCH_RAYS     524288u /* a group is at least one point */
#define RAYS_PER_CHUNK 1024u
#define PI             3.14159265358979323846
/* Along a side of the square of rays from a point to a source with a size. */
#define SOURCE_STRATA 16u
/* Rays begin so far above a surface, in widths of the grid: 4 units of snapping. */
#define LIFT 0x1p-18

/* A place that light falls on: a point, or what a ray met. */
typedef struct lit_place {
    vector3 position;
    vector3 normal; /* unit, on the side that is looked at; zero: nothing is there */
    double weight[3]; /* radiance that an irradiance of 1 adds; 1 for points, where irradiance itself is wanted */
} lit_place;

typedef struct path_work {
    const path_scene *scene;
    const svo_gather_point *points; /* of the group */
    path_result *results;
    uint32_t first_point, seed;
    unsigned bounce; /* rays of each path so far */
    unsigned strata, per_point; /* along a side of a set's square; 16 of these */
    double lift; /* world units */
    svo_grid grid;
    svo_ray *rays;
    svo_hit *hits;
    bool is_clear; /* something of the mesh may show in part */
    size_t *passing; /* of the rays, those that go on behind what they met; with is_clear */
    svo_ray *passing_rays;
    svo_hit *passing_hits;
    double *pass; /* the share of light that what a ray to a source met lets through; likewise */
    lit_place *places;
    double *radiance; /* three to a place */
    const svo_light_source *source; /* of the running batch of shadow rays */
    uint32_t source_ray, source_rays; /* of those to this source from each place: the running one, and all */
} path_work;

/* ---- samples ---- */

/* Two numbers in [0, 1) for a sample: a function of seed, bounce, point and sample alone. */
static void random_pair(const path_work *work, uint32_t point, uint32_t sample, double out[2])
{
    random_stream of_bounce = {.state = work->bounce};
    const uint64_t bounce = work->bounce > 0 ? random_bits(&of_bounce) : 0;
    random_stream of_point = {.state = ((uint64_t)work->seed << 32 | point) ^ bounce};
    random_stream of_sample = {.state = random_bits(&of_point) + sample};
    out[0] = random_between(&of_sample, 0, 1);
    out[1] = random_between(&of_sample, 0, 1);
}

/* Cosine-weighted, around +z: the projection of a uniform disk. */
static vector3 sample_hemisphere(const path_work *work, uint32_t point, uint32_t sample)
{
    const unsigned stratum = sample % (work->strata * work->strata);
    double jitter[2];
    random_pair(work, point, sample, jitter);
    const double squared = (stratum / work->strata + jitter[0]) / work->strata; /* NOLINT: a row */
    const double angle = 2 * PI * (stratum % work->strata + jitter[1]) / work->strata;
    return vector(sqrt(squared) * cos(angle), sqrt(squared) * sin(angle), sqrt(1 - squared));
}

/* From around +z to around the normal. */
static vector3 turn_to(vector3 normal, vector3 local)
{
    const vector3 size = vector(fabs(normal.x), fabs(normal.y), fabs(normal.z));
    const vector3 axis = size.x <= size.y && size.x <= size.z ? vector(1, 0, 0)
                         : size.y <= size.z                   ? vector(0, 1, 0)
                                                              : vector(0, 0, 1);
    const vector3 side = vector_normalize(vector_cross(normal, axis));
    const vector3 other = vector_cross(normal, side);
    return vector_add(vector_scale(normal, local.z),
                      vector_add(vector_scale(side, local.x), vector_scale(other, local.y)));
}

void path_source_spread(const svo_light_source *source, const double chosen[2], source_view *view)
{
    const double turn = 2 * PI * chosen[1];
    if (source->kind == SVO_SOURCE_DISK) {
        const double aside = (double)source->radius * sqrt(chosen[0]);
        const vector3 axis = vector_normalize(vector_of(source->direction));
        const vector3 across = turn_to(axis, vector(aside * cos(turn), aside * sin(turn), 0));
        const vector3 towards = vector_add(vector_scale(view->direction, view->distance), across);
        view->strength *= pow(view->distance / vector_length(towards), 3); /* the cosine over the squared distance */
        view->distance = vector_length(towards);
        view->direction = vector_normalize(towards);
        return;
    }
    const bool is_far = source->kind == SVO_SOURCE_DIRECTIONAL;
    const double size = is_far ? sin((double)source->radius) : (double)source->radius / view->distance;
    if (!(size < 1)) {
        return; /* inside the ball */
    }
    const double sine = size * sqrt(chosen[0]);
    const double cosine = sqrt(1 - sine * sine);
    view->direction = turn_to(view->direction, vector(sine * cos(turn), sine * sin(turn), cosine));
    view->distance *= cosine - (is_far ? 0 : sqrt(size * size - sine * sine));
    view->strength /= cosine;
}

/* The running batch's source as a place sees it, with a size the point of it that the batch's ray goes to. */
static bool see_source(const path_work *work, size_t place, source_view *view)
{
    double jitter[2];
    const bool is_seen = path_source_view(work->source, work->places[place].position, view);
    if (is_seen && work->source->radius > 0.0F) {
        random_pair(work, work->first_point + (uint32_t)place, ~work->source_ray, jitter);
        const unsigned row = work->source_ray / SOURCE_STRATA;
        const unsigned column = work->source_ray % SOURCE_STRATA;
        const double strata = work->source_rays > 1 ? SOURCE_STRATA : 1;
        const double chosen[2] = {(row + jitter[0]) / strata, (column + jitter[1]) / strata};
        path_source_spread(work->source, chosen, view);
        view->strength /= work->source_rays;
    }
    return is_seen;
}

static const svo_ray no_ray = {.direction = {0, 0, 1}, .t_min = 0, .t_max = -1};

/* From above a place. direction: unit. */
static svo_ray ray_from(const path_work *work, const lit_place *place, vector3 direction, double length)
{
    const vector3 origin = vector_add(place->position, vector_scale(place->normal, work->lift));
    return (svo_ray){.origin = {(float)origin.x, (float)origin.y, (float)origin.z},
                     .direction = {(float)direction.x, (float)direction.y, (float)direction.z},
                     .t_min = 0,
                     .t_max = (float)length};
}

/* ---- tracing ---- */

/* Layers that rays go through. */
#define LAYERS_MAX 64u
/* Less light does not get through. */
#define LEAST_PASS 1e-9

/* Whether a ray goes on behind what it met. To a source all of it does that is let through; else by chance, a function
   of seed, bounce, place in the batch and layer alone. */
static bool passes(const path_work *work, size_t i, unsigned layer, bool to_source)
{
    const svo_hit *hit = &work->hits[i];
    double albedo[3];
    if (hit->triangle == SVO_NO_TRIANGLE) {
        return false;
    }
    const double alpha = path_albedo(work->scene->mesh, hit->triangle, (double)hit->u, (double)hit->v, albedo);
    if (to_source) {
        work->pass[i] *= 1 - alpha;
        return work->pass[i] > LEAST_PASS;
    }
    random_stream of_layer = {.state = (uint64_t)work->seed << 32 | (LAYERS_MAX * work->bounce + layer)};
    random_stream of_ray = {.state = random_bits(&of_layer) + (uint64_t)work->first_point * work->per_point + i};
    return alpha < 1 && random_between(&of_ray, 0, 1) >= alpha;
}

/* Notes the rays that go on, of those that went on before. Returns how many. */
static size_t find_passing(path_work *work, size_t before, unsigned layer, bool to_source)
{
    size_t count = 0;
    for (size_t k = 0; k < before; ++k) {
        const size_t i = layer == 0 ? k : work->passing[k];
        if (passes(work, i, layer, to_source)) {
            work->passing_rays[count] = work->rays[i];
            work->passing_rays[count].t_min = (float)((double)work->hits[i].t + work->lift);
            work->passing[count++] = i;
        }
    }
    return count;
}

static svo_status trace_once(const path_work *work, svo_ray *rays, svo_hit *hits, size_t count, bool to_source)
{
    const uint32_t flags = to_source && !work->is_clear ? SVO_TRACE_ANY : SVO_TRACE_CLOSEST;
    return svo_trace_triangles(svo_tree_target(work->scene->tree), svo_in_host(rays), svo_in_host(hits), count, flags,
                               &(svo_submit){.queue = work->scene->queue});
}

/* What the batch's rays meet; of those to sources, whether they meet anything. */
static svo_status trace_rays(path_work *work, size_t count, bool to_source)
{
    svo_status status = trace_once(work, work->rays, work->hits, count, to_source);
    for (size_t i = 0; work->is_clear && i < count; ++i) {
        work->pass[i] = 1;
    }
    size_t passing = work->is_clear && status == SVO_OK ? find_passing(work, count, 0, to_source) : 0;
    for (unsigned layer = 1; passing > 0 && layer < LAYERS_MAX; ++layer) {
        status = trace_once(work, work->passing_rays, work->passing_hits, passing, to_source);
        if (status != SVO_OK) {
            return status;
        }
        for (size_t k = 0; k < passing; ++k) {
            work->hits[work->passing[k]] = work->passing_hits[k];
        }
        passing = find_passing(work, passing, layer, to_source);
    }
    return status;
}

/* ---- the group's places ---- */

/* Points without a normal or outside the grid become places without one. */
static lit_place place_of_point(const path_work *work, const svo_gather_point *point)
{
    const lit_place place = {
        .position = vector_of(point->position), .normal = vector_of(point->normal), .weight = {1, 1, 1}};
    const double position[3] = {place.position.x, place.position.y, place.position.z};
    const double length = vector_length(place.normal);
    uint32_t cell[3];
    if (!(length > 0) || !isfinite(length) ||
        svo_grid_cell_of_point(&work->grid, work->grid.depth, position, cell) == 0) {
        return (lit_place){.weight = {0}};
    }
    return (lit_place){
        .position = place.position, .normal = vector_scale(place.normal, 1 / length), .weight = {1, 1, 1}};
}

static bool is_there(const lit_place *place)
{
    return vector_dot(place->normal, place->normal) > 0;
}

/* The next ray of each path, from its point or from what it met. */
static void make_rays(void *user, unsigned thread_index, size_t begin, size_t end)
{
    const path_work *work = user;
    (void)thread_index;
    for (size_t i = begin; i < end; ++i) {
        const size_t point = i / work->per_point;
        if (work->bounce == 0) {
            work->places[i] = place_of_point(work, &work->points[point]);
            memset(work->radiance + 3 * i, 0, 3 * sizeof *work->radiance);
        }
        work->rays[i] = no_ray;
        if (is_there(&work->places[i])) {
            const vector3 local =
                sample_hemisphere(work, work->first_point + (uint32_t)point, (uint32_t)(i % work->per_point));
            work->rays[i] = ray_from(work, &work->places[i], turn_to(work->places[i].normal, local), INFINITY);
        }
    }
}

/* What a ray met, and the radiance that comes from there without the sources: emission, or the sky's. Directions have
   the density of the cosine, so that an irradiance of pi comes with a radiance of 1. */
static void find_place(const path_work *work, size_t i)
{
    const svo_light_setup *setup = work->scene->setup;
    const svo_ray *ray = &work->rays[i];
    const svo_hit *hit = &work->hits[i];
    lit_place *place = &work->places[i];
    double *radiance = work->radiance + 3 * i;
    const double share = work->bounce > 0 ? PI : 1;
    const double arriving[3] = {share * place->weight[0], share * place->weight[1], share * place->weight[2]};
    *place = (lit_place){.weight = {0}};
    if (hit->triangle == SVO_NO_TRIANGLE) {
        double outside[3] = {0, 0, 0};
        if (ray->t_max > 0) {
            path_outside(setup, vector_of(ray->direction), outside);
        }
        for (int channel = 0; channel < 3; ++channel) {
            radiance[channel] += arriving[channel] * outside[channel];
        }
        return;
    }
    double emission[3];
    path_emission(work->scene->mesh, setup, hit->triangle, emission);
    (void)path_albedo(work->scene->mesh, hit->triangle, (double)hit->u, (double)hit->v, place->weight);
    const vector3 direction = vector_of(ray->direction);
    const vector3 normal = vector_of(hit->normal);
    place->position = vector_add(vector_of(ray->origin), vector_scale(direction, (double)hit->t));
    place->normal = vector_scale(normal, vector_dot(normal, direction) > 0 ? -1 : 1);
    for (int channel = 0; channel < 3; ++channel) {
        radiance[channel] += arriving[channel] * emission[channel];
        place->weight[channel] *= arriving[channel] / PI;
    }
}

static void find_places(void *user, unsigned thread_index, size_t begin, size_t end)
{
    (void)thread_index;
    for (size_t i = begin; i < end; ++i) {
        find_place(user, i);
    }
}

static void take_points(path_work *work, size_t point_count)
{
    for (size_t i = 0; i < point_count; ++i) {
        work->places[i] = place_of_point(work, &work->points[i]);
    }
    memset(work->radiance, 0, 3 * point_count * sizeof *work->radiance);
}

/* ---- light of the sources ---- */

static void make_shadow_rays(void *user, unsigned thread_index, size_t begin, size_t end)
{
    const path_work *work = user;
    (void)thread_index;
    for (size_t i = begin; i < end; ++i) {
        const lit_place *place = &work->places[i];
        source_view view;
        work->rays[i] = no_ray;
        if (is_there(place) && see_source(work, i, &view) && vector_dot(view.direction, place->normal) > 0) {
            work->rays[i] = ray_from(work, place, view.direction, view.distance);
        }
    }
}

static void add_light(void *user, unsigned thread_index, size_t begin, size_t end)
{
    const path_work *work = user;
    (void)thread_index;
    for (size_t i = begin; i < end; ++i) {
        const lit_place *place = &work->places[i];
        source_view view;
        if (work->rays[i].t_max > 0 && work->hits[i].triangle == SVO_NO_TRIANGLE && see_source(work, i, &view)) {
            const double pass = work->is_clear ? work->pass[i] : 1;
            const double irradiance = pass * view.strength * vector_dot(view.direction, place->normal);
            for (int channel = 0; channel < 3; ++channel) {
                work->radiance[3 * i + (size_t)channel] +=
                    place->weight[channel] * irradiance * (double)work->source->value[channel];
            }
        }
    }
}

/* Adds what each source brings to the first places. rays: from each to a source with a size. */
static svo_status add_sources(path_work *work, size_t place_count, uint32_t rays)
{
    const path_scene *scene = work->scene;
    for (size_t i = 0; i < scene->setup->source_count; ++i) {
        work->source = &scene->setup->sources[i];
        work->source_rays = work->source->radius > 0.0F ? rays : 1;
        for (work->source_ray = 0; work->source_ray < work->source_rays; ++work->source_ray) {
            threads_run(scene->threads, place_count, RAYS_PER_CHUNK, make_shadow_rays, work);
            const svo_status status = trace_rays(work, place_count, true);
            if (status != SVO_OK) {
                return status;
            }
            threads_run(scene->threads, place_count, RAYS_PER_CHUNK, add_light, work);
        }
    }
    return SVO_OK;
}

/* ---- means ---- */

/* The mean of the sets' means, and its standard error. */
static void average_sets(const double means[PATH_SETS], double *mean, double *error)
{
    double sum = 0;
    double squares = 0;
    for (unsigned set = 0; set < PATH_SETS; ++set) {
        sum += means[set] / PATH_SETS;
    }
    for (unsigned set = 0; set < PATH_SETS; ++set) {
        squares += (means[set] - sum) * (means[set] - sum);
    }
    *mean = sum;
    *error = sqrt(squares / (PATH_SETS - 1) / PATH_SETS);
}

static void sum_openness(void *user, unsigned thread_index, size_t begin, size_t end)
{
    const path_work *work = user;
    const unsigned per_set = work->per_point / PATH_SETS;
    const double range = work->scene->range > 0 ? work->scene->range : INFINITY;
    (void)thread_index;
    for (size_t point = begin; point < end; ++point) {
        double means[PATH_SETS] = {0};
        for (size_t i = 0; i < work->per_point; ++i) {
            const double t = (double)work->hits[point * work->per_point + i].t;
            const bool occludes = isfinite(t) && t < range;
            means[i / per_set] += (occludes ? 1 - 1 / (1 + work->scene->falloff * t) : 1) / per_set;
        }
        average_sets(means, &work->results[point].openness, &work->results[point].openness_error);
    }
}

static void sum_irradiance(void *user, unsigned thread_index, size_t begin, size_t end)
{
    const path_work *work = user;
    const unsigned per_set = work->per_point / PATH_SETS;
    (void)thread_index;
    for (size_t point = begin; point < end; ++point) {
        path_result *result = &work->results[point];
        for (size_t channel = 0; channel < 3; ++channel) {
            double means[PATH_SETS] = {0};
            for (size_t i = 0; i < work->per_point; ++i) {
                means[i / per_set] += PI * work->radiance[3 * (point * work->per_point + i) + channel] / per_set;
            }
            average_sets(means, &result->irradiance[channel], &result->irradiance_error[channel]);
        }
    }
}

static void take_direct(const path_work *work, size_t point_count)
{
    for (size_t i = 0; i < point_count; ++i) {
        work->results[i].is_gathered = is_there(&work->places[i]);
        memcpy(work->results[i].direct, work->radiance + 3 * i, sizeof work->results[i].direct);
    }
}

/* ---- groups ---- */

static svo_status trace_points(path_work *work, size_t point_count)
{
    take_points(work, point_count);
    const svo_status status = add_sources(work, point_count, SOURCE_STRATA * SOURCE_STRATA);
    take_direct(work, point_count);
    return status;
}

/* One ray of each path, and the light of what it met. */
static svo_status trace_bounce(path_work *work, size_t point_count)
{
    const path_scene *scene = work->scene;
    const size_t ray_count = point_count * work->per_point;
    threads_run(scene->threads, ray_count, RAYS_PER_CHUNK, make_rays, work);
    const svo_status status = trace_rays(work, ray_count, false);
    if (status != SVO_OK) {
        return status;
    }
    if (work->bounce == 0) {
        threads_run(scene->threads, point_count, 1, sum_openness, work);
    }
    threads_run(scene->threads, ray_count, RAYS_PER_CHUNK, find_places, work);
    return add_sources(work, ray_count, 1);
}

static svo_status trace_paths(path_work *work, size_t point_count)
{
    const path_scene *scene = work->scene;
    svo_status status = SVO_OK;
    for (work->bounce = 0; status == SVO_OK && work->bounce < (scene->bounces > 0 ? scene->bounces : 1);
         ++work->bounce) {
        status = trace_bounce(work, point_count);
    }
    threads_run(scene->threads, point_count, 1, sum_irradiance, work);
    return status;
}

/* Points first to first + count - 1 of the caller's. */
static svo_status trace_group(path_work *work, const svo_gather_point *points, size_t first, size_t count,
                              path_result *results)
{
    work->first_point = (uint32_t)first;
    work->points = points + first;
    work->results = results + first;
    const svo_status status = trace_points(work, count);
    if (status != SVO_OK) {
        return status;
    }
    return trace_paths(work, count);
}

static bool allocate(path_work *work, size_t ray_count)
{
    work->rays = calloc(ray_count, sizeof *work->rays);
    work->hits = calloc(ray_count, sizeof *work->hits);
    work->places = calloc(ray_count, sizeof *work->places);
    work->radiance = calloc(3 * ray_count, sizeof *work->radiance);
    if (work->is_clear) {
        work->passing = calloc(ray_count, sizeof *work->passing);
        work->passing_rays = calloc(ray_count, sizeof *work->passing_rays);
        work->passing_hits = calloc(ray_count, sizeof *work->passing_hits);
        work->pass = calloc(ray_count, sizeof *work->pass);
    }
    const bool has_passing =
        work->passing != NULL && work->passing_rays != NULL && work->passing_hits != NULL && work->pass != NULL;
    return work->rays != NULL && work->hits != NULL && work->places != NULL && work->radiance != NULL &&
           (has_passing || !work->is_clear);
}

static void release(path_work *work)
{
    free(work->rays);
    free(work->hits);
    free(work->passing);
    free(work->passing_rays);
    free(work->passing_hits);
    free(work->pass);
    free(work->places);
    free(work->radiance);
}

static unsigned strata_of(unsigned samples)
{
    const unsigned strata = (unsigned)sqrt((double)samples / PATH_SETS);
    return strata > 0 ? strata : 1;
}

unsigned path_sample_count(unsigned samples)
{
    return PATH_SETS * strata_of(samples) * strata_of(samples);
}

svo_status path_trace(const path_scene *scene, const svo_gather_point *points, size_t point_count, unsigned samples,
                      uint32_t seed, path_result *results)
{
    path_work work = {
        .scene = scene, .seed = seed, .strata = strata_of(samples), .per_point = path_sample_count(samples)};
    const size_t in_batch = work.per_point < BATCH_RAYS ? BATCH_RAYS / work.per_point : 1;
    const size_t group = point_count < in_batch ? point_count : in_batch;
    svo_status status = svo_tree_get_grid(scene->tree, &work.grid);
    if (status != SVO_OK || point_count == 0) {
        return status;
    }
    work.is_clear = path_is_clear(scene->mesh);
    work.lift = LIFT * svo_grid_cell_edge(&work.grid, 0);
    status = allocate(&work, group * work.per_point) ? SVO_OK : SVO_OUT_OF_HOST_MEMORY;
    size_t done = 0;
    while (status == SVO_OK && done < point_count) {
        const size_t left = point_count - done;
        const size_t count = left < group ? left : group;
        status = trace_group(&work, points, done, count, results);
        done += count;
    }
    release(&work);
    return status;
}
