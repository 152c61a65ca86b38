/* SPDX-License-Identifier: MIT */
/* Scenes for cones: triangles in a pose, gathering, and openness by exact rays. */
#include "cone_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>

#include "support/meshes.h"

#define PI 3.14159265358979323846

cone_scene *cone_scene_new(uint32_t depth, uint64_t seed)
{
    cone_scene *scene = calloc(1, sizeof *scene);
    assert_non_null(scene);
    scene->depth = depth;
    scene->seed = seed;
    cone_scene_pose(scene, false, 0);
    return scene;
}

void cone_scene_free(cone_scene *scene)
{
    free(scene);
}

void cone_scene_clear(cone_scene *scene)
{
    scene->triangle_count = 0;
    scene->point_count = 0;
}

/* ---- poses ---- */

/* A unit quaternion, evenly distributed. */
static void random_turn(uint64_t *seed, double q[4])
{
    double square;
    do {
        square = 0;
        for (int k = 0; k < 4; ++k) {
            q[k] = 2 * random_unit(seed) - 1;
            square += q[k] * q[k];
        }
    } while (square > 1 || square < 0.01);
    for (int k = 0; k < 4; ++k) {
        q[k] /= sqrt(square);
    }
}

void cone_scene_pose(cone_scene *scene, bool turned, double shift)
{
    double q[4] = {1, 0, 0, 0};
    if (turned) {
        random_turn(&scene->seed, q);
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const int k = (i + 2) % 3;
        const double *v = q + 1;
        scene->turn[4 * i] = 1 - 2 * (v[j] * v[j] + v[k] * v[k]);
        scene->turn[3 * i + j] = 2 * (v[i] * v[j] - q[0] * v[k]);
        scene->turn[3 * j + i] = 2 * (v[i] * v[j] + q[0] * v[k]);
        scene->center[i] = ldexp(0.5, (int)scene->depth) + shift * (2 * random_unit(&scene->seed) - 1);
    }
}

static void turn_vector(const cone_scene *scene, const double v[3], double out[3])
{
    for (int i = 0; i < 3; ++i) {
        const double *row = scene->turn + 3 * (size_t)i;
        out[i] = row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
    }
}

/* ---- shapes ---- */

static void add_triangle(cone_scene *scene, const double a[3], const double b[3], const double c[3])
{
    const double *corners[3] = {a, b, c};
    assert_true(scene->triangle_count < CONE_SCENE_TRIANGLES_MAX);
    float *to = scene->corners + 9 * scene->triangle_count++;
    for (int i = 0; i < 3; ++i) {
        double turned[3];
        turn_vector(scene, corners[i], turned);
        for (int k = 0; k < 3; ++k) {
            to[3 * i + k] = (float)(turned[k] + scene->center[k]);
        }
    }
}

void cone_scene_add_quad(cone_scene *scene, const double o[3], const double u[3], const double v[3])
{
    double corners[4][3];
    for (int k = 0; k < 3; ++k) {
        corners[0][k] = o[k];
        corners[1][k] = o[k] + u[k];
        corners[2][k] = o[k] + u[k] + v[k];
        corners[3][k] = o[k] + v[k];
    }
    add_triangle(scene, corners[0], corners[1], corners[2]);
    add_triangle(scene, corners[0], corners[2], corners[3]);
}

void cone_scene_add_disk(cone_scene *scene, const double center[3], double radius)
{
    enum { CORNERS = 64 };
    for (int k = 0; k < CORNERS; ++k) {
        const double a = 2 * PI * k / CORNERS;
        const double b = 2 * PI * (k + 1) / CORNERS;
        const double from[3] = {center[0] + radius * cos(a), center[1] + radius * sin(a), center[2]};
        const double to[3] = {center[0] + radius * cos(b), center[1] + radius * sin(b), center[2]};
        add_triangle(scene, center, to, from);
    }
}

static void sphere_corner(const double center[3], double radius, double polar, double around, double out[3])
{
    out[0] = center[0] + radius * sin(polar) * cos(around);
    out[1] = center[1] + radius * sin(polar) * sin(around);
    out[2] = center[2] + radius * cos(polar);
}

void cone_scene_add_sphere(cone_scene *scene, const double center[3], double radius)
{
    enum { RINGS = 24, CORNERS = 48 };
    for (int ring = 0; ring < RINGS; ++ring) {
        for (int k = 0; k < CORNERS; ++k) {
            double corners[4][3];
            for (int i = 0; i < 4; ++i) {
                sphere_corner(center, radius, PI * (ring + (i > 1)) / RINGS, 2 * PI * (k + i % 2) / CORNERS,
                              corners[i]);
            }
            add_triangle(scene, corners[0], corners[2], corners[3]);
            add_triangle(scene, corners[0], corners[3], corners[1]);
        }
    }
}

void cone_scene_add_room(cone_scene *scene, const double half[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3;
        const int last = (axis + 2) % 3;
        for (int side = -1; side <= 1; side += 2) {
            double u[3] = {0};
            double v[3] = {0};
            double o[3];
            o[axis] = side * half[axis];
            o[next] = -half[next];
            o[last] = -half[last];
            (side < 0 ? u : v)[next] = 2 * half[next];
            (side < 0 ? v : u)[last] = 2 * half[last];
            cone_scene_add_quad(scene, o, u, v);
        }
    }
}

void cone_scene_flip(cone_scene *scene)
{
    for (size_t i = 0; i < scene->triangle_count; ++i) {
        float *corners = scene->corners + 9 * i;
        for (int k = 0; k < 3; ++k) {
            const float kept = corners[3 + k];
            corners[3 + k] = corners[6 + k];
            corners[6 + k] = kept;
        }
    }
}

void cone_scene_add_point(cone_scene *scene, const double position[3], const double normal[3], double openness)
{
    double at[3];
    double towards[3];
    assert_true(scene->point_count < CONE_SCENE_POINTS_MAX);
    svo_gather_point *point = &scene->points[scene->point_count];
    turn_vector(scene, position, at);
    turn_vector(scene, normal, towards);
    memset(point, 0, sizeof *point);
    for (int k = 0; k < 3; ++k) {
        point->position[k] = (float)(at[k] + scene->center[k]);
        point->normal[k] = (float)towards[k];
    }
    scene->openness[scene->point_count++] = openness;
}

/* ---- gathering ---- */

/* mesh: without the triangles. */
static svo_tree *build(const fixture *opened, const cone_scene *scene, svo_mesh mesh, uint32_t need)
{
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    built made;
    mesh.positions = scene->corners;
    mesh.vertex_count = 3 * scene->triangle_count;
    mesh.triangle_count = scene->triangle_count;
    options.edge = ldexp(1, (int)scene->depth);
    options.need = need;
    fixture_build(opened, &mesh, scene->depth, &options, &made);
    svo_tree *tree = made.tree;
    made.tree = NULL;
    built_destroy(&made);
    return tree;
}

svo_tree *cone_scene_build(const fixture *opened, const cone_scene *scene, uint32_t need)
{
    return build(opened, scene, (svo_mesh)SVO_MESH_INIT, need);
}

svo_tree *cone_scene_build_colored(const fixture *opened, const cone_scene *scene, size_t plain,
                                   const uint8_t colors[2][4], uint32_t need)
{
    svo_material materials[2] = {{.texture_index = SVO_NO_TEXTURE}, {.texture_index = SVO_NO_TEXTURE}};
    uint16_t of_triangles[CONE_SCENE_TRIANGLES_MAX];
    svo_mesh mesh = SVO_MESH_INIT;
    for (size_t i = 0; i < scene->triangle_count; ++i) {
        of_triangles[i] = i < plain ? 0 : 1;
    }
    memcpy(materials[0].rgba, colors[0], sizeof materials[0].rgba);
    memcpy(materials[1].rgba, colors[1], sizeof materials[1].rgba);
    mesh.materials = materials;
    mesh.material_count = 2;
    mesh.triangle_materials = of_triangles;
    return build(opened, scene, mesh, need);
}

void cone_scene_gather(const fixture *opened, cone_scene *scene, svo_light *light, const svo_gather_options *options)
{
    static const svo_gather_options cones = {.struct_size = sizeof cones, .method = SVO_GATHER_CONES};
    light_succeed(opened, svo_gather(light, svo_in_host(scene->points), svo_in_host(scene->results), scene->point_count,
                                     options != NULL ? options : &cones, &(svo_submit){.queue = opened->queue}));
}

void cone_scene_gather_form(const fixture *opened, cone_scene *scene, svo_light_form form,
                            const svo_gather_options *options)
{
    svo_tree *tree = cone_scene_build(opened, scene, SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA);
    svo_light *light = light_of(opened, tree, form);
    cone_scene_gather(opened, scene, light, options);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
}

/* ---- the truth ---- */

/* Rays of a point, stratified over the disk below its hemisphere. */
static void make_rays(cone_scene *scene, const svo_gather_point *point, uint32_t side, svo_ray *rays)
{
    const float *n = point->normal;
    const int least = fabsf(n[0]) <= fabsf(n[1]) && fabsf(n[0]) <= fabsf(n[2]) ? 0 : fabsf(n[1]) <= fabsf(n[2]) ? 1 : 2;
    double t[3] = {0};
    double b[3];
    const double length = sqrt(1 - (double)n[least] * n[least]);
    t[(least + 1) % 3] = n[(least + 2) % 3] / length;
    t[(least + 2) % 3] = -n[(least + 1) % 3] / length;
    for (int k = 0; k < 3; ++k) {
        b[k] = n[(k + 1) % 3] * t[(k + 2) % 3] - n[(k + 2) % 3] * t[(k + 1) % 3];
    }
    for (uint32_t i = 0; i < side * side; ++i) {
        const uint32_t row = i / side;
        const double part = (row + random_unit(&scene->seed)) / side;
        const double turn = 2 * PI * (i % side + random_unit(&scene->seed)) / side;
        rays[i] = (svo_ray){.t_min = 1e-3F, .t_max = INFINITY};
        for (int k = 0; k < 3; ++k) {
            rays[i].origin[k] = point->position[k];
            rays[i].direction[k] = (float)(sqrt(part) * (cos(turn) * t[k] + sin(turn) * b[k]) + sqrt(1 - part) * n[k]);
        }
    }
}

void cone_scene_trace_openness(const fixture *opened, cone_scene *scene, uint32_t side)
{
    const size_t per_point = (size_t)side * side;
    const size_t count = per_point * scene->point_count;
    svo_ray *rays = malloc(count * sizeof *rays);
    svo_hit *hits = malloc(count * sizeof *hits);
    assert_non_null(rays);
    assert_non_null(hits);
    for (size_t i = 0; i < scene->point_count; ++i) {
        make_rays(scene, &scene->points[i], side, rays + i * per_point);
    }
    svo_tree *tree = cone_scene_build(opened, scene, SVO_NEED_RAYS);
    light_succeed(opened, svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits), count,
                                              SVO_TRACE_ANY, &(svo_submit){.queue = opened->queue}));
    for (size_t i = 0; i < scene->point_count; ++i) {
        size_t open = 0;
        for (size_t k = 0; k < per_point; ++k) {
            open += hits[i * per_point + k].triangle == SVO_NO_TRIANGLE;
        }
        scene->openness[i] = (double)open / (double)per_point;
    }
    svo_tree_destroy(&tree);
    free(rays);
    free(hits);
}

/* ---- errors ---- */

void cone_errors_add(cone_errors *errors, double difference)
{
    errors->square_sum += difference * difference;
    errors->sum += difference;
    errors->worst = fmax(errors->worst, fabs(difference));
    ++errors->count;
}

void cone_errors_add_scene(cone_errors *errors, const cone_scene *scene)
{
    for (size_t i = 0; i < scene->point_count; ++i) {
        cone_errors_add(errors, scene->results[i].openness - scene->openness[i]);
    }
}

double cone_errors_rms(const cone_errors *errors)
{
    return sqrt(errors->square_sum / (double)errors->count);
}

double cone_errors_mean(const cone_errors *errors)
{
    return errors->sum / (double)errors->count;
}
