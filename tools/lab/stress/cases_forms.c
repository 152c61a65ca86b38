/* SPDX-License-Identifier: MIT */
/* Cases with known results that need no reference: T2 closed forms, T5 the fragment estimate, T6 symmetry. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measure/tree_check.h"
#include "stress/cases.h"
#include "stress/stress.h"

static void expect_voxels(stress_case *one, uint64_t expected, uint64_t found, unsigned depth)
{
    one->figure += (double)expected;
    one->false_negatives += expected > found ? expected - found : 0;
    one->false_positives += found > expected ? found - expected : 0;
    if (expected != found) {
        stress_fail(one, "depth %u: %llu voxels instead of %llu", depth, (unsigned long long)found,
                    (unsigned long long)expected);
    }
}

/* Builds at depths 1 to 7 and compares the number of voxels. */
static void closed_form(stress *run, const char *name, const svo_mesh *mesh, uint64_t (*count_voxels)(uint64_t))
{
    stress_case one = stress_begin("T2 %s", name);
    one.unit = "voxels";
    for (unsigned depth = 1; depth <= stress_depth(run, 7, 3); ++depth) {
        const svo_plan_options plan_options = {.edge = TRIANGLE_SET_UNITS, .need = (uint32_t)SVO_NEED_NONE};
        stress_tree built;
        if (stress_build(run, NULL, mesh, depth, &plan_options, &one, &built)) {
            expect_voxels(&one, count_voxels(UINT64_C(1) << depth), built.info.leaf_count, depth);
            stress_tree_free(&built);
        }
    }
    stress_end(run, &one);
}

static uint64_t hull_voxels(uint64_t r)
{
    return 8 + 12 * (r - 2) + 6 * (r - 2) * (r - 2);
}

static uint64_t square_voxels(uint64_t r)
{
    return r * r;
}

static uint64_t one_voxel(uint64_t r)
{
    (void)r;
    return 1;
}

static void closed_forms(stress *run)
{
    static const double m = TRIANGLE_SET_UNITS - 1;
    static const double h = TRIANGLE_SET_UNITS / 2.0;
    const double cube[24] = {0, 0, 0, m, 0, 0, 0, m, 0, m, m, 0, 0, 0, m, m, 0, m, 0, m, m, m, m, m};
    static const uint32_t faces[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    const double quad[18] = {0, 0, h, m, 0, h, m, m, h, 0, 0, h, m, m, h, 0, m, h};
    const double point[9] = {7, 8, 9, 7, 8, 9, 7, 8, 9};
    const svo_mesh hull = {.struct_size = sizeof hull,
                           .positions_double = cube,
                           .vertex_count = 8,
                           .indices = faces,
                           .triangle_count = 12};
    const svo_mesh square = {
        .struct_size = sizeof square, .positions_double = quad, .vertex_count = 6, .triangle_count = 2};
    const svo_mesh dot = {.struct_size = sizeof dot, .positions_double = point, .vertex_count = 3, .triangle_count = 1};
    closed_form(run, "cube hull", &hull, hull_voxels);
    closed_form(run, "mid-plane", &square, square_voxels);
    closed_form(run, "point", &dot, one_voxel);
}

/* E[voxels] of one triangle over random offsets: 1 + (wx + wy + wz) / h + A (|nx| + |ny| + |nz|) / h^2. */
static double expected_voxels(const double corners[9], double voxel)
{
    double widths = 0.0;
    double areas = 0.0;
    for (int k = 0; k < 3; ++k) {
        const int u = (k + 1) % 3;
        const int v = (k + 2) % 3;
        widths += fmax(corners[k], fmax(corners[3 + k], corners[6 + k])) -
                  fmin(corners[k], fmin(corners[3 + k], corners[6 + k]));
        areas += fabs((corners[3 + u] - corners[u]) * (corners[6 + v] - corners[v]) -
                      (corners[3 + v] - corners[v]) * (corners[6 + u] - corners[u])) /
                 2.0;
    }
    return 1.0 + widths / voxel + areas / (voxel * voxel);
}

/* Deviation of the mean count per triangle from the estimate, in standard errors. */
static double standard_errors(const stress_tree *built, size_t triangle_count, double estimate)
{
    uint32_t *counts = calloc(triangle_count + 1, sizeof *counts);
    double mean = 0.0;
    double variance = 0.0;
    if (counts == NULL) {
        return INFINITY;
    }
    for (uint64_t i = 0; i < built->info.list_count; ++i) {
        ++counts[built->arrays.triangle_ids[built->arrays.list[i]]];
    }
    for (size_t t = 0; t < triangle_count; ++t) {
        mean += counts[t] / (double)triangle_count;
    }
    for (size_t t = 0; t < triangle_count; ++t) {
        variance += (counts[t] - mean) * (counts[t] - mean) / (double)(triangle_count - 1);
    }
    free(counts);
    return fabs(mean - estimate) / sqrt(variance / (double)triangle_count);
}

static void fragment_estimate(stress *run)
{
    static const double shape[9] = {0, 5000, 20000, 41000, 0, 33000, 17000, 52000, 0};
    stress_case one = stress_begin("T5 fragment estimate");
    one.unit = "standard errors";
    const size_t triangle_count = run->count < 8 ? stress_amount(run, 2500, 150) : 20000;
    const svo_plan_options plan_options = {.edge = TRIANGLE_SET_UNITS, .need = SVO_NEED_RAYS};
    random_stream random = {run->seed};
    triangle_set made;
    if (!triangle_set_empty(triangle_count, &made)) {
        run->failed = true;
        return;
    }
    for (size_t t = 0; t < triangle_count; ++t) {
        for (size_t k = 0; k < 3; ++k) {
            const double offset = random_index(&random, TRIANGLE_SET_UNITS - 65536); /* whole voxels */
            for (size_t i = k; i < 9; i += 3) {
                made.positions[t * 9 + i] = shape[i] + offset;
            }
        }
    }
    stress_tree built;
    if (stress_build(run, NULL, &made.mesh, 6, &plan_options, &one, &built)) {
        one.figure = standard_errors(&built, triangle_count, expected_voxels(shape, TRIANGLE_SET_UNITS / 64.0));
        if (!(one.figure <= 4.0)) {
            stress_fail(&one, "%.2f standard errors from the estimate, 4 are allowed", one.figure);
        }
        stress_tree_free(&built);
    }
    triangle_set_free(&made);
    stress_end(run, &one);
}

/* The image of axis k is axis (turn + k or - k) mod 3, mirrored where the bit of mirror says so. */
typedef struct symmetry {
    unsigned turn, flip, mirror;
} symmetry;

static unsigned image_axis(const symmetry *s, unsigned k)
{
    return s->flip != 0 ? (s->turn + 3 - k) % 3 : (s->turn + k) % 3;
}

static void apply(const symmetry *s, const double *from, double *to, size_t vertex_count)
{
    for (size_t i = 0; i < vertex_count * 3; ++i) {
        const double value = from[i];
        to[i / 3 * 3 + image_axis(s, (unsigned)(i % 3))] =
            (s->mirror >> i % 3 & 1) != 0 ? TRIANGLE_SET_UNITS - value : value;
    }
}

static void apply_to_pairs(const symmetry *s, oracle_pairs *pairs, unsigned depth)
{
    for (size_t i = 0; i < pairs->count; ++i) {
        oracle_box box;
        uint32_t voxel[3];
        oracle_voxel_box(pairs->pairs[i].code, depth, depth, &box);
        for (unsigned k = 0; k < 3; ++k) {
            const uint32_t at = (uint32_t)box.corner[k];
            voxel[image_axis(s, k)] = (s->mirror >> k & 1) != 0 ? (1u << depth) - 1 - at : at;
        }
        pairs->pairs[i].code = oracle_voxel_code(voxel[0], voxel[1], voxel[2], depth);
    }
}

static bool list_pairs(const stress_tree *built, stress_case *one, oracle_pairs *out)
{
    uint64_t empty_leaf_count = 0;
    const bool good = tree_check_list_pairs(&built->info, &built->arrays, out, &empty_leaf_count);
    if (!good || empty_leaf_count != 0) {
        stress_fail(one, "leaf lists are malformed");
    }
    return good;
}

static void compare_image(const symmetry *s, const stress_tree *original, const stress_tree *image, stress_case *one)
{
    oracle_pairs expected = {0};
    oracle_pairs actual = {0};
    oracle_difference difference = {0};
    if (list_pairs(original, one, &expected) && list_pairs(image, one, &actual)) {
        apply_to_pairs(s, &expected, original->info.depth);
        if (oracle_pairs_sort(expected.pairs, expected.count)) {
            oracle_compare(&expected, &actual, &difference);
        } else {
            stress_fail(one, "out of memory");
        }
    }
    one->false_negatives += difference.missed_pairs;
    one->false_positives += difference.surplus_pairs;
    one->figure += (double)expected.count;
    if (difference.missed_pairs != 0 || difference.surplus_pairs != 0) {
        stress_fail(one, "axes turned by %u, flipped %u, mirrored %u: a different set", s->turn, s->flip, s->mirror);
    }
    oracle_pairs_free(&expected);
    oracle_pairs_free(&actual);
}

/* Closed coverage of triangles with corners on voxel corners, under all 48 symmetries of the cube. With --count 0,
   under seven of them, which include every axis and rotation. */
static void symmetries(stress *run)
{
    stress_case one = stress_begin("T6 symmetries");
    const svo_plan_options plan_options = {
        .edge = TRIANGLE_SET_UNITS, .coverage = SVO_COVERAGE_CLOSED, .need = SVO_NEED_RAYS};
    triangle_set made;
    triangle_set image;
    stress_tree original;
    if (!triangle_set_create(TRIANGLES_LATTICE, run->seed, 10 + stress_amount(run, 10, 0), &made)) {
        run->failed = true;
        return;
    }
    if (!triangle_set_empty(made.mesh.triangle_count, &image)) {
        triangle_set_free(&made);
        run->failed = true;
        return;
    }
    const bool has_original =
        stress_build(run, NULL, &made.mesh, stress_depth(run, 6, 4), &plan_options, &one, &original);
    const unsigned step = run->count > 0 ? 1 : 7;
    for (unsigned i = 0; has_original && i < 48; i += step) {
        const symmetry s = {i % 3, i / 3 % 2, i / 6};
        stress_tree built;
        apply(&s, made.positions, image.positions, made.mesh.vertex_count);
        if (stress_build(run, NULL, &image.mesh, stress_depth(run, 6, 4), &plan_options, &one, &built)) {
            compare_image(&s, &original, &built, &one);
            stress_tree_free(&built);
        }
    }
    if (has_original) {
        stress_tree_free(&original);
    }
    triangle_set_free(&image);
    triangle_set_free(&made);
    stress_end(run, &one);
}

void stress_cases_forms(stress *run)
{
    closed_forms(run);
    fragment_estimate(run);
    symmetries(run);
}
