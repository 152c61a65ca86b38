/* SPDX-License-Identifier: MIT */
/*
 * Light views by rasterization beside those by rays: the share of pixels that name the same triangle, the points on
 * those, the flux of the whole light, the same result for each run, and what is refused.
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

#include "light/source_views.h"
#include "light_fixture.h"
#include "photon_reference.h"
#include "raster/light_view.h"
#include "scenes.h"
#include "support/gl_contexts.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

#define RESOLUTION 120
#define BAND       4096 /* photons: several bands a view */

static const svo_plan_options with_rays = {.need = SVO_NEED_RAYS | SVO_NEED_NORMAL | SVO_NEED_COLOR};

/* One of each kind; in cornell all of them see something. The point source looks to all sides. */
static const svo_light_source sources[] = {
    {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {-0.3F, -1.0F, -0.2F}, .value = {3.0F, 2.0F, 1.0F}},
    {.kind = SVO_SOURCE_POINT, .position = {0.6F, 0.7F, 0.5F}, .value = {0.1F, 0.0F, 0.5F}},
    {.kind = SVO_SOURCE_SPOT,
     .position = {0.4F, 0.8F, 0.5F},
     .direction = {0.2F, -1.0F, 0.1F},
     .value = {2.0F, 2.0F, 5.0F},
     .inner_angle = 0.3F,
     .outer_angle = 1.0F},
};
enum { SOURCES = sizeof sources / sizeof sources[0] };

/* ---- pixels ---- */

typedef struct tally {
    uint64_t pixels, same;
    double farthest; /* difference of distances on the same triangle, relative */
} tally;

static void compare_hits(const svo_hit *traced, const svo_hit *drawn, uint32_t count, tally *out)
{
    for (uint32_t i = 0; i < count; ++i) {
        const bool same = traced[i].triangle == drawn[i].triangle;
        ++out->pixels;
        out->same += same ? 1 : 0;
        if (same && traced[i].triangle != SVO_NO_TRIANGLE) {
            out->farthest = fmax(out->farthest, fabs((double)drawn[i].t / (double)traced[i].t - 1));
            for (int axis = 0; axis < 3; ++axis) {
                assert_true(fabsf(drawn[i].normal[axis] - traced[i].normal[axis]) < 1e-5F);
            }
            assert_true(drawn[i].u >= 0 && drawn[i].v >= 0 && drawn[i].u + drawn[i].v <= 1.0001F);
            assert_true(fabsf(drawn[i].u - traced[i].u) < 0.01F && fabsf(drawn[i].v - traced[i].v) < 0.01F);
        }
    }
}

/* A band of a view, by rays and drawn. */
static void compare_band(const fixture *opened, const built *made, const svo_i_photon_caster *caster,
                         const svo_i_light_view *view, uint32_t first, tally *out)
{
    static svo_photon_weight weights[BAND];
    static svo_ray rays[BAND];
    static svo_hit traced[BAND];
    static svo_hit drawn[BAND];
    svo_light_view_params params = view->params;
    cl_context context = info_of_device(opened->device).context;
    cl_int error = CL_SUCCESS;
    params.first = first;
    params.count = view->photon_count - first < BAND ? view->photon_count - first : BAND;
    (void)svo_i_view_weights(view, first, params.count, weights);
    for (uint32_t i = 0; i < params.count; ++i) {
        rays[i] = reference_photon_ray(&params, first + i, weights[i].flux > 0);
    }
    assert_int_equal(svo_trace_triangles(svo_tree_target(made->tree), svo_in_host(rays), svo_in_host(traced),
                                         params.count, SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened->queue}),
                     SVO_OK);
    cl_mem hits = clCreateBuffer(context, CL_MEM_READ_WRITE, sizeof drawn, NULL, &error);
    assert_int_equal(error, CL_SUCCESS);
    light_succeed(opened, caster->cast(caster->self, &params, weights, opened->queue, hits));
    assert_int_equal(
        clEnqueueReadBuffer(opened->queue, hits, CL_TRUE, 0, params.count * sizeof drawn[0], drawn, 0, NULL, NULL),
        CL_SUCCESS);
    clReleaseMemObject(hits);
    compare_hits(traced, drawn, params.count, out);
}

/* What the sources shine on: the whole grid. */
static svo_i_lit_box box_of(const built *made)
{
    svo_grid grid;
    svo_i_lit_box box = {.leaf_edge = 0};
    assert_int_equal(svo_tree_get_grid(made->tree, &grid), SVO_OK);
    box.leaf_edge = svo_grid_cell_edge(&grid, grid.depth);
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = grid.origin[axis];
        box.high[axis] = grid.origin[axis] + svo_grid_cell_edge(&grid, 0);
    }
    return box;
}

static void compare_views(const fixture *opened, const built *made, tally *out)
{
    const svo_i_lit_box box = box_of(made);
    svo_i_light_raster *raster = NULL;
    light_succeed(opened,
                  svo_i_light_raster_create(opened->device, opened->context, chosen_share(opened->gl), &raster));
    light_succeed(opened, svo_i_gl_context_make_current(opened->context, NULL));
    const svo_i_photon_caster caster = svo_i_light_raster_begin(raster, made->tree);
    for (size_t i = 0; i < SOURCES; ++i) {
        svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX];
        const uint32_t count = svo_i_light_views(&sources[i], &box, RESOLUTION, views);
        for (uint32_t k = 0; k < count; ++k) {
            for (uint32_t first = 0; first < views[k].photon_count; first += BAND) {
                compare_band(opened, made, &caster, &views[k], first, out);
            }
        }
    }
    svo_i_light_raster_end(raster);
    svo_i_gl_context_release_current(opened->context);
    svo_i_light_raster_destroy(&raster);
}

static void check_pixels(const fixture *opened, const svo_mesh *mesh, double least)
{
    tally all = {.pixels = 0};
    built made;
    fixture_build(opened, mesh, 6, &with_rays, &made);
    compare_views(opened, &made, &all);
    const double share = (double)all.same / (double)all.pixels;
    print_message("%llu pixels, %.5f of them the same, distances within %.2g\n", (unsigned long long)all.pixels, share,
                  all.farthest);
    if (!(share >= least) || !(all.farthest < 1e-4)) {
        fail_msg("share %.5f is below %.5f, or distances differ by %.3g", share, least, all.farthest);
        return;
    }
    built_destroy(&made);
}

static void pixels_name_the_same_triangles(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *cornell = fixture_scene("cornell:94");
    scene *statue = fixture_scene("statue:3000");
    check_pixels(opened, scene_mesh(cornell), 0.999);
    check_pixels(opened, scene_mesh(statue), 0.999);
    scene_destroy(&cornell);
    scene_destroy(&statue);
}

/* ---- lights ---- */

static void assert_near(double found, double expected, double error, const char *what)
{
    if (!(fabs(found - expected) <= error)) {
        fail_msg("%s: %.9g is not within %g of %.9g", what, found, error, expected);
        return;
    }
}

static void flux_is_that_of_rays(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *cornell = fixture_scene("cornell:94");
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    char hashes[2][SVO_HASH_TEXT_BYTES];
    built made;
    setup.sources = sources;
    setup.source_count = SOURCES;
    fixture_build(opened, scene_mesh(cornell), 6, &with_rays, &made);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        svo_light *light = light_of(opened, made.tree, (svo_light_form)form);
        light_succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
        const svo_light_info traced = light_info_of(light);
        for (int run = 0; run < 2; ++run) {
            light_succeed(opened, svo_gl_light_set_sources(opened->gl, light, &setup, opened->queue));
            light_succeed(opened, svo_light_hash(light, opened->queue, hashes[run]));
        }
        const svo_light_info drawn = light_info_of(light);
        assert_string_equal(hashes[0], hashes[1]);
        assert_int_equal(drawn.photons, traced.photons);
        assert_true(drawn.lost_flux < 1e-6);
        assert_near((double)drawn.photon_hits, (double)traced.photon_hits, 1e-3 * (double)traced.photon_hits, "hits");
        assert_near((double)drawn.lit_leaves, (double)traced.lit_leaves, 2e-3 * (double)traced.lit_leaves, "leaves");
        for (int channel = 0; channel < 3; ++channel) {
            assert_near(drawn.flux[channel], traced.flux[channel], 1e-3 * traced.flux[channel], "flux");
        }
        svo_light_destroy(&light);
    }
    built_destroy(&made);
    scene_destroy(&cornell);
}

static void trees_without_triangles_are_refused(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const svo_plan_options bare = {.need = SVO_NEED_COLOR};
    scene *cornell = fixture_scene("cornell:94");
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    built made;
    fixture_build(opened, scene_mesh(cornell), 4, &bare, &made);
    svo_light *light = light_of(opened, made.tree, SVO_LIGHT_FACES);
    assert_int_equal(svo_gl_light_set_sources(opened->gl, light, &setup, opened->queue), SVO_UNSUPPORTED);
    assert_non_null(strstr(svo_device_message(opened->device), "SVO_NEED_RAYS"));
    assert_int_equal(svo_gl_light_set_sources(NULL, light, &setup, opened->queue), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_gl_light_set_sources(opened->gl, NULL, &setup, opened->queue), SVO_INVALID_ARGUMENT);
    svo_light_destroy(&light);
    built_destroy(&made);
    scene_destroy(&cornell);
}

static void failures_name_the_function(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *cornell = fixture_scene("cornell:94");
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    built made;
    setup.view_resolution = 20000;
    fixture_build(opened, scene_mesh(cornell), 4, &with_rays, &made);
    svo_light *light = light_of(opened, made.tree, SVO_LIGHT_FACES);
    assert_int_equal(svo_gl_light_set_sources(opened->gl, light, &setup, opened->queue), SVO_INVALID_ARGUMENT);
    assert_non_null(
        strstr(svo_device_message(opened->device), "svo_gl_light_set_sources: setup.view_resolution 20000"));
    svo_light_destroy(&light);
    built_destroy(&made);
    scene_destroy(&cornell);
}

TEST_GROUP(light_gl)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_name_the_same_triangles),
        cmocka_unit_test(flux_is_that_of_rays),
        cmocka_unit_test(trees_without_triangles_are_refused),
        cmocka_unit_test(failures_name_the_function),
    };
    return cmocka_run_group_tests_name("light_gl", tests, fixture_group_setup, fixture_group_teardown);
}
