/* SPDX-License-Identifier: MIT */
/*
 * Chooses default lights: camera rays find points in view, and rays from these to candidate suns tell which of them
 * would shine there. The sun behind the camera shows shapes best and stays where it does its part.
 */
#include "support/default_lights.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/info_of.h"
#include "support/query_table.h"
#include "support/viewpoint.h"

/* Camera rays along the picture's longer side. */
#define SIDE       24u
#define POINTS_MAX ((size_t)SIDE * SIDE)
/* Candidates: behind the camera, above the horizon, and as many below it. */
#define HIGH_SUNS 32u
#define SUNS      (1 + 2 * HIGH_SUNS)
/* Triangles that shine: rays are sent to so many. */
#define EMITTERS_MAX 16u
/* The sine of the height of the lowest candidate. */
#define LOWEST 0.15
/* Radians from one candidate to the next: the golden angle, H. Vogel, 1979. */
#define TURN 2.399963229728653
/* A room is closed where no sun lights more than this of what is in view, less than that of the picture is sky, and
   less than that of the ways from what is in view leads outside: cracks let some through. */
#define LIT_SHARE  0.01
#define SKY_SHARE  0.02
#define OPEN_SHARE 0.005
/* Of what the best sun lights: the one behind the camera stays if it lights so much. */
#define FAIR_SHARE (1.0 / 3)
/* Widths of the grid from a triangle to where rays to lights begin; of voxels it is a leaf's width. */
#define LIFT 1e-5

const float default_lights_sky[3] = {0.42F, 0.52F, 0.66F};
static const float sun_value[3] = {3.0F, 2.8F, 2.5F};

/* A point in view. */
typedef struct seen_point {
    float position[3]; /* a little above the surface */
    float normal[3]; /* unit, to the camera's side */
} seen_point;

/* A direction that the sun may shine from. */
typedef struct sun_candidate {
    float towards[3]; /* unit */
    double share; /* mean cosine over what is in view, 0 where something is between */
} sun_candidate;

typedef struct choosing {
    program *state;
    const job *done;
    bool has_triangles; /* rays meet those, else voxels */
    double lift; /* world units from a surface to where rays to lights begin */
    svo_ray rays[POINTS_MAX * SUNS];
    svo_hit hits[POINTS_MAX * SUNS];
    seen_point points[POINTS_MAX];
    size_t point_count;
    double distance; /* mean, of the points from the camera */
    double sky_share; /* of the picture */
    double open_share; /* of the ways to candidates */
    sun_candidate suns[SUNS];
} choosing;

_Static_assert(sizeof(svo_voxel_hit) == sizeof(svo_hit) && offsetof(svo_voxel_hit, t) == offsetof(svo_hit, t) &&
                   offsetof(svo_voxel_hit, normal) == offsetof(svo_hit, normal),
               "what is read of hits has one place");

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* ---- rays ---- */

/* Traces the first rays. of_any: whether there is a hit is all that is asked. */
static int trace(choosing *work, size_t count, bool of_any)
{
    const session *opened = &work->done->opened;
    const svo_target tree = svo_tree_target(work->done->result.tree);
    const svo_submit submit = {.queue = opened->queue};
    /* Hits of voxels have distance and normal where those of triangles have them. */
    const svo_status status =
        work->has_triangles
            ? svo_trace_triangles(tree, svo_in_host(work->rays), svo_in_host(work->hits), count,
                                  of_any ? (uint32_t)SVO_TRACE_ANY : (uint32_t)SVO_TRACE_CLOSEST, &submit)
            : svo_trace_voxels(tree, svo_in_host(work->rays), svo_in_host(work->hits), count, 0, 0, &submit);
    return status == SVO_OK ? PROGRAM_DONE : program_fail_library(work->state, svo_device_message(opened->device));
}

/* ---- what is in view ---- */

static void see(choosing *work, const svo_ray *ray, const svo_hit *hit)
{
    const float side = dot(hit->normal, ray->direction) > 0 ? -1 : 1;
    if (!isfinite(hit->t) || !(dot(hit->normal, hit->normal) > 0)) {
        return; /* a miss, or the eye is inside a voxel */
    }
    seen_point *point = &work->points[work->point_count++];
    for (int axis = 0; axis < 3; ++axis) {
        point->normal[axis] = side * hit->normal[axis];
        point->position[axis] =
            ray->origin[axis] + hit->t * ray->direction[axis] + (float)work->lift * point->normal[axis];
    }
    work->distance += (double)(hit->t * sqrtf(dot(ray->direction, ray->direction)));
}

static int look(choosing *work, const svo_camera *camera, uint32_t width, uint32_t height)
{
    uint32_t columns = width;
    uint32_t rows = height;
    size_t misses = 0;
    ray_table table;
    viewpoint_shrink(SIDE, &columns, &rows);
    int exit_code = ray_table_from_camera(work->state, camera, columns, rows, NULL, &table);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    memcpy(work->rays, table.rays, table.count * sizeof *table.rays);
    exit_code = trace(work, table.count, false);
    for (size_t i = 0; i < table.count && exit_code == PROGRAM_DONE; ++i) {
        misses += isfinite(work->hits[i].t) ? 0 : 1;
        see(work, &work->rays[i], &work->hits[i]);
    }
    work->sky_share = (double)misses / (double)table.count;
    work->distance /= work->point_count > 0 ? (double)work->point_count : 1;
    ray_table_free(&table);
    return exit_code;
}

/* ---- suns ---- */

/* High over the right shoulder of the viewer. */
static svo_light_source sun_behind(const svo_camera *camera)
{
    float away[3];
    svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL};
    float length = 0;
    for (int axis = 0; axis < 3; ++axis) {
        away[axis] = camera->target[axis] - camera->eye[axis];
        length += away[axis] * away[axis];
    }
    length = sqrtf(length);
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3;
        const int last = (axis + 2) % 3;
        const float right = away[next] * camera->up[last] - away[last] * camera->up[next];
        sun.direction[axis] = 0.38F * away[axis] - 0.5F * right - 0.85F * length * camera->up[axis];
        sun.value[axis] = sun_value[axis];
    }
    return sun;
}

/* A candidate of a spiral around the camera's up. side: 1 above the horizon, -1 below. */
static void place_sun(const svo_camera *camera, unsigned index, double side, float towards[3])
{
    const camera_axes axes = ray_table_axes(camera);
    const double height = 1 - (1 - LOWEST) * (index + 0.5) / HIGH_SUNS;
    const double across = sqrt(1 - height * height);
    double up_length = 0;
    for (int axis = 0; axis < 3; ++axis) {
        up_length = hypot(up_length, (double)camera->up[axis]);
    }
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3;
        const int last = (axis + 2) % 3;
        const double up = (double)camera->up[axis] / up_length;
        const double forward =
            ((double)camera->up[next] * axes.right[last] - (double)camera->up[last] * axes.right[next]) / up_length;
        towards[axis] =
            (float)(side * height * up + across * (cos(TURN * index) * forward + sin(TURN * index) * axes.right[axis]));
    }
}

static void place_suns(choosing *work, const svo_camera *camera)
{
    const svo_light_source behind = sun_behind(camera);
    const float length = sqrtf(dot(behind.direction, behind.direction));
    for (int axis = 0; axis < 3; ++axis) {
        work->suns[0].towards[axis] = -behind.direction[axis] / length;
    }
    for (unsigned i = 0; i < HIGH_SUNS; ++i) {
        place_sun(camera, i, 1, work->suns[1 + i].towards);
        place_sun(camera, i, -1, work->suns[1 + HIGH_SUNS + i].towards);
    }
}

/* Begins a ray from a point; t_max in lengths of direction. */
static svo_ray ray_from(const seen_point *point, const float direction[3], float t_max)
{
    svo_ray ray = {.t_min = 0, .t_max = t_max};
    memcpy(ray.origin, point->position, sizeof ray.origin);
    memcpy(ray.direction, direction, sizeof ray.direction);
    return ray;
}

/* Finds what each candidate lights. */
static int try_suns(choosing *work)
{
    size_t open = 0;
    size_t ways = 0;
    for (size_t i = 0; i < work->point_count * SUNS; ++i) {
        work->rays[i] = ray_from(&work->points[i / SUNS], work->suns[i % SUNS].towards, INFINITY);
    }
    const int exit_code = trace(work, work->point_count * SUNS, true);
    for (size_t i = 0; i < work->point_count * SUNS && exit_code == PROGRAM_DONE; ++i) {
        const float cosine = dot(work->points[i / SUNS].normal, work->suns[i % SUNS].towards);
        const bool is_open = cosine > 0 && !isfinite(work->hits[i].t);
        ways += cosine > 0 ? 1 : 0;
        open += is_open ? 1 : 0;
        work->suns[i % SUNS].share += is_open ? (double)cosine / (double)work->point_count : 0;
    }
    work->open_share = ways > 0 ? (double)open / (double)ways : 0;
    return exit_code;
}

/* The candidate that lights most; one below the horizon only where none above it lights anything. */
static const sun_candidate *best_sun(const choosing *work)
{
    const sun_candidate *best = &work->suns[0];
    for (unsigned i = 1; i < SUNS && (i <= HIGH_SUNS || best->share < LIT_SHARE); ++i) {
        best = work->suns[i].share > best->share ? &work->suns[i] : best;
    }
    return best;
}

/* ---- what shines in a closed room ---- */

static bool shines(const svo_mesh *mesh, size_t triangle)
{
    const size_t material = mesh->triangle_materials != NULL ? mesh->triangle_materials[triangle] : 0;
    const float *emission = mesh->finishes[material < mesh->material_count ? material : 0].emission;
    return emission[0] > 0 || emission[1] > 0 || emission[2] > 0;
}

static void middle_of(const svo_mesh *mesh, size_t triangle, float middle[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        double sum = 0;
        for (size_t corner = 0; corner < 3; ++corner) {
            const size_t at = 3 * triangle + corner;
            const size_t place = 3 * (mesh->indices != NULL ? (size_t)mesh->indices[at] : at) + (size_t)axis;
            sum += mesh->positions != NULL ? (double)mesh->positions[place] : mesh->positions_double[place];
        }
        middle[axis] = (float)(sum / 3);
    }
}

/* Some of the triangles that shine, spread over all of them. Returns how many. */
static size_t find_emitters(const svo_mesh *mesh, float middles[EMITTERS_MAX][3])
{
    size_t shining = 0;
    size_t passed = 0;
    size_t count = 0;
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        shining += shines(mesh, i) ? 1 : 0;
    }
    for (size_t i = 0; i < mesh->triangle_count && shining > 0; ++i) {
        if (shines(mesh, i) && passed++ >= count * shining / EMITTERS_MAX && count < EMITTERS_MAX) {
            middle_of(mesh, i, middles[count++]);
        }
    }
    return count;
}

/* Whether triangles that shine light what is in view. */
static int try_emitters(choosing *work, bool *lit)
{
    float middles[EMITTERS_MAX][3];
    const svo_mesh *mesh = work->done->source.mesh;
    const size_t emitters =
        mesh != NULL && mesh->finishes != NULL && mesh->material_count > 0 ? find_emitters(mesh, middles) : 0;
    size_t reached = 0;
    *lit = false;
    if (emitters == 0) {
        return PROGRAM_DONE;
    }
    for (size_t i = 0; i < work->point_count * emitters; ++i) {
        const seen_point *point = &work->points[i / emitters];
        float way[3];
        for (int axis = 0; axis < 3; ++axis) {
            way[axis] = middles[i % emitters][axis] - point->position[axis];
        }
        work->rays[i] = ray_from(point, way, 1 - 2 * (float)work->lift / sqrtf(dot(way, way)));
    }
    const int exit_code = trace(work, work->point_count * emitters, true);
    for (size_t i = 0; i < work->point_count * emitters && exit_code == PROGRAM_DONE; ++i) {
        const bool faces = dot(work->points[i / emitters].normal, work->rays[i].direction) > 0;
        reached += faces && !isfinite(work->hits[i].t) ? 1 : 0;
    }
    *lit = (double)reached > LIT_SHARE * (double)(work->point_count * emitters);
    return exit_code;
}

/* ---- the choice ---- */

static bool is_closed(const choosing *work)
{
    return work->point_count > 0 && best_sun(work)->share < LIT_SHARE && work->sky_share < SKY_SHARE &&
           work->open_share < OPEN_SHARE;
}

/* A lamp at the camera: at the mean distance of what is in view it is as bright as a sun. */
static svo_light_source lamp_at(const svo_camera *camera, double distance)
{
    svo_light_source lamp = {.kind = SVO_SOURCE_POINT};
    for (int axis = 0; axis < 3; ++axis) {
        lamp.position[axis] = camera->eye[axis];
        lamp.value[axis] = (float)((double)sun_value[axis] * distance * distance);
    }
    return lamp;
}

static int choose_in_closed(choosing *work, const svo_camera *camera, default_lights *out)
{
    bool lit = false; /* by what shines there, which is no light of the direct view */
    const int exit_code = work->state->options.view != (int)SVO_VIEW_DIRECT ? try_emitters(work, &lit) : PROGRAM_DONE;
    out->kind = lit ? DEFAULT_LIGHT_EMITTERS : DEFAULT_LIGHT_LAMP;
    out->source_count = lit ? 0 : 1;
    out->source = lamp_at(camera, work->distance);
    return exit_code;
}

static void choose_sun(const choosing *work, default_lights *out)
{
    const sun_candidate *best = best_sun(work);
    if (work->suns[0].share >= FAIR_SHARE * best->share) {
        return;
    }
    out->kind = DEFAULT_LIGHT_SUN_ELSEWHERE;
    for (int axis = 0; axis < 3; ++axis) {
        out->source.direction[axis] = -best->towards[axis];
    }
}

static int choose(choosing *work, const svo_camera *camera, uint32_t width, uint32_t height, default_lights *out)
{
    const svo_tree_info info = info_of_tree(work->done->result.tree);
    work->has_triangles = (info.need & (uint32_t)SVO_NEED_RAYS) != 0 && info.coverage != (uint32_t)SVO_COVERAGE_THIN;
    work->lift = work->has_triangles ? LIFT * info.edge : info.edge / (double)(1u << info.depth);
    int exit_code = look(work, camera, width, height);
    if (exit_code == PROGRAM_DONE && work->point_count > 0) {
        place_suns(work, camera);
        exit_code = try_suns(work);
    }
    if (exit_code == PROGRAM_DONE && is_closed(work)) {
        exit_code = choose_in_closed(work, camera, out);
    } else if (exit_code == PROGRAM_DONE) {
        choose_sun(work, out);
    }
    return exit_code;
}

int default_lights_choose(program *state, const job *done, const svo_camera *camera, uint32_t width, uint32_t height,
                          default_lights *out)
{
    *out = (default_lights){.kind = DEFAULT_LIGHT_SUN_BEHIND, .source = sun_behind(camera), .source_count = 1};
    choosing *work = calloc(1, sizeof *work);
    if (work == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for rays to the sun");
    }
    work->state = state;
    work->done = done;
    const int exit_code = choose(work, camera, width, height, out);
    free(work);
    return exit_code;
}

/* ---- reports ---- */

const char *default_lights_name(default_light kind)
{
    static const char *const names[] = {"", "sun behind the camera", "sun", "emitters", "lamp"};
    return names[kind];
}

default_lights_words default_lights_describe(const default_lights *chosen)
{
    static const char *const words[] = {"", "lit by a sun behind the camera and a sky", "",
                                        "the scene is closed: lit by what shines in it",
                                        "the scene is closed: lit by a lamp at the camera; --lights FILE sets others"};
    default_lights_words described;
    const float *along = chosen->source.direction;
    (void)snprintf(described.text, sizeof described.text, "%s", words[chosen->kind]);
    if (chosen->kind == DEFAULT_LIGHT_SUN_ELSEWHERE) {
        (void)snprintf(
            described.text, sizeof described.text,
            "lit by a sun along %.3g,%.3g,%.3g and a sky: one behind the camera hardly reaches what is in view",
            (double)along[0], (double)along[1], (double)along[2]);
    }
    return described;
}
