/* SPDX-License-Identifier: MIT */
/*
 * The payload: color, normal, material and fill of every leaf and every inner node equal the reference byte for byte,
 * for every kind of attribute. Colors agree with double precision. Means over very many triangles are exact. Neither
 * the order nor the chunking of the list matters.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/device.h"
#include "scenes.h"
#include "support/attributed_mesh.h"
#include "support/payload_reference.h"
#include "support/suite.h"

#define NEED_MEANS ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL)
/* Payload of every kind. */
#define NEED_PAYLOAD (NEED_MEANS | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL)

static void check_payload(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options)
{
    built actual;
    exact expected;
    fixture_build(opened, mesh, depth, options, &actual);
    exact_create(mesh, depth, options, &expected);
    assert_tree_is_exact(&actual, &expected);
    assert_payload_is_exact(mesh, &expected, &actual);
    exact_destroy(&expected);
    built_destroy(&actual);
}

static void payload_of_every_attribute_is_exact(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (uint64_t seed = 1; seed <= (suite_is_long() ? 12 : 7); ++seed) {
        const unsigned depth = 1 + (unsigned)seed % 7;
        print_message("seed %llu at depth %u\n", (unsigned long long)seed, depth);
        attributed_mesh made;
        attributed_mesh_create(seed, seed % 4 == 0 ? 3 : 300, 0.0, &made);
        check_payload(opened, &made.mesh, depth, &(svo_plan_options){.need = NEED_PAYLOAD});
        check_payload(opened, &made.mesh, depth, &(svo_plan_options){.need = SVO_NEED_ALL, .edge = 1.0});
        for (int weights = SVO_WEIGHTS_AREA; weights <= SVO_WEIGHTS_CENTER; ++weights) {
            const svo_plan_options options = {.need = NEED_MEANS | SVO_NEED_MATERIAL, .weights = (svo_weights)weights};
            check_payload(opened, &made.mesh, depth, &options);
        }
        attributed_mesh_destroy(&made);
    }
}

/* Missing attributes have defaults: white, the triangle's own normal, the first material, no texture. */
static void payload_without_some_attributes_is_exact(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (unsigned without = 0; without < 64; without += suite_is_long() ? 1 : 7) {
        attributed_mesh made;
        attributed_mesh_create(1000 + without, 60, 0.0, &made);
        svo_mesh mesh = made.mesh;
        mesh.colors = (without & 1) != 0 ? NULL : mesh.colors;
        mesh.normals = (without & 2) != 0 ? NULL : mesh.normals;
        mesh.uvs = (without & 4) != 0 ? NULL : mesh.uvs;
        mesh.triangle_materials = (without & 8) != 0 ? NULL : mesh.triangle_materials;
        mesh.material_count = (without & 16) != 0 ? 0 : mesh.material_count;
        mesh.texture_count = (without & 32) != 0 ? 0 : mesh.texture_count;
        static const uint32_t needs[] = {NEED_PAYLOAD, SVO_NEED_COLOR, SVO_NEED_NORMAL, SVO_NEED_MATERIAL,
                                         SVO_NEED_FILL};
        const uint32_t need = needs[without % 5];
        check_payload(opened, &mesh, 5, &(svo_plan_options){.need = need});
        attributed_mesh_destroy(&made);
    }
}

/* Triangles that reach far outside the grid, so that weights are computed from 61-bit areas. */
static void payload_of_wide_triangles_is_exact(void **state)
{
    static const double reaches[] = {0.3, 5.0, 120.0, 510.0};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < 4; ++i) {
        attributed_mesh made;
        attributed_mesh_create(50 + i, 200, reaches[i], &made);
        check_payload(opened, &made.mesh, 4 + (unsigned)i % 3, &(svo_plan_options){.need = NEED_PAYLOAD, .edge = 1.0});
        attributed_mesh_destroy(&made);
    }
}

/* Fragments of three words, at depths where voxels are small. */
static void payload_at_great_depths_is_exact(void **state)
{
    const fixture *opened = fixture_of_group(state);
    attributed_mesh made;
    attributed_mesh_create(12, 3, 0.0, &made);
    for (unsigned depth = 9; depth <= SVO_DEPTH_MAX; depth += suite_is_long() ? 1 : 7) {
        /* Deeper grids keep the voxel size of depth 12; otherwise there would be billions of voxels. */
        const double edge = depth <= 12 ? 0.0 : ldexp(1.0, (int)depth - 12);
        check_payload(opened, &made.mesh, depth, &(svo_plan_options){.need = NEED_PAYLOAD, .edge = edge});
    }
    attributed_mesh_destroy(&made);
}

/* Grids whose edge is no power of two, around numbers that are no multiples of its units: voxels of 2^15, 2^8 and again
   2^8 units. */
static void payload_follows_the_given_numbers(void **state)
{
    static const unsigned depths[] = {5, 12, 14};
    const fixture *opened = fixture_of_group(state);
    for (unsigned i = 0; i < 6; ++i) {
        const unsigned depth = depths[i % 3];
        const double edge = ldexp(1.0 / 0.73, (int)depth - 5);
        const svo_plan_options options = {.need = NEED_PAYLOAD | SVO_NEED_PROJECTED_AREA,
                                          .origin = {-0.31 * edge, -0.1 / 3.0 - 0.4 * edge, 0.011},
                                          .edge = edge};
        attributed_mesh made;
        attributed_mesh_create(90 + i, 60, 0.0, &made);
        float *positions = calloc(made.mesh.vertex_count * 3, sizeof *positions);
        assert_non_null(positions);
        for (size_t k = 0; k < made.mesh.vertex_count * 3; ++k) {
            positions[k] = (float)made.mesh.positions_double[k];
        }
        svo_mesh mesh = made.mesh;
        mesh.positions = i < 3 ? positions : NULL;
        mesh.positions_double = i < 3 ? NULL : mesh.positions_double;
        check_payload(opened, &mesh, depth, &options);
        free(positions);
        attributed_mesh_destroy(&made);
    }
}

static void payload_of_scenes_is_exact(void **state)
{
    static const char *const specs[] = {"atrium", "statue:20000", "knot:5000", "terrain:20000", "cornell", "cube"};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; ++i) {
        scene *made = fixture_scene(specs[i]);
        check_payload(opened, scene_mesh(made), suite_is_long() ? 8 : 7, &(svo_plan_options){.need = NEED_PAYLOAD});
        scene_destroy(&made);
    }
}

/* In faces: with less surface than this in a voxel, rounding affects the weights. */
#define AREA_THAT_COUNTS 1e-4

/* The largest difference of built leaf colors from those in doubles. */
static double largest_color_error(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_weights weights)
{
    const svo_plan_options options = {.need = SVO_NEED_COLOR, .weights = weights};
    built actual;
    exact expected;
    fixture_build(opened, mesh, depth, &options, &actual);
    exact_create(mesh, depth, NULL, &expected);
    assert_tree_is_exact(&actual, &expected);
    double *rgba = malloc(actual.info.leaf_count * 4 * sizeof *rgba);
    double *areas = malloc(actual.info.leaf_count * sizeof *areas);
    assert_non_null(rgba);
    assert_non_null(areas);
    payload_double_colors(mesh, &expected, weights, rgba);
    payload_double_areas(&expected, areas);
    double largest = 0.0;
    size_t compared = 0;
    for (size_t leaf = 0; leaf < actual.info.leaf_count; ++leaf) {
        const uint8_t *found = actual.arrays.colors + (actual.info.inner_count + leaf) * 4;
        const bool is_weighed = weights != SVO_WEIGHTS_AREA || areas[leaf] > AREA_THAT_COUNTS;
        compared += is_weighed ? 1 : 0;
        for (size_t channel = 0; is_weighed && channel < 4; ++channel) {
            const double shows = channel < 3 ? rgba[leaf * 4 + 3] / 255 : 1; /* colors count as far as they show */
            largest = fmax(largest, shows * fabs(rgba[leaf * 4 + channel] - found[channel]));
        }
    }
    assert_in_range(compared, actual.info.leaf_count * 9 / 10, actual.info.leaf_count);
    free(areas);
    free(rgba);
    exact_destroy(&expected);
    built_destroy(&actual);
    return largest;
}

/* Half a unit for each of the blend, the product and the mean; the error of 16-bit weights is negligible. */
static void colors_agree_with_doubles(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (uint64_t seed = 1; seed <= 4; ++seed) {
        attributed_mesh made;
        attributed_mesh_create(seed, 300, 0.0, &made);
        made.mesh.texture_count = 0;
        for (int weights = SVO_WEIGHTS_AREA; weights <= SVO_WEIGHTS_CENTER; ++weights) {
            const double error = largest_color_error(opened, &made.mesh, 6, (svo_weights)weights);
            print_message("colors and materials, %s, seed %llu: %.3f units\n",
                          svo_name(SVO_NAME_WEIGHTS, (svo_weights)weights), (unsigned long long)seed, error);
            assert_true(error <= 1.5);
        }
        attributed_mesh_destroy(&made);
    }
}

/* Half a unit for each of the texel, its 256ths on both axes, the product and the mean, and another half for 16-bit
   weights where neighboring texels differ by the full range. */
static void textures_agree_with_doubles(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (uint64_t seed = 1; seed <= 4; ++seed) {
        attributed_mesh made;
        attributed_mesh_create(seed, 300, 0.0, &made);
        made.mesh.colors = NULL;
        for (size_t i = 0; i < made.mesh.vertex_count * 2; ++i) {
            made.uvs[i] = isfinite(made.uvs[i]) ? fmodf(made.uvs[i], 1.0F) : 0.0F;
        }
        const double error = largest_color_error(opened, &made.mesh, 6, SVO_WEIGHTS_CENTER);
        print_message("textures, seed %llu: %.3f units\n", (unsigned long long)seed, error);
        assert_true(error <= 3.0);
        attributed_mesh_destroy(&made);
    }
}

/* Triangles in one voxel, each with one random color and normal. */
typedef struct crowd {
    owned_mesh base;
    svo_mesh mesh;
    uint8_t *colors;
    float *normals;
} crowd;

static void crowd_create(size_t triangle_count, crowd *out)
{
    static const double corner[3] = {0.3, 0.6, 0.9};
    uint64_t state = triangle_count;
    random_dust(triangle_count, triangle_count, corner, 0.001, &out->base);
    out->mesh = out->base.mesh;
    out->colors = malloc(triangle_count * 12);
    out->normals = malloc(triangle_count * 9 * sizeof(float));
    assert_non_null(out->colors);
    assert_non_null(out->normals);
    for (size_t t = 0; t < triangle_count; ++t) {
        for (unsigned k = 0; k < 12; ++k) {
            out->colors[t * 12 + k] = k < 4 ? (uint8_t)random_word(&state) : out->colors[t * 12 + k - 4];
        }
        for (unsigned k = 0; k < 9; ++k) {
            out->normals[t * 9 + k] = k < 3 ? (float)(random_unit(&state) - 0.3) : out->normals[t * 9 + k - 3];
        }
    }
    out->mesh.colors = out->colors;
    out->mesh.normals = out->normals;
}

static void crowd_destroy(crowd *made)
{
    free(made->normals);
    free(made->colors);
    owned_mesh_free(&made->base);
}

/* Half a unit for the mean; for normals another half, since their inputs are rounded to integers. */
static void assert_crowd_mean(const crowd *made, const built *actual)
{
    const size_t count = made->mesh.triangle_count;
    assert_int_equal(actual->info.leaf_count, 1);
    assert_int_equal(actual->info.fragments, count);
    double color[4] = {0.0};
    double normal[3] = {0.0};
    for (size_t t = 0; t < count; ++t) {
        const float *n = made->normals + t * 9;
        const double length =
            sqrt((double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] + (double)n[2] * (double)n[2]);
        for (unsigned k = 0; k < 4; ++k) {
            color[k] += made->colors[t * 12 + k] * (k < 3 ? made->colors[t * 12 + 3] : 1.0); /* alpha weighs */
        }
        for (unsigned k = 0; k < 3; ++k) {
            normal[k] += (double)n[k] / length * 32767.0;
        }
    }
    for (size_t node = 0; node < actual->info.node_count; ++node) {
        for (unsigned k = 0; k < 4; ++k) {
            const double by = k < 3 ? color[3] : (double)count;
            assert_true(fabs(actual->arrays.colors[node * 4 + k] - color[k] / by) <= 0.5000001);
        }
        for (unsigned k = 0; k < 3; ++k) {
            assert_true(fabs(actual->arrays.normals[node * 3 + k] - normal[k] / (double)count) <= 1.0);
        }
    }
}

static void shuffle(uint64_t seed, uint32_t *indices, size_t triangle_count)
{
    uint64_t state = seed;
    for (size_t t = triangle_count; t-- > 1;) {
        uint32_t kept[3];
        const size_t other = random_below(&state, (uint32_t)t + 1);
        memcpy(kept, indices + t * 3, sizeof kept);
        memmove(indices + t * 3, indices + other * 3, sizeof kept);
        memcpy(indices + other * 3, kept, sizeof kept);
    }
}

static void t14_means_over_many_triangles_are_exact(void **state)
{
    static const size_t counts[] = {1, 2, 15, 16, 17, 63, 64, 255, 256, 257, 16383, 16384, 100000};
    const fixture *opened = fixture_of_group(state);
    const svo_plan_options options = {.need = NEED_MEANS, .weights = SVO_WEIGHTS_UNIFORM, .edge = 1.0};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        crowd made;
        built actual;
        built shuffled;
        crowd_create(counts[i], &made);
        fixture_build(opened, &made.mesh, 5, &options, &actual);
        assert_crowd_mean(&made, &actual);
        shuffle(i, made.base.indices, counts[i]);
        fixture_build(opened, &made.mesh, 5, &options, &shuffled);
        assert_string_equal(shuffled.hash, actual.hash);
        built_destroy(&shuffled);
        built_destroy(&actual);
        crowd_destroy(&made);
    }
}

/* Sums far above 32 bits: two million triangles with the colors of two materials. The unit of weights makes their total
   take 44 bits, whatever their number. */
static void t14_means_over_millions_of_triangles_are_exact(void **state)
{
    enum { COUNT = 2000000 };
    static const float positions[9] = {0.5F, 0.5F, 0.5F, 0.51F, 0.5F, 0.5F, 0.5F, 0.51F, 0.5F};
    static const svo_material materials[2] = {{{255, 255, 0, 9}, SVO_NO_TEXTURE}, {{255, 0, 3, 254}, SVO_NO_TEXTURE}};
    uint32_t *indices = malloc((size_t)COUNT * 3 * sizeof *indices);
    uint16_t *triangle_materials = malloc((size_t)COUNT * sizeof *triangle_materials);
    assert_non_null(indices);
    assert_non_null(triangle_materials);
    uint64_t ones = 0;
    for (size_t t = 0; t < COUNT; ++t) {
        indices[t * 3] = 0;
        indices[t * 3 + 1] = 1;
        indices[t * 3 + 2] = 2;
        triangle_materials[t] = t % 7 < 2 ? 1 : 0;
        ones += triangle_materials[t];
    }
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions = positions,
                           .vertex_count = 3,
                           .indices = indices,
                           .triangle_count = COUNT,
                           .triangle_materials = triangle_materials,
                           .materials = materials,
                           .material_count = 2};
    built actual;
    fixture_build(fixture_of_group(state), &mesh, 2, &(svo_plan_options){.need = NEED_PAYLOAD, .edge = 1.0}, &actual);
    assert_int_equal(actual.info.node_count, 3);
    for (unsigned node = 0; node < 3; ++node) {
        for (unsigned k = 0; k < 4; ++k) {
            const double weights[2] = {(double)(COUNT - ones) * (k < 3 ? materials[0].rgba[3] : 1.0),
                                       (double)ones * (k < 3 ? materials[1].rgba[3] : 1.0)};
            const double mean =
                (materials[0].rgba[k] * weights[0] + materials[1].rgba[k] * weights[1]) / (weights[0] + weights[1]);
            assert_int_equal(actual.arrays.colors[node * 4 + k], (int)floor(mean + 0.5));
        }
        assert_int_equal(actual.arrays.normals[node * 3], 0);
        assert_int_equal(actual.arrays.normals[node * 3 + 1], 0);
        assert_int_equal(actual.arrays.normals[node * 3 + 2], 32767);
    }
    built_destroy(&actual);
    free(triangle_materials);
    free(indices);
}

/* A square of leaves: texels of one green show by as many alphas, those between have another color and do not show. The
   green is that of every node, at the rims, too. */
static void what_does_not_show_has_no_color(void **state)
{
    enum { SIDE = 8 };
    static const float positions[12] = {0, 0, 0.4F, 1, 0, 0.4F, 1, 1, 0.4F, 0, 1, 0.4F};
    static const float uvs[8] = {0, 0, 1, 0, 1, 1, 0, 1};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    uint8_t texels[SIDE * SIDE][4];
    double alpha = 0;
    for (size_t i = 0; i < sizeof texels / sizeof texels[0]; ++i) {
        const bool shows = (i / 2 + i / (SIDE * 2)) % 2 == 0;
        const uint8_t shown[4] = {10, 200, 30, (uint8_t)(255 - 2 * i)};
        memcpy(texels[i], shows ? shown : (const uint8_t[4]){255, 0, 255, 0}, 4);
        alpha += texels[i][3] / (double)(SIDE * SIDE);
    }
    const svo_texture texture = {.rgba = texels[0], .width = SIDE, .height = SIDE};
    const svo_material material = {.rgba = {255, 255, 255, 255}};
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions = positions,
                           .vertex_count = 4,
                           .indices = indices,
                           .triangle_count = 2,
                           .uvs = uvs,
                           .materials = &material,
                           .material_count = 1,
                           .textures = &texture,
                           .texture_count = 1};
    for (int weights = SVO_WEIGHTS_AREA; weights <= SVO_WEIGHTS_CENTER; weights += SVO_WEIGHTS_CENTER) {
        const svo_plan_options options = {.need = SVO_NEED_COLOR, .weights = (svo_weights)weights, .edge = 1.0};
        built actual;
        size_t clear = 0;
        fixture_build(fixture_of_group(state), &mesh, 6, &options, &actual);
        for (size_t node = 0; node < actual.info.node_count; ++node) {
            const uint8_t *color = actual.arrays.colors + node * 4;
            const uint8_t expected[3] = {10, 200, 30};
            assert_memory_equal(color, color[3] > 0 ? expected : (const uint8_t[3]){0}, 3);
            clear += color[3] == 0 ? 1 : 0;
        }
        assert_in_range(clear, 1, actual.info.node_count - 1);
        assert_true(fabs(actual.arrays.colors[3] - alpha) <= 1.5);
        built_destroy(&actual);
    }
}

/* A hundred thousand triangles with sixty thousand materials in one voxel, and with a few materials in some hundred
   voxels. */
static void materials_of_many_triangles_are_exact(void **state)
{
    static const struct {
        size_t triangle_count, material_count;
        double width;
        unsigned depth;
        uint64_t chunk_bytes;
    } cases[] = {
        {100000, 60000, 0.001, 3, 0}, {20000, 5, 0.2, 5, 0}, {20000, 300, 0.2, 4, 65536}, {33, 1, 0.001, 4, 0}};
    static const double corner[3] = {0.3, 0.6, 0.7};
    const fixture *opened = fixture_of_group(state);
    svo_material *materials = calloc(60000, sizeof *materials);
    assert_non_null(materials);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        owned_mesh made;
        uint64_t random = i;
        const size_t triangle_count = cases[i].triangle_count;
        random_dust(i + 1, triangle_count, corner, cases[i].width, &made);
        uint16_t *given = malloc(triangle_count * sizeof *given);
        assert_non_null(given);
        for (size_t t = 0; t < triangle_count; ++t) {
            given[t] = (uint16_t)random_below(&random, (uint32_t)cases[i].material_count);
        }
        made.mesh.triangle_materials = given;
        made.mesh.materials = materials;
        made.mesh.material_count = cases[i].material_count;
        for (int weights = SVO_WEIGHTS_AREA; weights <= SVO_WEIGHTS_CENTER; ++weights) {
            const svo_plan_options options = {.need = SVO_NEED_MATERIAL | (weights % 2 == 0 ? 0 : SVO_NEED_RAYS),
                                              .weights = (svo_weights)weights,
                                              .edge = 1.0,
                                              .chunk_bytes = cases[i].chunk_bytes};
            check_payload(opened, &made.mesh, cases[i].depth, &options);
        }
        free(given);
        owned_mesh_free(&made);
    }
    free(materials);
}

/* The fill of a leaf is the area in it within half a step, the fill of a node the area below it. */
static void fills_are_areas(void **state)
{
    static const char *const specs[] = {"knot:2000", "statue:3000", "cube", "needles:200"};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; ++i) {
        scene *made = fixture_scene(specs[i]);
        built actual;
        exact expected;
        fixture_build(opened, scene_mesh(made), 6, &(svo_plan_options){.need = SVO_NEED_FILL}, &actual);
        exact_create(scene_mesh(made), 6, NULL, &expected);
        double *areas = malloc(actual.info.leaf_count * sizeof *areas);
        assert_non_null(areas);
        payload_double_areas(&expected, areas);
        double total = 0.0;
        for (size_t leaf = 0; leaf < actual.info.leaf_count; ++leaf) {
            const double fill = fmin(areas[leaf] * 4096.0, 65535.0);
            assert_true(fabs(fill - actual.arrays.fills[actual.info.inner_count + leaf]) <= 0.51);
            total += areas[leaf];
        }
        assert_true(fabs(total - actual.arrays.fills[0]) <= 0.51); /* 64 x 64 leaf faces per face of the root */
        print_message("%s: %.6f faces of the grid\n", specs[i], total / 4096.0);
        free(areas);
        exact_destroy(&expected);
        built_destroy(&actual);
        scene_destroy(&made);
    }
}

/* Segments, points and triangles that only touch a voxel have equal weights there, whatever their size. */
static void triangles_without_area_have_equal_weights(void **state)
{
    /* A point, a short and a long segment in one voxel of 8; colors of the three. */
    static const float positions[] = {0.3F,  0.3F,  0.3F, 0.3F,  0.3F,  0.3F, 0.3F,  0.3F,  0.3F,
                                      0.31F, 0.3F,  0.3F, 0.32F, 0.3F,  0.3F, 0.33F, 0.3F,  0.3F,
                                      0.3F,  0.27F, 0.3F, 0.3F,  0.29F, 0.3F, 0.3F,  0.36F, 0.3F};
    static const uint8_t colors[] = {250, 0,   0, 255, 250, 0,   0, 255, 250, 0,   0, 255, 0, 100, 0, 255, 0, 100,
                                     0,   255, 0, 100, 0,   255, 0, 0,   7,   255, 0, 0,   7, 255, 0, 0,   7, 255};
    const svo_mesh mesh = {
        .struct_size = sizeof mesh, .positions = positions, .vertex_count = 9, .triangle_count = 3, .colors = colors};
    built actual;
    fixture_build(fixture_of_group(state), &mesh, 3, &(svo_plan_options){.need = SVO_NEED_COLOR, .edge = 1.0}, &actual);
    assert_int_equal(actual.info.leaf_count, 1);
    for (size_t node = 0; node < actual.info.node_count; ++node) {
        const uint8_t *found = actual.arrays.colors + node * 4;
        assert_int_equal(found[0], 83);
        assert_int_equal(found[1], 33);
        assert_int_equal(found[2], 2);
        assert_int_equal(found[3], 255);
    }
    built_destroy(&actual);
}

static void payload_does_not_depend_on_the_chunks(void **state)
{
    static const uint64_t sizes_bytes[] = {16384, 65536, 100000};
    const fixture *opened = fixture_of_group(state);
    attributed_mesh made;
    attributed_mesh_create(99, 120, 0.0, &made);
    for (unsigned depth = 1; depth <= 7; depth += 3) {
        built whole;
        fixture_build(opened, &made.mesh, depth, &(svo_plan_options){.need = NEED_PAYLOAD}, &whole);
        assert_int_equal(whole.report.list_chunks, 1);
        for (size_t i = 0; i < sizeof sizes_bytes / sizeof sizes_bytes[0]; ++i) {
            const svo_plan_options options = {.need = NEED_PAYLOAD, .chunk_bytes = sizes_bytes[i]};
            built cut;
            fixture_build(opened, &made.mesh, depth, &options, &cut);
            assert_in_range(cut.report.list_chunks, depth == 7 ? 2 : 1, UINT32_MAX);
            assert_string_equal(cut.hash, whole.hash);
            built_destroy(&cut);
        }
        built_destroy(&whole);
    }
    check_payload(opened, &made.mesh, 6, &(svo_plan_options){.need = NEED_PAYLOAD, .chunk_bytes = 16384});
    attributed_mesh_destroy(&made);
}

/* As on GPUs: pair by pair, not eight pairs at a time. */
static int setup_for_single_pairs(void **state)
{
    const int failed = fixture_group_setup_unoptimized(state);
    if (failed == 0 && *state != NULL) {
        fixture_of_group(state)->device->cpu_path = false;
    }
    return failed;
}

TEST_GROUP(payload)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(payload_of_every_attribute_is_exact),
        cmocka_unit_test(payload_without_some_attributes_is_exact),
        cmocka_unit_test(payload_of_wide_triangles_is_exact),
        cmocka_unit_test(payload_at_great_depths_is_exact),
        cmocka_unit_test(payload_follows_the_given_numbers),
        cmocka_unit_test(payload_of_scenes_is_exact),
        cmocka_unit_test(colors_agree_with_doubles),
        cmocka_unit_test(textures_agree_with_doubles),
        cmocka_unit_test(t14_means_over_many_triangles_are_exact),
        cmocka_unit_test(t14_means_over_millions_of_triangles_are_exact),
        cmocka_unit_test(materials_of_many_triangles_are_exact),
        cmocka_unit_test(what_does_not_show_has_no_color),
        cmocka_unit_test(fills_are_areas),
        cmocka_unit_test(triangles_without_area_have_equal_weights),
        cmocka_unit_test(payload_does_not_depend_on_the_chunks),
    };
    return cmocka_run_group_tests_name("eight pairs", tests, fixture_group_setup, fixture_group_teardown) +
           cmocka_run_group_tests_name("single pairs", tests, setup_for_single_pairs,
                                       fixture_group_teardown_unoptimized);
}
