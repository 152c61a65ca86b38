/* SPDX-License-Identifier: MIT */
/*
 * Probes as a whole: texels beside exact rays, least distances and the field beside their definitions, probes that move
 * and that are switched off, radiance and maps in closed forms, what is allocated and compiled, the same bytes every
 * time, what is refused.
 */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "light/light_fixture.h"
#include "probes_of.h"
#include "support/counting.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/solid_meshes.h"
#include "support/suite.h"

#define PI         3.14159265358979323846
#define RESOLUTION 64u
#define DEPTH      5

/* ---- scenes ---- */

/* A room of 8 x 8 x 8 with a ball in it; from inside the room both are seen from the front. */
static parts room_with_ball(void)
{
    parts out = {.positions = NULL};
    parts_add_cube(&out, 0, 8, true, -1);
    parts_add_sphere(&out, (const double[3]){5, 4.5, 3.5}, 1.25, 8);
    return out;
}

static void build(const fixture *opened, const parts *of, uint32_t need, built *out)
{
    const svo_plan_options options = {.need = need};
    const svo_mesh mesh = parts_mesh(of);
    fixture_build(opened, &mesh, DEPTH, &options, out);
}

/* Probes with copies of what they hold. */
typedef struct seen {
    svo_probes *probes;
    svo_probe_info info;
    svo_probe *places;
    uint32_t *texels;
    uint16_t *least, *field;
    uint32_t *irradiance;
    float *moments;
} seen;

/* The copy of a buffer; an empty one where it is not held. Released by free. */
static void *read_buffer(const fixture *opened, const svo_probes *probes, svo_probes_buffer buffer, uint64_t bytes)
{
    void *copy = malloc((size_t)bytes + 1);
    assert_non_null(copy);
    if (bytes > 0) {
        assert_int_equal(clEnqueueReadBuffer(opened->queue, svo_probes_get_buffer(probes, buffer), CL_TRUE, 0,
                                             (size_t)bytes, copy, 0, NULL, NULL),
                         CL_SUCCESS);
    }
    return copy;
}

/* Takes the probes. */
static seen look(const fixture *opened, svo_probes *probes)
{
    seen out = {.probes = probes, .info = SVO_PROBE_INFO_INIT};
    assert_int_equal(svo_probes_get_info(probes, &out.info), SVO_OK);
    const uint64_t *bytes = out.info.bytes;
    out.places = read_buffer(opened, probes, SVO_PROBES_PLACES, bytes[SVO_PROBES_PLACES]);
    out.texels = read_buffer(opened, probes, SVO_PROBES_TEXELS, bytes[SVO_PROBES_TEXELS]);
    out.least = read_buffer(opened, probes, SVO_PROBES_LEAST, bytes[SVO_PROBES_LEAST]);
    out.field = read_buffer(opened, probes, SVO_PROBES_FIELD, bytes[SVO_PROBES_FIELD]);
    out.irradiance = read_buffer(opened, probes, SVO_PROBES_IRRADIANCE, bytes[SVO_PROBES_IRRADIANCE]);
    out.moments = read_buffer(opened, probes, SVO_PROBES_MOMENTS, bytes[SVO_PROBES_MOMENTS]);
    return out;
}

static svo_probe_options small_options(uint32_t x, uint32_t y, uint32_t z)
{
    svo_probe_options options = SVO_PROBE_OPTIONS_INIT;
    options.counts[0] = x;
    options.counts[1] = y;
    options.counts[2] = z;
    options.resolution = RESOLUTION;
    options.field_size = 8;
    return options;
}

static seen make(const fixture *opened, svo_tree *tree, const svo_probe_options *options)
{
    svo_probes *probes = NULL;
    light_succeed(opened, probes_of_tree(tree, options, opened->queue, &probes));
    return look(opened, probes);
}

static void forget(seen *of)
{
    svo_probes_destroy(&of->probes);
    free(of->places);
    free(of->texels);
    free(of->least);
    free(of->field);
    free(of->irradiance);
    free(of->moments);
}

static const uint32_t *texel_at(const seen *of, uint32_t probe, uint32_t column, uint32_t row)
{
    const uint32_t resolution = of->info.resolution;
    return of->texels + 2 * (((size_t)probe * resolution + row) * resolution + column);
}

/* ---- texels ---- */

/* A texel against a hit along its direction, unit. */
static void expect_texel(const seen *of, const uint32_t *texel, const float direction[3], float t, const float met[3])
{
    const uint32_t code = texel[0] & 0xffffu;
    const double leaf_edge = (double)of->info.leaf_edge;
    const double growth = log1p((double)of->info.farthest / leaf_edge);
    float normal[3];
    double along = 0;
    double alike = 0;
    if (isinf(t)) {
        assert_int_equal(code, SVO_PROBE_NOTHING);
        return;
    }
    const double bound = ((1 + 1e-4) * ((double)t + leaf_edge) * growth / 131068) + (double)t * 4e-7;
    svo_probe_normal(texel[0], normal);
    for (int axis = 0; axis < 3; ++axis) {
        along += (double)normal[axis] * (double)direction[axis];
        alike += (double)normal[axis] * (double)met[axis];
    }
    if (!(fabs(svo_probe_distance(&of->info, code) - (double)t) <= bound) || !(along < 0.02) ||
        !(fabs(alike) >= cos(PI / 180))) {
        fail_msg("a ray of %.9g, normal (%g, %g, %g), became %.9g, (%g, %g, %g): cosine %g", (double)t, (double)met[0],
                 (double)met[1], (double)met[2], svo_probe_distance(&of->info, code), (double)normal[0],
                 (double)normal[1], (double)normal[2], along);
    }
}

/* Rays of all texels of a probe, by a unit direction each. */
static void aim(const seen *of, uint32_t probe, svo_ray *rays)
{
    const uint32_t resolution = of->info.resolution;
    for (uint32_t i = 0; i < resolution * resolution; ++i) {
        memcpy(rays[i].origin, of->places[probe].position, sizeof rays[i].origin);
        svo_probe_direction(resolution, i % resolution, i / resolution, rays[i].direction);
        rays[i].t_min = 0.0F;
        rays[i].t_max = INFINITY;
    }
}

/* Edges of the ball's triangles may go to either neighbor, whose normals differ: these few are left out. */
static bool is_near_an_edge(const svo_hit *hit)
{
    const float margin = 1e-3F;
    return hit->triangle != SVO_NO_TRIANGLE && (hit->u < margin || hit->v < margin || hit->u + hit->v > 1 - margin);
}

static void texels_are_what_exact_rays_meet(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static svo_ray rays[RESOLUTION * RESOLUTION];
    static svo_hit hits[RESOLUTION * RESOLUTION];
    parts room = room_with_ball();
    built tree;
    build(&opened, &room, SVO_NEED_RAYS, &tree);
    const svo_probe_options options = small_options(3, 2, 2);
    seen of = make(&opened, tree.tree, &options);
    assert_int_equal(of.info.rays, (uint64_t)(12 - of.info.off) * RESOLUTION * RESOLUTION);
    size_t compared = 0;
    for (uint32_t probe = 0; probe < of.info.probe_count; ++probe) {
        aim(&of, probe, rays);
        light_succeed(&opened, svo_trace_triangles(svo_tree_target(tree.tree), svo_in_host(rays), svo_in_host(hits),
                                                   RESOLUTION * RESOLUTION, SVO_TRACE_CLOSEST, NULL));
        for (uint32_t i = 0; i < RESOLUTION * RESOLUTION; ++i) {
            if (!is_near_an_edge(&hits[i])) {
                expect_texel(&of, texel_at(&of, probe, i % RESOLUTION, i / RESOLUTION), rays[i].direction, hits[i].t,
                             hits[i].normal);
                ++compared;
            }
            assert_int_equal(texel_at(&of, probe, i % RESOLUTION, i / RESOLUTION)[1], 0);
        }
    }
    assert_true(compared > of.info.probe_count * RESOLUTION * RESOLUTION * 9 / 10);
    forget(&of);
    built_destroy(&tree);
    parts_free(&room);
}

/* Trees without triangles are seen by their voxels. */
static void voxels_are_seen_without_triangles(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static svo_ray rays[RESOLUTION * RESOLUTION];
    static svo_voxel_hit hits[RESOLUTION * RESOLUTION];
    parts room = room_with_ball();
    built tree;
    build(&opened, &room, SVO_NEED_NORMAL, &tree);
    const svo_probe_options options = small_options(2, 2, 2);
    seen of = make(&opened, tree.tree, &options);
    uint32_t differing = 0;
    for (uint32_t probe = 0; probe < of.info.probe_count; ++probe) {
        aim(&of, probe, rays);
        light_succeed(&opened, svo_trace_voxels(svo_tree_target(tree.tree), svo_in_host(rays), svo_in_host(hits),
                                                RESOLUTION * RESOLUTION, 0.0F, 0, NULL));
        for (uint32_t i = 0; i < RESOLUTION * RESOLUTION; ++i) {
            const uint32_t code = texel_at(&of, probe, i % RESOLUTION, i / RESOLUTION)[0] & 0xffffu;
            const double distance = svo_probe_distance(&of.info, code);
            differing += fabs(distance - (double)hits[i].t) > 1e-3 * (1 + distance) ? 1 : 0;
        }
    }
    /* Along edges of voxels single precision goes either way. */
    assert_in_range(differing, 0, of.info.probe_count * RESOLUTION * RESOLUTION / 500);
    forget(&of);
    built_destroy(&tree);
    parts_free(&room);
}

/* Least distances are those of 16 x 16 texels. */
static void least_distances_are_of_blocks(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts room = room_with_ball();
    built tree;
    build(&opened, &room, SVO_NEED_RAYS, &tree);
    svo_probe_options options = small_options(2, 1, 1);
    options.resolution = 80;
    seen of = make(&opened, tree.tree, &options);
    const uint32_t blocks = options.resolution / 16;
    for (uint32_t i = 0; i < of.info.probe_count * blocks * blocks; ++i) {
        uint32_t least = SVO_PROBE_NOTHING;
        for (uint32_t k = 0; k < 256; ++k) {
            const uint32_t code =
                texel_at(&of, i / blocks / blocks, i % blocks * 16 + k % 16, i / blocks % blocks * 16 + k / 16)[0] &
                0xffffu;
            least = code < least ? code : least;
        }
        assert_int_equal(of.least[i], least);
    }
    forget(&of);
    built_destroy(&tree);
    parts_free(&room);
}

/* ---- the field ---- */

/* What an entry may be: 1 the probe sees the center, -1 it does not, 0 too close to tell. */
static int sees(const seen *of, uint32_t probe, const double center[3], double *distance)
{
    float way[3];
    uint32_t column = 0;
    uint32_t row = 0;
    *distance = 0;
    for (int axis = 0; axis < 3; ++axis) {
        way[axis] = (float)(center[axis] - (double)of->places[probe].position[axis]);
        *distance += (double)way[axis] * (double)way[axis];
    }
    *distance = sqrt(*distance);
    if (of->places[probe].state == SVO_PROBE_OFF) {
        return -1;
    }
    svo_probe_texel(of->info.resolution, way, &column, &row);
    const double stored = svo_probe_distance(&of->info, texel_at(of, probe, column, row)[0] & 0xffffu);
    const double margin = 1e-3 * (stored + (double)of->info.leaf_edge);
    return isinf(stored) || *distance < stored - margin ? 1 : *distance > stored + margin ? -1 : 0;
}

static void the_field_lists_the_nearest_that_see(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts room = room_with_ball();
    built tree;
    build(&opened, &room, SVO_NEED_RAYS, &tree);
    svo_probe_options options = small_options(3, 3, 3);
    options.field_size = 12;
    seen of = make(&opened, tree.tree, &options);
    size_t listed = 0;
    size_t hidden = 0;
    for (uint32_t cell = 0; cell < 12 * 12 * 12; ++cell) {
        const uint16_t *entries = of.field + (size_t)4 * cell;
        const uint32_t at[3] = {cell % 12, cell / 12 % 12, cell / 144};
        double center[3];
        double farthest = 0;
        double distance = 0;
        uint32_t count = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double low = (double)of.info.low[axis];
            center[axis] = low + (at[axis] + 0.5) * ((double)of.info.high[axis] - low) / 12;
        }
        for (; count < 4 && entries[count] != SVO_PROBE_NONE; ++count) {
            assert_true(sees(&of, entries[count], center, &distance) >= 0);
            assert_true(distance >= farthest - 1e-5);
            farthest = distance;
        }
        for (uint32_t probe = 0; probe < of.info.probe_count; ++probe) {
            bool is_listed = false;
            for (uint32_t k = 0; k < count; ++k) {
                is_listed = is_listed || entries[k] == probe;
            }
            const int seen_by = sees(&of, probe, center, &distance);
            hidden += seen_by < 0 ? 1 : 0;
            /* Whoever sees the center and is not listed is farther away. */
            if (!is_listed && seen_by > 0 && (count < 4 || distance < farthest - 1e-5)) {
                fail_msg("cell %u lists %u probes up to %g, but not %u at %g", cell, count, farthest, probe, distance);
                return;
            }
        }
        listed += count;
    }
    assert_true(listed > 0 && hidden > 0);
    forget(&of);
    built_destroy(&tree);
    parts_free(&room);
}

/* Ties go to the smaller index: a cell in the middle of eight probes lists the first four. */
static void ties_go_to_the_smaller_index(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts room = {.positions = NULL};
    built tree;
    parts_add_cube(&room, 0, 8, true, -1);
    build(&opened, &room, SVO_NEED_RAYS, &tree);
    svo_probe_options options = small_options(2, 2, 2);
    options.field_size = 1;
    /* The center of a fitted grid is not a round number: its probes are put around it. */
    svo_probe_info planned = SVO_PROBE_INFO_INIT;
    light_succeed(&opened, plan_of_tree(tree.tree, &options, &planned));
    for (int axis = 0; axis < 3; ++axis) {
        const float half = (planned.high[axis] - planned.low[axis]) / 2;
        options.start[axis] = planned.low[axis] + half - 0.25F * half;
        options.step[axis] = 0.5F * half;
    }
    seen of = make(&opened, tree.tree, &options);
    const uint16_t expected[4] = {0, 1, 2, 3};
    for (int axis = 0; axis < 3; ++axis) {
        const float center = of.info.low[axis] + (of.info.high[axis] - of.info.low[axis]) / 2;
        const uint32_t next = axis == 0 ? 1 : axis == 1 ? 2 : 4;
        assert_true(center - of.places[0].position[axis] == of.places[next].position[axis] - center);
    }
    assert_memory_equal(of.field, expected, sizeof expected);
    forget(&of);
    built_destroy(&tree);
    parts_free(&room);
}

/* ---- places ---- */

/* One probe at a point, with a step of its own. */
static svo_probe_options one_probe(float x, float y, float z, float step)
{
    svo_probe_options options = small_options(1, 1, 1);
    options.start[0] = x;
    options.start[1] = y;
    options.start[2] = z;
    options.step[0] = options.step[1] = options.step[2] = step;
    return options;
}

/* The share of a probe's texels that are behind the room's front, by the normals of exact rays. */
static double share_behind(const fixture *opened, svo_tree *tree, const seen *of, uint32_t probe, double *nearest)
{
    static svo_ray rays[RESOLUTION * RESOLUTION];
    static svo_hit hits[RESOLUTION * RESOLUTION];
    uint32_t behind = 0;
    aim(of, probe, rays);
    light_succeed(opened, svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits),
                                              RESOLUTION * RESOLUTION, SVO_TRACE_CLOSEST, NULL));
    *nearest = INFINITY;
    for (uint32_t i = 0; i < RESOLUTION * RESOLUTION; ++i) {
        double along = 0;
        for (int axis = 0; axis < 3; ++axis) {
            along += (double)hits[i].normal[axis] * (double)rays[i].direction[axis];
        }
        behind += along > 0 ? 1 : 0;
        *nearest = fmin(*nearest, (double)hits[i].t);
    }
    return (double)behind / (RESOLUTION * RESOLUTION);
}

static void probes_in_bad_places_move(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts room = room_with_ball();
    built tree;
    build(&opened, &room, SVO_NEED_RAYS, &tree);
    /* In the ball, near its middle; at its surface; at a wall. */
    const float starts[3][3] = {{4.9F, 4.4F, 3.5F}, {5, 5.7F, 3.5F}, {0.05F, 3, 3}};
    for (int k = 0; k < 3; ++k) {
        double nearest = 0;
        const svo_probe_options options = one_probe(starts[k][0], starts[k][1], starts[k][2], 4);
        seen of = make(&opened, tree.tree, &options);
        assert_int_equal(of.info.moved, 1);
        assert_int_equal(of.info.off, 0);
        assert_int_equal(of.places[0].state, SVO_PROBE_MOVED);
        assert_true(of.info.place_rays > 32 * 32);
        for (int axis = 0; axis < 3; ++axis) {
            assert_true(fabsf(of.places[0].position[axis] - starts[k][axis]) <= 2.0F);
            assert_true(of.places[0].position[axis] > 0 && of.places[0].position[axis] < 8);
        }
        assert_true(share_behind(&opened, tree.tree, &of, 0, &nearest) < 0.5);
        assert_true(nearest >= (double)of.info.leaf_edge * 0.99);
        /* The nearest of them: not much farther than needed to leave the ball, or the wall. */
        double squared = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double way = (double)of.places[0].position[axis] - (double)starts[k][axis];
            squared += way * way;
        }
        assert_true(sqrt(squared) <= (k == 0 ? 1.25 : 0.25) + 3.0 * (double)of.info.leaf_edge);
        forget(&of);
    }
    built_destroy(&tree);
    parts_free(&room);
}

static void probes_without_a_free_place_are_off(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts room = room_with_ball();
    built tree;
    build(&opened, &room, SVO_NEED_RAYS, &tree);
    /* Two in the ball; half a step does not leave it. */
    svo_probe_options options = one_probe(5, 4.5F, 3.5F, 0.5F);
    options.counts[0] = 2;
    options.step[0] = 0.75F;
    options.field_size = 4;
    seen of = make(&opened, tree.tree, &options);
    assert_int_equal(of.info.off, 2);
    assert_int_equal(of.info.moved, 0);
    assert_int_equal(of.info.rays, 0);
    for (uint32_t i = 0; i < RESOLUTION * RESOLUTION * 2; ++i) {
        assert_int_equal(of.texels[2 * i] & 0xffffu, SVO_PROBE_NOTHING);
    }
    for (int i = 0; i < 4 * 64; ++i) {
        assert_int_equal(of.field[i], SVO_PROBE_NONE);
    }
    forget(&of);
    options.keep_places = 1;
    of = make(&opened, tree.tree, &options);
    assert_int_equal(of.info.off + of.info.moved, 0);
    assert_int_equal(of.info.place_rays, 0);
    assert_int_equal(of.info.rays, 2 * RESOLUTION * RESOLUTION);
    assert_true(of.places[0].state == SVO_PROBE_IN_PLACE && of.places[1].position[0] == 5.75F);
    assert_true((of.texels[0] & 0xffffu) < SVO_PROBE_NOTHING);
    forget(&of);
    built_destroy(&tree);
    parts_free(&room);
}

/* ---- light ---- */

typedef struct lit {
    built tree;
    svo_light *light;
} lit;

static const svo_plan_options lit_grid = {.need = SVO_NEED_NORMAL | (unsigned)SVO_NEED_RAYS |
                                                  (unsigned)SVO_NEED_MATERIAL | (unsigned)SVO_NEED_COLOR};

/* A room of one material, which emits; its color is black. */
static void open_glowing_room(const fixture *opened, const float emission[3], lit *out)
{
    const svo_material black = {.rgba = {0, 0, 0, 255}, .texture_index = SVO_NO_TEXTURE};
    const uint16_t materials[12] = {0};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    const svo_finish finish = {.emission = {emission[0], emission[1], emission[2]}};
    parts room = {.positions = NULL};
    parts_add_cube(&room, 0, 8, true, -1);
    svo_mesh mesh = parts_mesh(&room);
    mesh.materials = &black;
    mesh.material_count = 1;
    mesh.triangle_materials = materials;
    fixture_build(opened, &mesh, DEPTH, &lit_grid, &out->tree);
    out->light = light_of(opened, out->tree.tree, SVO_LIGHT_FACES);
    setup.finishes = &finish;
    setup.finish_count = 1;
    light_succeed(opened, svo_light_set_sources(out->light, &setup, opened->queue));
    parts_free(&room);
}

static void close_lit(lit *of)
{
    svo_light_destroy(&of->light);
    built_destroy(&of->tree);
}

/* A black room that glows has its emission as radiance everywhere, and pi times it as irradiance. */
static void a_glowing_room_has_its_emission(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const float emission[3] = {1.5F, 0.25F, 0.0625F};
    lit room;
    open_glowing_room(&opened, emission, &room);
    svo_probe_options options = small_options(2, 2, 1);
    options.light = room.light;
    options.diffuse = 1;
    options.cones = 1;
    seen of = make(&opened, room.tree.tree, &options);
    for (uint32_t i = 0; i < of.info.probe_count * RESOLUTION * RESOLUTION; ++i) {
        float radiance[3];
        svo_probe_radiance(of.texels[2 * i + 1], radiance);
        assert_true(radiance[0] == 1.5F && radiance[1] == 0.25F && radiance[2] == 0.0625F);
    }
    for (uint32_t i = 0; i < of.info.probe_count * 64; ++i) {
        float irradiance[3];
        svo_probe_radiance(of.irradiance[i], irradiance);
        for (int channel = 0; channel < 3; ++channel) {
            const double expected = PI * (double)emission[channel];
            const double step = channel == 2 ? 1.0 / 64 : 1.0 / 128;
            if (!(fabs((double)irradiance[channel] - expected) <= (step + 0.02) * expected)) {
                fail_msg("irradiance %g of channel %d instead of %g", (double)irradiance[channel], channel, expected);
            }
        }
    }
    forget(&of);
    close_lit(&room);
}

/* Direct light of the sun on a floor, without photons: albedo E cos / pi on the floor, the sky above. */
static void texels_have_the_direct_light(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const float positions[] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1};
    static const uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    const svo_plan_options grid = {
        .need = SVO_NEED_NORMAL | (unsigned)SVO_NEED_RAYS, .edge = 2, .origin = {-1, -1, -1}};
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {3, -4, 0}, .value = {2, 2, 2}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    svo_mesh mesh = SVO_MESH_INIT;
    lit floor;
    mesh.positions = positions;
    mesh.vertex_count = 4;
    mesh.indices = indices;
    mesh.triangle_count = 2;
    fixture_build(&opened, &mesh, DEPTH, &grid, &floor.tree);
    floor.light = light_of(&opened, floor.tree.tree, SVO_LIGHT_FACES);
    setup.sources = &sun;
    setup.source_count = 1;
    setup.no_photons = 1;
    light_succeed(&opened, svo_light_set_sources(floor.light, &setup, opened.queue));
    svo_probe_options options = one_probe(0, 0.5F, 0, 1);
    options.light = floor.light;
    seen of = make(&opened, floor.tree.tree, &options);
    uint32_t floor_texels = 0;
    for (uint32_t i = 0; i < RESOLUTION * RESOLUTION; ++i) {
        const bool met = (of.texels[2 * i] & 0xffffu) != SVO_PROBE_NOTHING;
        const double expected = met ? 0.6 * 2 * 0.8 / PI : 0;
        float radiance[3];
        svo_probe_radiance(of.texels[2 * i + 1], radiance);
        floor_texels += met ? 1 : 0;
        if (!(fabs((double)radiance[0] - expected) <= expected / 64) || radiance[1] != radiance[0]) {
            fail_msg("texel %u has %g instead of %g", i, (double)radiance[0], expected);
        }
    }
    assert_in_range(floor_texels, RESOLUTION * RESOLUTION / 8, RESOLUTION * RESOLUTION / 2);
    forget(&of);
    close_lit(&floor);
}

/* A pane of some alpha that glows green over a floor that glows red; albedos are black. need: of the tree. */
static void open_pane(const fixture *opened, uint8_t alpha, uint32_t need, lit *out)
{
    static const float positions[] = {-0.97F, -0.48F, -0.97F, 0.97F, -0.48F, -0.97F, 0.97F, -0.48F,
                                      0.97F,  -0.97F, -0.48F, 0.97F, -0.9F,  0.02F,  -0.9F, 0.9F,
                                      0.02F,  -0.9F,  0.9F,   0.02F, 0.9F,   -0.9F,  0.02F, 0.9F};
    static const uint32_t indices[] = {0, 2, 1, 0, 3, 2, 4, 6, 5, 4, 7, 6};
    static const uint16_t of_triangles[] = {0, 0, 1, 1};
    const svo_material materials[2] = {{.rgba = {0, 0, 0, 255}, .texture_index = SVO_NO_TEXTURE},
                                       {.rgba = {0, 0, 0, alpha}, .texture_index = SVO_NO_TEXTURE}};
    const svo_finish finishes[2] = {{.emission = {1, 0, 0}}, {.emission = {0, 1, 0}}};
    const svo_plan_options grid = {.need = need, .edge = 2, .origin = {-1, -1, -1}};
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions = positions,
                           .vertex_count = 8,
                           .indices = indices,
                           .triangle_count = 4,
                           .triangle_materials = of_triangles,
                           .materials = materials,
                           .material_count = 2};
    const svo_light_setup setup = {
        .struct_size = sizeof setup, .finishes = finishes, .finish_count = 2, .sky = {0, 0, 1}, .no_photons = 1};
    fixture_build(opened, &mesh, DEPTH, &grid, &out->tree);
    out->light = light_of(opened, out->tree.tree, SVO_LIGHT_FACES);
    light_succeed(opened, svo_light_set_sources(out->light, &setup, opened->queue));
}

/* What a probe above sees of them in its texels: by how much more of those towards the pane have it than should, as a
   share. Each has the light of what its distance is of. A slanted ray meets another voxel of the pane as often as it
   is slanted along an axis. error: of distances, world units. */
static double more_of_pane(const seen *of, double alpha, bool of_voxels, double error)
{
    double towards = 0;
    double more = 0;
    for (uint32_t i = 0; i < RESOLUTION * RESOLUTION; ++i) {
        float direction[3];
        float radiance[3];
        svo_probe_direction(RESOLUTION, i % RESOLUTION, i / RESOLUTION, direction);
        svo_probe_radiance(of->texels[2 * i + 1], radiance);
        const double down = -(double)direction[1];
        const double slants[2] = {fabs((double)direction[0]) / down, fabs((double)direction[2]) / down};
        const bool is_towards = down > 0 && slants[0] < 1 && slants[1] < 1;
        const double passes = (1 - alpha) * (of_voxels ? (1 - alpha * slants[0]) * (1 - alpha * slants[1]) : 1);
        const uint32_t code = of->texels[2 * i] & 0xffffu;
        const double height = code == SVO_PROBE_NOTHING ? HUGE_VAL : down * svo_probe_distance(&of->info, code);
        const bool is_pane = fabs(height - 0.5) <= error;
        const bool is_floor = fabs(height - 1) <= error;
        if ((radiance[1] == 1.0F) != is_pane || (radiance[0] == 1.0F) != is_floor ||
            (radiance[2] > 0.5F) != (code == SVO_PROBE_NOTHING)) {
            fail_msg("texel %u: radiance %g %g %g, %g below the probe", i, (double)radiance[0], (double)radiance[1],
                     (double)radiance[2], height);
        }
        towards += is_towards ? 1 : 0;
        more += is_towards ? (is_pane ? 1 : 0) - (1 - passes) : 0;
    }
    return more / towards;
}

/* Of texels towards a pane as many see it as its alpha tells; the others see what is behind, each with its light. */
static void texels_see_by_alpha(void **state)
{
    static const uint8_t alphas[] = {0, 64, 128, 254, 255};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t k = 0; k < 2 * sizeof alphas; ++k) {
        const uint8_t alpha = alphas[k / 2];
        const bool of_voxels = k % 2 != 0;
        lit panes;
        open_pane(&opened, alpha, of_voxels ? lit_grid.need & ~(unsigned)SVO_NEED_RAYS : lit_grid.need, &panes);
        svo_probe_options options = one_probe(0, 0.52F, 0, 1);
        options.light = panes.light;
        options.keep_places = 1;
        seen of = make(&opened, panes.tree.tree, &options);
        const double more = more_of_pane(&of, alpha / 255.0, of_voxels, of_voxels ? 2.0 / 32 : 0.002);
        if (!(fabs(more) <= (of_voxels ? 0.03 : 0.02))) {
            fail_msg("alpha %u of %s: %g more of the texels than should see the pane", alpha,
                     of_voxels ? "voxels" : "triangles", more);
        }
        forget(&of);
        close_lit(&panes);
    }
}

/* New light changes radiance and irradiance, and nothing else; the same light gives the same bytes. */
static void relighting_changes_radiance_alone(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const float emission[3] = {1, 1, 1};
    const svo_finish brighter = {.emission = {2, 2, 2}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    char hashes[3][SVO_HASH_TEXT_BYTES];
    lit room;
    open_glowing_room(&opened, emission, &room);
    svo_probe_options options = small_options(2, 1, 1);
    options.light = room.light;
    options.diffuse = 1;
    options.cones = 1;
    seen before = make(&opened, room.tree.tree, &options);
    light_succeed(&opened, svo_probes_hash(before.probes, NULL, hashes[0]));
    light_succeed(&opened, svo_probes_relight(before.probes, opened.queue));
    light_succeed(&opened, svo_probes_hash(before.probes, NULL, hashes[1]));
    assert_string_equal(hashes[0], hashes[1]);
    setup.finishes = &brighter;
    setup.finish_count = 1;
    light_succeed(&opened, svo_light_set_sources(room.light, &setup, opened.queue));
    light_succeed(&opened, svo_probes_relight(before.probes, NULL));
    light_succeed(&opened, svo_probes_hash(before.probes, NULL, hashes[2]));
    assert_string_not_equal(hashes[0], hashes[2]);
    seen after = look(&opened, before.probes);
    before.probes = NULL;
    for (uint32_t i = 0; i < 2 * RESOLUTION * RESOLUTION; ++i) {
        float radiance[3];
        svo_probe_radiance(after.texels[2 * i + 1], radiance);
        assert_int_equal(after.texels[2 * i], before.texels[2 * i]);
        assert_true(radiance[0] == 2.0F && radiance[2] == 2.0F);
    }
    assert_memory_equal(after.places, before.places, after.info.bytes[SVO_PROBES_PLACES]);
    assert_memory_equal(after.least, before.least, after.info.bytes[SVO_PROBES_LEAST]);
    assert_memory_equal(after.field, before.field, after.info.bytes[SVO_PROBES_FIELD]);
    assert_memory_equal(after.moments, before.moments, after.info.bytes[SVO_PROBES_MOMENTS]);
    assert_true(memcmp(after.irradiance, before.irradiance, after.info.bytes[SVO_PROBES_IRRADIANCE]) != 0);
    forget(&before);
    forget(&after);
    close_lit(&room);
}

/* Moments are the means of what the texels say. */
static void moments_are_means_of_texels(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const float emission[3] = {1, 1, 1};
    lit room;
    open_glowing_room(&opened, emission, &room);
    svo_probe_options options = small_options(257, 1, 1); /* more than a launch makes */
    options.keep_places = 1;
    options.light = room.light;
    options.diffuse = 1;
    options.cones = 1;
    seen of = make(&opened, room.tree.tree, &options);
    const uint32_t edge = RESOLUTION / 16;
    for (uint32_t i = 0; i < of.info.probe_count * 256; ++i) {
        double mean = 0;
        double square = 0;
        for (uint32_t k = 0; k < edge * edge; ++k) {
            const uint32_t *texel = texel_at(&of, i / 256, i % 16 * edge + k % edge, i / 16 % 16 * edge + k / edge);
            const double leaf_edges = svo_probe_distance(&of.info, texel[0] & 0xffffu) / (double)of.info.leaf_edge;
            mean += leaf_edges / (edge * edge);
            square += leaf_edges * leaf_edges / (edge * edge);
        }
        if (!(fabs((double)of.moments[2 * i] - mean) <= 0.005) ||
            !(fabs((double)of.moments[2 * i + 1] - square) <= 0.01 * (1 + mean))) {
            fail_msg("moments %g, %g of texel %u instead of %g, %g", (double)of.moments[2 * i],
                     (double)of.moments[2 * i + 1], i, mean, square);
        }
    }
    forget(&of);
    close_lit(&room);
}

/* ---- scenes of placed trees ---- */

/* All but what is found on the way. */
static void expect_as_planned(const svo_probe_info *made, const svo_probe_info *planned)
{
    svo_probe_info found = *planned;
    assert_int_equal(planned->rays, (uint64_t)planned->probe_count * planned->resolution * planned->resolution);
    assert_true(made->place_rays <= planned->place_rays);
    assert_true(planned->moved == 0 && planned->off == 0);
    found.moved = made->moved;
    found.off = made->off;
    found.rays -= (uint64_t)made->off * made->resolution * made->resolution;
    found.place_rays = made->place_rays;
    memcpy(found.stage_ms, made->stage_ms, sizeof found.stage_ms);
    assert_memory_equal(made, &found, sizeof found);
}

/* Of a pane in a scene as many texels see what is behind as of the pane's tree, and the same ones, where the instance
   is not moved; by voxels, also where the scene has triangles. */
static void scenes_are_seen_by_alpha(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const uint32_t of_voxels = lit_grid.need & ~(uint32_t)SVO_NEED_RAYS;
    svo_probe_options options = one_probe(0, 0.52F, 0, 1);
    lit panes;
    options.keep_places = 1;
    open_pane(&opened, 128, of_voxels, &panes);
    seen by_tree = make(&opened, panes.tree.tree, &options);
    close_lit(&panes);
    for (int k = 0; k < 2; ++k) {
        open_pane(&opened, 128, k == 0 ? of_voxels : lit_grid.need, &panes);
        const svo_instance instance = {.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
        const uint32_t need = k == 0 ? SVO_NEED_COLOR : (uint32_t)SVO_NEED_COLOR | SVO_NEED_RAYS;
        const svo_scene_options placed = {.struct_size = sizeof placed,
                                          .trees = &panes.tree.tree,
                                          .instances = &instance,
                                          .tree_count = 1,
                                          .instance_count = 1,
                                          .need = need};
        svo_scene *scene = NULL;
        svo_probes *probes = NULL;
        light_succeed(&opened, svo_scene_create(opened.device, &placed, opened.queue, &scene));
        options.scene = scene;
        light_succeed(&opened, svo_probes_create(&options, opened.queue, &probes));
        seen by_scene = look(&opened, probes);
        uint32_t behind = 0;
        uint32_t differing = 0;
        for (uint32_t i = 0; i < RESOLUTION * RESOLUTION; ++i) {
            float direction[3];
            svo_probe_direction(RESOLUTION, i % RESOLUTION, i / RESOLUTION, direction);
            const double a = svo_probe_distance(&by_tree.info, by_tree.texels[2 * i] & 0xffffu);
            const double b = svo_probe_distance(&by_scene.info, by_scene.texels[2 * i] & 0xffffu);
            behind += direction[1] < 0 && b < 1e6 && -(double)direction[1] * b > 0.75 ? 1 : 0;
            differing += fabs(a - b) > 1e-3 * (1 + a) ? 1 : 0;
        }
        assert_in_range(differing, 0, RESOLUTION * RESOLUTION / 500);
        assert_in_range(behind, RESOLUTION * RESOLUTION / 40, RESOLUTION * RESOLUTION / 4);
        forget(&by_scene);
        svo_scene_destroy(&scene);
        options.scene = NULL;
        close_lit(&panes);
    }
    forget(&by_tree);
}

/* An instance that is not moved has the tree's hits, so its probes see the same where they are at the same places. */
static void scenes_are_seen_as_their_trees(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const uint32_t needs[2] = {SVO_NEED_RAYS, SVO_NEED_NORMAL};
    for (int k = 0; k < 2; ++k) {
        parts room = room_with_ball();
        built tree;
        build(&opened, &room, needs[k], &tree);
        const svo_instance instance = {.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
        const svo_scene_options placed = {.struct_size = sizeof placed,
                                          .trees = &tree.tree,
                                          .instances = &instance,
                                          .tree_count = 1,
                                          .instance_count = 1,
                                          .need = needs[k]};
        svo_scene *scene = NULL;
        svo_probes *probes = NULL;
        light_succeed(&opened, svo_scene_create(opened.device, &placed, opened.queue, &scene));
        svo_probe_options options = one_probe(2, 2, 2, 1);
        seen by_tree = make(&opened, tree.tree, &options);
        options.scene = scene;
        options.tree = tree.tree;
        assert_int_equal(svo_probes_create(&options, opened.queue, &probes), SVO_INVALID_ARGUMENT);
        assert_string_equal(svo_device_message(opened.device),
                            "svo_probes_create: options.tree and options.scene are both given");
        svo_probe_info planned = SVO_PROBE_INFO_INIT;
        assert_int_equal(svo_probes_plan(&options, &planned), SVO_INVALID_ARGUMENT);
        assert_string_equal(svo_device_message(opened.device),
                            "svo_probes_plan: options.tree and options.scene are both given");
        options.tree = NULL;
        light_succeed(&opened, svo_probes_plan(&options, &planned));
        light_succeed(&opened, svo_probes_create(&options, opened.queue, &probes));
        seen by_scene = look(&opened, probes);
        expect_as_planned(&by_scene.info, &planned);
        assert_true(fabs((double)by_scene.info.leaf_edge / (double)by_tree.info.leaf_edge - 1) < 1e-6);
        uint32_t differing = 0;
        for (uint32_t i = 0; i < RESOLUTION * RESOLUTION; ++i) {
            const double a = svo_probe_distance(&by_tree.info, by_tree.texels[2 * i] & 0xffffu);
            const double b = svo_probe_distance(&by_scene.info, by_scene.texels[2 * i] & 0xffffu);
            differing += fabs(a - b) > 1e-3 * (1 + a) || (by_tree.texels[2 * i] ^ by_scene.texels[2 * i]) >> 16 != 0;
        }
        assert_in_range(differing, 0, RESOLUTION * RESOLUTION / 500);
        forget(&by_tree);
        forget(&by_scene);
        svo_scene_destroy(&scene);
        built_destroy(&tree);
        parts_free(&room);
    }
}

/* ---- what is allocated and compiled ---- */

static void probes_allocate_what_is_planned(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const float emission[3] = {1, 1, 1};
    lit room;
    open_glowing_room(&opened, emission, &room);
    light_succeed(&opened, svo_tree_make_bvh(room.tree.tree, SVO_BVH_BEST, opened.queue));
    for (int k = 0; k < 3; ++k) {
        svo_probe_options options = small_options(3, 2, 2);
        svo_probe_info planned = SVO_PROBE_INFO_INIT;
        svo_probe_info made = SVO_PROBE_INFO_INIT;
        svo_probes *probes = NULL;
        options.resolution = k == 1 ? 192 : 64; /* more than a band, and less */
        options.light = k > 0 ? room.light : NULL;
        options.diffuse = k == 2;
        options.cones = 1;
        light_succeed(&opened, plan_of_tree(room.tree.tree, &options, &planned));
        counting_begin();
        light_succeed(&opened, probes_of_tree(room.tree.tree, &options, opened.queue, &probes));
        const counted taken = counting_read();
        light_succeed(&opened, svo_probes_get_info(probes, &made));
        assert_int_equal(taken.live_bytes, planned.total_bytes);
        assert_int_equal(taken.peak_bytes, planned.total_bytes + planned.scratch_bytes);
        assert_memory_equal(made.bytes, planned.bytes, sizeof made.bytes);
        assert_int_equal(made.total_bytes, planned.total_bytes);
        assert_int_equal(made.scratch_bytes, planned.scratch_bytes);
        assert_int_equal(planned.bytes[SVO_PROBES_IRRADIANCE] > 0, k == 2);
        assert_int_equal(planned.rays, (uint64_t)12 * options.resolution * options.resolution);
        assert_int_equal(made.rays, planned.rays);
        assert_in_range(made.place_rays, 12 * 32 * 32, planned.place_rays);
        assert_true((made.stage_ms[SVO_PROBES_STAGE_RADIANCE] > 0) == (k > 0));
        assert_true((made.stage_ms[SVO_PROBES_STAGE_FILTER] > 0) == (k == 2));
        svo_probes_destroy(&probes);
        assert_int_equal(counting_read().live_bytes, 0);
    }
    close_lit(&room);
}

/* Neither builds nor lights compile kernels of probes; a plan compiles and allocates nothing; radiance and maps have
   programs of their own. */
static void kernels_are_compiled_where_they_are_asked_for(void **state)
{
    const fixture_options none = {.context = 0};
    const float emission[3] = {1, 1, 1};
    fixture opened;
    lit room;
    (void)state;
    counting_begin();
    fixture_open_cl(&none, &opened);
    open_glowing_room(&opened, emission, &room);
    const counted before = counting_read();
    for (size_t i = 0; i < before.builds; ++i) {
        assert_null(strstr(counting_kernels(i), "svo_k_probe"));
        assert_null(strstr(counting_kernels(i), "svo_k_light_shade"));
    }
    svo_probe_options options = small_options(1, 1, 1);
    svo_probe_info planned = SVO_PROBE_INFO_INIT;
    light_succeed(&opened, plan_of_tree(room.tree.tree, &options, &planned));
    const counted after_plan = counting_read();
    assert_memory_equal(&after_plan, &before, sizeof before);
    seen of = make(&opened, room.tree.tree, &options);
    for (size_t i = before.builds; i < counting_read().builds; ++i) {
        assert_null(strstr(counting_kernels(i), "svo_k_light"));
        assert_null(strstr(counting_kernels(i), "svo_k_probe_irradiance"));
    }
    forget(&of);
    const size_t without = (size_t)counting_read().builds;
    options.light = room.light;
    options.diffuse = 1;
    options.cones = 1;
    of = make(&opened, room.tree.tree, &options);
    assert_int_equal(counting_read().builds, without + 2);
    assert_string_equal(counting_kernels(without), "svo_k_light_shade");
    assert_non_null(strstr(counting_kernels(without + 1), "svo_k_probe_irradiance"));
    forget(&of);
    close_lit(&room);
    fixture_close(&opened);
}

/* ---- the same bytes ---- */

static void hash_room(const fixture *opened, cl_command_queue queue, char text[SVO_HASH_TEXT_BYTES])
{
    parts room = room_with_ball();
    built tree;
    svo_probes *probes = NULL;
    build(opened, &room, SVO_NEED_RAYS, &tree);
    const svo_probe_options options = small_options(3, 3, 3);
    light_succeed(opened, probes_of_tree(tree.tree, &options, queue, &probes));
    light_succeed(opened, svo_probes_hash(probes, queue, text));
    svo_probes_destroy(&probes);
    built_destroy(&tree);
    parts_free(&room);
}

/* For the test below. */
static void print_hash(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char text[SVO_HASH_TEXT_BYTES];
    hash_room(&opened, NULL, text);
    printf("hash %s\n", text);
}

/* The line that this program prints with so many threads of PoCL. */
static void hash_by_threads(unsigned threads, char text[SVO_HASH_TEXT_BYTES])
{
    char path[512] = "";
    char command[640];
    char line[256];
    bool found = false;
    assert_true(readlink("/proc/self/exe", path, sizeof path - 1) > 0);
    (void)snprintf(command, sizeof command, "POCL_MAX_PTHREAD_COUNT=%u '%s' probe_hash 2>/dev/null", threads, path);
    FILE *output = popen(command, "r");
    assert_non_null(output);
    while (fgets(line, sizeof line, output) != NULL) {
        found = found || sscanf(line, "hash %32[0-9a-f]", text) == 1;
    }
    (void)pclose(output);
    assert_true(found);
}

static void queues_and_threads_give_the_same_bytes(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char hashes[4][SVO_HASH_TEXT_BYTES];
    cl_int error = CL_SUCCESS;
    cl_command_queue unordered =
        clCreateCommandQueue(info_of_device(opened.device).context, info_of_device(opened.device).device,
                             CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &error);
    hash_room(&opened, opened.queue, hashes[0]);
    hash_room(&opened, error == CL_SUCCESS ? unordered : NULL, hashes[1]);
    hash_by_threads(1, hashes[2]);
    hash_by_threads(2, hashes[3]);
    for (int k = 1; k < 4; ++k) {
        assert_string_equal(hashes[0], hashes[k]);
    }
    if (error == CL_SUCCESS) {
        clReleaseCommandQueue(unordered);
    }
}

/* ---- options ---- */

/* Without a resolution, the largest up to 256 that the bytes allow. */
static void bytes_choose_the_resolution(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const struct {
        uint32_t count;
        uint64_t max_bytes;
        uint32_t resolution; /* 0: refused */
    } cases[] = {{8, 0, 256},
                 {512, 0, 256},
                 {2048, 0, 256},
                 {2049, 0, 240},
                 {8, UINT64_C(8) * 8 * 128 * 128, 128},
                 {8, (UINT64_C(8) * 8 * 128 * 128) - 1, 112},
                 {8, UINT64_C(8) * 8 * 64 * 64, 64},
                 {8, (UINT64_C(8) * 8 * 64 * 64) - 1, 0},
                 {65534, 0, 0},
                 {65534, UINT64_C(1) << 34, 176}};
    parts room = room_with_ball();
    built tree;
    build(&opened, &room, SVO_NEED_RAYS, &tree);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        svo_probe_options options = small_options(cases[k].count, 1, 1);
        svo_probe_info info = SVO_PROBE_INFO_INIT;
        options.resolution = 0;
        options.max_bytes = cases[k].max_bytes;
        const svo_status status = plan_of_tree(tree.tree, &options, &info);
        assert_int_equal(status, cases[k].resolution != 0 ? SVO_OK : SVO_INVALID_ARGUMENT);
        if (status == SVO_OK) {
            assert_int_equal(info.resolution, cases[k].resolution);
        }
    }
    built_destroy(&tree);
    parts_free(&room);
}

/* Probes are at the centers of equal cells of the grid, or where the caller wants them. */
static void places_are_those_of_the_grid(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts room = room_with_ball();
    built tree;
    build(&opened, &room, SVO_NEED_RAYS, &tree);
    svo_probe_options options = small_options(4, 2, 3);
    options.step[2] = 1.5F;
    options.start[2] = 2.0F;
    options.start[0] = 77; /* not read */
    options.keep_places = 1;
    seen of = make(&opened, tree.tree, &options);
    for (uint32_t i = 0; i < 24; ++i) {
        const double expected[3] = {8 * (i % 4 + 0.5) / 4, 8 * (i / 4 % 2 + 0.5) / 2,
                                    2 + 1.5 * (double)(uint32_t)(i / 8)};
        for (int axis = 0; axis < 3; ++axis) {
            assert_true(fabs((double)of.places[i].position[axis] - expected[axis]) < 1e-4);
        }
    }
    forget(&of);
    built_destroy(&tree);
    parts_free(&room);
}

/* F is at least as far as any probe sees; probes far outside have distances, not clamped ones. */
static void probes_outside_see_the_whole_grid(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts ball = {.positions = NULL};
    built tree;
    parts_add_sphere(&ball, (const double[3]){0, 0, 0}, 1, 12);
    build(&opened, &ball, SVO_NEED_RAYS, &tree);
    const svo_probe_options options = one_probe(0.01F, 0.02F, 50, 1);
    seen of = make(&opened, tree.tree, &options);
    assert_true(of.info.farthest > 51);
    assert_int_equal(of.places[0].state, SVO_PROBE_IN_PLACE);
    uint32_t met = 0;
    for (uint32_t i = 0; i < RESOLUTION * RESOLUTION; ++i) {
        const double distance = svo_probe_distance(&of.info, of.texels[2 * i] & 0xffffu);
        met += isinf(distance) ? 0 : 1;
        assert_true(isinf(distance) || (distance > 48.9 && distance < 50.1));
    }
    assert_true(met <= 4);
    forget(&of);
    built_destroy(&tree);
    parts_free(&ball);
}

static void an_empty_tree_has_probes(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh none = SVO_MESH_INIT;
    const svo_plan_options needs[2] = {{.need = SVO_NEED_RAYS}, {.need = SVO_NEED_NONE}};
    for (int k = 0; k < 2; ++k) {
        built tree;
        fixture_build(&opened, &none, DEPTH, &needs[k], &tree);
        const svo_probe_options options = small_options(2, 2, 2);
        seen of = make(&opened, tree.tree, &options);
        const uint16_t expected[4] = {0, 1, 2, 4};
        assert_int_equal(of.info.moved + of.info.off, 0);
        for (uint32_t i = 0; i < 8 * RESOLUTION * RESOLUTION; ++i) {
            assert_int_equal(of.texels[2 * i] & 0xffffu, SVO_PROBE_NOTHING);
        }
        for (int i = 0; i < 4; ++i) {
            assert_int_equal(of.field[i], expected[i]);
        }
        forget(&of);
        built_destroy(&tree);
    }
}

/* ---- what is refused ---- */

static void refuse(const fixture *opened, svo_status status, const char *message)
{
    assert_int_equal(status, SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened->device), message);
}

static void wrong_options_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const float emission[3] = {1, 1, 1};
    svo_probe_info info = SVO_PROBE_INFO_INIT;
    svo_probes *probes = NULL;
    lit room;
    parts other = room_with_ball();
    built tree;
    open_glowing_room(&opened, emission, &room);
    build(&opened, &other, SVO_NEED_RAYS, &tree);
    svo_probe_options options = small_options(1, 0, 1);
    refuse(&opened, plan_of_tree(tree.tree, &options, &info),
           "svo_probes_plan: options.counts[1] 0 is not in 1 .. 65534");
    options = small_options(300, 300, 1);
    refuse(&opened, probes_of_tree(tree.tree, &options, NULL, &probes),
           "svo_probes_create: options.counts 300 x 300 x 1 are above 65534 probes");
    options = small_options(1, 1, 1);
    options.resolution = 100;
    refuse(&opened, probes_of_tree(tree.tree, &options, NULL, &probes),
           "svo_probes_create: options.resolution 100 is not a multiple of 16 in 64 .. 1024");
    options.resolution = 1040;
    refuse(&opened, probes_of_tree(tree.tree, &options, NULL, &probes),
           "svo_probes_create: options.resolution 1040 is not a multiple of 16 in 64 .. 1024");
    options.resolution = 1024;
    options.max_bytes = 1000;
    refuse(&opened, probes_of_tree(tree.tree, &options, NULL, &probes),
           "svo_probes_create: 1 probes of options.resolution 1024 take 8388608 bytes, above options.max_bytes 1000");
    options = small_options(65534, 1, 1);
    options.resolution = 512;
    options.max_bytes = UINT64_MAX;
    refuse(&opened, plan_of_tree(tree.tree, &options, &info),
           "svo_probes_plan: 65534 probes of options.resolution 512 have more than 4294967295 texels");
    options = small_options(1, 1, 1);
    options.field_size = 257;
    refuse(&opened, probes_of_tree(tree.tree, &options, NULL, &probes),
           "svo_probes_create: options.field_size 257 is not in 1 .. 256");
    options = small_options(1, 1, 1);
    options.step[1] = -1;
    refuse(&opened, probes_of_tree(tree.tree, &options, NULL, &probes),
           "svo_probes_create: options.step[1] -1 is negative or not finite");
    options.step[1] = 1;
    options.start[1] = INFINITY;
    refuse(&opened, probes_of_tree(tree.tree, &options, NULL, &probes),
           "svo_probes_create: options.start[1] inf is not finite");
    options = one_probe(0, 0, 0, 1);
    options.counts[0] = 5;
    options.step[0] = 1e38F;
    assert_int_equal(probes_of_tree(tree.tree, &options, NULL, &probes), SVO_UNSUPPORTED);
    assert_non_null(strstr(svo_device_message(opened.device), "beyond the range of floats"));
    options = small_options(1, 1, 1);
    options.diffuse = 1;
    refuse(&opened, probes_of_tree(tree.tree, &options, NULL, &probes),
           "svo_probes_create: options.diffuse 1 needs options.light, which is NULL");
    options.light = room.light;
    refuse(&opened, probes_of_tree(tree.tree, &options, NULL, &probes),
           "svo_probes_create: options.light is not of the tree");
    options.cones = 3;
    refuse(&opened, probes_of_tree(room.tree.tree, &options, NULL, &probes),
           "svo_probes_create: options.cones 3 is not 1, 5, 6, 16 or 64");
    options.struct_size = 4;
    assert_int_equal(probes_of_tree(tree.tree, &options, NULL, &probes), SVO_INVALID_ARGUMENT);
    assert_null(probes);
    built_destroy(&tree);
    parts_free(&other);
    close_lit(&room);
}

static void wrong_handles_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_probe_info info = SVO_PROBE_INFO_INIT;
    char text[SVO_HASH_TEXT_BYTES];
    parts room = room_with_ball();
    built tree;
    build(&opened, &room, SVO_NEED_RAYS, &tree);
    svo_probes *probes = NULL;
    svo_probe_options options = small_options(1, 1, 1);
    assert_int_equal(svo_probes_plan(NULL, &info), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_probes_plan(&options, &info), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_probes_create(NULL, NULL, &probes), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_probes_create(&options, NULL, &probes), SVO_INVALID_ARGUMENT);
    options.tree = tree.tree;
    refuse(&opened, svo_probes_create(&options, NULL, NULL), "svo_probes_create: out is NULL");
    light_succeed(&opened, svo_probes_create(&options, NULL, &probes));
    refuse(&opened, svo_probes_relight(probes, NULL), "svo_probes_relight: the probes were made without a light");
    refuse(&opened, svo_probes_hash(probes, NULL, NULL), "svo_probes_hash: text is NULL");
    assert_int_equal(svo_probes_relight(NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_probes_hash(NULL, NULL, text), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_probes_get_info(NULL, &info), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_probes_get_info(probes, NULL), SVO_INVALID_ARGUMENT);
    assert_null(svo_probes_get_buffer(NULL, SVO_PROBES_TEXELS));
    assert_null(svo_probes_get_buffer(probes, SVO_PROBES_BUFFER_COUNT));
    assert_null(svo_probes_get_buffer(probes, SVO_PROBES_MOMENTS));
    svo_probes_destroy(&probes);
    svo_probes_destroy(&probes);
    svo_probes_destroy(NULL);
    built_destroy(&tree);
    parts_free(&room);
}

static void names_are_those_of_the_header(void **state)
{
    (void)state;
    assert_string_equal(svo_name(SVO_NAME_PROBES_BUFFER, SVO_PROBES_PLACES), "places");
    assert_string_equal(svo_name(SVO_NAME_PROBES_BUFFER, SVO_PROBES_MOMENTS), "moments");
    assert_string_equal(svo_name(SVO_NAME_PROBES_BUFFER, SVO_PROBES_BUFFER_COUNT), "unknown buffer");
    assert_string_equal(svo_name(SVO_NAME_PROBES_STAGE, SVO_PROBES_STAGE_PLACE), "placing");
    assert_string_equal(svo_name(SVO_NAME_PROBES_STAGE, SVO_PROBES_STAGE_FILTER), "prefilter");
    assert_string_equal(svo_name(SVO_NAME_PROBES_STAGE, SVO_PROBES_STAGE_COUNT), "unknown stage");
}

/* For the same program with another number of threads. */
TEST_GROUP(probe_hash)
{
    const struct CMUnitTest printing[] = {cmocka_unit_test(print_hash)};
    return cmocka_run_group_tests_name("probe_hash", printing, fixture_group_setup, fixture_group_teardown);
}

TEST_GROUP(probes)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texels_are_what_exact_rays_meet),
        cmocka_unit_test(voxels_are_seen_without_triangles),
        cmocka_unit_test(least_distances_are_of_blocks),
        cmocka_unit_test(the_field_lists_the_nearest_that_see),
        cmocka_unit_test(ties_go_to_the_smaller_index),
        cmocka_unit_test(probes_in_bad_places_move),
        cmocka_unit_test(probes_without_a_free_place_are_off),
        cmocka_unit_test(a_glowing_room_has_its_emission),
        cmocka_unit_test(texels_have_the_direct_light),
        cmocka_unit_test(texels_see_by_alpha),
        cmocka_unit_test(relighting_changes_radiance_alone),
        cmocka_unit_test(moments_are_means_of_texels),
        cmocka_unit_test(scenes_are_seen_as_their_trees),
        cmocka_unit_test(scenes_are_seen_by_alpha),
        cmocka_unit_test(probes_allocate_what_is_planned),
        cmocka_unit_test(kernels_are_compiled_where_they_are_asked_for),
        cmocka_unit_test(queues_and_threads_give_the_same_bytes),
        cmocka_unit_test(bytes_choose_the_resolution),
        cmocka_unit_test(places_are_those_of_the_grid),
        cmocka_unit_test(probes_outside_see_the_whole_grid),
        cmocka_unit_test(an_empty_tree_has_probes),
        cmocka_unit_test(wrong_options_are_refused),
        cmocka_unit_test(wrong_handles_are_refused),
        cmocka_unit_test(names_are_those_of_the_header),
    };
    return cmocka_run_group_tests_name("probes", tests, fixture_group_setup, fixture_group_teardown);
}
