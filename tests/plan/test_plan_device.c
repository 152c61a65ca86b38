/* SPDX-License-Identifier: MIT */
/*
 * A plan that kernels make equals the host's, field by field: the snapped mesh, draw items, classes, estimate, payload
 * inputs, what is left out, predicted buffers, and messages of failures. On meshes of every kind, with counts around
 * those of work-items and groups. And both give work-items that run together about as much to do.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/arrays.h"
#include "plan/chunking.h"
#include "plan/plan_data.h"
#include "plan_compare.h"
#include "scenes.h"
#include "support/attributed_mesh.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

/* A plan, or the failure to make it. */
typedef struct attempt {
    svo_plan *plan; /* NULL after a failure */
    svo_status status;
    svo_message message;
} attempt;

static attempt make(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                    svo_place place)
{
    attempt made = {.plan = NULL};
    svo_mesh sized = *mesh;
    svo_plan_options placed = *options;
    sized.struct_size = sizeof sized;
    placed.struct_size = sizeof placed;
    placed.place = place;
    made.status = svo_plan_create(opened->device, &sized, depth, &placed, &made.plan);
    if (made.status != SVO_OK) {
        memcpy(made.message.text, svo_device_message(opened->device), sizeof made.message.text);
    } else {
        assert_int_equal(made.plan->info.place, place);
    }
    return made;
}

static void compare(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options)
{
    attempt host = make(opened, mesh, depth, options, SVO_PLACE_HOST);
    attempt device = make(opened, mesh, depth, options, SVO_PLACE_DEVICE);
    assert_int_equal(host.status, device.status);
    if (host.status == SVO_OK) {
        plan_compare(host.plan, device.plan);
    } else {
        assert_string_equal(host.message.text, device.message.text);
    }
    svo_plan_destroy(&host.plan);
    svo_plan_destroy(&device.plan);
}

/* Every coverage, grids fitted and given, depths on both sides of where arithmetic changes. */
static void compare_everywhere(const fixture *opened, const svo_mesh *mesh, uint32_t need)
{
    static const unsigned depths[] = {1, 6, 12, 16};
    static const double edges[] = {0.0, 0.4};
    for (size_t d = 0; d < sizeof depths / sizeof depths[0]; ++d) {
        for (int coverage = 0; coverage <= SVO_COVERAGE_THIN; ++coverage) {
            for (size_t e = 0; e < sizeof edges / sizeof edges[0]; ++e) {
                const svo_plan_options options = {
                    .need = need, .coverage = (svo_coverage)coverage, .edge = edges[e], .origin = {0.25, 0.25, 0.25}};
                compare(opened, mesh, depths[d], &options);
            }
        }
    }
}

static void random_meshes_of_all_counts_give_the_same_plan(void **state)
{
    static const size_t counts[] = {1, 15, 16, 17, 63, 64, 65, 1023, 1024, 1025, 3000};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        owned_mesh owned;
        random_mesh(40 + i, counts[i], i % 2 == 0 ? 0.0 : 0.5, &owned);
        compare_everywhere(&opened, &owned.mesh, SVO_NEED_NONE);
        owned_mesh_free(&owned);
    }
}

static void ill_conditioned_meshes_give_the_same_plan(void **state)
{
    static const double offsets[] = {0.0, 1e3, 65536.0, 1e6, 1e9, 1e12};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof offsets / sizeof offsets[0]; ++i) {
        const double corner[3] = {offsets[i], -offsets[i], offsets[i] * 0.5};
        owned_mesh owned;
        random_dust(7 + i, 200, corner, 1.0, &owned);
        compare_everywhere(&opened, &owned.mesh, SVO_NEED_NONE);
        owned_mesh_free(&owned);
    }
    owned_mesh owned;
    random_needles(3, 500, &owned);
    compare_everywhere(&opened, &owned.mesh, SVO_NEED_ALL);
    owned_mesh_free(&owned);
    corner_mesh(6, &owned);
    compare_everywhere(&opened, &owned.mesh, SVO_NEED_ALL);
    owned_mesh_free(&owned);
}

static void meshes_without_triangles_give_the_same_plan(void **state)
{
    static const float point[3] = {0.5F, 0.5F, 0.5F};
    static const uint32_t indices[6] = {0, 0, 0, 1, 2, 3};
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh empty = {.struct_size = sizeof empty};
    const svo_mesh no_vertices = {.indices = indices, .triangle_count = 2};
    const svo_mesh one_point = {.positions = point, .vertex_count = 1, .indices = indices, .triangle_count = 2};
    const svo_mesh too_many = {.positions = point, .vertex_count = 1, .triangle_count = 100};
    const svo_mesh unused = {.positions = point, .vertex_count = 1};
    compare_everywhere(&opened, &empty, SVO_NEED_ALL);
    compare_everywhere(&opened, &no_vertices, SVO_NEED_ALL);
    compare_everywhere(&opened, &one_point, SVO_NEED_ALL);
    compare_everywhere(&opened, &too_many, SVO_NEED_ALL);
    compare_everywhere(&opened, &unused, SVO_NEED_ALL);
}

/* Writes numbers of every kind over some coordinates, and indices out of range over some corners. */
static void spoil(owned_mesh *owned, uint64_t seed, double huge)
{
    const double bad[] = {NAN, INFINITY, -INFINITY, -0.0, 5e-324, 1e-40, huge, -huge, 0.0, 1.0};
    uint64_t random = seed;
    for (size_t i = 0; i < owned->mesh.triangle_count / 4; ++i) {
        const uint32_t coordinate = random_below(&random, (uint32_t)owned->mesh.vertex_count * 3);
        const uint32_t corner = random_below(&random, (uint32_t)owned->mesh.triangle_count * 3);
        owned->positions[coordinate] = bad[random_below(&random, sizeof bad / sizeof bad[0])];
        if (i % 8 == 0) {
            owned->indices[corner] = i % 16 == 0 ? UINT32_MAX : (uint32_t)owned->mesh.vertex_count;
        }
    }
}

static void garbage_gives_the_same_plan_or_the_same_message(void **state)
{
    static const double huge[] = {1e3, 1e30, 1e300, 1.7e308};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof huge / sizeof huge[0]; ++i) {
        owned_mesh owned;
        random_mesh(90 + i, 700, 0.5, &owned);
        spoil(&owned, i, huge[i]);
        compare_everywhere(&opened, &owned.mesh, SVO_NEED_ALL);
        owned_mesh_free(&owned);
    }
}

/* The attributes of half the corners' vertices, or of all of them, become equal. */
static void flatten(attributed_mesh *made, bool colors, bool normals, bool materials)
{
    for (size_t v = 1; v < made->mesh.vertex_count; ++v) {
        for (size_t k = 0; k < 4 && colors; ++k) {
            made->colors[v * 4 + k] = made->colors[k];
        }
        for (size_t k = 0; k < 3 && normals; ++k) {
            made->normals[v * 3 + k] = made->normals[k];
        }
    }
    for (size_t t = 0; t < made->mesh.triangle_count && materials; ++t) {
        made->triangle_materials[t] = 3;
    }
}

static void attributes_give_the_same_plan(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (unsigned bits = 0; bits < 32; ++bits) {
        attributed_mesh made;
        attributed_mesh_create(50 + bits, bits % 5 * 400 + 1, 0.3, &made);
        flatten(&made, (bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0);
        made.mesh.uvs = (bits & 8) != 0 ? NULL : made.mesh.uvs;
        made.mesh.texture_count = (bits & 16) != 0 ? 0 : made.mesh.texture_count;
        if (bits == 31) { /* zero normals stand for the triangles' own */
            memset(made.normals, 0, made.mesh.vertex_count * 3 * sizeof *made.normals);
        }
        compare_everywhere(&opened, &made.mesh, bits % 3 == 0 ? SVO_NEED_DEFAULT : SVO_NEED_ALL);
        attributed_mesh_destroy(&made);
    }
}

static void unusual_attributes_give_the_same_plan(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const float bad[] = {NAN, INFINITY, -INFINITY, -0.0F, 1e-45F, 3e38F, 1e9F, -1e9F};
    attributed_mesh made;
    attributed_mesh_create(77, 900, 0.3, &made);
    for (size_t i = 0; i < made.mesh.vertex_count; ++i) {
        made.normals[i * 3 + i % 3] = i % 3 == 0 ? bad[i / 3 % 8] : made.normals[i * 3 + i % 3];
        made.uvs[i * 2 + i % 2] = i % 5 == 0 ? bad[i / 5 % 8] : made.uvs[i * 2 + i % 2];
    }
    for (size_t t = 0; t < made.mesh.triangle_count; t += 7) {
        made.triangle_materials[t] = 65535;
    }
    compare_everywhere(&opened, &made.mesh, SVO_NEED_ALL);
    attributed_mesh_destroy(&made);
}

/* Floats, indices, normals and colors; some are closed, some open. */
static void scenes_give_the_same_plan(void **state)
{
    static const char *const specs[] = {"cube",        "statue:5000", "knot:3000",   "terrain:2000",
                                        "needles:500", "dust:2000",   "cornell:500", "atrium"};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; ++i) {
        scene *made = fixture_scene(specs[i]);
        const svo_plan_options chunked = {.need = SVO_NEED_ALL, .chunk_bytes = 16384};
        compare_everywhere(&opened, scene_mesh(made), SVO_NEED_ALL);
        compare(&opened, scene_mesh(made), 8, &chunked);
        scene_destroy(&made);
    }
}

/* Without indices, in floats. */
static void soups_give_the_same_plan(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    float positions[333 * 3];
    uint64_t random = 12;
    for (size_t i = 0; i < sizeof positions / sizeof positions[0]; ++i) {
        positions[i] = (float)random_unit(&random);
    }
    positions[100] = NAN;
    const svo_mesh soup = {.positions = positions, .vertex_count = 333, .triangle_count = 120};
    compare_everywhere(&opened, &soup, SVO_NEED_ALL);
}

/* Builds of both plans: one chunk and many, blocking, with and without rays. */
static void both_plans_build_the_same_tree(void **state)
{
    static const uint32_t needs[] = {SVO_NEED_NONE, SVO_NEED_ALL};
    const fixture opened = fixture_cl_of_group(state);
    attributed_mesh made;
    attributed_mesh_create(21, 2000, 0.2, &made);
    for (size_t i = 0; i < 4; ++i) {
        svo_plan_options options = {.need = needs[i / 2], .edge = 1.0, .chunk_bytes = i % 2 * UINT64_C(65536)};
        built host;
        built device;
        options.place = SVO_PLACE_HOST;
        fixture_build(&opened, &made.mesh, 6, &options, &host);
        options.place = SVO_PLACE_DEVICE;
        fixture_build(&opened, &made.mesh, 6, &options, &device);
        assert_int_equal(device.plan.place, SVO_PLACE_DEVICE);
        assert_string_equal(host.hash, device.hash);
        assert_true(host.buffer_count > device.buffer_count); /* the mesh is on the device already */
        built_destroy(&host);
        built_destroy(&device);
    }
    attributed_mesh_destroy(&made);
}

/* A handle makes its first small plans on the host, and later ones by kernels. */
static void plans_move_to_the_device_after_enough_triangles(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *large = fixture_scene("terrain:131072");
    scene *small = fixture_scene("terrain:4096");
    scene *least = fixture_scene("terrain:4095");
    svo_device *device = NULL;
    svo_message message;
    assert_int_equal(svo_device_create(info_of_device(opened.device).context, info_of_device(opened.device).device,
                                       NULL, &device, &message),
                     SVO_OK);
    const struct {
        const scene *made;
        svo_place place;
    } steps[] = {{small, SVO_PLACE_HOST}, {least, SVO_PLACE_HOST}, {large, SVO_PLACE_HOST}, /* 131,072 triangles each */
                 {large, SVO_PLACE_HOST}, {large, SVO_PLACE_HOST}, {large, SVO_PLACE_DEVICE}, {small, SVO_PLACE_DEVICE},
                 {least, SVO_PLACE_HOST}};
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; ++i) {
        svo_plan *plan = NULL;
        svo_plan_info info = SVO_PLAN_INFO_INIT;
        assert_int_equal(svo_plan_create(device, scene_mesh(steps[i].made), 5, NULL, &plan), SVO_OK);
        assert_int_equal(svo_plan_get_info(plan, &info), SVO_OK);
        assert_int_equal(info.place, steps[i].place);
        svo_plan_destroy(&plan);
    }
    svo_device_destroy(&device);
    scene_destroy(&large);
    scene_destroy(&small);
    scene_destroy(&least);
}

/* ---- equal work ---- */

/* Columns of work-items: their own, and those if each of LANES neighbors had as many as the busiest. */
typedef struct busy_lanes {
    uint64_t own, busiest;
} busy_lanes;

#define LANES 32

static void add_lanes(const uint32_t *columns, size_t count, busy_lanes *busy)
{
    for (size_t first = 0; first < count; first += LANES) {
        uint32_t most = 0;
        for (size_t i = first; i < count && i < first + LANES; ++i) {
            busy->own += columns[i];
            most = columns[i] > most ? columns[i] : most;
        }
        busy->busiest += (uint64_t)most * LANES;
    }
}

/* The voxels of an item on the two axes across that of its projection; its triangle lies in the grid. */
static void item_voxels(const svo_plan *plan, uint32_t item, int32_t first[2], int32_t end[2])
{
    const uint32_t *corners = plan->indices + (size_t)plan->items[item].triangle * 3;
    for (unsigned k = 0; k < 2; ++k) {
        const unsigned axis = ((plan->items[item].flags & SVO_DRAW_AXIS_MASK) + 1 + k) % 3;
        first[k] = INT32_MAX;
        end[k] = 0;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t voxel = plan->vertices[(size_t)corners[corner] * 3 + axis] >> plan->voxel_log2;
            first[k] = voxel < first[k] ? voxel : first[k];
            end[k] = voxel >= end[k] ? voxel + 1 : end[k];
        }
    }
}

static uint32_t item_columns(const svo_plan *plan, uint32_t item)
{
    int32_t first[2];
    int32_t end[2];
    item_voxels(plan, item, first, end);
    const uint32_t columns = (uint32_t)(end[0] - first[0]) * (uint32_t)(end[1] - first[1]);
    return columns <= SVO_TILE_COLUMNS ? columns : 0;
}

static uint32_t tile_columns(const svo_plan *plan, const svo_tile_item *tile)
{
    const int32_t corner[2] = {(int32_t)(tile->corner & 0xffffu), (int32_t)(tile->corner >> 16)};
    uint32_t columns = 1;
    int32_t first[2];
    int32_t end[2];
    item_voxels(plan, tile->item, first, end);
    for (unsigned k = 0; k < 2; ++k) {
        columns *= (uint32_t)(end[k] - corner[k] < SVO_TILE_EDGE ? end[k] - corner[k] : SVO_TILE_EDGE);
    }
    return columns;
}

/* Adds the work-items of a draw of all triangles of a class. */
static void add_class(const svo_plan *plan, svo_i_class class_id, busy_lanes *busy)
{
    const uint32_t begin = plan->class_begin[class_id];
    const uint32_t grid = 1u << plan->info.depth;
    const svo_i_draw draw = {class_id, begin, plan->class_begin[class_id + 1] - begin, 0, 0, grid, grid};
    svo_i_tiles tiles = {0};
    assert_true(svo_i_tiles_of_draw(plan, &draw, 0, &tiles));
    const size_t most = draw.item_count > tiles.count ? draw.item_count : tiles.count;
    uint32_t *columns = calloc(most + 1, sizeof *columns);
    assert_non_null(columns);
    for (uint32_t i = 0; i < draw.item_count; ++i) {
        columns[i] = item_columns(plan, begin + i);
    }
    add_lanes(columns, draw.item_count, busy);
    for (size_t i = 0; i < tiles.count; ++i) {
        columns[i] = tile_columns(plan, &tiles.items[i]);
    }
    add_lanes(columns, tiles.count, busy);
    free(columns);
    svo_i_tiles_free(&tiles);
}

/* In the order of the mesh the voxelizer's lanes are busy for 60 and 70 % of the time of the busiest. Triangles inside
   one voxel are left out: all have one column. */
static void neighbors_visit_about_as_many_columns(void **state)
{
    static const char *const scenes[] = {"statue:20000", "atrium:17000"};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i) {
        scene *made = fixture_scene(scenes[i]);
        for (svo_place place = SVO_PLACE_HOST; place <= SVO_PLACE_DEVICE; ++place) {
            busy_lanes busy = {0, 0};
            attempt planned = make(&opened, scene_mesh(made), 8, &(svo_plan_options){.need = SVO_NEED_NONE}, place);
            assert_int_equal(planned.status, SVO_OK);
            assert_int_equal(svo_i_plan_copy_to_host(planned.plan), SVO_OK);
            for (svo_i_class c = SVO_I_CLASS_NARROW; c < SVO_I_CLASS_COUNT; ++c) {
                add_class(planned.plan, c, &busy);
            }
            print_message("%s, %s: %.3f\n", scenes[i], svo_name(SVO_NAME_PLACE, place),
                          (double)busy.own / (double)busy.busiest);
            assert_true(busy.own > 0);
            assert_in_range(busy.own * 10, busy.busiest * 9, busy.busiest * 10);
            svo_plan_destroy(&planned.plan);
        }
        scene_destroy(&made);
    }
}

TEST_GROUP(plan_device)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(neighbors_visit_about_as_many_columns),
        cmocka_unit_test(random_meshes_of_all_counts_give_the_same_plan),
        cmocka_unit_test(ill_conditioned_meshes_give_the_same_plan),
        cmocka_unit_test(meshes_without_triangles_give_the_same_plan),
        cmocka_unit_test(garbage_gives_the_same_plan_or_the_same_message),
        cmocka_unit_test(attributes_give_the_same_plan),
        cmocka_unit_test(unusual_attributes_give_the_same_plan),
        cmocka_unit_test(scenes_give_the_same_plan),
        cmocka_unit_test(soups_give_the_same_plan),
        cmocka_unit_test(both_plans_build_the_same_tree),
        cmocka_unit_test(plans_move_to_the_device_after_enough_triangles),
    };
    return cmocka_run_group_tests_name("plan_device", tests, fixture_group_setup, fixture_group_teardown);
}
