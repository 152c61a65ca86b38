/* SPDX-License-Identifier: MIT */
/* Rays and exact cones have directions around the points' normals. */
#include "errors/cone_peers.h"

#include <math.h>
#include <stdlib.h>

#include "errors/hemisphere.h"
#include "support/input.h"

/* ---- few paths ---- */

bool few_paths_make(const error_run *run, const cone_truth *truth, svo_light *light, unsigned per_point, few_paths *out)
{
    *out = (few_paths){.run = run, .truth = truth, .light = light, .per_point = per_point};
    out->results = calloc(truth->count, sizeof *out->results);
    return out->results != NULL;
}

void few_paths_free(few_paths *work)
{
    free(work->results);
    work->results = NULL;
}

double few_paths_trace(void *user)
{
    const few_paths *work = user;
    const svo_gather_options asked = {.struct_size = sizeof asked, .method = SVO_GATHER_RAYS, .paths = work->per_point};
    const double started_ms = input_now_ms();
    const svo_status status = svo_gather(work->light, svo_in_host(work->truth->points), svo_in_host(work->results),
                                         work->truth->count, &asked, &(svo_submit){.queue = work->run->opened.queue});
    return status == SVO_OK ? input_now_ms() - started_ms : -1.0;
}

truth_error few_paths_error(const few_paths *work)
{
    double *irradiance = calloc(3 * work->truth->count, sizeof *irradiance);
    truth_error error = {NAN, NAN, NAN, NAN};
    for (size_t i = 0; i < 3 * work->truth->count && irradiance != NULL; ++i) {
        irradiance[i] = (double)work->results[i / 3].irradiance[i % 3];
    }
    if (irradiance != NULL) {
        error = cone_truth_irradiance_error(work->truth, irradiance);
    }
    free(irradiance);
    return error;
}

#define PI              3.14159265358979323846
#define GOLDEN_TURN     0.38196601125010515 /* of a circle: the golden angle */
#define RAYS_OF_CONE    64u
#define LIFT            0x1p-18 /* of origins above their surface, in widths of the grid */
#define POINTS_OF_BATCH 256u

/* ---- rays ---- */

bool occlusion_rays_make(const error_run *run, const cone_truth *truth, unsigned per_point, occlusion_rays *out)
{
    const hemisphere_set set = {.strata = (unsigned)sqrt((double)per_point),
                                .seed = per_point,
                                .lift = LIFT * truth->edge,
                                .length = truth->range};
    *out = (occlusion_rays){.run = run, .truth = truth, .per_point = set.strata * set.strata};
    out->rays = calloc(truth->count * out->per_point, sizeof *out->rays);
    out->hits = calloc(truth->count * out->per_point, sizeof *out->hits);
    if (out->rays == NULL || out->hits == NULL) {
        occlusion_rays_free(out);
        return false;
    }
    hemisphere_rays(&set, truth->points, truth->count, out->rays);
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
        return embree_trace(work->peer, EMBREE_OCCLUDED1, work->rays, work->hits, count, work->run->threads);
    }
    const double started_ms = input_now_ms();
    const svo_status status =
        svo_trace_triangles(svo_tree_target(work->truth->tree), svo_in_host(work->rays), svo_in_host(work->hits), count,
                            SVO_TRACE_ANY, &(svo_submit){.queue = work->run->opened.queue});
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
    return frame_direction(around, sqrt(1 - cosine * cosine), GOLDEN_TURN * index);
}

static void make_cone_rays(const cone_truth *truth, size_t first, size_t count, unsigned cones, svo_ray *rays)
{
    const hemisphere_set set = {.lift = LIFT * truth->edge, .length = truth->range};
    for (size_t i = 0; i < count * cones; ++i) {
        const svo_gather_point *point = &truth->points[first + i / cones];
        const exact_cone cone = cone_of_set(cones, (unsigned)(i % cones));
        const turned_frame frame = hemisphere_frame(point);
        const turned_frame around = frame_around(frame_direction(&frame, cone.sine, cone.turns));
        for (unsigned k = 0; k < RAYS_OF_CONE; ++k) {
            rays[i * RAYS_OF_CONE + k] = hemisphere_ray(&set, point, ray_of_cone(&around, cone.half_angle, k));
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
        worked =
            svo_trace_triangles(svo_tree_target(truth->tree), svo_in_host(rays), svo_in_host(hits), count * per_point,
                                SVO_TRACE_ANY, &(svo_submit){.queue = run->opened.queue}) == SVO_OK;
        sum_cones(hits, count, cones, openness + first);
    }
    free(rays);
    free(hits);
    return worked;
}
