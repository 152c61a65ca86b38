/* SPDX-License-Identifier: MIT */
/*
 * Rays and points against the triangles of a tree, compared with a reference that tests every triangle in long double:
 * closest hits, any hit, counts, nearest triangles, trees of every depth, users' own kernels, and valid and invalid
 * calls.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rays/rays.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/ray_check.h"
#include "support/suite.h"

/* ---- any hit, counts, depths ---- */

/* A procedural scene by its name, for rays. */
static void build_scene(const fixture *opened, const char *name, unsigned depth, built *out)
{
    scene *made = make_scene(name);
    build_for_rays(opened, scene_mesh(made), depth, NULL, 0, out);
    scene_destroy(&made);
}

static void any_hit_and_count_agree_with_the_reference(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 2000 };
    static svo_ray rays[RAYS];
    static svo_hit closest[RAYS];
    static svo_hit any[RAYS];
    static svo_hit count[RAYS];
    uint64_t random = 99;
    owned_mesh owned;
    built tree;
    random_mesh(4, 500, 0, &owned);
    build_for_rays(opened, &owned.mesh, 6, NULL, 0, &tree);
    const oracle_ray_scene mesh = ray_scene_of(&tree);
    for (size_t i = 0; i < RAYS; ++i) {
        rays[i] = random_ray(&random, 3.0);
    }
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, closest);
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_ANY, any);
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_COUNT, count);
    for (size_t i = 0; i < RAYS; ++i) {
        const oracle_ray wide = widen_ray(&rays[i]);
        assert_int_equal(any[i].triangle == SVO_NO_TRIANGLE, closest[i].triangle == SVO_NO_TRIANGLE);
        assert_int_equal(count[i].triangle, closest[i].triangle);
        assert_int_equal(count[i].count, oracle_ray_count(&mesh, &wide));
        double t = 0;
        if (any[i].triangle != SVO_NO_TRIANGLE) {
            assert_true(oracle_ray_meets(&mesh, any[i].triangle, &wide, &t)); /* none refused: ids equal indices */
            assert_true(is_tied((double)any[i].t, t));
        }
    }
    built_destroy(&tree);
    owned_mesh_free(&owned);
}

/* Compares everything except the number of visited BVH leaves. */
static void assert_same_hits(const svo_hit *a, const svo_hit *b, size_t count, unsigned depth)
{
    for (size_t i = 0; i < count; ++i) {
        if (memcmp(&a[i], &b[i], offsetof(svo_hit, count)) != 0) {
            fail_msg("depth %u, ray %zu: triangle %d at %.9g instead of %d at %.9g", depth, i, (int)a[i].triangle,
                     (double)a[i].t, (int)b[i].triangle, (double)b[i].t);
        }
    }
}

/* Like random_ray, scaled by the tree's edge. */
static svo_ray random_ray_near(const built *tree, uint64_t *random, double spread)
{
    svo_ray ray = random_ray(random, spread);
    for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = (float)(tree->info.origin[axis] + tree->info.edge * (double)ray.origin[axis]);
    }
    return ray;
}

static void hits_do_not_depend_on_the_depth(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 4000 };
    static svo_ray rays[RAYS];
    static svo_hit first[RAYS];
    static svo_hit hits[RAYS];
    uint64_t random = 2;
    scene *made = make_scene("knot:3000");
    for (unsigned depth = 1; depth <= 11; ++depth) {
        built tree;
        build_for_rays(opened, scene_mesh(made), depth, NULL, 0, &tree);
        for (size_t i = 0; i < RAYS && depth == 1; ++i) {
            rays[i] = random_ray_near(&tree, &random, 3.0);
        }
        trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, depth == 1 ? first : hits);
        assert_same_hits(depth == 1 ? first : hits, first, RAYS, depth);
        built_destroy(&tree);
    }
    scene_destroy(&made);
}

/* u, v and the normal of one known triangle. */
static void hits_report_the_point_on_the_triangle(void **state)
{
    const fixture *opened = fixture_of_group(state);
    static const float corners[9] = {0, 0, 0, 4, 0, 0, 0, 4, 0};
    const svo_mesh mesh = {.struct_size = sizeof mesh, .positions = corners, .vertex_count = 3, .triangle_count = 1};
    const double origin[3] = {-4, -4, -4};
    const svo_ray ray = {{1, 2, 3}, {0, 0, -0.5f}, 0, 100};
    svo_hit hit;
    built tree;
    build_for_rays(opened, &mesh, 3, origin, 16, &tree);
    trace_rays(opened, &tree, &ray, 1, SVO_TRACE_CLOSEST, &hit);
    assert_int_equal(hit.triangle, 0);
    assert_true(hit.t == 6.0f && hit.u == 0.25f && hit.v == 0.5f);
    assert_true(hit.normal[0] == 0.0f && hit.normal[1] == 0.0f && hit.normal[2] == 1.0f);
    built_destroy(&tree);
}

static void rays_miss_an_empty_tree(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const svo_mesh nothing = {.struct_size = sizeof nothing};
    const svo_ray ray = {{0.5f, 0.5f, -1}, {0, 0, 1}, 0, INFINITY};
    for (unsigned depth = 1; depth <= 4; ++depth) {
        svo_hit hit;
        built tree;
        build_for_rays(opened, &nothing, depth, NULL, 0, &tree);
        trace_rays(opened, &tree, &ray, 1, SVO_TRACE_CLOSEST, &hit);
        assert_int_equal(hit.triangle, SVO_NO_TRIANGLE);
        built_destroy(&tree);
    }
}

/* ---- batches and single rays ---- */

/* A camera's rays are traced in packets of eight, scattered ones alone, and counting traces each alone: the hits are
   the same. */
static void hits_do_not_depend_on_neighboring_rays(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { EDGE = 90, RAYS = EDGE * EDGE + 5 };
    static svo_ray rays[RAYS];
    static svo_hit together[RAYS];
    static svo_hit alone[RAYS];
    static svo_hit any[RAYS];
    built tree;
    size_t met = 0;
    uint64_t random = 5;
    build_scene(opened, "knot:20000", 7, &tree);
    for (size_t i = 0; i < RAYS; ++i) {
        const size_t row = i / EDGE;
        const double across[3] = {(double)(i % EDGE) / EDGE - 0.5, (double)row / EDGE - 0.5, 1.0};
        /* Every seventh row is interrupted by invalid rays, or by rays with other directions. */
        const bool odd = i / EDGE % 7 == 0 && i % 3 == 0;
        rays[i] = (svo_ray){.t_min = 0, .t_max = i % 11 == 0 ? 2.0f : INFINITY};
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = (float)(tree.info.origin[axis] + tree.info.edge * (axis == 2 ? -1.0 : 0.5));
            rays[i].direction[axis] = (float)(odd ? random_unit(&random) - 0.5 : across[axis]);
        }
        rays[i].direction[1] = odd && i % 2 == 0 ? NAN : rays[i].direction[1];
    }
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, together);
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_COUNT, alone);
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_ANY, any);
    assert_same_hits(together, alone, RAYS, 7);
    for (size_t i = 0; i < RAYS; ++i) {
        met += alone[i].triangle != SVO_NO_TRIANGLE;
        assert_int_equal(any[i].triangle == SVO_NO_TRIANGLE, alone[i].triangle == SVO_NO_TRIANGLE);
        assert_true(any[i].triangle == SVO_NO_TRIANGLE || any[i].t >= alone[i].t);
    }
    assert_true(met > RAYS / 20 && met < RAYS - RAYS / 20);
    built_destroy(&tree);
}

/* Incoherent rays, in batches of sizes around those that are traced as a stream. */
static void hits_do_not_depend_on_the_batch_size(void **state)
{
    const fixture *opened = fixture_of_group(state);
    static const size_t sizes[] = {1, 7, 8, 9, 15, 16, 17, 63, 64, 65, 71, 72, 73, 127, 128, 129, 200};
    enum { RAYS = 200 };
    svo_ray rays[RAYS];
    svo_hit alone[RAYS];
    svo_hit batch[RAYS];
    built tree;
    size_t met = 0;
    uint64_t random = 11;
    build_scene(opened, "knot:3000", 6, &tree);
    for (size_t i = 0; i < RAYS; ++i) {
        rays[i] = random_ray_near(&tree, &random, 1.5);
        rays[i].t_max = i % 13 == 5 ? -1.0f : rays[i].t_max; /* ends before it begins */
        trace_rays(opened, &tree, &rays[i], 1, SVO_TRACE_CLOSEST, &alone[i]);
        met += alone[i].triangle != SVO_NO_TRIANGLE;
    }
    assert_true(met > RAYS / 10 && met < RAYS - RAYS / 10);
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; ++k) {
        memset(batch, 0x5a, sizeof batch);
        trace_rays(opened, &tree, rays, sizes[k], SVO_TRACE_CLOSEST, batch);
        assert_same_hits(batch, alone, sizes[k], 6);
    }
    built_destroy(&tree);
}

/* A stack of sheets in descending order: rays up and down that begin between two of them hit the next one, with
   hundreds of bounding boxes ahead and behind. */
static void rays_through_a_stack_hit_the_next_sheet(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { SHEETS = 2000, EDGE = 1 << 12 };
    static float corners[SHEETS * 9];
    static svo_ray rays[2 * SHEETS];
    static svo_hit hits[2 * SHEETS];
    const svo_mesh mesh = {
        .struct_size = sizeof mesh, .positions = corners, .vertex_count = SHEETS * 3, .triangle_count = SHEETS};
    const double origin[3] = {0, 0, 0};
    built tree;
    for (size_t i = 0; i < SHEETS; ++i) {
        const float height = (float)(2 * (SHEETS - i));
        const float sheet[9] = {0, 0, height, EDGE - 1, 0, height, 0, EDGE - 1, height};
        memcpy(corners + 9 * i, sheet, sizeof sheet);
        /* Up through all of them from below, with t_min one unit below this one; and down likewise. */
        rays[2 * i] = (svo_ray){{100, 200, -10}, {0, 0, 1}, height + 9, INFINITY};
        rays[2 * i + 1] = (svo_ray){{300, 100, 5000}, {0, 0, -1}, 4999 - height, INFINITY};
    }
    build_for_rays(opened, &mesh, 5, origin, EDGE, &tree);
    trace_rays(opened, &tree, rays, 2 * SHEETS, SVO_TRACE_CLOSEST, hits);
    for (size_t i = 0; i < SHEETS; ++i) {
        const float height = (float)(2 * (SHEETS - i));
        assert_int_equal(hits[2 * i].triangle, i);
        assert_true(hits[2 * i].t == height + 10);
        assert_int_equal(hits[2 * i + 1].triangle, i);
        assert_true(hits[2 * i + 1].t == 5000 - height);
    }
    trace_rays(opened, &tree, rays, 2 * SHEETS, SVO_TRACE_ANY, hits);
    for (size_t i = 0; i < 2 * SHEETS; ++i) {
        const bool up = i % 2 == 0;
        assert_true(hits[i].triangle < SHEETS && (up ? hits[i].triangle <= i / 2 : hits[i].triangle >= i / 2));
    }
    built_destroy(&tree);
}

/* Coincident triangles, and smaller and smaller ones side by side, which no split can balance: every one is found. */
static void coincident_and_nested_triangles_are_found(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { NESTED = 18, COPIES = 300, TRIANGLES = NESTED * COPIES };
    static float corners[TRIANGLES * 9];
    svo_ray rays[NESTED];
    svo_hit hits[NESTED];
    const svo_mesh mesh = {
        .struct_size = sizeof mesh, .positions = corners, .vertex_count = TRIANGLES * 3, .triangle_count = TRIANGLES};
    const double origin[3] = {0, 0, 0};
    built tree;
    for (size_t i = 0; i < TRIANGLES; ++i) {
        const float at = ldexpf(1.0f, (int)(i % NESTED) + 1);
        const float triangle[9] = {at, at, at, at * 1.5f, at, at, at, at * 1.5f, at};
        memcpy(corners + 9 * i, triangle, sizeof triangle);
    }
    for (size_t k = 0; k < NESTED; ++k) {
        const float at = ldexpf(1.0f, (int)k + 1) * 1.125f;
        rays[k] = (svo_ray){{at, at, -1}, {0, 0, 1}, 0, INFINITY};
    }
    build_for_rays(opened, &mesh, 6, origin, 0x1p20, &tree);
    trace_rays(opened, &tree, rays, NESTED, SVO_TRACE_COUNT, hits);
    for (size_t k = 0; k < NESTED; ++k) {
        assert_int_equal(hits[k].triangle, k); /* the first of its copies */
        assert_int_equal(hits[k].count, COPIES);
    }
    trace_rays(opened, &tree, rays, NESTED, SVO_TRACE_CLOSEST, hits);
    for (size_t k = 0; k < NESTED; ++k) {
        assert_int_equal(hits[k].triangle, k);
    }
    built_destroy(&tree);
}

/* ---- when the BVH is built ---- */

static void the_bvh_is_built_on_request(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const svo_ray ray = {{0.5f, 0.5f, -1}, {0, 0, 1}, 0, INFINITY};
    scene *made = make_scene("knot:3000");
    svo_hit hit;
    built first_use;
    built prepared;
    build_for_rays(opened, scene_mesh(made), 4, NULL, 0, &first_use);
    build_for_rays(opened, scene_mesh(made), 4, NULL, 0, &prepared);
    assert_int_equal(info_of_tree(first_use.tree).ray_bytes, 0);
    trace_rays(opened, &first_use, &ray, 1, SVO_TRACE_CLOSEST, &hit);
    assert_int_equal(info_of_tree(prepared.tree).ray_bytes, 0);
    assert_int_equal(svo_tree_make_bvh(prepared.tree, SVO_BVH_BEST, NULL), SVO_OK); /* on the device's own queue */
    const uint64_t bytes = info_of_tree(prepared.tree).ray_bytes;
    assert_int_equal(svo_tree_make_bvh(prepared.tree, SVO_BVH_BEST, opened->queue), SVO_OK); /* once is enough */
    assert_int_equal(info_of_tree(prepared.tree).ray_bytes, bytes);
    assert_int_equal(info_of_tree(first_use.tree).ray_bytes, bytes);
    assert_in_range(bytes, 1, 208 * prepared.info.list_triangle_count + 192);
    for (size_t i = 0; i < prepared.buffer_count; ++i) {
        assert_int_not_equal(strncmp(prepared.buffers[i].name, "ray_", 4), 0); /* no part of the build */
    }
    built_destroy(&prepared);
    built_destroy(&first_use);
    scene_destroy(&made);
}

/* Both qualities, and one after the other. */
static void hits_do_not_depend_on_the_quality(void **state)
{
    static const char *const names[] = {"statue:8000", "atrium", "needles:3000", "dust:4000", "terrain:9000"};
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 4000 };
    static svo_ray rays[RAYS];
    static svo_hit best[RAYS];
    static svo_hit hits[RAYS];
    uint64_t random = 5;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        built tree;
        build_scene(opened, names[i], 6, &tree);
        for (size_t k = 0; k < RAYS; ++k) {
            rays[k] = random_ray_near(&tree, &random, 3.0);
        }
        trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, best);
        const uint64_t bytes = info_of_tree(tree.tree).ray_bytes;
        assert_int_equal(svo_tree_make_bvh(tree.tree, SVO_BVH_FAST, opened->queue), SVO_OK);
        assert_int_not_equal(info_of_tree(tree.tree).ray_bytes, bytes); /* another one */
        trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, hits);
        assert_same_hits(hits, best, RAYS, 6);
        assert_int_not_equal(info_of_tree(tree.tree).ray_bytes, bytes); /* rays are content with one of any quality */
        assert_int_equal(svo_tree_make_bvh(tree.tree, SVO_BVH_BEST, opened->queue), SVO_OK);
        assert_int_equal(info_of_tree(tree.tree).ray_bytes, bytes);
        built_destroy(&tree);
    }
}

/* Writes vertices to a tree on the device: the snapped ones, and those that rays meet. */
static void write_vertices(const fixture *opened, const built *to, const int32_t *snapped)
{
    const size_t count = (size_t)to->info.vertex_count * 3;
    float *positions = malloc(count * sizeof *positions);
    assert_non_null(positions);
    for (size_t i = 0; i < count; ++i) {
        positions[i] = (float)(to->info.origin[i % 3] + snapped[i] / to->info.scale);
    }
    assert_int_equal(clEnqueueWriteBuffer(opened->queue, svo_tree_get_buffer(to->tree, SVO_TREE_VERTICES), CL_TRUE, 0,
                                          count * sizeof *snapped, snapped, 0, NULL, NULL),
                     CL_SUCCESS);
    assert_int_equal(clEnqueueWriteBuffer(opened->queue, svo_tree_get_buffer(to->tree, SVO_TREE_POSITIONS), CL_TRUE, 0,
                                          count * sizeof *positions, positions, 0, NULL, NULL),
                     CL_SUCCESS);
    free(positions);
}

/* Vertices move on the device; a refit BVH and a new one give the same hits, which are others than before. */
static void hits_after_a_refit_are_those_of_a_new_bvh(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 4000 };
    static svo_ray rays[RAYS];
    static svo_hit before[RAYS];
    static svo_hit refit[RAYS];
    static svo_hit anew[RAYS];
    uint64_t random = 17;
    built tree;
    build_scene(opened, "knot:9000", 6, &tree);
    const size_t count = (size_t)tree.info.vertex_count * 3;
    int32_t *moved = malloc(count * sizeof *moved);
    assert_non_null(moved);
    for (size_t i = 0; i < count; ++i) {
        const int32_t last = (1 << tree.info.snap_bits) - 1;
        moved[i] = i % 3 == 0 ? last - tree.arrays.vertices[i] : tree.arrays.vertices[i] / 2;
    }
    for (size_t k = 0; k < RAYS; ++k) {
        rays[k] = random_ray_near(&tree, &random, 2.0);
    }
    for (svo_bvh_quality quality = SVO_BVH_BEST; quality <= SVO_BVH_FAST; ++quality) {
        const svo_i_bvh_options options = {.quality = quality, .can_refit = true};
        write_vertices(opened, &tree, tree.arrays.vertices);
        assert_int_equal(svo_i_rays_make(tree.tree, "test", opened->queue, &options), SVO_OK);
        trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, before);
        write_vertices(opened, &tree, moved);
        assert_int_equal(svo_i_rays_refit(tree.tree, "test", opened->queue, NULL, NULL), SVO_OK);
        trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, refit);
        assert_int_equal(svo_i_rays_make(tree.tree, "test", opened->queue, &options), SVO_OK);
        trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, anew);
        assert_same_hits(refit, anew, RAYS, 6);
        unsigned moved_hits = 0;
        for (size_t k = 0; k < RAYS; ++k) {
            moved_hits += before[k].triangle != anew[k].triangle ? 1 : 0;
        }
        assert_int_not_equal(moved_hits, 0);
    }
    free(moved);
    built_destroy(&tree);
}

static void the_bvh_is_refused_for_trees_without_lists(void **state)
{
    const fixture *opened = fixture_of_group(state);
    static uint8_t picture[8 * 8 * 4];
    const svo_render_options triangles = {.struct_size = sizeof triangles,
                                          .width = 8,
                                          .height = 8,
                                          .camera = {{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 0.5f},
                                          .view = SVO_VIEW_TRIANGLES};
    scene *made = make_scene("cube");
    built plain;
    built thin;
    fixture_build(opened, scene_mesh(made), 3, &(svo_plan_options){.need = SVO_NEED_NONE}, &plain);
    fixture_build(opened, scene_mesh(made), 3,
                  &(svo_plan_options){.need = SVO_NEED_RAYS, .coverage = SVO_COVERAGE_THIN}, &thin);
    assert_int_equal(svo_tree_make_bvh(NULL, SVO_BVH_BEST, opened->queue), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_make_bvh(plain.tree, SVO_BVH_BEST, opened->queue), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "SVO_NEED_RAYS"));
    assert_int_equal(svo_tree_make_bvh(thin.tree, SVO_BVH_BEST, opened->queue), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "thin"));
    assert_int_equal(svo_render(svo_tree_target(plain.tree), &triangles, svo_in_host(picture),
                                &(svo_submit){.queue = opened->queue}),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(
        svo_render(svo_tree_target(thin.tree), &triangles, svo_in_host(picture), &(svo_submit){.queue = opened->queue}),
        SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "thin"));
    assert_int_equal(info_of_tree(plain.tree).ray_bytes, 0);
    built_destroy(&thin);
    built_destroy(&plain);
    scene_destroy(&made);
}

/* ---- nearest triangles ---- */

static void check_nearest(const fixture *opened, const svo_mesh *mesh, unsigned depth, uint64_t seed)
{
    enum { POINTS = 1500 };
    static svo_query_point points[POINTS];
    static svo_nearest results[POINTS];
    uint64_t random = seed;
    built tree;
    build_for_rays(opened, mesh, depth, NULL, 0, &tree);
    const oracle_ray_scene snapped = ray_scene_of(&tree);
    for (size_t i = 0; i < POINTS; ++i) {
        const double spread = i % 3 == 0 ? 1.0 : i % 3 == 1 ? 2.0 : 30.0;
        for (int axis = 0; axis < 3; ++axis) {
            points[i].position[axis] =
                (float)(tree.info.origin[axis] + tree.info.edge * (0.5 + spread * (random_unit(&random) - 0.5)));
        }
        points[i].max_distance = i % 5 == 0 ? (float)(tree.info.edge * 0.05) : INFINITY;
    }
    assert_int_equal(svo_tree_nearest(tree.tree, svo_in_host(points), svo_in_host(results), POINTS,
                                      &(svo_submit){.queue = opened->queue}),
                     SVO_OK);
    for (size_t i = 0; i < POINTS; ++i) {
        const double at[3] = {(double)points[i].position[0], (double)points[i].position[1],
                              (double)points[i].position[2]};
        size_t triangle = 0;
        const double distance = oracle_nearest(&snapped, at, &triangle);
        const double slack = distance * 0x1p-23;
        if (results[i].triangle == SVO_NO_TRIANGLE) {
            assert_true(distance >= (double)points[i].max_distance - slack);
            continue;
        }
        const uint32_t met = results[i].triangle; /* none refused: ids equal indices */
        if (fabs((double)results[i].distance - distance) > slack ||
            oracle_triangle_distance(&snapped, met, at) > distance + slack) {
            fail_msg("depth %u, point %zu: triangle %u at %.9g, the reference has %zu at %.9g", depth, i, met,
                     (double)results[i].distance, triangle, distance);
        }
        double moved = 0;
        for (int axis = 0; axis < 3; ++axis) {
            moved += ((double)results[i].position[axis] - at[axis]) * ((double)results[i].position[axis] - at[axis]);
        }
        assert_true(fabs(sqrt(moved) - distance) <= tree.info.edge * 1e-5);
    }
    built_destroy(&tree);
}

static void the_nearest_triangle_agrees_with_the_reference(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *made = make_scene("knot:1500");
    owned_mesh owned;
    random_mesh(31, 300, 0, &owned);
    for (unsigned depth = 1; depth <= 7; depth += 2) {
        check_nearest(opened, &owned.mesh, depth, depth);
    }
    check_nearest(opened, scene_mesh(made), 6, 6);
    owned_mesh_free(&owned);
    scene_destroy(&made);
}

/* ---- a user's own kernel ---- */

static const char voxel_kernel[] =
    "__kernel void find(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_voxel_hit *hits)\n"
    "{\n"
    "    SVO_TREE_MAKE(tree);\n"
    "    const svo_ray ray = rays[get_global_id(0)];\n"
    "    svo_voxel_hit hit;\n"
    "    svo_trace_voxel(&tree, &ray, 0.0f, &hit);\n"
    "    hits[get_global_id(0)] = hit;\n"
    "}\n";

static cl_kernel make_voxel_kernel(const fixture *opened)
{
    const char *sources[2] = {svo_kernel_source(svo_tree_target(NULL)), voxel_kernel};
    const cl_device_id device = info_of_device(opened->device).device;
    cl_int error = CL_SUCCESS;
    cl_program program = clCreateProgramWithSource(info_of_device(opened->device).context, 2, sources, NULL, &error);
    assert_int_equal(clBuildProgram(program, 1, &device, svo_kernel_options(svo_tree_target(NULL)), NULL, NULL),
                     CL_SUCCESS);
    cl_kernel kernel = clCreateKernel(program, "find", &error);
    assert_int_equal(error, CL_SUCCESS);
    clReleaseProgram(program);
    return kernel;
}

static void run_voxel_kernel(const fixture *opened, const built *tree, const svo_ray *rays, svo_voxel_hit *hits,
                             size_t count)
{
    cl_context context = info_of_device(opened->device).context;
    cl_kernel kernel = make_voxel_kernel(opened);
    const size_t local = 50;
    cl_mem from = clCreateBuffer(context, CL_MEM_READ_WRITE, count * sizeof *rays, NULL, NULL);
    cl_mem to = clCreateBuffer(context, CL_MEM_READ_WRITE, count * sizeof *hits, NULL, NULL);
    assert_int_equal(svo_kernel_set_arguments(svo_tree_target(tree->tree), kernel, 0), SVO_OK);
    clSetKernelArg(kernel, SVO_TREE_ARGUMENTS, sizeof from, (const void *)&from);
    clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 1, sizeof to, (const void *)&to);
    clEnqueueWriteBuffer(opened->queue, from, CL_TRUE, 0, count * sizeof *rays, rays, 0, NULL, NULL);
    assert_int_equal(clEnqueueNDRangeKernel(opened->queue, kernel, 1, NULL, &count, &local, 0, NULL, NULL), CL_SUCCESS);
    clEnqueueReadBuffer(opened->queue, to, CL_TRUE, 0, count * sizeof *hits, hits, 0, NULL, NULL);
    clReleaseMemObject(from);
    clReleaseMemObject(to);
    clReleaseKernel(kernel);
}

/* Each work-item traces an array of rays: 77 of them, so that packets and what remains meet other rays than in the
   library's batches. */
#define RAYS_PER_ITEM 77u
static const char arrays_kernel[] =
    "__kernel void find(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_hit *hits, uint count, uint "
    "any)\n"
    "{\n"
    "    SVO_TREE_MAKE(tree);\n"
    "    const uint first = min((uint)get_global_id(0) * 77u, count);\n"
    "    svo_trace_rays(&tree, rays + first, hits + first, min(77u, count - first), any != 0u);\n"
    "}\n";

static void run_arrays_kernel(const fixture *opened, const built *tree, const char *options, cl_uint any,
                              const svo_ray *rays, svo_hit *hits, cl_uint count)
{
    const char *sources[2] = {svo_kernel_source(svo_tree_target(NULL)), arrays_kernel};
    const cl_device_id device = info_of_device(opened->device).device;
    cl_context context = info_of_device(opened->device).context;
    const size_t items = (count + RAYS_PER_ITEM - 1u) / RAYS_PER_ITEM;
    const size_t local = 1;
    cl_int error = CL_SUCCESS;
    cl_program program = clCreateProgramWithSource(context, 2, sources, NULL, &error);
    assert_int_equal(clBuildProgram(program, 1, &device, options, NULL, NULL), CL_SUCCESS);
    cl_kernel kernel = clCreateKernel(program, "find", &error);
    cl_mem from = clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, count * sizeof *rays, (void *)rays, NULL);
    cl_mem to = clCreateBuffer(context, CL_MEM_READ_WRITE, count * sizeof *hits, NULL, NULL);
    assert_int_equal(svo_kernel_set_arguments(svo_tree_target(tree->tree), kernel, 0), SVO_OK);
    clSetKernelArg(kernel, SVO_TREE_ARGUMENTS, sizeof from, (const void *)&from);
    clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 1, sizeof to, (const void *)&to);
    clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 2, sizeof count, &count);
    clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 3, sizeof any, &any);
    assert_int_equal(clEnqueueNDRangeKernel(opened->queue, kernel, 1, NULL, &items, &local, 0, NULL, NULL), CL_SUCCESS);
    clEnqueueReadBuffer(opened->queue, to, CL_TRUE, 0, count * sizeof *hits, hits, 0, NULL, NULL);
    clReleaseMemObject(from);
    clReleaseMemObject(to);
    clReleaseKernel(kernel);
    clReleaseProgram(program);
}

/* Closest hits are the same but for the leaves visited; any hit is one where there is one. */
static void expect_hits(const svo_hit *hits, const svo_hit *expected, size_t count, cl_uint any, const char *way)
{
    for (size_t i = 0; i < count; ++i) {
        const bool same = any != 0 ? (hits[i].triangle == SVO_NO_TRIANGLE) == (expected[i].triangle == SVO_NO_TRIANGLE)
                                   : memcmp(&hits[i], &expected[i], offsetof(svo_hit, count)) == 0;
        if (!same) {
            fail_msg("%s: ray %zu, any %u: triangle %u, expected %u", way, i, any, hits[i].triangle,
                     expected[i].triangle);
            return;
        }
    }
}

/* Camera rays, then scattered ones; with streams and without. */
static void an_own_kernel_traces_arrays_of_rays(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 3000 };
    static svo_ray rays[RAYS];
    static svo_hit expected[RAYS];
    static svo_hit hits[RAYS];
    uint64_t random = 21;
    built tree;
    build_scene(opened, "knot:3000", 6, &tree);
    for (size_t i = 0; i < RAYS; ++i) {
        rays[i] = random_ray(&random, 1.0);
        for (int axis = 0; axis < 3; ++axis) {
            const double pixel[3] = {0.35 + 1e-3 * (double)(i % 50), 0.2 + 2e-2 * floor((double)i / 50), 0.5};
            const double at = i < RAYS / 2 ? pixel[axis] : random_unit(&random);
            const double eye = i < RAYS / 2 ? 1.5 + 0.25 * axis : axis == (int)(i % 3) ? 2.0 : random_unit(&random);
            rays[i].origin[axis] = (float)(tree.info.origin[axis] + tree.info.edge * eye);
            rays[i].direction[axis] =
                (float)(tree.info.origin[axis] + tree.info.edge * at - (double)rays[i].origin[axis]);
        }
    }
    for (cl_uint any = 0; any < 2; ++any) {
        trace_rays(opened, &tree, rays, RAYS, any != 0 ? SVO_TRACE_ANY : SVO_TRACE_CLOSEST, expected);
        size_t met = 0;
        for (size_t i = 0; i < RAYS / 2; ++i) {
            met += expected[i].triangle != SVO_NO_TRIANGLE;
        }
        assert_in_range(met, RAYS / 20, RAYS / 2 - RAYS / 20);
        for (int streams = 0; streams < 2; ++streams) {
            char options[128];
            snprintf(options, sizeof options, "%s%s", svo_kernel_options(svo_tree_target(NULL)),
                     streams != 0 ? " -DSVO_RAY_STREAMS" : "");
            run_arrays_kernel(opened, &tree, options, any, rays, hits, RAYS);
            expect_hits(hits, expected, RAYS, any, options);
        }
    }
    built_destroy(&tree);
}

/* Traces rays by field and by record: the same hits, bit for bit, in whole packets and beyond them. */
static void expect_by_field(const fixture *opened, const built *tree, const svo_ray *rays, size_t ray_count)
{
    enum { RAYS = 2048, WORDS = sizeof(svo_ray) / sizeof(uint32_t) };
    static svo_hit expected[RAYS];
    static uint32_t from[RAYS * WORDS];
    static uint32_t to[RAYS * WORDS];
    assert_true(ray_count <= RAYS && sizeof(svo_hit) == sizeof(svo_ray));
    for (size_t i = 0; i < ray_count; ++i) {
        uint32_t words[WORDS];
        memcpy(words, &rays[i], sizeof words);
        for (size_t k = 0; k < WORDS; ++k) {
            from[k * ray_count + i] = words[k];
        }
    }
    for (uint32_t mode = SVO_TRACE_CLOSEST; mode <= SVO_TRACE_COUNT; ++mode) {
        const svo_submit submit = {.queue = opened->queue};
        trace_rays(opened, tree, rays, ray_count, mode, expected);
        memset(to, 0x5a, sizeof to);
        assert_int_equal(svo_trace_triangles(svo_tree_target(tree->tree), svo_in_host(from), svo_in_host(to), ray_count,
                                             mode | SVO_TRACE_BY_FIELD, &submit),
                         SVO_OK);
        for (size_t i = 0; i < ray_count; ++i) {
            uint32_t words[WORDS];
            memcpy(words, &expected[i], sizeof words);
            for (size_t k = 0; k < WORDS; ++k) {
                if (to[k * ray_count + i] != words[k]) {
                    fail_msg("mode %u, ray %zu, word %zu: %08x instead of %08x", mode, i, k, to[k * ray_count + i],
                             words[k]);
                }
            }
        }
    }
    assert_int_equal(svo_trace_triangles(svo_tree_target(tree->tree), svo_in_host(from), svo_in_host(to), ray_count,
                                         3 | SVO_TRACE_BY_FIELD, NULL),
                     SVO_INVALID_ARGUMENT);
}

/* Packets whose rays come from one to four eyes, so that groups of every size occur; of each fourth packet a ray is
   invalid and another one unusually long. */
static void rays_of_a_packet_are_traced_in_groups(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 2048 };
    static svo_ray rays[RAYS];
    static svo_hit expected[RAYS];
    static svo_hit hits[RAYS];
    uint64_t random = 22;
    built tree;
    size_t met = 0;
    build_scene(opened, "knot:3000", 6, &tree);
    for (size_t i = 0; i < RAYS; ++i) {
        const size_t packet = i / 8;
        const size_t eye = (size_t)(random_unit(&random) * (double)(1 + packet % 4));
        const double length = packet % 4 != 3 ? 1.0 : i % 8 == 2 ? 0.0 : i % 8 == 5 ? 0x1p70 : 1.0;
        rays[i] = random_ray(&random, 1.0);
        for (int axis = 0; axis < 3; ++axis) {
            const double pixel[3] = {0.2 + 0.04 * (double)(packet % 16), 0.2 + 0.04 * floor((double)packet / 16.0),
                                     0.5};
            const double from = 1.5 + 0.25 * axis + 0.1 * (double)eye;
            rays[i].origin[axis] = (float)(tree.info.origin[axis] + tree.info.edge * from);
            rays[i].direction[axis] = (float)(length * tree.info.edge * (pixel[axis] + 1e-3 * (double)(i % 8) - from));
        }
    }
    run_arrays_kernel(opened, &tree, svo_kernel_options(svo_tree_target(NULL)), 0, rays, expected, RAYS);
    for (cl_uint any = 0; any < 2; ++any) {
        trace_rays(opened, &tree, rays, RAYS, any != 0 ? SVO_TRACE_ANY : SVO_TRACE_CLOSEST, hits);
        for (size_t i = 0; i < RAYS; ++i) {
            met += any == 0 && expected[i].triangle != SVO_NO_TRIANGLE;
        }
        expect_hits(hits, expected, RAYS, any, "packets");
    }
    assert_in_range(met, RAYS / 8, RAYS - RAYS / 8);
    expect_by_field(opened, &tree, rays, RAYS);
    expect_by_field(opened, &tree, rays + 3, RAYS - 6);
    built_destroy(&tree);
}

/* Bundles of 32 rays from one eye. Packets of the eighth ones are so far apart that they have few leaves in common; of
   others a ray is invalid, comes from elsewhere, ends soon or begins late, or a packet misses. */
static void coherent_packets_are_traced_in_bundles(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 16384 };
    static svo_ray rays[RAYS];
    static svo_hit expected[RAYS];
    static svo_hit hits[RAYS];
    uint64_t random = 23;
    double at[3] = {0, 0, 0.5};
    built tree;
    build_scene(opened, "knot:3000", 6, &tree);
    for (size_t i = 0; i < RAYS; ++i) {
        const size_t bundle = i / 32;
        const size_t kind = bundle % 8;
        const bool is_odd = i % 32 == bundle % 31; /* NOLINT: one of them */
        const double wide = kind == 0 ? 0.004 : 0.001;
        if (i % 32 == 0) {
            at[0] = 0.2 + 0.6 * random_unit(&random);
            at[1] = 0.2 + 0.6 * random_unit(&random);
        }
        const double from[3] = {1.5 + (kind == 5 && is_odd ? 0.5 : 0), 1.75, 2};
        const double to[3] = {at[0] + wide * (double)(i % 4), at[1] + wide * (double)(i / 4 % 8),
                              kind == 7 && i / 8 % 4 == 1 ? 9 : at[2]};
        rays[i] = random_ray(&random, 1.0);
        rays[i].t_min = kind == 3 && is_odd ? 1 : 0;
        rays[i].t_max = kind == 2 && is_odd ? 0.7F : INFINITY;
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = (float)(tree.info.origin[axis] + tree.info.edge * from[axis]);
            rays[i].direction[axis] = kind == 4 && is_odd ? 0 : (float)(tree.info.edge * (to[axis] - from[axis]));
        }
    }
    run_arrays_kernel(opened, &tree, svo_kernel_options(svo_tree_target(NULL)), 0, rays, expected, RAYS);
    for (cl_uint any = 0; any < 2; ++any) {
        trace_rays(opened, &tree, rays, RAYS, any != 0 ? SVO_TRACE_ANY : SVO_TRACE_CLOSEST, hits);
        expect_hits(hits, expected, RAYS, any, "bundles");
    }
    expect_by_field(opened, &tree, rays, 2048);
    built_destroy(&tree);
}

/* Packets of short rays in all directions from one or two places close to the surface, so that groups of every size
   occur; some rays are long, invalid, unusual, or begin behind their start. Every fifth packet starts at the grid's
   corner. */
static void rays_that_end_soon_are_traced_together(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 8192 };
    static svo_ray aimed[RAYS];
    static svo_ray rays[RAYS];
    static svo_hit expected[RAYS];
    static svo_hit hits[RAYS];
    uint64_t random = 23;
    built tree;
    size_t met = 0;
    build_scene(opened, "knot:20000", 7, &tree);
    for (size_t i = 0; i < RAYS; ++i) {
        aimed[i] = random_ray_near(&tree, &random, 1.0);
    }
    trace_rays(opened, &tree, aimed, RAYS, SVO_TRACE_CLOSEST, hits);
    for (size_t i = 0; i < RAYS; ++i) {
        const size_t packet = i / 8;
        const size_t place = packet * 8 + (random_unit(&random) * 8.0 < (double)(packet % 8) ? 1 : 0);
        const double t = hits[place].triangle != SVO_NO_TRIANGLE ? 0.999 * (double)hits[place].t : 0.5;
        const double length = i % 53 == 0 ? 0.0 : i % 31 == 0 ? 0x1p70 : 1.0;
        for (int axis = 0; axis < 3; ++axis) {
            const double from = (double)aimed[place].origin[axis] + t * (double)aimed[place].direction[axis];
            const double spread = 0.01 * tree.info.edge * (random_unit(&random) - 0.5);
            rays[i].origin[axis] = (float)((packet % 5 == 4 ? tree.info.origin[axis] : from) + spread);
            rays[i].direction[axis] = (float)(length * tree.info.edge * (random_unit(&random) - 0.5));
        }
        rays[i].t_min = i % 37 == 0 ? -0.05f : 0.0f;
        rays[i].t_max = (float)(i % 17 == 0 ? 2.0 : i % 41 == 0 ? -0.1 : 0.15 * random_unit(&random));
    }
    run_arrays_kernel(opened, &tree, svo_kernel_options(svo_tree_target(NULL)), 0, rays, expected, RAYS);
    for (size_t i = 0; i < RAYS; ++i) {
        met += expected[i].triangle != SVO_NO_TRIANGLE;
    }
    assert_in_range(met, RAYS / 8, RAYS - RAYS / 8);
    for (cl_uint any = 0; any < 2; ++any) {
        trace_rays(opened, &tree, rays, RAYS, any != 0 ? SVO_TRACE_ANY : SVO_TRACE_CLOSEST, hits);
        expect_hits(hits, expected, RAYS, any, "short rays");
    }
    built_destroy(&tree);
}

/* The tree needs no lists. A voxel is hit before the triangles in it, by at most its diagonal. */
static void voxel_hits_come_just_before_triangle_hits(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 1000 };
    static svo_ray rays[RAYS];
    static svo_hit triangles[RAYS];
    static svo_voxel_hit voxels[RAYS];
    uint64_t random = 8;
    scene *made = make_scene("knot:3000");
    built tree;
    built plain;
    size_t met = 0;
    build_for_rays(opened, scene_mesh(made), 6, NULL, 0, &tree);
    fixture_build(opened, scene_mesh(made), 6, &(svo_plan_options){.need = SVO_NEED_NONE}, &plain);
    for (size_t i = 0; i < RAYS; ++i) {
        rays[i] = random_ray(&random, 1.0);
        for (int axis = 0; axis < 3; ++axis) {
            const double side = axis == (int)(i % 3) ? 2.0 : (double)rays[i].origin[axis];
            const double towards = tree.info.origin[axis] + tree.info.edge * random_unit(&random);
            rays[i].origin[axis] = (float)(tree.info.origin[axis] + tree.info.edge * side);
            rays[i].direction[axis] = (float)(towards - (double)rays[i].origin[axis]);
        }
    }
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, triangles);
    run_voxel_kernel(opened, &plain, rays, voxels, RAYS);
    for (size_t i = 0; i < RAYS; ++i) {
        if (triangles[i].triangle != SVO_NO_TRIANGLE) {
            ++met;
            assert_int_not_equal(voxels[i].node, SVO_NO_NODE);
            assert_true(voxels[i].t <= triangles[i].t * 1.0001f);
        }
        if (voxels[i].node != SVO_NO_NODE) {
            assert_int_equal(voxels[i].level, 6);
            assert_in_range(voxels[i].node, plain.info.inner_count, plain.info.node_count - 1);
            assert_in_range(voxels[i].face, 0, 5);
            const int axis = (int)voxels[i].face / 2;
            assert_true(voxels[i].normal[axis] == (voxels[i].face % 2 == 0 ? -1.0f : 1.0f));
            assert_true(voxels[i].normal[axis] * rays[i].direction[axis] < 0.0f);
        }
    }
    assert_true(met > RAYS / 20);
    built_destroy(&plain);
    built_destroy(&tree);
    scene_destroy(&made);
}

/* ---- calls ---- */

static void invalid_calls_are_refused(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *made = make_scene("cube");
    const svo_ray ray = {{0.5f, 0.5f, -1}, {0, 0, 1}, 0, INFINITY};
    svo_hit hit;
    built plain;
    built tree;
    fixture_build(opened, scene_mesh(made), 3, &(svo_plan_options){.need = SVO_NEED_NONE}, &plain);
    build_for_rays(opened, scene_mesh(made), 3, NULL, 0, &tree);
    assert_int_equal(svo_trace_triangles(svo_tree_target(plain.tree), svo_in_host(&ray), svo_in_host(&hit), 1, 0,
                                         &(svo_submit){.queue = opened->queue}),
                     SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "SVO_NEED_RAYS"));
    assert_int_equal(svo_trace_triangles(svo_tree_target(tree.tree), svo_in_host(NULL), svo_in_host(&hit), 1, 0,
                                         &(svo_submit){.queue = opened->queue}),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_trace_triangles(svo_tree_target(tree.tree), svo_in_host(&ray), svo_in_host(NULL), 1, 0,
                                         &(svo_submit){.queue = opened->queue}),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_trace_triangles(svo_tree_target(tree.tree), svo_in_host(&ray), svo_in_host(&hit), 1, 0, NULL),
                     SVO_OK);
    assert_int_equal(svo_trace_triangles(svo_tree_target(tree.tree), svo_in_host(&ray), svo_in_host(&hit), 1, 7,
                                         &(svo_submit){.queue = opened->queue}),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_trace_triangles(svo_tree_target(NULL), svo_in_host(&ray), svo_in_host(&hit), 1, 0,
                                         &(svo_submit){.queue = opened->queue}),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_trace_triangles(svo_tree_target(tree.tree), svo_in_host(&ray), svo_in_host(&hit), 0, 0,
                                         &(svo_submit){.queue = opened->queue}),
                     SVO_OK);
    built_destroy(&tree);
    built_destroy(&plain);
    scene_destroy(&made);
}

/* On an out-of-order queue, only events define the order of commands. */
static void events_order_an_out_of_order_queue(void **state)
{
    const fixture *opened = fixture_of_group(state);
    built tree;
    build_scene(opened, "cube", 4, &tree);
    cl_int error = CL_SUCCESS;
    cl_context context = info_of_device(opened->device).context;
    cl_command_queue queue = clCreateCommandQueue(context, info_of_device(opened->device).device,
                                                  CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &error);
    if (error != CL_SUCCESS) {
        queue = clCreateCommandQueue(context, info_of_device(opened->device).device, 0, &error);
    }
    const svo_ray ray = {{(float)(tree.info.origin[0] + tree.info.edge * 0.3),
                          (float)(tree.info.origin[1] + tree.info.edge * 0.4), (float)(tree.info.origin[2] - 1)},
                         {0, 0, 1},
                         0,
                         INFINITY};
    svo_hit hit = {.triangle = SVO_NO_TRIANGLE};
    cl_mem rays = clCreateBuffer(context, CL_MEM_READ_WRITE, sizeof ray, NULL, &error);
    cl_mem hits = clCreateBuffer(context, CL_MEM_READ_WRITE, sizeof hit, NULL, &error);
    cl_event events[2] = {NULL, NULL};
    assert_int_equal(clEnqueueWriteBuffer(queue, rays, CL_FALSE, 0, sizeof ray, &ray, 0, NULL, &events[0]), CL_SUCCESS);
    assert_int_equal(
        svo_trace_triangles(svo_tree_target(tree.tree), svo_in_buffer(rays), svo_in_buffer(hits), 1, 0,
                            &(svo_submit){.queue = queue, .num_wait = 1, .wait = &events[0], .event = &events[1]}),
        SVO_OK);
    assert_int_equal(clEnqueueReadBuffer(queue, hits, CL_TRUE, 0, sizeof hit, &hit, 1, &events[1], NULL), CL_SUCCESS);
    assert_int_not_equal(hit.triangle, SVO_NO_TRIANGLE);
    assert_true(fabsf(hit.t - 1.0f) < 1e-4f);
    assert_int_equal(svo_trace_triangles(svo_tree_target(tree.tree), svo_in_buffer(rays), svo_in_buffer(hits), 2, 0,
                                         &(svo_submit){.queue = queue}),
                     SVO_INVALID_ARGUMENT);
    for (int i = 0; i < 2; ++i) {
        clReleaseEvent(events[i]);
    }
    clReleaseMemObject(rays);
    clReleaseMemObject(hits);
    clReleaseCommandQueue(queue);
    built_destroy(&tree);
}

TEST_GROUP(rays)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_report_the_point_on_the_triangle),
        cmocka_unit_test(rays_miss_an_empty_tree),
        cmocka_unit_test(any_hit_and_count_agree_with_the_reference),
        cmocka_unit_test(hits_do_not_depend_on_the_depth),
        cmocka_unit_test(hits_do_not_depend_on_neighboring_rays),
        cmocka_unit_test(hits_do_not_depend_on_the_batch_size),
        cmocka_unit_test(rays_through_a_stack_hit_the_next_sheet),
        cmocka_unit_test(coincident_and_nested_triangles_are_found),
        cmocka_unit_test(the_bvh_is_built_on_request),
        cmocka_unit_test(hits_do_not_depend_on_the_quality),
        cmocka_unit_test(hits_after_a_refit_are_those_of_a_new_bvh),
        cmocka_unit_test(the_bvh_is_refused_for_trees_without_lists),
        cmocka_unit_test(the_nearest_triangle_agrees_with_the_reference),
        cmocka_unit_test(an_own_kernel_traces_arrays_of_rays),
        cmocka_unit_test(rays_of_a_packet_are_traced_in_groups),
        cmocka_unit_test(coherent_packets_are_traced_in_bundles),
        cmocka_unit_test(rays_that_end_soon_are_traced_together),
        cmocka_unit_test(voxel_hits_come_just_before_triangle_hits),
        cmocka_unit_test(invalid_calls_are_refused),
        cmocka_unit_test(events_order_an_out_of_order_queue),
    };
    return cmocka_run_group_tests_name("rays", tests, fixture_group_setup, fixture_group_teardown);
}
