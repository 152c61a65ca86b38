/* SPDX-License-Identifier: MIT */
/* Directions of rays and cones around the points' normals. */
#include "errors/occlusion_rays.h"

#include <math.h>
#include <stdlib.h>

#include "scenes/maths.h"
#include "support/input.h"

#define PI              3.14159265358979323846
#define GOLDEN_TURN     0.38196601125010515 /* of a circle: the golden angle */
#define RAYS_OF_CONE    64u
#define LIFT            0x1p-18 /* of origins above their surface, in widths of the grid */
#define POINTS_OF_BATCH 256u

/* Around a normal. */
typedef struct turned_frame {
    vector3 side, other, normal;
} turned_frame;

static turned_frame frame_of(vector3 normal)
{
    const double x = fabs(normal.x);
    const double y = fabs(normal.y);
    const double z = fabs(normal.z);
    const vector3 axis = x <= y && x <= z ? vector(1, 0, 0) : y <= z ? vector(0, 1, 0) : vector(0, 0, 1);
    turned_frame frame = {.normal = normal};
    frame.side = vector_normalize(vector_cross(normal, axis));
    frame.other = vector_cross(normal, frame.side);
    return frame;
}

static vector3 normal_of(const svo_gather_point *point)
{
    return vector((double)point->normal[0], (double)point->normal[1], (double)point->normal[2]);
}

/* At a sine from the normal and a turn around it. */
static vector3 direction_at(const turned_frame *frame, double sine, double turns)
{
    const double along = sine * cos(2 * PI * turns);
    const double across = sine * sin(2 * PI * turns);
    return vector_add(vector_scale(frame->normal, sqrt(1 - sine * sine)),
                      vector_add(vector_scale(frame->side, along), vector_scale(frame->other, across)));
}

static svo_ray ray_of(const cone_truth *truth, const svo_gather_point *point, vector3 direction)
{
    const double lift = LIFT * truth->edge;
    svo_ray ray = {.t_min = 0, .t_max = (float)truth->range};
    for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = (float)((double)point->position[axis] + lift * (double)point->normal[axis]);
    }
    ray.direction[0] = (float)direction.x;
    ray.direction[1] = (float)direction.y;
    ray.direction[2] = (float)direction.z;
    return ray;
}

/* ---- rays ---- */

bool occlusion_rays_make(const error_run *run, const cone_truth *truth, unsigned per_point, occlusion_rays *out)
{
    const unsigned strata = (unsigned)sqrt((double)per_point);
    random_stream stream = {.state = per_point};
    *out = (occlusion_rays){.run = run, .truth = truth, .per_point = strata * strata};
    out->rays = calloc(truth->count * out->per_point, sizeof *out->rays);
    out->hits = calloc(truth->count * out->per_point, sizeof *out->hits);
    if (out->rays == NULL || out->hits == NULL) {
        occlusion_rays_free(out);
        return false;
    }
    for (size_t i = 0; i < truth->count * out->per_point; ++i) {
        const svo_gather_point *point = &truth->points[i / out->per_point];
        const unsigned stratum = (unsigned)(i % out->per_point);
        const turned_frame frame = frame_of(normal_of(point));
        const double squared = (stratum / strata + random_between(&stream, 0, 1)) / strata; /* NOLINT: a row */
        const double turns = (stratum % strata + random_between(&stream, 0, 1)) / strata;
        out->rays[i] = ray_of(truth, point, direction_at(&frame, sqrt(squared), turns));
    }
    return true;
}

void occlusion_rays_free(occlusion_rays *work)
{
    free(work->rays);
    free(work->hits);
    *work = (occlusion_rays){.per_point = 0};
}

double occlusion_rays_trace(void *user)
{
    const occlusion_rays *work = user;
    const size_t count = work->truth->count * work->per_point;
    if (work->peer != NULL) {
        return embree_occluded(work->peer, work->rays, work->hits, count, work->run->threads);
    }
    const double started_ms = input_now_ms();
    const svo_status status =
        svo_tree_trace(work->truth->tree, work->rays, work->hits, count, SVO_TRACE_ANY, work->run->opened.queue);
    return status == SVO_OK ? input_now_ms() - started_ms : -1.0;
}

void occlusion_rays_openness(const occlusion_rays *work, double *openness)
{
    for (size_t point = 0; point < work->truth->count; ++point) {
        unsigned open = 0;
        for (size_t i = 0; i < work->per_point; ++i) {
            open += work->hits[point * work->per_point + i].triangle == SVO_NO_TRIANGLE;
        }
        openness[point] = (double)open / work->per_point;
    }
}

/* ---- exact cones ---- */

typedef struct exact_cone {
    double sine; /* between the normal and its axis */
    double turns; /* around the normal */
    double half_angle;
    double weight;
} exact_cone;

/* The sets of cones of svo_gather_options.cones. */
static exact_cone cone_of_set(unsigned cones, unsigned index)
{
    if (cones == 1) {
        return (exact_cone){.half_angle = PI / 3, .weight = 1};
    }
    if (cones <= 6) {
        const unsigned around = cones - 1;
        return index == 0 ? (exact_cone){.half_angle = PI / 6, .weight = 0.25}
                          : (exact_cone){.sine = sin(PI / 3),
                                         .turns = (double)index / around,
                                         .half_angle = PI / 6,
                                         .weight = 0.75 / around};
    }
    return (exact_cone){.sine = sqrt((index + 0.5) / cones),
                        .turns = GOLDEN_TURN * index,
                        .half_angle = asin(1 / sqrt((double)cones)),
                        .weight = 1.0 / cones};
}

/* Evenly spread over the cone's solid angle: equal steps of the cosine along a golden spiral. */
static vector3 ray_of_cone(const turned_frame *around, double half_angle, unsigned index)
{
    const double cosine = 1 - (1 - cos(half_angle)) * (index + 0.5) / RAYS_OF_CONE;
    return direction_at(around, sqrt(1 - cosine * cosine), GOLDEN_TURN * index);
}

static void make_cone_rays(const cone_truth *truth, size_t first, size_t count, unsigned cones, svo_ray *rays)
{
    for (size_t i = 0; i < count * cones; ++i) {
        const svo_gather_point *point = &truth->points[first + i / cones];
        const exact_cone cone = cone_of_set(cones, (unsigned)(i % cones));
        const turned_frame frame = frame_of(normal_of(point));
        const turned_frame around = frame_of(direction_at(&frame, cone.sine, cone.turns));
        for (unsigned k = 0; k < RAYS_OF_CONE; ++k) {
            rays[i * RAYS_OF_CONE + k] = ray_of(truth, point, ray_of_cone(&around, cone.half_angle, k));
        }
    }
}

static void sum_cones(const svo_hit *hits, size_t count, unsigned cones, double *openness)
{
    for (size_t point = 0; point < count; ++point) {
        openness[point] = 1;
        for (size_t i = 0; i < (size_t)cones * RAYS_OF_CONE; ++i) {
            const bool met = hits[point * cones * RAYS_OF_CONE + i].triangle != SVO_NO_TRIANGLE;
            openness[point] -= met ? cone_of_set(cones, (unsigned)(i / RAYS_OF_CONE)).weight / RAYS_OF_CONE : 0;
        }
    }
}

bool occlusion_exact_cones(const error_run *run, const cone_truth *truth, unsigned cones, double *openness)
{
    const size_t per_point = (size_t)cones * RAYS_OF_CONE;
    svo_ray *rays = calloc(POINTS_OF_BATCH * per_point, sizeof *rays);
    svo_hit *hits = calloc(POINTS_OF_BATCH * per_point, sizeof *hits);
    bool worked = rays != NULL && hits != NULL;
    for (size_t first = 0; first < truth->count && worked; first += POINTS_OF_BATCH) {
        const size_t left = truth->count - first;
        const size_t count = left < POINTS_OF_BATCH ? left : POINTS_OF_BATCH;
        make_cone_rays(truth, first, count, cones, rays);
        worked = svo_tree_trace(truth->tree, rays, hits, count * per_point, SVO_TRACE_ANY, run->opened.queue) == SVO_OK;
        sum_cones(hits, count, cones, openness + first);
    }
    free(rays);
    free(hits);
    return worked;
}
