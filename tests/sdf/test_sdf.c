/* SPDX-License-Identifier: MIT */
/*
 * Signed distance fields: every distance within an ulp of that to the nearest of all triangles, by brute force in long
 * doubles; every sign that of the winding number, by solid angles; bands that are parts of the dense field; and the
 * trees and arguments that are refused.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/tree.h"
#include "support/fixture.h"
#include "support/meshes.h"
#include "support/solid_meshes.h"
#include "support/suite.h"

/* Voxels may be off by this where the distance is smaller than floats tell, in their widths. */
#define SMALL 0x1p-42

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

/* ---- brute force ---- */

typedef struct point {
    long double x, y, z;
} point;

static point minus(point a, point b)
{
    return (point){a.x - b.x, a.y - b.y, a.z - b.z};
}

static long double dot(point a, point b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static point cross(point a, point b)
{
    return (point){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* Squared, from 0, 0, 0. */
static long double to_segment(point a, point b)
{
    const point edge = minus(b, a);
    const long double squared = dot(edge, edge);
    const long double share = squared > 0 ? fminl(fmaxl(-dot(a, edge) / squared, 0), 1) : 0;
    const point at = {a.x + share * edge.x, a.y + share * edge.y, a.z + share * edge.z};
    return dot(at, at);
}

/* Squared, from 0, 0, 0. */
static long double to_triangle(const point corners[3])
{
    const point normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    const long double area = dot(normal, normal);
    long double least = INFINITY;
    bool beside = area == 0;
    for (int i = 0; i < 3; ++i) {
        const point from = corners[i];
        const point to = corners[(i + 1) % 3];
        const point inwards = cross(normal, minus(to, from));
        beside = beside || -dot(from, inwards) < 0;
        least = fminl(least, to_segment(from, to));
    }
    return beside ? least : dot(corners[0], normal) * dot(corners[0], normal) / area;
}

/* Solid angle over 4 pi, with the sign of the side. */
static double winding_of(const point corners[3])
{
    long double length[3];
    for (int i = 0; i < 3; ++i) {
        length[i] = sqrtl(dot(corners[i], corners[i]));
    }
    const long double volume = dot(corners[0], cross(corners[1], corners[2]));
    const long double rest = length[0] * length[1] * length[2] + dot(corners[0], corners[1]) * length[2] +
                             dot(corners[1], corners[2]) * length[0] + dot(corners[2], corners[0]) * length[1];
    return (double)(atan2l(volume, rest) / (2 * acosl(-1)));
}

typedef struct truth {
    long double distance;
    double winding;
} truth;

static truth truth_of(const svo_mesh *mesh, const long double center[3])
{
    truth r = {.distance = INFINITY};
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        point corners[3];
        for (int i = 0; i < 3; ++i) {
            const double *at = mesh->positions_double + 3 * (size_t)mesh->indices[3 * t + (size_t)i];
            corners[i] = (point){at[0] - center[0], at[1] - center[1], at[2] - center[2]};
        }
        r.distance = fminl(r.distance, to_triangle(corners));
        r.winding += winding_of(corners);
    }
    r.distance = sqrtl(r.distance);
    return r;
}

/* ---- fields ---- */

typedef struct field {
    svo_sdf *sdf;
    svo_sdf_info info;
    svo_sdf_arrays arrays;
} field;

static void make_field(const fixture *opened, const svo_tree *tree, const svo_sdf_options *options, field *out)
{
    out->sdf = NULL;
    out->info = (svo_sdf_info)SVO_SDF_INFO_INIT;
    out->arrays = (svo_sdf_arrays)SVO_SDF_ARRAYS_INIT;
    succeed(opened, svo_sdf_create(tree, options, opened->queue, &out->sdf));
    succeed(opened, svo_sdf_download(out->sdf, opened->queue));
    assert_int_equal(svo_sdf_get_info(out->sdf, &out->info), SVO_OK);
    assert_int_equal(svo_sdf_get_arrays(out->sdf, &out->arrays), SVO_OK);
}

static void cell_of(const field *made, size_t index, uint32_t cell[3])
{
    const uint32_t mask = (1U << made->info.depth) - 1;
    if (made->arrays.codes != NULL) {
        svo_code_to_cell(made->arrays.codes[index], cell);
        return;
    }
    for (uint32_t axis = 0; axis < 3; ++axis) {
        cell[axis] = (uint32_t)(index >> axis * made->info.depth) & mask;
    }
}

/* The place of a voxel in a dense field. */
static size_t dense_index(const field *made, const uint32_t cell[3])
{
    const uint32_t depth = made->info.depth;
    return cell[0] + ((size_t)cell[1] << depth) + ((size_t)cell[2] << 2 * depth);
}

/* How a field's signs are checked. */
typedef enum sign_rule { SIGNS_NONE = 0, SIGNS_WINDING, SIGNS_PARITY } sign_rule;

static void check_voxel(const field *made, const svo_mesh *mesh, size_t index, sign_rule rule)
{
    uint32_t cell[3];
    long double center[3];
    cell_of(made, index, cell);
    for (int axis = 0; axis < 3; ++axis) {
        center[axis] = made->info.origin[axis] + (cell[axis] + 0.5L) * made->info.spacing;
    }
    const truth expected = truth_of(mesh, center);
    const float got = fabsf(made->arrays.distances[index]);
    const float right = (float)expected.distance;
    if (nextafterf(got, right) != right && fabs((double)got - (double)expected.distance) > SMALL * made->info.spacing) {
        fail_msg("voxel %u %u %u: distance %.9g, not %.9g", cell[0], cell[1], cell[2], (double)got, (double)right);
    }
    const long winding = lround(expected.winding);
    const bool inside = rule != SIGNS_NONE && (rule == SIGNS_PARITY ? winding % 2 != 0 : winding != 0);
    if (expected.distance > 1e-9L && inside != (signbit(made->arrays.distances[index]) != 0)) {
        fail_msg("voxel %u %u %u: %.9g, winding number %g", cell[0], cell[1], cell[2],
                 (double)made->arrays.distances[index], expected.winding);
    }
}

/* Checks every voxel of a dense field, and that bands are the parts of it that are below their widths. */
static void check_mesh(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_plan_options plan,
                       sign_rule rule)
{
    static const float bands[] = {0.6F, 3.0F};
    svo_sdf_options options = {.struct_size = sizeof options,
                               .is_unsigned = rule == SIGNS_NONE,
                               .rule = rule == SIGNS_PARITY ? SVO_SOLID_PARITY : SVO_SOLID_WINDING};
    built tree;
    field dense;
    plan.need = SVO_NEED_RAYS;
    fixture_build(opened, mesh, depth, &plan, &tree);
    make_field(opened, tree.tree, &options, &dense);
    assert_int_equal(dense.info.voxel_count, 1ULL << 3 * depth);
    assert_null(dense.arrays.codes);
    for (size_t i = 0; i < dense.info.voxel_count; ++i) {
        check_voxel(&dense, mesh, i, rule);
    }
    for (size_t k = 0; k < sizeof bands / sizeof bands[0]; ++k) {
        field band;
        size_t expected = 0;
        options.band = bands[k];
        const float limit = (float)((double)bands[k] * dense.info.spacing);
        make_field(opened, tree.tree, &options, &band);
        for (size_t i = 0; i < dense.info.voxel_count; ++i) {
            expected += fabsf(dense.arrays.distances[i]) < limit;
        }
        assert_int_equal(band.info.voxel_count, expected);
        for (size_t i = 0; i < band.info.voxel_count; ++i) {
            uint32_t cell[3];
            cell_of(&band, i, cell);
            assert_true(i == 0 || band.arrays.codes[i - 1] < band.arrays.codes[i]);
            assert_memory_equal(&band.arrays.distances[i], &dense.arrays.distances[dense_index(&dense, cell)], 4);
        }
        svo_sdf_destroy(&band.sdf);
    }
    svo_sdf_destroy(&dense.sdf);
    built_destroy(&tree);
}

/* Whether two fields have the same bytes. */
static void compare(const field *a, const field *b)
{
    assert_int_equal(a->info.voxel_count, b->info.voxel_count);
    assert_memory_equal(a->arrays.distances, b->arrays.distances, a->info.voxel_count * sizeof(float));
    assert_int_equal(a->arrays.codes == NULL, b->arrays.codes == NULL);
    if (a->arrays.codes != NULL) {
        assert_memory_equal(a->arrays.codes, b->arrays.codes, a->info.voxel_count * sizeof(uint64_t));
    }
}

/* A grid from 0, 0, 0 on of voxels one unit wide. */
static svo_plan_options unit_grid(unsigned depth)
{
    return (svo_plan_options){.edge = (double)(1U << depth)};
}

/* ---- meshes ---- */

static void spheres(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const double center[3] = {15.9, 16.3, 15.2};
    parts made = {.vertex_count = 0};
    parts_add_sphere(&made, center, 9.7, 6);
    const svo_mesh mesh = parts_mesh(&made);
    check_mesh(&opened, &mesh, 5, unit_grid(5), SIGNS_WINDING);
    parts_free(&made);
}

/* A hollow in a cube, with faces through the centers of voxels. */
static void shells(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, 2.5, 13.5, false, -1);
    parts_add_cube(&made, 5.25, 10.75, true, -1);
    parts_add_cube(&made, 7.0, 9.0, false, -1);
    const svo_mesh mesh = parts_mesh(&made);
    check_mesh(&opened, &mesh, 4, unit_grid(4), SIGNS_WINDING);
    parts_free(&made);
}

static void overlapping_parts(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const double low[3] = {6.3, 5.1, 7.7};
    static const double high[3] = {14.2, 11.9, 12.6};
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, 2.2, 9.8, false, -1);
    parts_add_box(&made, low, high, false, -1);
    const svo_mesh mesh = parts_mesh(&made);
    check_mesh(&opened, &mesh, 4, unit_grid(4), SIGNS_WINDING);
    check_mesh(&opened, &mesh, 4, unit_grid(4), SIGNS_PARITY);
    parts_free(&made);
}

/* Corners of a ring of boxes: a body with a hole. */
static void tori(void **state)
{
    enum { AROUND = 12, ACROSS = 7 };
    const fixture opened = fixture_cl_of_group(state);
    double positions[AROUND * ACROSS * 3];
    uint32_t indices[AROUND * ACROSS * 6];
    for (uint32_t i = 0; i < AROUND * ACROSS; ++i) {
        const uint32_t ring = i / ACROSS;
        const double a = 6.283185307179586 * ring / AROUND;
        const double b = 6.283185307179586 * (i % ACROSS) / ACROSS;
        const double reach = 9.0 + 3.4 * cos(b);
        const uint32_t next = i % ACROSS == ACROSS - 1 ? i + 1 - ACROSS : i + 1;
        const uint32_t turn = (i + ACROSS) % (AROUND * ACROSS);
        const uint32_t turn_next = (next + ACROSS) % (AROUND * ACROSS);
        const uint32_t quads[6] = {i, turn, next, turn, turn_next, next};
        positions[3 * i] = 16.1 + reach * cos(a);
        positions[3 * i + 1] = 15.7 + reach * sin(a);
        positions[3 * i + 2] = 16.0 + 3.4 * sin(b);
        memcpy(indices + 6 * i, quads, sizeof quads);
    }
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions_double = positions,
                           .vertex_count = AROUND * ACROSS,
                           .indices = indices,
                           .triangle_count = 2 * AROUND * ACROSS};
    check_mesh(&opened, &mesh, 5, unit_grid(5), SIGNS_WINDING);
}

/* Slivers, needles, segments and points, far from closed. */
static void triangles_of_all_kinds(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    owned_mesh made;
    random_mesh(5, 60, 0.0, &made);
    check_mesh(&opened, &made.mesh, 4, (svo_plan_options){.edge = 1.0}, SIGNS_NONE);
    owned_mesh_free(&made);
    random_needles(6, 40, &made);
    check_mesh(&opened, &made.mesh, 4, (svo_plan_options){.edge = 1.0}, SIGNS_NONE);
    owned_mesh_free(&made);
}

/* The smallest grids, one far from the origin, and one of coverage closed. */
static void grids(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const double tetrahedron[4][3] = {{0.2, 0.3, 0.1}, {0.9, 0.2, 0.3}, {0.3, 0.8, 0.2}, {0.4, 0.4, 0.9}};
    for (unsigned depth = 1; depth <= 3; ++depth) {
        parts made = {.vertex_count = 0};
        parts_add_tetrahedron(&made, tetrahedron);
        const svo_mesh mesh = parts_mesh(&made);
        check_mesh(&opened, &mesh, depth, (svo_plan_options){.edge = 1.0}, SIGNS_WINDING);
        check_mesh(&opened, &mesh, depth, (svo_plan_options){.edge = 1.1, .coverage = SVO_COVERAGE_CLOSED},
                   SIGNS_WINDING);
        for (size_t i = 0; i < 3 * made.vertex_count; ++i) {
            made.positions[i] = 1e6 + 1e-3 * made.positions[i];
        }
        check_mesh(&opened, &mesh, depth, (svo_plan_options){.origin = {1e6, 1e6, 1e6}, .edge = 1e-3}, SIGNS_WINDING);
        parts_free(&made);
    }
}

/* ---- signs of open meshes ---- */

/* Where a mesh is open, cells that no surface touches are what the solid says. */
static void open_meshes_have_the_signs_of_solids(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts made = {.vertex_count = 0};
    svo_compact *solid = NULL;
    svo_tree *full = NULL;
    built tree;
    field dense;
    svo_plan_options plan = unit_grid(5);
    unsigned inside = 0;
    parts_add_cube(&made, 4.3, 26.6, false, 5);
    parts_add_cube(&made, 9.1, 12.2, true, -1);
    const svo_mesh mesh = parts_mesh(&made);
    plan.need = SVO_NEED_RAYS;
    fixture_build(&opened, &mesh, 5, &plan, &tree);
    make_field(&opened, tree.tree, NULL, &dense);
    assert_true(dense.info.open_columns[2] > 0 && dense.info.open_columns[0] == 0);
    succeed(&opened, svo_solid_create(tree.tree, NULL, opened.queue, &solid, NULL));
    succeed(&opened, svo_compact_expand(solid, opened.queue, &full));
    succeed(&opened, svo_tree_download(full, opened.queue));
    for (size_t i = 0; i < dense.info.voxel_count; ++i) {
        uint32_t cell[3];
        svo_node node;
        cell_of(&dense, i, cell);
        const bool surface = svo_tree_find_cell(tree.tree, 5, cell, &node) == SVO_OK && node.level == 5;
        const bool is_full = svo_tree_find_cell(full, 5, cell, &node) == SVO_OK && node.level == 5;
        if (!surface) {
            assert_int_equal(signbit(dense.arrays.distances[i]) != 0, is_full);
            inside += is_full ? 1 : 0;
        }
    }
    assert_true(inside > 3000);
    svo_tree_destroy(&full);
    svo_compact_destroy(&solid);
    svo_sdf_destroy(&dense.sdf);
    built_destroy(&tree);
    parts_free(&made);
}

/* ---- bytes ---- */

/* Batches of cells, whatever their number, and an out-of-order queue give the same bytes. */
static void batches_and_queues_give_the_same_bytes(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const double center[3] = {30.2, 33.1, 31.9};
    parts made = {.vertex_count = 0};
    svo_plan_options plan = unit_grid(6);
    plan.need = SVO_NEED_RAYS;
    parts_add_sphere(&made, center, 22.5, 9);
    const svo_mesh mesh = parts_mesh(&made);
    fixture other;
    fixture_open_cl(&(fixture_options){.queue_properties = CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE}, &other);
    for (int is_band = 0; is_band < 2; ++is_band) {
        svo_sdf_options options = {.struct_size = sizeof options, .band = is_band != 0 ? 2.5F : 0.0F};
        built tree;
        built again;
        field whole;
        field parted;
        field third;
        fixture_build(&opened, &mesh, 6, &plan, &tree);
        fixture_build(&other, &mesh, 6, &plan, &again);
        make_field(&opened, tree.tree, &options, &whole);
        options.batch_bytes = 1;
        make_field(&opened, tree.tree, &options, &parted);
        options.batch_bytes = 30000;
        make_field(&other, again.tree, &options, &third);
        compare(&whole, &parted);
        compare(&whole, &third);
        assert_true(parted.info.scratch_bytes <= whole.info.scratch_bytes);
        svo_sdf_destroy(&whole.sdf);
        svo_sdf_destroy(&parted.sdf);
        svo_sdf_destroy(&third.sdf);
        built_destroy(&tree);
        built_destroy(&again);
    }
    fixture_close(&other);
    parts_free(&made);
}

/* ---- arguments ---- */

static void refuse(const fixture *opened, const svo_tree *tree, const svo_sdf_options *options, const char *message)
{
    svo_sdf_plan_info planned = SVO_SDF_PLAN_INFO_INIT;
    svo_sdf *sdf = NULL;
    assert_int_equal(svo_sdf_create(tree, options, opened->queue, &sdf), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), message));
    assert_non_null(strstr(svo_device_message(opened->device), "svo_sdf_create: "));
    assert_null(sdf);
    assert_int_equal(svo_sdf_plan(tree, options, &planned), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), message));
}

static void refuse_build(const fixture *opened, const svo_mesh *mesh, svo_plan_options plan, const char *message)
{
    built tree;
    fixture_build(opened, mesh, 4, &plan, &tree);
    refuse(opened, tree.tree, NULL, message);
    built_destroy(&tree);
}

static void trees_without_distances_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts made = {.vertex_count = 0};
    svo_plan_options plan = unit_grid(4);
    svo_sdf *sdf = NULL;
    built tree;
    parts_add_cube(&made, 2.5, 13.5, false, -1);
    const svo_mesh mesh = parts_mesh(&made);
    refuse_build(&opened, &mesh, plan, "holds no leaf lists");
    plan.need = SVO_NEED_RAYS;
    plan.coverage = SVO_COVERAGE_THIN;
    refuse_build(&opened, &mesh, plan, "coverage is thin");
    plan.coverage = SVO_COVERAGE_HALF_OPEN;
    plan.edge = 2.0;
    refuse_build(&opened, &mesh, plan, "triangles lie outside the tree's grid; a distance field needs all of the mesh");
    plan.edge = 8.0;
    fixture_build(&opened, &mesh, 4, &plan, &tree);
    for (uint32_t is_unsigned = 0; is_unsigned < 2; ++is_unsigned) {
        const svo_sdf_options options = {.struct_size = sizeof options, .is_unsigned = is_unsigned};
        assert_int_equal(svo_sdf_create(tree.tree, &options, opened.queue, &sdf), SVO_INVALID_ARGUMENT);
        assert_non_null(strstr(svo_device_message(opened.device), "outside the tree's grid"));
        assert_null(sdf);
    }
    built_destroy(&tree);
    plan.edge = 0;
    const svo_mesh none = {.struct_size = sizeof none};
    refuse_build(&opened, &none, plan, "the tree has 0 leaves");
    parts_free(&made);
}

static void wrong_arguments_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts made = {.vertex_count = 0};
    svo_plan_options plan = unit_grid(4);
    svo_sdf_options options = SVO_SDF_OPTIONS_INIT;
    svo_sdf_plan_info planned = SVO_SDF_PLAN_INFO_INIT;
    svo_sdf_info info = SVO_SDF_INFO_INIT;
    svo_sdf_arrays arrays = SVO_SDF_ARRAYS_INIT;
    svo_sdf *sdf = NULL;
    built tree;
    plan.need = SVO_NEED_RAYS;
    parts_add_cube(&made, 2.5, 13.5, false, -1);
    const svo_mesh mesh = parts_mesh(&made);
    fixture_build(&opened, &mesh, 4, &plan, &tree);
    assert_int_equal(svo_sdf_create(NULL, NULL, NULL, &sdf), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_sdf_create(tree.tree, NULL, NULL, NULL), SVO_INVALID_ARGUMENT);
    options.band = -1.0F;
    refuse(&opened, tree.tree, &options, "options.band -1 is not in 0 .. 65536");
    options.band = NAN;
    refuse(&opened, tree.tree, &options, "options.band");
    options.band = 65537.0F;
    refuse(&opened, tree.tree, &options, "options.band 65537 is not in 0 .. 65536");
    options = (svo_sdf_options){.struct_size = sizeof options, .rule = (svo_solid_rule)2};
    refuse(&opened, tree.tree, &options, "options.rule 2 is not in 0 .. 1");
    options = (svo_sdf_options){.struct_size = 3};
    refuse(&opened, tree.tree, &options, "struct_size");
    planned.struct_size = 8;
    assert_int_equal(svo_sdf_plan(tree.tree, NULL, &planned), SVO_INVALID_ARGUMENT);
    succeed(&opened, svo_sdf_create(tree.tree, NULL, NULL, &sdf));
    info.struct_size = 8;
    assert_int_equal(svo_sdf_get_info(sdf, &info), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_sdf_get_info(NULL, &info), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_sdf_get_arrays(sdf, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_sdf_get_arrays(sdf, &arrays), SVO_OK);
    assert_null(arrays.distances);
    assert_int_equal(svo_sdf_download(NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_null(svo_sdf_get_buffer(sdf, SVO_SDF_CODES));
    assert_null(svo_sdf_get_buffer(sdf, (svo_sdf_buffer)7));
    assert_non_null(svo_sdf_get_buffer(sdf, SVO_SDF_DISTANCES));
    svo_sdf_destroy(&sdf);
    svo_sdf_destroy(&sdf);
    svo_sdf_destroy(NULL);
    built_destroy(&tree);
    parts_free(&made);
}

/* The plan's bytes: exact for a dense field, above those of a band; scratch holds. */
static void plans_tell_the_bytes(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const double center[3] = {32, 32, 32};
    parts made = {.vertex_count = 0};
    svo_plan_options plan = unit_grid(6);
    built tree;
    plan.need = SVO_NEED_RAYS;
    parts_add_sphere(&made, center, 24.0, 16);
    const svo_mesh mesh = parts_mesh(&made);
    fixture_build(&opened, &mesh, 6, &plan, &tree);
    for (int is_band = 0; is_band < 2; ++is_band) {
        const svo_sdf_options options = {.struct_size = sizeof options, .band = is_band != 0 ? 3.0F : 0.0F};
        svo_sdf_plan_info planned = SVO_SDF_PLAN_INFO_INIT;
        size_t bytes = 0;
        size_t code_bytes = 0;
        field sdf;
        succeed(&opened, svo_sdf_plan(tree.tree, &options, &planned));
        make_field(&opened, tree.tree, &options, &sdf);
        const cl_mem codes = svo_sdf_get_buffer(sdf.sdf, SVO_SDF_CODES);
        clGetMemObjectInfo(svo_sdf_get_buffer(sdf.sdf, SVO_SDF_DISTANCES), CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
        if (codes != NULL) {
            clGetMemObjectInfo(codes, CL_MEM_SIZE, sizeof code_bytes, &code_bytes, NULL);
        }
        assert_int_equal(bytes + code_bytes, sdf.info.bytes);
        assert_true(is_band != 0 ? planned.result_bytes >= sdf.info.bytes && planned.result_bytes < 2 * sdf.info.bytes
                                 : planned.result_bytes == sdf.info.bytes);
        assert_true(planned.scratch_bytes >= sdf.info.scratch_bytes);
        assert_int_equal(sdf.info.voxel_count * (is_band != 0 ? 12 : 4), sdf.info.bytes);
        svo_sdf_destroy(&sdf.sdf);
    }
    built_destroy(&tree);
    parts_free(&made);
}

TEST_GROUP(sdf)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spheres),
        cmocka_unit_test(shells),
        cmocka_unit_test(overlapping_parts),
        cmocka_unit_test(tori),
        cmocka_unit_test(triangles_of_all_kinds),
        cmocka_unit_test(grids),
        cmocka_unit_test(open_meshes_have_the_signs_of_solids),
        cmocka_unit_test(batches_and_queues_give_the_same_bytes),
        cmocka_unit_test(trees_without_distances_are_refused),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(plans_tell_the_bytes),
    };
    return cmocka_run_group_tests_name("sdf", tests, fixture_group_setup, fixture_group_teardown);
}
