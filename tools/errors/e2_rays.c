/* SPDX-License-Identifier: MIT */
/* E2: missed rays, wrong triangles and errors of t, for random and adversarial rays. */
#include "errors/e2_rays.h"

#include <math.h>
#include <stdlib.h>

#include "errors/adversarial_rays.h"
#include "errors/ray_methods.h"
#include "measure/quantization.h"

#define UNIT       32.0 /* of coordinates, 0 .. 2^20 - 32: 15 bits, so that long double decides exactly */
#define GRID_EDGE  1048576.0
#define QUICK_RAYS 30000u
#define FULL_RAYS  200000u

static result_table *begin_table(error_run *run, size_t ray_count)
{
    result_table *table = result_add_table(run->results, "e2-rays", "E2: rays", "");
    result_set_note(
        table,
        "%zu rays of each kind against the same triangles. Coordinates and origins are 15-bit integers, exact in "
        "float32, and adversarial rays pass through their vertex or edge exactly: long double decides the first hit "
        "without rounding. Wrong: another triangle at another t, or a false hit. Error of t: |t - exact| / exact over "
        "correct hits. svocl and \"voxels alone\" run on the OpenCL device. The float32 tests run on %u host threads "
        "in one BVH with conservative bounds, so that they differ in the test only; Embree runs on as many threads. "
        "\"Voxels alone\" stops at the first leaf of depth 6, 8 or 10 and reports no triangle. %s; methods run "
        "interleaved.",
        ray_count, run->threads, run->rounds_note);
    result_add_column(table, "triangles", "");
    result_add_column(table, "rays", "");
    result_add_column(table, "method", "");
    result_add_column(table, "time", "ns/ray");
    result_add_column(table, "missed", "");
    result_add_column(table, "wrong", "");
    result_add_column(table, "error", "%");
    result_add_column(table, "error of t, mean", "");
    result_add_column(table, "error of t, largest", "");
    return table;
}

static void add_row(result_table *table, size_t triangle_count, ray_target target, const ray_method_result *one)
{
    result_add_number(table, (double)triangle_count);
    result_add_text(table, "%s", ray_target_name(target));
    result_add_text(table, "%s", one->method);
    result_add_number(table, one->ms * 1e6 / (double)one->rays);
    result_add_number(table, (double)one->missed);
    result_add_number(table, (double)one->wrong);
    result_add_number(table, 100.0 * ray_method_error(one));
    result_add_number(table, one->t_error_mean);
    result_add_number(table, one->t_error_max);
}

static int measure_mesh(error_run *run, result_table *table, const svo_mesh *mesh, svo_ray *rays, size_t ray_count)
{
    int exit_code = PROGRAM_DONE;
    for (ray_target target = TARGET_RANDOM; target < TARGET_COUNT && exit_code == PROGRAM_DONE; ++target) {
        ray_method_result results[RAY_METHODS_MAX] = {0};
        size_t result_count = 0;
        const ray_case given = {
            .mesh = mesh, .edge = GRID_EDGE, .rays = rays, .ray_count = ray_count, .levels = {6, 8, 10}};
        progress_step(run->state->progress, "E2: rays");
        adversarial_rays(mesh, &(adversarial_set){.target = target, .unit = UNIT}, ray_count, rays);
        exit_code = ray_methods_measure(run, &given, results, &result_count);
        for (size_t i = 0; i < result_count && exit_code == PROGRAM_DONE; ++i) {
            add_row(table, mesh->triangle_count, target, &results[i]);
        }
    }
    return exit_code;
}

static int measure_scene(error_run *run, result_table *table, const char *spec, svo_ray *rays, size_t ray_count)
{
    scene *made = errors_scene(run, spec);
    if (made == NULL) {
        return PROGRAM_FAILED;
    }
    float *positions = quantization_positions(scene_mesh(made));
    int exit_code = PROGRAM_FAILED;
    for (size_t i = 0; positions != NULL && i < scene_mesh(made)->vertex_count * 3; ++i) {
        positions[i] = (float)(UNIT * floor((double)positions[i] / UNIT));
    }
    if (positions != NULL) {
        const svo_mesh mesh = quantization_mesh(scene_mesh(made), positions);
        exit_code = measure_mesh(run, table, &mesh, rays, ray_count);
    } else {
        errors_fail(run);
    }
    free(positions);
    scene_destroy(&made);
    return exit_code;
}

static int measure(error_run *run)
{
    static const char *const quick[] = {"statue:4000", "statue:40000", NULL};
    static const char *const full[] = {"statue:2000", "statue:15000", "statue:120000", NULL};
    const char *const *specs = run->quick ? quick : full;
    const size_t ray_count = run->quick ? QUICK_RAYS : FULL_RAYS;
    result_table *table = begin_table(run, ray_count);
    svo_ray *rays = calloc(ray_count, sizeof *rays);
    int exit_code = rays != NULL ? PROGRAM_DONE : errors_fail(run);
    for (size_t i = 0; specs[i] != NULL && exit_code == PROGRAM_DONE; ++i) {
        exit_code = measure_scene(run, table, specs[i], rays, ray_count);
    }
    free(rays);
    return exit_code;
}

static int run_all(suite *all)
{
    error_run run = errors_begin(all);
    return measure(&run);
}

const suite_subject errors_rays = {
    .name = "e2",
    .group = "errors",
    .summary = "error and run time of ray tracing: missed and wrong rays of each ray-triangle test",
    .run_all = run_all,
    .step_count = 12,
};
