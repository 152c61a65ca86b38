/* SPDX-License-Identifier: MIT */
/*
 * E5: the methods of E1 and E2 on meshes that become ill-conditioned by one number, to find where each fails: thinner
 * triangles, farther from the origin, smaller in their grid. Coordinates are no multiples of powers of two, so that
 * float32 has to round.
 */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "errors/adversarial_rays.h"
#include "errors/ray_methods.h"
#include "errors/subjects.h"
#include "errors/voxel_methods.h"
#include "measure/triangle_sets.h"

/* ---- meshes ---- */

typedef enum conditioning {
    CONDITIONING_ASPECT = 0, /* longest edge over height */
    CONDITIONING_OFFSET, /* distance from the origin of coordinates over the mesh's width */
    /* width of the grid over that of a triangle; for rays: distance of their origins over the mesh's width */
    CONDITIONING_SCALE,
    CONDITIONING_COUNT
} conditioning;

#define SEED      UINT64_C(20260301)
#define UNIT_EDGE 0.31 /* of a triangle at scale ratio 1 */

static const char *conditioning_name(conditioning family)
{
    static const char *const names[CONDITIONING_COUNT] = {"aspect ratio", "offset from the origin", "scale ratio"};
    return names[family];
}

static double between(random_stream *random, double low, double high)
{
    return low + (high - low) * (double)(random_bits(random) >> 11) * 0x1p-53;
}

/* A segment of that length in a random direction, and a third vertex at that height over a point of it. */
static void make_triangle(random_stream *random, double length, double height, double corners[9])
{
    const vector3 along = random_direction(random);
    const vector3 other = random_direction(random);
    vector3 across = vector_cross(along, other);
    across = vector_scale(across, 1.0 / fmax(vector_length(across), 1e-9));
    const vector3 first =
        vector(between(random, UNIT_EDGE, 1.0 - UNIT_EDGE), between(random, UNIT_EDGE, 1.0 - UNIT_EDGE),
               between(random, UNIT_EDGE, 1.0 - UNIT_EDGE));
    const vector3 second = vector_add(first, vector_scale(along, length));
    const vector3 third =
        vector_add(vector_mix(first, second, between(random, 0.2, 0.8)), vector_scale(across, height));
    const vector3 all[3] = {first, second, third};
    for (size_t i = 0; i < 3; ++i) {
        corners[3 * i] = all[i].x;
        corners[3 * i + 1] = all[i].y;
        corners[3 * i + 2] = all[i].z;
    }
}

/* A triangle that is one corner of the unit cube: two of them fix the fitted grid, whatever the others are. */
static void pin_grid(double corner, double corners[9])
{
    for (int i = 0; i < 9; ++i) {
        corners[i] = corner;
    }
}

/* Triangles for voxelization, inside the unit cube or, for an offset, that far from it. triangle_count: at least 2.
   Returns false when out of memory. Released by triangle_set_free. */
static bool ill_conditioned_triangles(conditioning family, double value, size_t triangle_count, triangle_set *out)
{
    random_stream random = {SEED};
    if (!triangle_set_empty(triangle_count, out)) {
        return false;
    }
    const double length = family == CONDITIONING_SCALE ? UNIT_EDGE / value : UNIT_EDGE;
    const double height = family == CONDITIONING_ASPECT ? length / value : 0.6 * length;
    pin_grid(0.0, out->positions);
    pin_grid(1.0, out->positions + 9);
    for (size_t t = 2; t < triangle_count; ++t) {
        make_triangle(&random, length, height, out->positions + t * 9);
    }
    if (family == CONDITIONING_OFFSET) {
        triangle_set_move(out, 1.0, value);
    }
    return true;
}

/* A closed mesh's positions in double, flattened along y or moved along all axes. out: vertex_count * 3. */
static void ill_conditioned_positions(const svo_mesh *mesh, conditioning family, double value, double *out)
{
    double width = 0.0;
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        out[i] = (double)mesh->positions[i];
        width = fmax(width, fabs(out[i]));
    }
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        out[i] = out[i] / width / (family == CONDITIONING_ASPECT && i % 3 == 1 ? value : 1.0) +
                 (family == CONDITIONING_OFFSET ? value : 0.0);
    }
}

/* ---- the subject ---- */

#define VALUES_MAX 8u

static const double values[CONDITIONING_COUNT][VALUES_MAX] = {
    [CONDITIONING_ASPECT] = {1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6},
    [CONDITIONING_OFFSET] = {1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6},
    [CONDITIONING_SCALE] = {1.0, 1e1, 1e2, 1e3, 1e4},
};

static result_table *begin_table(error_run *run, size_t triangle_count, unsigned depth, size_t ray_count)
{
    result_table *table = result_add_table(run->results, "e5-conditioning", "E5: ill-conditioned meshes", "");
    result_set_note(
        table,
        "Voxelization: %zu randomly oriented triangles in a grid of %u³, as in E1. Rays: %zu rays at edges of a closed "
        "knot, from nearby, as in E2. Aspect ratio: longest edge of the triangles over their height; for rays the knot "
        "is flattened by this factor. Offset: distance of the mesh from the origin along all axes, in widths of the "
        "mesh; float32 methods and Embree get coordinates rounded to float32. Scale ratio: width of the grid over "
        "three edges of a triangle; for rays the distance of their origins in widths of the mesh. %s; methods run "
        "interleaved.",
        triangle_count, 1u << depth, ray_count, run->rounds_note);
    result_add_column(table, "problem", "");
    result_add_column(table, "conditioning", "");
    result_add_column(table, "value", "");
    result_add_column(table, "method", "");
    result_add_column(table, "time", "ms");
    result_add_column(table, "error", "%");
    return table;
}

static void add_row(result_table *table, const char *problem, conditioning family, double value, const char *method,
                    double ms, double error)
{
    result_add_text(table, "%s", problem);
    result_add_text(table, "%s", conditioning_name(family));
    result_add_number(table, value);
    result_add_text(table, "%s", method);
    result_add_number(table, ms);
    result_add_number(table, 100.0 * error);
}

static int measure_voxels(error_run *run, result_table *table, conditioning family, double value, size_t triangle_count,
                          unsigned depth)
{
    triangle_set made;
    if (!ill_conditioned_triangles(family, value, triangle_count, &made)) {
        return errors_fail(run);
    }
    voxel_method_result results[VOXEL_METHODS_MAX] = {0};
    size_t result_count = 0;
    const int exit_code = voxel_methods_measure(run, &made.mesh, depth, 0.0, results, &result_count);
    for (size_t i = 0; i < result_count && exit_code == PROGRAM_DONE; ++i) {
        add_row(table, "voxelization", family, value, results[i].method, results[i].ms,
                voxel_method_error(&results[i]));
    }
    triangle_set_free(&made);
    return exit_code;
}

/* Rays against a mesh. */
typedef struct ray_problem {
    const char *name; /* in the table */
    const svo_mesh *mesh;
    conditioning family;
    double value;
    size_t ray_count;
} ray_problem;

static int measure_rays(error_run *run, result_table *table, const ray_problem *problem)
{
    const svo_mesh *given_mesh = problem->mesh;
    const conditioning family = problem->family;
    const double value = problem->value;
    const size_t ray_count = problem->ray_count;
    svo_ray *rays = calloc(ray_count, sizeof *rays);
    double *positions = calloc(given_mesh->vertex_count * 3 + 1, sizeof *positions);
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions_double = positions,
                           .vertex_count = given_mesh->vertex_count,
                           .indices = given_mesh->indices,
                           .triangle_count = given_mesh->triangle_count};
    const adversarial_set set = {.target = TARGET_EDGES, .reach = family == CONDITIONING_SCALE ? value : 0.0};
    const ray_case given = {.mesh = &mesh, .rays = rays, .ray_count = ray_count};
    ray_method_result results[RAY_METHODS_MAX] = {0};
    size_t result_count = 0;
    int exit_code = PROGRAM_DONE;
    if (rays == NULL || positions == NULL) {
        exit_code = errors_fail(run);
        goto cleanup;
    }
    ill_conditioned_positions(given_mesh, family, value, positions);
    adversarial_rays(&mesh, &set, ray_count, rays);
    exit_code = ray_methods_measure(run, &given, results, &result_count);
    for (size_t i = 0; i < result_count && exit_code == PROGRAM_DONE; ++i) {
        add_row(table, problem->name, family, value, results[i].method, results[i].ms, ray_method_error(&results[i]));
    }
cleanup:
    free(positions);
    free(rays);
    return exit_code;
}

/* Rays against a mesh that becomes ill-conditioned in each way. */
static int measure_scene(error_run *run, result_table *table, const error_scene *given, size_t ray_count)
{
    suite_input made = {.text = ""};
    int exit_code = suite_open(run->state, given->spec, &made);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    char problem[512] = "rays";
    if (run->scenes[0] != NULL) {
        (void)snprintf(problem, sizeof problem, "rays, %s", suite_scene_name(&made.source));
    }
    for (int family = 0; family < CONDITIONING_COUNT && exit_code == PROGRAM_DONE; ++family) {
        progress_step(run->state->progress, "E5: ill-conditioned meshes");
        for (size_t i = 0; i < VALUES_MAX && values[family][i] > 0.0 && exit_code == PROGRAM_DONE; ++i) {
            const ray_problem one = {problem, made.source.mesh, (conditioning)family, values[family][i], ray_count};
            exit_code = measure_rays(run, table, &one);
        }
    }
    input_close(&made.source);
    return exit_code;
}

static int measure(error_run *run)
{
    const size_t triangle_count = run->quick ? 200 : 400;
    const size_t ray_count = run->quick ? 5000 : 20000;
    const unsigned depth = run->quick ? 6 : 7;
    result_table *table = begin_table(run, triangle_count, depth, ray_count);
    static const error_scene own[] = {{NULL, "knot:4000"}, {NULL, NULL}};
    int exit_code = PROGRAM_DONE;
    for (int family = 0; family < CONDITIONING_COUNT && exit_code == PROGRAM_DONE; ++family) {
        progress_step(run->state->progress, "E5: ill-conditioned meshes");
        for (size_t i = 0; i < VALUES_MAX && values[family][i] > 0.0 && exit_code == PROGRAM_DONE; ++i) {
            exit_code = measure_voxels(run, table, (conditioning)family, values[family][i], triangle_count, depth);
        }
    }
    error_scene given = errors_scene_at(run, own, 0);
    for (size_t i = 1; given.spec != NULL && exit_code == PROGRAM_DONE; given = errors_scene_at(run, own, i++)) {
        exit_code = measure_scene(run, table, &given, ray_count);
    }
    return exit_code;
}

static int run_all(suite *all)
{
    error_run run = errors_begin(all);
    return measure(&run);
}

const suite_subject errors_conditioning = {
    .words = &subject_table[SUBJECT_E5],
    .run_all = run_all,
    .takes_scenes = true,
    .step_count = 6,
};
