/* SPDX-License-Identifier: MIT */
/*
 * Lobes of materials that shine: they keep their energy, point where light is mirrored, widen by the exponent and by
 * the spread of light and normals, and leave nothing behind the surface.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/work.h"
#include "light/shoot.h"
#include "light_fixture.h"
#include "support/meshes.h"
#include "support/suite.h"

#define PI    3.14159265358979323846
#define DEPTH 4

/* Radiance of the lit leaves, and their sums of flux. */
typedef struct lit_faces {
    uint64_t count;
    uint32_t *leaves;
    double (*radiance)[6][3]; /* premultiplied */
    double (*flux)[6]; /* red, green, blue, all times direction; over pi h^2 */
} lit_faces;

static void *read_all(const fixture *opened, cl_mem buffer, size_t bytes)
{
    void *data = malloc(bytes + 1);
    assert_non_null(data);
    assert_int_equal(clEnqueueReadBuffer(opened->queue, buffer, CL_TRUE, 0, bytes, data, 0, NULL, NULL), CL_SUCCESS);
    return data;
}

static void shine(const fixture *opened, const built *made, const svo_light_source *source, const svo_finish *finish,
                  lit_faces *out)
{
    svo_i_device_work work;
    svo_i_lit_leaves lit;
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = source;
    setup.source_count = 1;
    setup.finishes = finish;
    setup.finish_count = 1;
    setup.view_resolution = 200;
    svo_light *light = light_of(opened, made->tree, SVO_LIGHT_FACES);
    light_succeed(opened, svo_i_work_begin(opened->device, "shine", opened->queue, &work));
    light_succeed(opened, svo_i_light_shine(&work, light, &setup, NULL, &lit));
    light_succeed(opened, svo_i_work_wait(&work));
    *out = (lit_faces){.count = lit.lit_count};
    out->leaves = read_all(opened, lit.leaves, lit.lit_count * sizeof *out->leaves);
    out->radiance = malloc(lit.lit_count * sizeof *out->radiance);
    out->flux = malloc(lit.lit_count * sizeof *out->flux);
    assert_non_null(out->radiance);
    assert_non_null(out->flux);
    uint32_t *radiance = read_all(opened, lit.radiance, lit.lit_count * 18 * sizeof *radiance);
    int64_t *sums = read_all(opened, light->buffers[SVO_LIGHT_FLUX], lit.lit_count * 6 * sizeof *sums);
    uint64_t red = 0;
    for (uint64_t i = 0; i < lit.lit_count; ++i) {
        red += (uint64_t)sums[i * 6];
    }
    const svo_light_info info = light_info_of(light);
    const double edge = (double)light->params.voxel_edge;
    for (uint64_t i = 0; i < lit.lit_count; ++i) {
        for (unsigned k = 0; k < 18; ++k) {
            out->radiance[i][k / 3][k % 3] = radiance[i * 18 + k] * (double)lit.unit;
        }
        for (unsigned k = 0; k < 6; ++k) {
            out->flux[i][k] = (double)sums[i * 6 + k] * info.flux[0] / (double)red / (PI * edge * edge);
        }
    }
    free(radiance);
    free(sums);
    svo_i_work_end(&work);
    svo_light_destroy(&light);
}

static void free_faces(lit_faces *lit)
{
    free(lit->leaves);
    free(lit->radiance);
    free(lit->flux);
}

static const svo_plan_options grid = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS | SVO_NEED_MATERIAL,
                                      .edge = 1};
static const svo_material black = {{0, 0, 0, 255}, SVO_NO_TEXTURE};

static void assert_near(double found, double expected, double error, const char *what)
{
    if (!(fabs(found - expected) <= error)) {
        fail_msg("%s: %.9g is not within %g of %.9g", what, found, error, expected);
        return;
    }
}

/* A black surface sends what it mirrors, 2 pi / 3 times the sum of its six directions, and no more. */
static void test_lobes_keep_their_energy(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_source source = {
        .kind = SVO_SOURCE_POINT, .position = {0.45F, 0.6F, 0.5F}, .value = {1.0F, 2.0F, 0.5F}};
    const float exponents[] = {0, 1, 30, 5000};
    owned_mesh random;
    built made;
    random_mesh(11, 300, 0, &random);
    random.mesh.materials = &black;
    random.mesh.material_count = 1;
    fixture_build(&opened, &random.mesh, DEPTH, &grid, &made);
    for (size_t n = 0; n < sizeof exponents / sizeof exponents[0]; ++n) {
        const svo_finish finish = {.specular = {0.5F, 0.25F, 1}, .exponent = exponents[n]};
        lit_faces lit;
        shine(&opened, &made, &source, &finish, &lit);
        assert_true(lit.count > 100);
        for (uint64_t i = 0; i < lit.count; ++i) {
            for (unsigned channel = 0; channel < 3; ++channel) {
                double sum = 0;
                for (unsigned direction = 0; direction < 6; ++direction) {
                    sum += lit.radiance[i][direction][channel];
                }
                const double mirrored = (double)finish.specular[channel] * lit.flux[i][channel];
                assert_near(sum, 1.5 * mirrored, mirrored * 1e-3 + 1e-5, "all directions");
            }
        }
        free_faces(&lit);
    }
    built_destroy(&made);
    owned_mesh_free(&random);
}

/* A slope of 45 degrees turns light from above to +x. Steps of the exponential function are 1/256. */
static void test_lobes_point_where_light_is_mirrored(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_source source = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, -1, 0}, .value = {1, 1, 1}};
    const float positions[] = {0.02F, 0.98F, 0.02F, 0.98F, 0.02F, 0.02F, 0.98F, 0.02F, 0.98F, 0.02F, 0.98F, 0.98F};
    const uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    const float exponents[] = {1, 10, 1000};
    svo_mesh mesh = SVO_MESH_INIT;
    mesh.positions = positions;
    mesh.vertex_count = 4;
    mesh.indices = indices;
    mesh.triangle_count = 2;
    mesh.materials = &black;
    mesh.material_count = 1;
    built made;
    fixture_build(&opened, &mesh, DEPTH, &grid, &made);
    for (size_t n = 0; n < sizeof exponents / sizeof exponents[0]; ++n) {
        const svo_finish finish = {.specular = {1, 1, 1}, .exponent = exponents[n]};
        const double aside = exp(-1 / (1.0 / 3 + 1 / (double)exponents[n]));
        lit_faces lit;
        shine(&opened, &made, &source, &finish, &lit);
        assert_true(lit.count > 16);
        for (uint64_t i = 0; i < lit.count; ++i) {
            const double flux = lit.flux[i][0];
            assert_near(lit.flux[i][4], -3 * flux, flux * 1e-4, "mean direction");
            /* A ray along -x sees what leaves along +x. */
            assert_near(lit.radiance[i][1][0], 1.5 * flux / (1 + aside), flux * 0.01, "mirrored");
            assert_near(lit.radiance[i][3][0], 1.5 * flux * aside / (1 + aside), flux * 0.01, "back to the light");
            const unsigned others[] = {0, 2, 4, 5};
            for (unsigned k = 0; k < 4; ++k) {
                assert_near(lit.radiance[i][others[k]][0], 0, 0, "behind and aside");
            }
        }
        free_faces(&lit);
    }
    built_destroy(&made);
}

TEST_GROUP(light_lobes)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lobes_keep_their_energy),
        cmocka_unit_test(test_lobes_point_where_light_is_mirrored),
    };
    return cmocka_run_group_tests_name("light_lobes", tests, fixture_group_setup, fixture_group_teardown);
}
