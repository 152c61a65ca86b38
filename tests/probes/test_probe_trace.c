/* SPDX-License-Identifier: MIT */
/*
 * Rays through probes: a walk beside a slow reference that crosses every texel's boundary in long double, closed and
 * sealed rooms, rays through a probe, hits beside exact rays, rays of any kind that end, diffuse light in a closed
 * form, what is refused.
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

#include "errors/published_probes.h"
#include "light/light_fixture.h"
#include "probe_reference.h"
#include "probes_of.h"
#include "support/solid_meshes.h"
#include "support/suite.h"

#define PI        3.14159265358979323846
#define RAY_COUNT 4096u
#define DEPTH     5

static uint64_t random_state;

/* 0 .. 1 */
static double next_random(void)
{
    random_state = random_state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(random_state >> 11) * 0x1p-53;
}

static void random_direction(float out[3])
{
    const double z = 2 * next_random() - 1;
    const double angle = 2 * PI * next_random();
    const double across = sqrt(1 - z * z);
    out[0] = (float)(across * cos(angle));
    out[1] = (float)(across * sin(angle));
    out[2] = (float)z;
}

/* ---- scenes ---- */

typedef struct scene {
    built tree;
    svo_probes *probes;
    svo_probe_info info;
} scene;

static svo_probe_options options_of(uint32_t x, uint32_t y, uint32_t z, uint32_t resolution)
{
    svo_probe_options options = SVO_PROBE_OPTIONS_INIT;
    options.counts[0] = x;
    options.counts[1] = y;
    options.counts[2] = z;
    options.resolution = resolution;
    options.field_size = 16;
    return options;
}

static void open_scene(const fixture *opened, parts *of, const svo_plan_options *grid, const svo_probe_options *options,
                       scene *out)
{
    const svo_mesh mesh = parts_mesh(of);
    *out = (scene){.info = SVO_PROBE_INFO_INIT};
    fixture_build(opened, &mesh, DEPTH, grid, &out->tree);
    light_succeed(opened, probes_of_tree(out->tree.tree, options, opened->queue, &out->probes));
    assert_int_equal(svo_probes_get_info(out->probes, &out->info), SVO_OK);
    parts_free(of);
}

static void close_scene(scene *of)
{
    svo_probes_destroy(&of->probes);
    built_destroy(&of->tree);
}

/* A room of 8 x 8 x 8, and a ball in it. */
static parts room_of(bool with_ball)
{
    parts out = {.positions = NULL};
    parts_add_cube(&out, 0, 8, true, -1);
    if (with_ball) {
        parts_add_sphere(&out, (const double[3]){5, 4.5, 3.5}, 1.25, 8);
    }
    return out;
}

static const svo_plan_options with_rays = {.need = SVO_NEED_RAYS};

/* From random points of a cube, outside the ball. */
static void random_rays(double low, double high, svo_ray *rays)
{
    for (uint32_t i = 0; i < RAY_COUNT; ++i) {
        double away = 0;
        while (!(away > 1.5 * 1.5)) {
            away = 0;
            for (int axis = 0; axis < 3; ++axis) {
                static const double middle[3] = {5, 4.5, 3.5};
                const double at = low + (high - low) * next_random();
                rays[i].origin[axis] = (float)at;
                away += (at - middle[axis]) * (at - middle[axis]);
            }
        }
        random_direction(rays[i].direction);
        rays[i].t_min = 0.0F;
        rays[i].t_max = INFINITY;
    }
}

/* How rays choose their probes: as svo_probes_trace, and as published. */
enum { BY_FIELD, BY_EIGHT, CHOICES };
static const char *const choice_names[CHOICES] = {"field", "eight"};

static void trace(const fixture *opened, const scene *of, const svo_ray *rays, int choice, svo_probe_hit *hits)
{
    if (choice == BY_FIELD) {
        light_succeed(opened, svo_probes_trace(of->probes, svo_in_host(rays), svo_in_host(hits), RAY_COUNT, NULL,
                                               &(svo_submit){.queue = opened->queue}));
    } else {
        published_probes made;
        assert_true(published_probes_make(opened->device, of->probes, opened->queue, &made));
        assert_true(published_probes_trace(&made, rays, hits, RAY_COUNT));
        published_probes_free(&made);
    }
}

/* ---- the walk ---- */

static void *read_buffer(const fixture *opened, const scene *of, svo_probes_buffer buffer)
{
    const size_t bytes = (size_t)of->info.bytes[buffer];
    void *copy = malloc(bytes);
    assert_non_null(copy);
    assert_int_equal(clEnqueueReadBuffer(opened->queue, svo_probes_get_buffer(of->probes, buffer), CL_TRUE, 0, bytes,
                                         copy, 0, NULL, NULL),
                     CL_SUCCESS);
    return copy;
}

/* Fails unless the hit is the reference's. */
static void expect_answer(const svo_ray *ray, const svo_probe_hit *hit, const probe_answer *expected, float leaf_edge)
{
    const bool same =
        hit->state == expected->state &&
        (expected->state == SVO_PROBE_MISS || fabs((double)hit->t - expected->t) <= 0.01 * (double)leaf_edge) &&
        (expected->state != SVO_PROBE_HIT || hit->texel == expected->texel);
    if (!same) {
        fail_msg("from (%.9g, %.9g, %.9g) along (%.9g, %.9g, %.9g): state %u, t %.9g, texel %u instead of %u, %.9g, %u",
                 (double)ray->origin[0], (double)ray->origin[1], (double)ray->origin[2], (double)ray->direction[0],
                 (double)ray->direction[1], (double)ray->direction[2], hit->state, (double)hit->t, hit->texel,
                 expected->state, expected->t, expected->texel);
    }
}

/* By one probe; rays whose comparisons are nearly even are left out. */
static void check_walk(const fixture *opened, uint32_t resolution)
{
    static svo_ray rays[RAY_COUNT];
    static svo_probe_hit hits[RAY_COUNT];
    svo_probe_options options = options_of(1, 1, 1, resolution);
    parts room = room_of(true);
    scene of;
    size_t compared[3] = {0};
    open_scene(opened, &room, &with_rays, &options, &of);
    uint32_t *texels = read_buffer(opened, &of, SVO_PROBES_TEXELS);
    svo_probe *places = read_buffer(opened, &of, SVO_PROBES_PLACES);
    probe_map map = {.info = of.info, .texels = texels};
    memcpy(map.position, places[0].position, sizeof map.position);
    random_rays(0.5, 7.5, rays);
    for (uint32_t i = 0; i < RAY_COUNT; ++i) {
        /* Not far out of the room, where rays are cut. */
        rays[i].t_max = (float)(0.2 + 5 * next_random());
        for (int axis = 0; axis < 3; ++axis) {
            const float wall = rays[i].direction[axis] > 0.0F ? 8.2F : -0.2F;
            rays[i].t_max = fminf(rays[i].t_max, (wall - rays[i].origin[axis]) / rays[i].direction[axis]);
        }
    }
    trace(opened, &of, rays, BY_EIGHT, hits);
    for (uint32_t i = 0; i < RAY_COUNT; ++i) {
        const probe_answer expected = probe_reference_trace(&map, &rays[i]);
        if (!expected.close) {
            expect_answer(&rays[i], &hits[i], &expected, of.info.leaf_edge);
            ++compared[expected.state];
        }
    }
    print_message("R %u: compared %zu misses, %zu hits, %zu unknown\n", resolution, compared[0], compared[1],
                  compared[2]);
    assert_true(compared[0] > RAY_COUNT / 4 && compared[1] > RAY_COUNT / 50 && compared[2] > RAY_COUNT / 50);
    free(texels);
    free(places);
    close_scene(&of);
}

static void a_walk_is_that_of_the_reference(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    random_state = 17;
    check_walk(&opened, 64);
    check_walk(&opened, 80); /* octants end inside coarse texels */
}

/* ---- rooms ---- */

/* In a closed room rays hit walls, where exact rays do. */
static void a_closed_room_has_no_way_out(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static svo_ray rays[RAY_COUNT];
    static svo_hit exact[RAY_COUNT];
    static svo_probe_hit hits[RAY_COUNT];
    const svo_probe_options options = options_of(2, 2, 2, 128);
    parts room = room_of(false);
    scene of;
    double worst = 0;
    random_state = 18;
    open_scene(&opened, &room, &with_rays, &options, &of);
    random_rays(0.5, 7.5, rays);
    light_succeed(&opened, svo_trace_triangles(svo_tree_target(of.tree.tree), svo_in_host(rays), svo_in_host(exact),
                                               RAY_COUNT, SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened.queue}));
    for (int choice = 0; choice < CHOICES; ++choice) {
        uint32_t known = 0;
        trace(&opened, &of, rays, choice, hits);
        for (uint32_t i = 0; i < RAY_COUNT; ++i) {
            assert_int_not_equal(hits[i].state, SVO_PROBE_MISS);
            if (hits[i].state == SVO_PROBE_HIT) {
                worst = fmax(worst, fabs((double)hits[i].t - (double)exact[i].t) / (double)of.info.leaf_edge);
                ++known;
            }
        }
        print_message("%s: %u of %u rays hit, at most %.3f leaf edges off\n", choice_names[choice], known, RAY_COUNT,
                      worst);
        assert_true(known >= RAY_COUNT * 999 / 1000);
        assert_true(worst < 1.5);
    }
    close_scene(&of);
}

static const svo_plan_options wide_grid = {
    .need = SVO_NEED_NORMAL | (unsigned)SVO_NEED_RAYS, .edge = 16, .origin = {-4, -4, -4}};

/* The walls of a room are single sheets that the sun shines on; probes are inside and outside. Rays from inside, those
   that begin at the walls included, neither see that light nor leave. */
static void a_sealed_room_is_dark(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static svo_ray rays[RAY_COUNT];
    static svo_probe_hit hits[RAY_COUNT];
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {1, 2, -3}, .value = {3, 3, 3}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    svo_probe_options options = options_of(4, 4, 4, 128);
    parts room = {.positions = NULL};
    built tree;
    svo_light *light = NULL;
    scene of = {.info = SVO_PROBE_INFO_INIT};
    random_state = 19;
    parts_add_cube(&room, 0.125, 7.875, true, -1);
    const svo_mesh mesh = parts_mesh(&room);
    fixture_build(&opened, &mesh, DEPTH, &wide_grid, &tree);
    light = light_of(&opened, tree.tree, SVO_LIGHT_FACES);
    setup.sources = &sun;
    setup.source_count = 1;
    setup.no_photons = 1;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    options.light = light;
    options.keep_places = 1;
    light_succeed(&opened, probes_of_tree(tree.tree, &options, opened.queue, &of.probes));
    for (uint32_t i = 0; i < RAY_COUNT; ++i) {
        const uint32_t axis = i % 3;
        for (uint32_t k = 0; k < 3; ++k) {
            rays[i].origin[k] = (float)(0.5 + 7 * next_random());
        }
        /* A tenth of a leaf edge above a wall. */
        rays[i].origin[axis] = i % 2 == 0 ? 0.175F : 7.825F;
        random_direction(rays[i].direction);
        rays[i].direction[axis] = copysignf(rays[i].direction[axis], i % 2 == 0 ? 1.0F : -1.0F);
        rays[i].t_min = 0.0F;
        rays[i].t_max = INFINITY;
    }
    uint32_t known = 0;
    trace(&opened, &of, rays, BY_FIELD, hits);
    for (uint32_t i = 0; i < RAY_COUNT; ++i) {
        if (hits[i].state == SVO_PROBE_MISS || hits[i].radiance[0] > 0.0F) {
            fail_msg("from (%.9g, %.9g, %.9g) along (%.9g, %.9g, %.9g): state %u, radiance %g",
                     (double)rays[i].origin[0], (double)rays[i].origin[1], (double)rays[i].origin[2],
                     (double)rays[i].direction[0], (double)rays[i].direction[1], (double)rays[i].direction[2],
                     hits[i].state, (double)hits[i].radiance[0]);
        }
        known += hits[i].state == SVO_PROBE_HIT ? 1 : 0;
    }
    print_message("%u of %u rays hit\n", known, RAY_COUNT);
    assert_true(known > RAY_COUNT * 95 / 100);
    svo_probes_destroy(&of.probes);
    svo_light_destroy(&light);
    built_destroy(&tree);
    parts_free(&room);
}

/* ---- single rays ---- */

/* Rays from a probe, and rays that pass through one, hit what they hit exactly. */
static void rays_pass_through_a_probe(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static svo_ray rays[RAY_COUNT];
    static svo_hit exact[RAY_COUNT];
    static svo_probe_hit hits[RAY_COUNT];
    const svo_probe_options options = options_of(1, 1, 1, 256);
    parts room = room_of(false);
    scene of;
    random_state = 20;
    open_scene(&opened, &room, &with_rays, &options, &of);
    svo_probe *places = read_buffer(&opened, &of, SVO_PROBES_PLACES);
    for (uint32_t i = 0; i < RAY_COUNT; ++i) {
        random_direction(rays[i].direction);
        if (i % 8 == 1) { /* along an axis */
            rays[i].direction[0] = rays[i].direction[1] = 0.0F;
        }
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = places[0].position[axis] - (float)(i % 4) * 0.75F * rays[i].direction[axis];
        }
        rays[i].t_min = 0.0F;
        rays[i].t_max = INFINITY;
    }
    light_succeed(&opened, svo_trace_triangles(svo_tree_target(of.tree.tree), svo_in_host(rays), svo_in_host(exact),
                                               RAY_COUNT, SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened.queue}));
    for (int choice = 0; choice < CHOICES; ++choice) {
        trace(&opened, &of, rays, choice, hits);
        for (uint32_t i = 0; i < RAY_COUNT; ++i) {
            const double error = fabs((double)hits[i].t - (double)exact[i].t) / (double)of.info.leaf_edge;
            if (hits[i].state != SVO_PROBE_HIT || !(error < 1)) {
                fail_msg("ray %u: state %u, t %g instead of %g", i, hits[i].state, (double)hits[i].t,
                         (double)exact[i].t);
            }
        }
    }
    free(places);
    close_scene(&of);
}

/* Numbers that rays may hold, whatever they mean. */
static float odd_number(void)
{
    static const float odd[] = {0.0F,   -0.0F,    1.0F,   -1.0F, 1e-38F, -1e-44F, 1e38F,
                                -1e30F, INFINITY, -1e-8F, 4.0F,  8.0F,   7.999F};
    const double which = next_random();
    return which < 0.02  ? NAN
           : which < 0.3 ? odd[(size_t)(next_random() * sizeof odd / sizeof *odd)]
                         : (float)(20 * next_random() - 6);
}

/* Any ray ends, within what the field and the maps allow, and says where. */
static void any_ray_ends(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static svo_ray rays[RAY_COUNT];
    static svo_probe_hit hits[RAY_COUNT];
    static const uint32_t fields[2] = {1, 7};
    random_state = 21;
    for (int k = 0; k < 2; ++k) {
        svo_probe_options options = options_of(1, 3, 2, 80);
        parts room = room_of(true);
        scene of;
        options.field_size = fields[k];
        open_scene(&opened, &room, &with_rays, &options, &of);
        const uint32_t walk_most = 4 * 2 * 2 * 80 + 4 * 16;
        const uint32_t probes_most = 4 * (3 * fields[k] + 1);
        for (uint32_t i = 0; i < RAY_COUNT; ++i) {
            for (int axis = 0; axis < 3; ++axis) {
                rays[i].origin[axis] = odd_number();
                rays[i].direction[axis] = odd_number();
            }
            rays[i].t_min = i % 4 == 0 ? odd_number() : 0.0F;
            rays[i].t_max = i % 4 == 1 ? odd_number() : INFINITY;
        }
        for (int choice = 0; choice < CHOICES; ++choice) {
            trace(&opened, &of, rays, choice, hits);
            for (uint32_t i = 0; i < RAY_COUNT; ++i) {
                const bool miss = hits[i].state == SVO_PROBE_MISS;
                assert_in_range(hits[i].state, SVO_PROBE_MISS, SVO_PROBE_UNKNOWN);
                assert_true(hits[i].visited <= walk_most * (choice == BY_FIELD ? probes_most : 8));
                assert_int_equal(hits[i].texel == SVO_NO_TEXEL, hits[i].state != SVO_PROBE_HIT);
                if (miss ? !isinf(hits[i].t) : !isfinite(hits[i].t)) {
                    fail_msg("ray %u: state %u, t %g", i, hits[i].state, (double)hits[i].t);
                }
            }
        }
        close_scene(&of);
    }
}

/* ---- beside exact rays ---- */

/* A hall of pillars. */
static parts hall(void)
{
    parts out = {.positions = NULL};
    parts_add_cube(&out, 0, 8, true, -1);
    for (int i = 0; i < 9; ++i) {
        const double x = 1.5 + 2.2 * (i % 3);
        const double z = 1.2 + 2.3 * (i - i % 3) / 3.0;
        parts_add_box(&out, (const double[3]){x, 0, z}, (const double[3]){x + 0.7, 8, z + 0.6}, false, -1);
    }
    return out;
}

static bool is_in_pillar(const float at[3])
{
    bool inside = false;
    for (int i = 0; i < 9; ++i) {
        const double x = (double)at[0] - (1.5 + 2.2 * (i % 3));
        const double z = (double)at[2] - (1.2 + 2.3 * (i - i % 3) / 3.0);
        inside = inside || (x >= -0.05 && x <= 0.75 && z >= -0.05 && z <= 0.65);
    }
    return inside;
}

/* Random rays in a hall of pillars: few are wrong, and the field leaves fewer unknown than the eight. */
static void hits_are_near_those_of_exact_rays(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static svo_ray rays[RAY_COUNT];
    static svo_hit exact[RAY_COUNT];
    static svo_probe_hit hits[RAY_COUNT];
    const svo_probe_options options = options_of(4, 4, 4, 128);
    uint32_t unknown[CHOICES] = {0};
    parts room = hall();
    scene of;
    random_state = 22;
    open_scene(&opened, &room, &with_rays, &options, &of);
    for (uint32_t i = 0; i < RAY_COUNT; ++i) {
        do {
            for (int axis = 0; axis < 3; ++axis) {
                rays[i].origin[axis] = (float)(0.1 + 7.8 * next_random());
            }
        } while (is_in_pillar(rays[i].origin));
        random_direction(rays[i].direction);
        rays[i].t_min = 0.0F;
        rays[i].t_max = INFINITY;
    }
    light_succeed(&opened, svo_trace_triangles(svo_tree_target(of.tree.tree), svo_in_host(rays), svo_in_host(exact),
                                               RAY_COUNT, SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened.queue}));
    for (int choice = 0; choice < CHOICES; ++choice) {
        uint32_t wrong = 0;
        trace(&opened, &of, rays, choice, hits);
        for (uint32_t i = 0; i < RAY_COUNT; ++i) {
            const double error = fabs((double)hits[i].t - (double)exact[i].t) / (double)of.info.leaf_edge;
            unknown[choice] += hits[i].state == SVO_PROBE_UNKNOWN ? 1 : 0;
            wrong += hits[i].state == SVO_PROBE_MISS || (hits[i].state == SVO_PROBE_HIT && error > 2) ? 1 : 0;
        }
        print_message("%s: of %u rays %u unknown, %u wrong\n", choice_names[choice], RAY_COUNT, unknown[choice], wrong);
        assert_true(wrong <= RAY_COUNT / 50);
    }
    assert_true(unknown[BY_FIELD] * 3 <= unknown[BY_EIGHT]);
    close_scene(&of);
}

/* ---- diffuse light ---- */

/* In a black room that glows irradiance is pi times the emission, wherever the point and whatever its normal. */
static void diffuse_light_of_a_glowing_room(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const uint16_t materials[12] = {0};
    const svo_material black = {.rgba = {0, 0, 0, 255}, .texture_index = SVO_NO_TEXTURE};
    const svo_plan_options grid = {.need = SVO_NEED_NORMAL | (unsigned)SVO_NEED_RAYS | (unsigned)SVO_NEED_MATERIAL |
                                           (unsigned)SVO_NEED_COLOR};
    const svo_finish glow = {.emission = {2, 1, 0.5F}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    svo_probe_options options = options_of(2, 1, 2, 64);
    svo_gather_point points[64];
    svo_probe_irradiance results[64];
    parts room = room_of(false);
    svo_mesh mesh = parts_mesh(&room);
    svo_probes *probes = NULL;
    built tree;
    random_state = 23;
    mesh.materials = &black;
    mesh.material_count = 1;
    mesh.triangle_materials = materials;
    fixture_build(&opened, &mesh, DEPTH, &grid, &tree);
    svo_light *light = light_of(&opened, tree.tree, SVO_LIGHT_FACES);
    setup.finishes = &glow;
    setup.finish_count = 1;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    options.light = light;
    options.diffuse = 1;
    options.cones = 1;
    light_succeed(&opened, probes_of_tree(tree.tree, &options, opened.queue, &probes));
    for (int i = 0; i < 64; ++i) {
        points[i] = (svo_gather_point){.exponent = 0};
        for (int axis = 0; axis < 3; ++axis) {
            points[i].position[axis] = (float)(8 * next_random());
        }
        random_direction(points[i].normal);
    }
    memset(points[0].normal, 0, sizeof points[0].normal);
    points[1].position[0] = NAN;
    light_succeed(&opened, svo_probes_irradiance(probes, svo_in_host(points), svo_in_host(results), 64,
                                                 &(svo_submit){.queue = opened.queue}));
    for (int i = 0; i < 64; ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            const double expected = i < 2 ? 0 : PI * (double)glow.emission[channel];
            if (!(fabs((double)results[i].irradiance[channel] - expected) <= 0.04 * expected) ||
                (results[i].weight > 0.0F) != (i >= 2)) {
                fail_msg("point %d: irradiance %g instead of %g, weight %g", i, (double)results[i].irradiance[channel],
                         expected, (double)results[i].weight);
            }
        }
    }
    svo_probes_destroy(&probes);
    svo_light_destroy(&light);
    built_destroy(&tree);
    parts_free(&room);
}

/* ---- arguments ---- */

static void expect_refusal(const fixture *opened, svo_status status, const char *message)
{
    assert_int_equal(status, SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened->device), message);
}

static void wrong_arguments_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_probe_options options = options_of(1, 1, 1, 64);
    svo_probe_trace_options asked = SVO_PROBE_TRACE_OPTIONS_INIT;
    svo_ray ray = {.direction = {1, 0, 0}};
    svo_gather_point point = {.normal = {1, 0, 0}};
    svo_probe_irradiance light;
    svo_probe_hit hit;
    parts room = room_of(false);
    scene of;
    open_scene(&opened, &room, &with_rays, &options, &of);
    assert_int_equal(svo_probes_trace(NULL, svo_in_host(&ray), svo_in_host(&hit), 1, NULL, NULL), SVO_INVALID_ARGUMENT);
    light_succeed(&opened, svo_probes_trace(of.probes, svo_in_host(NULL), svo_in_host(NULL), 0, NULL,
                                            &(svo_submit){.queue = opened.queue}));
    expect_refusal(&opened, svo_probes_trace(of.probes, svo_in_host(NULL), svo_in_host(&hit), 1, NULL, NULL),
                   "svo_probes_trace: rays is NULL");
    expect_refusal(&opened, svo_probes_trace(of.probes, svo_in_host(&ray), svo_in_host(NULL), 1, NULL, NULL),
                   "svo_probes_trace: hits is NULL");
    asked.thickness = -1.0F;
    expect_refusal(&opened, svo_probes_trace(of.probes, svo_in_host(&ray), svo_in_host(&hit), 1, &asked, NULL),
                   "svo_probes_trace: options.thickness -1 is negative or not finite");
    expect_refusal(&opened, svo_probes_irradiance(of.probes, svo_in_host(&point), svo_in_host(&light), 1, NULL),
                   "svo_probes_irradiance: the probes were made without diffuse maps");
    expect_refusal(&opened, svo_kernel_set_arguments(svo_probes_target(of.probes), NULL, 0),
                   "svo_kernel_set_arguments: kernel is NULL");
    close_scene(&of);
}

TEST_GROUP(probe_trace)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_walk_is_that_of_the_reference),
        cmocka_unit_test(a_closed_room_has_no_way_out),
        cmocka_unit_test(a_sealed_room_is_dark),
        cmocka_unit_test(rays_pass_through_a_probe),
        cmocka_unit_test(any_ray_ends),
        cmocka_unit_test(hits_are_near_those_of_exact_rays),
        cmocka_unit_test(diffuse_light_of_a_glowing_room),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests_name("probe_trace", tests, fixture_group_setup, fixture_group_teardown);
}
