/* SPDX-License-Identifier: MIT */
/*
 * Photons into leaves: every sum equals that of a reference on the host, bit for bit, and over all leaves they are the
 * flux that hit. Radiance against closed forms: Lambert's law, inverse squares, emission; none behind a lit wall.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/work.h"
#include "light/shoot.h"
#include "light_fixture.h"
#include "photon_reference.h"
#include "scenes.h"
#include "support/meshes.h"
#include "support/suite.h"
#include "wall_mesh.h"

#define PI 3.14159265358979323846

/* ---- lit leaves on the host ---- */

typedef struct lit_leaves {
    uint64_t count;
    uint32_t *leaves;
    uint32_t *radiance; /* count * values */
    uint64_t values;
    uint64_t *flux; /* count * 6 */
    double unit;
    svo_light_info info;
} lit_leaves;

static void *read_scratch(const fixture *opened, cl_mem buffer, size_t bytes)
{
    void *data = malloc(bytes + 1);
    assert_non_null(data);
    if (bytes > 0) {
        assert_int_equal(clEnqueueReadBuffer(opened->queue, buffer, CL_TRUE, 0, bytes, data, 0, NULL, NULL),
                         CL_SUCCESS);
    }
    return data;
}

/* Shines, and reads what the filter would get. Released by free_lit. */
static void shine(const fixture *opened, svo_light *light, const svo_light_setup *setup, lit_leaves *out)
{
    svo_i_device_work work;
    svo_i_lit_leaves lit;
    light_succeed(opened, svo_light_set_sources(light, NULL, opened->queue)); /* dark */
    light_succeed(opened, svo_i_work_begin(opened->device, "shine", opened->queue, &work));
    light_succeed(opened, svo_i_light_shine(&work, light, setup, NULL, &lit));
    light_succeed(opened, svo_i_work_wait(&work));
    *out = (lit_leaves){.count = lit.lit_count, .unit = (double)lit.unit, .info = light_info_of(light)};
    out->values = light->info.form == SVO_LIGHT_FACES ? 18 : 3;
    out->leaves = read_scratch(opened, lit.leaves, lit.lit_count * sizeof(uint32_t));
    out->radiance = read_scratch(opened, lit.radiance, lit.lit_count * out->values * sizeof(uint32_t));
    out->flux = read_scratch(opened, light->buffers[SVO_LIGHT_FLUX], lit.lit_count * 6 * sizeof(uint64_t));
    svo_i_work_end(&work);
}

static void free_lit(lit_leaves *lit)
{
    free(lit->leaves);
    free(lit->radiance);
    free(lit->flux);
    *lit = (lit_leaves){.count = 0};
}

static double radiance_at(const lit_leaves *lit, uint64_t place, unsigned direction, unsigned channel)
{
    return lit->radiance[place * lit->values + (lit->values == 18 ? direction * 3 : 0) + channel] * lit->unit;
}

static void assert_near(double found, double expected, double error, const char *what)
{
    if (!(fabs(found - expected) <= error)) {
        fail_msg("%s: %.9g is not within %g of %.9g", what, found, error, expected);
        return;
    }
}

static const svo_plan_options everything = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS |
                                                    SVO_NEED_MATERIAL | SVO_NEED_FILL};

/* ---- sums ---- */

/* The library's sums, as the reference makes them. */
static void sum_reference(const fixture *opened, const built *made, const svo_light_setup *setup, double unit,
                          photon_sums *sums, uint64_t *hits)
{
    svo_grid grid;
    svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX];
    svo_i_lit_box box = {.leaf_edge = 0};
    assert_int_equal(svo_tree_get_grid(made->tree, &grid), SVO_OK);
    box.leaf_edge = svo_grid_cell_edge(&grid, grid.depth);
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = INFINITY;
        box.high[axis] = -INFINITY;
    }
    for (uint64_t leaf = made->info.inner_count; leaf < made->info.node_count; ++leaf) {
        double low[3];
        double high[3];
        assert_int_equal(svo_tree_node_box(made->tree, (uint32_t)leaf, low, high), SVO_OK);
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] = fmin(box.low[axis], low[axis]);
            box.high[axis] = fmax(box.high[axis], high[axis]);
        }
    }
    *hits = 0;
    for (size_t i = 0; i < setup->source_count; ++i) {
        const uint32_t count = svo_i_light_views(&setup->sources[i], &box, setup->view_resolution, views);
        for (uint32_t k = 0; k < count; ++k) {
            *hits += reference_shoot(opened, made, &views[k], setup->sources[i].value, unit, sums);
        }
    }
}

/* The unit of flux, from the flux in world units and in the leaves. */
static double unit_of_flux(const lit_leaves *lit)
{
    uint64_t sum = 0;
    for (uint64_t i = 0; i < lit->count; ++i) {
        sum += lit->flux[i * 6];
    }
    assert_true(sum > 0);
    return lit->info.flux[0] / (double)sum;
}

static void compare_sums(const lit_leaves *lit, const photon_sums *sums, uint64_t leaf_count)
{
    uint64_t place = 0;
    for (uint64_t leaf = 0; leaf < leaf_count; ++leaf) {
        if (sums[leaf].photons == 0) {
            continue;
        }
        assert_true(place < lit->count);
        assert_int_equal(lit->leaves[place], leaf);
        for (int k = 0; k < 3; ++k) {
            assert_int_equal(lit->flux[place * 6 + (uint64_t)k], sums[leaf].flux[k]);
            assert_int_equal((int64_t)lit->flux[place * 6 + 3 + (uint64_t)k], sums[leaf].along[k]);
        }
        ++place;
    }
    assert_int_equal(place, lit->count);
}

/* Radiance is albedo times the sum over pi h^2. */
static void compare_radiance(const built *made, const lit_leaves *lit, const photon_sums *sums, double unit)
{
    svo_grid grid;
    assert_int_equal(svo_tree_get_grid(made->tree, &grid), SVO_OK);
    const double edge = svo_grid_cell_edge(&grid, grid.depth);
    for (uint64_t i = 0; i < lit->count; ++i) {
        const uint8_t *color = made->arrays.colors + (made->info.inner_count + lit->leaves[i]) * 4;
        for (unsigned k = 0; k < 18; ++k) {
            const double coded = color[k % 3] / 255.0;
            const double albedo = coded <= 0.04045 ? coded / 12.92 : pow((coded + 0.055) / 1.055, 2.4);
            const double flux = (double)sums[lit->leaves[i]].faces[k] * unit;
            const double expected = albedo * flux / (PI * edge * edge);
            assert_near(radiance_at(lit, i, k / 3, k % 3), expected, flux / (PI * edge * edge) * 2e-5 + lit->unit,
                        "radiance");
        }
    }
}

static const svo_light_source three_sources[] = {
    {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {-0.3F, -1.0F, -0.2F}, .value = {3.0F, 2.0F, 1.0F}},
    {.kind = SVO_SOURCE_POINT, .position = {0.6F, 0.7F, 0.5F}, .value = {0.1F, 0.0F, 0.5F}},
    {.kind = SVO_SOURCE_SPOT,
     .position = {2.0F, 0.5F, 0.4F},
     .direction = {-1.0F, 0.0F, 0.1F},
     .value = {2.0F, 2.0F, 5.0F},
     .inner_angle = 0.2F,
     .outer_angle = 0.5F},
};

static void check_sums(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_light_setup *setup)
{
    built made;
    lit_leaves lit;
    uint64_t hits = 0;
    fixture_build(opened, mesh, depth, &everything, &made);
    svo_light *light = light_of(opened, made.tree, SVO_LIGHT_FACES);
    shine(opened, light, setup, &lit);
    const double unit = unit_of_flux(&lit);
    photon_sums *sums = calloc(made.info.leaf_count, sizeof *sums);
    assert_non_null(sums);
    sum_reference(opened, &made, setup, unit, sums, &hits);
    assert_int_equal(lit.info.photon_hits, hits);
    assert_true(lit.info.lost_flux < 1e-6);
    compare_sums(&lit, sums, made.info.leaf_count);
    compare_radiance(&made, &lit, sums, unit);
    for (int channel = 0; channel < 3; ++channel) {
        uint64_t all = 0;
        for (uint64_t leaf = 0; leaf < made.info.leaf_count; ++leaf) {
            all += (uint64_t)sums[leaf].flux[channel];
        }
        assert_true((double)all * unit == lit.info.flux[channel]);
    }
    free(sums);
    free_lit(&lit);
    svo_light_destroy(&light);
    built_destroy(&made);
}

/* Triangles of every kind: slivers, needles, points, on the faces of voxels, outside the grid. */
static void test_sums_are_those_of_the_reference(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = three_sources;
    setup.source_count = 3;
    setup.view_resolution = 60;
    for (unsigned i = 0; i < 3; ++i) {
        owned_mesh random;
        random_mesh(40 + i, 120, i == 2 ? 1.0 : 0, &random);
        check_sums(&opened, &random.mesh, 3 + i, &setup);
        owned_mesh_free(&random);
    }
}

static void test_sums_of_a_scene(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *cornell = fixture_scene("cornell:94");
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = three_sources;
    setup.source_count = 2;
    setup.view_resolution = 100;
    check_sums(&opened, scene_mesh(cornell), 5, &setup);
    scene_destroy(&cornell);
}

/* ---- closed forms ---- */

static svo_light_setup setup_of(const svo_light_source *source, uint32_t resolution)
{
    return (svo_light_setup){
        .struct_size = sizeof(svo_light_setup), .sources = source, .source_count = 1, .view_resolution = resolution};
}

/* Whether a leaf is of the wall, away from its border. middle: receives the leaf's. */
static bool is_inner(const built *made, uint32_t leaf, double middle[3])
{
    double low[3];
    double high[3];
    assert_int_equal(svo_tree_node_box(made->tree, (uint32_t)made->info.inner_count + leaf, low, high), SVO_OK);
    for (int axis = 0; axis < 3; ++axis) {
        middle[axis] = (low[axis] + high[axis]) / 2;
    }
    return fabs(middle[1] - 0.5) < WALL_EDGE && middle[0] > WALL_EDGE && middle[0] < 1 - WALL_EDGE &&
           middle[2] > WALL_EDGE && middle[2] < 1 - WALL_EDGE;
}

/* White walls: the mesh has no colors, and the tree's are white. From above: a ray that goes along -y sees it. Four
   photons a leaf are enough, since they spread. */
static void test_parallel_light_obeys_lambert(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh mesh = wall_mesh();
    const svo_plan_options grid = wall_grid();
    const double irradiance[3] = {4, 2, 0.5};
    built made;
    fixture_build(&opened, &mesh, WALL_DEPTH, &grid, &made);
    svo_light *light = light_of(&opened, made.tree, SVO_LIGHT_FACES);
    const float directions[][3] = {{0, -1, 0}, {0.5F, -1, 0}, {1, -0.3F, 2}, {0, 2, 0.7F}};
    for (size_t n = 0; n < sizeof directions / sizeof directions[0]; ++n) {
        const float *d = directions[n];
        const svo_light_source source = {.kind = SVO_SOURCE_DIRECTIONAL,
                                         .direction = {d[0], d[1], d[2]},
                                         .value = {(float)irradiance[0], (float)irradiance[1], (float)irradiance[2]}};
        /* Grazing light needs more: photons reach too many leaves. */
        const svo_light_setup setup = setup_of(&source, n == 2 ? 1500 : 0);
        const double length = sqrt((double)(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
        const double cosine = fabs((double)d[1]) / length;
        const unsigned lit_side = d[1] < 0 ? 3 : 2;
        unsigned checked = 0;
        lit_leaves lit;
        shine(&opened, light, &setup, &lit);
        for (uint64_t i = 0; i < lit.count; ++i) {
            double middle[3];
            if (!is_inner(&made, lit.leaves[i], middle)) {
                continue;
            }
            ++checked;
            for (unsigned direction = 0; direction < 6; ++direction) {
                for (unsigned channel = 0; channel < 3; ++channel) {
                    const double expected = direction == lit_side ? irradiance[channel] * cosine / PI : 0;
                    assert_near(radiance_at(&lit, i, direction, channel), expected, expected * 0.06, "radiance");
                }
            }
            const double all = (double)(lit.flux[i * 6] + lit.flux[i * 6 + 1] + lit.flux[i * 6 + 2]);
            for (int axis = 0; axis < 3; ++axis) {
                assert_near((double)(int64_t)lit.flux[i * 6 + 3 + (uint64_t)axis] / all, (double)d[axis] / length, 1e-6,
                            "mean direction");
            }
        }
        assert_int_equal(checked, 30 * 30);
        free_lit(&lit);
    }
    svo_light_destroy(&light);
    built_destroy(&made);
}

static void test_point_light_obeys_inverse_squares(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh mesh = wall_mesh();
    const svo_plan_options grid = wall_grid();
    const svo_light_source source = {
        .kind = SVO_SOURCE_POINT, .position = {0.4F, 0.8F, 0.7F}, .value = {1.0F, 2.0F, 0.0F}};
    const svo_light_setup setup = setup_of(&source, 600);
    unsigned checked = 0;
    double sum = 0;
    double expected_sum = 0;
    built made;
    lit_leaves lit;
    fixture_build(&opened, &mesh, WALL_DEPTH, &grid, &made);
    svo_light *light = light_of(&opened, made.tree, SVO_LIGHT_FACES);
    shine(&opened, light, &setup, &lit);
    for (uint64_t i = 0; i < lit.count; ++i) {
        double middle[3];
        if (!is_inner(&made, lit.leaves[i], middle)) {
            continue;
        }
        const double to[3] = {middle[0] - (double)source.position[0], 0.5 - (double)source.position[1],
                              middle[2] - (double)source.position[2]};
        const double squared = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
        const double expected = fabs(to[1]) / sqrt(squared) / squared / PI;
        assert_near(radiance_at(&lit, i, 3, 0), expected, expected * 0.1, "red");
        assert_near(radiance_at(&lit, i, 3, 1), 2 * expected, 2 * expected * 0.1, "green");
        assert_near(radiance_at(&lit, i, 3, 2), 0, 0, "blue");
        assert_near(radiance_at(&lit, i, 2, 1), 0, 0, "the back");
        sum += radiance_at(&lit, i, 3, 0);
        expected_sum += expected;
        ++checked;
    }
    assert_int_equal(checked, 30 * 30);
    assert_near(sum, expected_sum, expected_sum * 2e-3, "all leaves");
    free_lit(&lit);
    svo_light_destroy(&light);
    built_destroy(&made);
}

/* Without directions: flux over the surface's area in the leaf, whose fill says how large that is. sheets: walls in one
   place, of which light meets one. */
static void check_without_directions(const fixture *opened, svo_light_form form, unsigned sheets)
{
    static const uint32_t indices[] = {4, 4, 4, 5, 5, 5, 0, 1, 2, 0, 2, 3, 0, 1, 2, 0, 2, 3};
    svo_mesh mesh = wall_mesh();
    const svo_plan_options grid = wall_grid();
    const svo_light_source source = {
        .kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, -1, 0}, .value = {1.0F, 0.5F, 0.25F}};
    const svo_light_setup setup = setup_of(&source, 1024);
    const double red = 1 / PI / sheets;
    unsigned checked = 0;
    built made;
    lit_leaves lit;
    mesh.indices = indices;
    mesh.triangle_count = 2 + 2 * (size_t)sheets;
    fixture_build(opened, &mesh, WALL_DEPTH, &grid, &made);
    svo_light *light = light_of(opened, made.tree, form);
    shine(opened, light, &setup, &lit);
    for (uint64_t i = 0; i < lit.count; ++i) {
        double middle[3];
        if (is_inner(&made, lit.leaves[i], middle)) {
            ++checked;
            assert_near(radiance_at(&lit, i, 0, 0), red, 0.01, "red");
            assert_near(radiance_at(&lit, i, 0, 1), red / 2, 0.005, "green");
            assert_near(radiance_at(&lit, i, 0, 2), red / 4, 0.0025, "blue");
        }
    }
    assert_int_equal(checked, 30 * 30);
    free_lit(&lit);
    svo_light_destroy(&light);
    built_destroy(&made);
}

static void test_radiance_without_directions(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (unsigned sheets = 1; sheets <= 2; ++sheets) {
        check_without_directions(&opened, SVO_LIGHT_BRICKS, sheets);
        check_without_directions(&opened, SVO_LIGHT_VOXELS, sheets);
    }
}

/* ---- emission ---- */

/* A wall that covers a face along y, and none along x and z. */
static void test_emission_is_premultiplied_by_area(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_finish finish = {.emission = {3, 2, 1}};
    const svo_material white = {{255, 255, 255, 255}, SVO_NO_TEXTURE};
    svo_plan_options grid = wall_grid();
    svo_mesh mesh = wall_mesh();
    mesh.materials = &white;
    mesh.material_count = 1;
    grid.need |= SVO_NEED_PROJECTED_AREA;
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.finishes = &finish;
    setup.finish_count = 1;
    unsigned checked = 0;
    built made;
    lit_leaves lit;
    fixture_build(&opened, &mesh, WALL_DEPTH, &grid, &made);
    svo_light *light = light_of(&opened, made.tree, SVO_LIGHT_FACES);
    shine(&opened, light, &setup, &lit);
    for (uint64_t i = 0; i < lit.count; ++i) {
        double middle[3];
        const bool inner = is_inner(&made, lit.leaves[i], middle);
        for (unsigned k = 0; k < 18 && inner; ++k) {
            const double expected = k / 3 == 2 || k / 3 == 3 ? 3.0 - k % 3 : 0;
            assert_near(radiance_at(&lit, i, k / 3, k % 3), expected, 2e-3, "emission");
            ++checked;
        }
    }
    assert_int_equal(checked, 30 * 30 * 18);
    free_lit(&lit);
    svo_light_destroy(&light);
    built_destroy(&made);
}

static void test_emitting_materials_are_lit(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const uint16_t triangle_materials[] = {1, 1, 0, 2};
    const svo_material materials[] = {{{255, 255, 255, 255}, SVO_NO_TEXTURE},
                                      {{255, 255, 255, 127}, SVO_NO_TEXTURE},
                                      {{255, 255, 255, 255}, SVO_NO_TEXTURE}};
    const svo_finish finishes[] = {{.emission = {0, 0, 0}}, {.emission = {10, 0.125F, 2000}}};
    const svo_plan_options grid = wall_grid();
    svo_mesh mesh = wall_mesh();
    mesh.triangle_materials = triangle_materials;
    mesh.materials = materials;
    mesh.material_count = 3;
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.finishes = finishes;
    setup.finish_count = 2;
    built made;
    fixture_build(&opened, &mesh, WALL_DEPTH, &grid, &made);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        lit_leaves lit;
        svo_light *light = light_of(&opened, made.tree, (svo_light_form)form);
        shine(&opened, light, &setup, &lit);
        const double alpha = form == SVO_LIGHT_FACES ? 127.0 / 255 : 1;
        assert_int_equal(lit.count, 32 * 32);
        assert_int_equal(lit.info.photons, 0);
        for (uint64_t i = 0; i < lit.count; ++i) {
            for (unsigned direction = 0; direction < 6; ++direction) {
                assert_near(radiance_at(&lit, i, direction, 0), 10 * alpha, 1e-5, "red");
                assert_near(radiance_at(&lit, i, direction, 1), 0.125 * alpha, 1e-5, "green");
                assert_near(radiance_at(&lit, i, direction, 2), 2000 * alpha, 1e-4, "blue");
            }
        }
        free_lit(&lit);
        svo_light_destroy(&light);
    }
    built_destroy(&made);
}

/* Emission times opacity, both whole numbers, is rounded half up: in every form of it, over all opacities. */
static void test_premultiplied_emission_is_rounded(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_finish finish = {.emission = {1, 0.75F, 0.3F}};
    const svo_plan_options grid = wall_grid();
    svo_mesh mesh = wall_mesh();
    unsigned halves = 0;
    for (unsigned alpha = 1; alpha <= 255; alpha += 2) {
        const svo_material material = {{255, 255, 255, (uint8_t)alpha}, SVO_NO_TEXTURE};
        mesh.materials = &material;
        mesh.material_count = 1;
        svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
        setup.finishes = &finish;
        setup.finish_count = 1;
        built made;
        lit_leaves lit;
        fixture_build(&opened, &mesh, 2, &grid, &made);
        svo_light *light = light_of(&opened, made.tree, SVO_LIGHT_FACES);
        shine(&opened, light, &setup, &lit);
        assert_true(lit.count > 0);
        for (unsigned k = 0; k < 18; ++k) {
            const uint64_t emission = (uint64_t)((double)finish.emission[k % 3] / lit.unit + 0.5);
            assert_int_equal(lit.radiance[k], (emission * alpha * 2 + 255) / 510);
            halves += emission * alpha * 2 % 510 >= 255 ? 1 : 0;
        }
        free_lit(&lit);
        svo_light_destroy(&light);
        built_destroy(&made);
    }
    assert_true(halves > 1000);
}

/* ---- trees without triangles ---- */

static void test_trees_without_triangles_are_lit(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh mesh = wall_mesh();
    const svo_plan_options occupancy = {.need = SVO_NEED_NONE, .edge = 1};
    const svo_light_source source = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, -1, 0}, .value = {1, 1, 1}};
    const svo_light_setup setup = setup_of(&source, 1024);
    unsigned checked = 0;
    built made;
    lit_leaves lit;
    fixture_build(&opened, &mesh, WALL_DEPTH, &occupancy, &made);
    svo_light *light = light_of(&opened, made.tree, SVO_LIGHT_FACES);
    shine(&opened, light, &setup, &lit);
    for (uint64_t i = 0; i < lit.count; ++i) {
        double middle[3];
        if (is_inner(&made, lit.leaves[i], middle)) {
            ++checked;
            assert_near(radiance_at(&lit, i, 3, 0), 0.6 / PI, 0.006, "the lit face");
            assert_near(radiance_at(&lit, i, 2, 0), 0, 0, "the back");
        }
    }
    assert_int_equal(checked, 30 * 30);
    free_lit(&lit);
    svo_light_destroy(&light);
    built_destroy(&made);
}

TEST_GROUP(light_photons)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sums_are_those_of_the_reference),
        cmocka_unit_test(test_sums_of_a_scene),
        cmocka_unit_test(test_parallel_light_obeys_lambert),
        cmocka_unit_test(test_point_light_obeys_inverse_squares),
        cmocka_unit_test(test_radiance_without_directions),
        cmocka_unit_test(test_emitting_materials_are_lit),
        cmocka_unit_test(test_emission_is_premultiplied_by_area),
        cmocka_unit_test(test_premultiplied_emission_is_rounded),
        cmocka_unit_test(test_trees_without_triangles_are_lit),
    };
    return cmocka_run_group_tests_name("light_photons", tests, fixture_group_setup, fixture_group_teardown);
}
