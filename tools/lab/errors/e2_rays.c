/* SPDX-License-Identifier: MIT */
/* E2: missed rays, wrong triangles and errors of t, for random and adversarial rays. */
#include "errors/subjects.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors/adversarial_rays.h"
#include "errors/ray_methods.h"
#include "measure/quantization.h"

#define UNIT       32.0 /* of coordinates, 0 .. 2^20 - 32: 15 bits, so that long double decides exactly */
#define GRID_EDGE  1048576.0
#define INPUT_RAYS 250000u /* of each kind against the input */
#define QUICK_RAYS 30000u
#define FULL_RAYS  200000u

/* The columns that both tables begin with. */
static void add_first_columns(result_table *table)
{
    result_add_column(table, "triangles", "");
    result_add_column(table, "rays", "");
    result_add_column(table, "method", "");
    result_add_column(table, "time", "ns/ray");
    result_add_column(table, "missed", "");
    result_add_column(table, "wrong", "");
}

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
    add_first_columns(table);
    result_add_column(table, "error", "%");
    result_add_column(table, "error of t, mean", "");
    result_add_column(table, "error of t, largest", "");
    return table;
}

static result_table *begin_input_table(error_run *run, size_t ray_count)
{
    result_table *table = result_add_table(run->results, "e2-input", "E2: rays and the input mesh", "");
    result_set_note(
        table,
        "%zu rays of each kind against the mesh as it was given, floats of 24 bits, by long double. Missed and wrong: "
        "as in the table above. Beyond: hits whose triangle the ray meets more than an ulp of float beyond the nearest "
        "one. Rounded: hits whose t is the exact one of their triangle, correctly rounded; error of t: the largest "
        "against it. %s; methods run interleaved.",
        ray_count, run->rounds_note);
    add_first_columns(table);
    result_add_column(table, "beyond", "");
    result_add_column(table, "rounded", "%");
    result_add_column(table, "error of t", "ulp");
    return table;
}

static void add_first_cells(result_table *table, size_t triangle_count, ray_target target, const ray_method_result *one)
{
    result_add_number(table, (double)triangle_count);
    result_add_text(table, "%s", ray_target_name(target));
    result_add_text(table, "%s", one->method);
    result_add_number(table, one->ms * 1e6 / (double)one->rays);
    result_add_number(table, (double)one->missed);
    result_add_number(table, (double)one->wrong);
}

static void add_input_row(result_table *table, size_t triangle_count, ray_target target, const ray_method_result *one)
{
    if (one->named == 0) { /* voxels alone */
        return;
    }
    add_first_cells(table, triangle_count, target, one);
    result_add_number(table, (double)one->beyond);
    result_add_number(table, 100.0 * (double)one->rounded / (double)one->named);
    result_add_number(table, one->ulps_max);
}

static void add_row(result_table *table, size_t triangle_count, ray_target target, const ray_method_result *one)
{
    add_first_cells(table, triangle_count, target, one);
    result_add_number(table, 100.0 * ray_method_error(one));
    result_add_number(table, one->t_error_mean);
    result_add_number(table, one->t_error_max);
}

/* What is measured: rays against a mesh, into the rows of a table. */
typedef struct ray_subject {
    const svo_mesh *mesh;
    double unit, edge; /* of quantized coordinates and their grid; 0: neither */
    svo_ray *rays;
    size_t ray_count;
    result_table *table;
    void (*add_row)(result_table *table, size_t triangle_count, ray_target target, const ray_method_result *one);
} ray_subject;

static int measure_mesh(error_run *run, const ray_subject *subject)
{
    int exit_code = PROGRAM_DONE;
    for (ray_target target = TARGET_RANDOM; target < TARGET_COUNT && exit_code == PROGRAM_DONE; ++target) {
        ray_method_result results[RAY_METHODS_MAX] = {0};
        size_t result_count = 0;
        ray_case given = {
            .mesh = subject->mesh, .edge = subject->edge, .rays = subject->rays, .ray_count = subject->ray_count};
        if (subject->unit > 0.0) {
            memcpy(given.levels, (const unsigned[]){6, 8, 10}, sizeof given.levels);
        }
        progress_step(run->state->progress, "E2: rays");
        adversarial_rays(subject->mesh, &(adversarial_set){.target = target, .unit = subject->unit}, subject->ray_count,
                         subject->rays);
        exit_code = ray_methods_measure(run, &given, results, &result_count);
        for (size_t i = 0; i < result_count && exit_code == PROGRAM_DONE; ++i) {
            subject->add_row(subject->table, subject->mesh->triangle_count, target, &results[i]);
        }
    }
    return exit_code;
}

static int measure_quantized(error_run *run, ray_subject *subject, const svo_mesh *given)
{
    float *positions = quantization_positions(given);
    int exit_code = PROGRAM_FAILED;
    for (size_t i = 0; positions != NULL && i < given->vertex_count * 3; ++i) {
        positions[i] = (float)(UNIT * floor((double)positions[i] / UNIT));
    }
    if (positions != NULL) {
        const svo_mesh mesh = quantization_mesh(given, positions);
        subject->mesh = &mesh;
        exit_code = measure_mesh(run, subject);
        subject->mesh = NULL;
    } else {
        errors_fail(run);
    }
    free(positions);
    return exit_code;
}

/* Every scene, its coordinates quantized if the subject says so. */
static int measure_scenes(error_run *run, ray_subject *subject)
{
    static const error_scene quick[] = {{"statue", "statue:4000"}, {"statue", "statue:40000"}, {NULL, NULL}};
    static const error_scene full[] = {
        {"statue", "statue:2000"}, {"statue", "statue:15000"}, {"statue", "statue:120000"}, {NULL, NULL}};
    const error_scene *own = run->quick ? quick : full;
    int exit_code = PROGRAM_DONE;
    error_scene given = errors_scene_at(run, own, 0);
    for (size_t i = 1; given.spec != NULL && exit_code == PROGRAM_DONE; given = errors_scene_at(run, own, i++)) {
        suite_input made = {.text = ""};
        exit_code = suite_open(run->state, given.spec, &made);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
        subject->mesh = made.source.mesh;
        exit_code =
            subject->unit > 0.0 ? measure_quantized(run, subject, made.source.mesh) : measure_mesh(run, subject);
        if (given.name == NULL) { /* rows name scenes by their triangles */
            result_extend_note(subject->table, "%s has %zu triangles.", suite_scene_name(&made.source),
                               made.source.mesh->triangle_count);
        }
        input_close(&made.source);
    }
    return exit_code;
}

static int measure(error_run *run)
{
    const size_t ray_count = run->quick ? QUICK_RAYS : FULL_RAYS;
    const size_t input_count = run->quick ? QUICK_RAYS : INPUT_RAYS;
    svo_ray *rays = calloc(INPUT_RAYS, sizeof *rays);
    ray_subject quantized = {.unit = UNIT, .edge = GRID_EDGE, .rays = rays, .ray_count = ray_count, .add_row = add_row};
    ray_subject raw = {.rays = rays, .ray_count = input_count, .add_row = add_input_row};
    int exit_code = rays != NULL ? PROGRAM_DONE : errors_fail(run);
    quantized.table = begin_table(run, ray_count);
    raw.table = begin_input_table(run, input_count);
    exit_code = exit_code == PROGRAM_DONE ? measure_scenes(run, &quantized) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? measure_scenes(run, &raw) : exit_code;
    free(rays);
    return exit_code;
}

static int run_all(suite *all)
{
    error_run run = errors_begin(all);
    return measure(&run);
}

const suite_subject errors_rays = {
    .words = &subject_table[SUBJECT_E2],
    .run_all = run_all,
    .takes_scenes = true,
    .step_count = 24,
};
