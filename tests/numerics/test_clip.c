/* SPDX-License-Identifier: MIT */
/*
 * The part of a triangle inside a voxel (kernels/shared/clip.clh), the basis of area weights. C, OpenCL C and GLSL
 * agree bit for bit; area and centroid match the triangle clipped in double precision; and T2: the pieces of a mesh add
 * up to its area inside the grid.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "clip_probe.clh"
#include "core/device.h"
#include "scenes.h"
#include "support/fixture.h"
#include "support/machine.h"
#include "support/meshes.h"
#include "support/payload_pair.h"
#include "support/suite.h"

extern const char clip_probe_source_cl[];
extern const char clip_probe_source_gl[];
extern const char clip_lanes_source_cl[];

enum { RECORDS = 20000 };

/* Remainders of odd corners, of half of the records. */
static void add_remainders(uint64_t *state, clip_probe_input *out)
{
    const int32_t most = 1 << (SVO_SUB_LOG2 - out->voxel_log2);
    const bool any = random_below(state, 2) == 0;
    for (int i = 0; i < 9; ++i) {
        const bool has = any && (out->corners[i] & 1) != 0;
        out->remainders[i] = has ? (int32_t)random_below(state, 2 * (uint32_t)most + 1) - most : 0;
    }
}

/* Voxels of 2^8, 2^11 and 2^19 units with triangles around them: smaller than a voxel, a few voxels and very many
   voxels large, slivers, in a voxel's face, with corners on voxel corners, and at the limits of the coordinates. */
static void make_record(uint64_t *state, clip_probe_input *out)
{
    static const int32_t voxel_logs[] = {8, 11, 19};
    const int32_t voxel_log2 = voxel_logs[random_below(state, 3)];
    const int32_t w = 1 << voxel_log2;
    const uint32_t kind = random_below(state, 7);
    *out = (clip_probe_input){.voxel_log2 = voxel_log2,
                              .stretch = (1u << 30) + random_below(state, 785000000),
                              .weight_log2 = 13 + random_below(state, 40)};
    const int32_t reach = kind == 0 ? w / 2 : kind <= 4 ? 3 * w : kind == 5 ? 1 << 20 : (1 << 30) - 1 - w;
    for (int i = 0; i < 9; ++i) {
        const int32_t at = (int32_t)random_below(state, 2 * (uint32_t)reach) - reach;
        out->corners[i] = kind == 4 ? at / w * w : at + (kind < 4 ? w / 2 : 0);
    }
    if (kind == 2) { /* thin, through the voxel */
        for (int k = 0; k < 3; ++k) {
            out->corners[6 + k] = out->corners[k] + (int32_t)random_below(state, 3);
        }
    }
    if (kind == 3) {
        out->corners[2] = out->corners[5] = out->corners[8] = random_below(state, 2) == 0 ? 0 : w;
    }
    add_remainders(state, out);
}

static clip_probe_input *make_records(void)
{
    uint64_t state = 20260101;
    clip_probe_input *records = calloc(RECORDS, sizeof *records);
    assert_non_null(records);
    for (uint32_t i = 0; i < RECORDS; ++i) {
        make_record(&state, &records[i]);
    }
    return records;
}

static void compare(const clip_probe_input *given, const clip_probe_output *found, const char *name)
{
    uint32_t with_area = 0;
    for (uint32_t i = 0; i < RECORDS; ++i) {
        const clip_probe_output expected = clip_probe(given[i]);
        with_area += expected.area[0] != 0 || expected.area[1] != 0 ? 1 : 0;
        if (memcmp(&found[i], &expected, sizeof expected) != 0) {
            fail_msg("record %u: weight %u, centroid %u %u in %s, %u, %u %u in C", i, found[i].weight, found[i].u,
                     found[i].v, name, expected.weight, expected.u, expected.v);
        }
    }
    assert_in_range(with_area, RECORDS / 4, RECORDS - RECORDS / 8);
}

/* Runs a kernel on the records. */
static void compare_kernel(svo_device *device, const char *source, const char *options, const char *kernel,
                           const clip_probe_input *given)
{
    clip_probe_output *found = calloc(RECORDS, sizeof *found);
    assert_non_null(found);
    const machine_job job = {given, RECORDS * sizeof *given, found, RECORDS * sizeof *found, RECORDS};
    machine_run_kernel(device, source, options, kernel, &job);
    compare(given, found, kernel);
    free(found);
}

static void opencl_agrees_with_c(void **state)
{
    (void)state;
    svo_device *device = machine_device_or_skip();
    clip_probe_input *given = make_records();
    compare_kernel(device, clip_probe_source_cl, "-cl-std=CL1.2", "clip_probe_all", given);
    free(given);
    svo_device_destroy(&device);
}

/* A part and a whole of up to 62 bits. Many quotients in 2^-31 are next to an integer: those that a wrong last step
   rounds to the other side. */
static void make_share(uint64_t *state, uint64_t share[2])
{
    const uint32_t bits = 1 + random_below(state, 62);
    const uint64_t random = (uint64_t)random_below(state, UINT32_MAX) << 32 | random_below(state, UINT32_MAX);
    const uint64_t top = UINT64_C(1) << (bits - 1);
    const uint64_t wholes[] = {top, top + 1, 2 * top - 1, top | (random & (top - 1)), top | (random & 255 & (top - 1))};
    const uint64_t whole = wholes[random_below(state, 5)];
    const uint64_t quotient = random_below(state, UINT32_C(1) << 31);
    const uint64_t high = whole >> 31;
    /* The least part with that quotient: (quotient whole + 2^31 - 1) / 2^31. */
    const uint64_t least = quotient * high + ((quotient * (whole - (high << 31)) + 0x7fffffff) >> 31);
    const uint64_t near = least + random_below(state, 3) - 1;
    const uint64_t parts[] = {near, near, near, random % whole, random % 1024 % whole, whole, whole - 1, 0};
    const uint64_t part = parts[random_below(state, 8)];
    share[0] = part > whole ? whole : part;
    share[1] = whole;
}

/* The quotients of OpenCL C come from floats, and those of C from a division. */
static void shares_are_exact_quotients(void **state)
{
    enum { SHARES = 1 << 21 };
    (void)state;
    svo_device *device = machine_device_or_skip();
    uint64_t seed = 20260103;
    uint64_t(*given)[2] = calloc(SHARES, sizeof *given);
    uint32_t *found = calloc(SHARES, sizeof *found);
    assert_true(given != NULL && found != NULL);
    for (uint32_t i = 0; i < SHARES; ++i) {
        make_share(&seed, given[i]);
    }
    const machine_job job = {given, SHARES * sizeof *given, found, SHARES * sizeof *found, SHARES};
    machine_run_kernel(device, clip_probe_source_cl, "-cl-std=CL1.2", "clip_share_all", &job);
    for (uint32_t i = 0; i < SHARES; ++i) {
        const int64_t expected = svo_share_of(given[i][0], given[i][1]);
        if (found[i] != expected) {
            fail_msg("%" PRIu64 " of %" PRIu64 ": %u, not %" PRId64 " in 2^-31", given[i][0], given[i][1], found[i],
                     expected);
        }
    }
    free(given);
    free(found);
    svo_device_destroy(&device);
}

static void glsl_agrees_with_c(void **state)
{
    (void)state;
    svo_gl_context *context = machine_any_context_or_skip();
    if (!svo_i_gl_has_extension(svo_i_gl_context_functions(context), "GL_ARB_gpu_shader_int64")) {
        svo_gl_context_destroy(&context);
        print_message("skipped: no 64-bit integers in GLSL\n");
        skip();
    }
    clip_probe_input *given = make_records();
    clip_probe_output *found = calloc(RECORDS, sizeof *found);
    assert_non_null(found);
    const machine_job job = {given, RECORDS * sizeof *given, found, RECORDS * sizeof *found, RECORDS};
    machine_run_shader(context, "#extension GL_ARB_gpu_shader_int64 : require\n#define SVO_INT64\n",
                       clip_probe_source_gl, &job);
    compare(given, found, "GLSL");
    free(found);
    free(given);
    svo_gl_context_destroy(&context);
}

/* Eight records of one voxel size. Beside those of make_record: planes with slopes of at most 1, larger than the voxel,
   whose triangles fill it or nearly so. */
static void make_lane_records(uint64_t *state, clip_probe_input *out)
{
    make_record(state, &out[0]);
    for (uint32_t lane = 1; lane < 8; ++lane) {
        do {
            make_record(state, &out[lane]);
        } while (out[lane].voxel_log2 != out[0].voxel_log2);
    }
    const int32_t w = 1 << out[0].voxel_log2;
    for (uint32_t lane = 0; lane < 8; lane += 1 + random_below(state, 3)) {
        int32_t *corners = out[lane].corners;
        const int32_t reach = 1 + (int32_t)random_below(state, 8 * (uint32_t)w);
        const int32_t rise = (int32_t)random_below(state, 3) * w / 4;
        for (uint32_t corner = 0; corner < 3; ++corner, corners += 3) {
            corners[0] = corner == 1 ? w + reach : -(int32_t)random_below(state, (uint32_t)reach) - 1;
            corners[1] = corner == 2 ? w + reach : -(int32_t)random_below(state, (uint32_t)reach) - 1;
            corners[2] = (int32_t)random_below(state, (uint32_t)(w + 1)) +
                         (rise > 0 ? (int32_t)random_below(state, (uint32_t)rise) - rise / 2 : 0);
            corners[2] = random_below(state, 4) == 0 ? (corners[2] > w / 2 ? w : 0) : corners[2];
        }
        add_remainders(state, &out[lane]);
    }
}

static void eight_lanes_agree_with_c(void **state)
{
    enum { ROUNDS = 128 };
    (void)state;
    svo_device *device = machine_device_or_skip();
    if (!device->has_fp64) {
        svo_device_destroy(&device);
        print_message("skipped: no fp64 in OpenCL\n");
        skip();
    }
    uint64_t seed = 20260102;
    clip_probe_input *given = calloc(RECORDS, sizeof *given);
    assert_non_null(given);
    for (int round = 0; round < ROUNDS; ++round) {
        for (uint32_t i = 0; i < RECORDS; i += 8) {
            make_lane_records(&seed, &given[i]);
        }
        compare_kernel(device, clip_lanes_source_cl, "-cl-std=CL1.2 -DSVO_PAIR_LANES", "clip_lanes_all", given);
    }
    free(given);
    svo_device_destroy(&device);
}

/* The error of a position along an edge, in voxels: 2^-31 of the edge's length, plus a sub-unit. */
static double corner_error(const clip_probe_input *given)
{
    double longest = 0.0;
    for (int i = 0; i < 9; ++i) {
        longest = fmax(longest, fabs((double)given->corners[i] - given->corners[(i + 3) % 9]));
    }
    return ldexp(longest, -given->voxel_log2 - 30) + ldexp(2.0, -SVO_SUB_LOG2);
}

/* Converts a record to a pair: u, v, t become x, y, z. */
static void open_record(const clip_probe_input *given, payload_pair *out)
{
    *out = (payload_pair){.indices = {0}};
    for (int i = 0; i < 9; ++i) {
        const int64_t sub_units = INT64_C(1) << (SVO_SUB_LOG2 - given->voxel_log2);
        out->corners[i / 3][i % 3] = given->corners[i] * sub_units + given->remainders[i];
    }
}

static void double_normal(const payload_pair *pair, double normal[3])
{
    int64_t exact_normal[3];
    payload_pair_normal(pair->corners, exact_normal);
    for (unsigned axis = 0; axis < 3; ++axis) {
        normal[axis] = (double)exact_normal[axis];
    }
}

/* An error e of a clipped corner moves the border by at most e, along at most the border's length, eight edges of a
   face. */
static void area_and_centroid_match_the_clipped_triangle(void **state)
{
    (void)state;
    clip_probe_input *given = make_records();
    double worst_area = 0.0;
    for (uint32_t i = 0; i < RECORDS; ++i) {
        payload_pair pair;
        double centroid[3] = {0.0, 0.0, 0.0};
        open_record(&given[i], &pair);
        const clip_probe_output found = clip_probe(given[i]);
        double n[3];
        double_normal(&pair, n);
        const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        const double seen = length > 0.0 ? payload_double_part(&pair, centroid) * fabs(n[2]) / length : 0.0;
        const double area = ldexp((double)found.area[1] * 2147483648.0 + found.area[0], -2 * SVO_SUB_LOG2 - 1);
        const double allowed = 8.0 * corner_error(&given[i]);
        if (fabs(area - seen) > allowed) {
            fail_msg("record %u: area %.9g, not %.9g faces of the voxel, %.3g allowed", i, area, seen, allowed);
        }
        worst_area = fmax(worst_area, given[i].voxel_log2 == 11 ? fabs(area - seen) : 0.0);
        /* Checked for parts with enough area only: the centroid of a tiny part may lie anywhere in it. */
        const double w = (double)PAYLOAD_WIDTH;
        const double moved = seen > 0.0 ? 4.0 * allowed / seen : 1.0;
        if (moved < 0.01 && (fabs(ldexp(found.u, -SVO_SUB_LOG2) - centroid[0] / w) > moved ||
                             fabs(ldexp(found.v, -SVO_SUB_LOG2) - centroid[1] / w) > moved)) {
            fail_msg("record %u: centroid %.9g %.9g, not %.9g %.9g, %.3g allowed", i, ldexp(found.u, -SVO_SUB_LOG2),
                     ldexp(found.v, -SVO_SUB_LOG2), centroid[0] / w, centroid[1] / w, moved);
        }
    }
    print_message("voxels of 2048 units: areas within %.3g of a face\n", worst_area);
    free(given);
}

/* The weight is the stretched area of the projection along t, in its unit, within half a unit; and never zero. */
static void weights_are_stretched_areas(void **state)
{
    (void)state;
    clip_probe_input *given = make_records();
    for (uint32_t i = 0; i < RECORDS; ++i) {
        const clip_probe_output found = clip_probe(given[i]);
        const double seen = ldexp((double)found.area[1] * 2147483648.0 + found.area[0], -2 * SVO_SUB_LOG2 - 1);
        const double weight = ldexp(seen * given[i].stretch, (int)given[i].weight_log2 - 30);
        const double step = fmax(0.5, ldexp(1.0, (int)given[i].weight_log2 - 54)); /* areas have 54 bits */
        if (weight < 4294967295.0 && fabs(fmax(weight, 1.0) - found.weight) > step + ldexp(weight, -48)) {
            fail_msg("record %u: weight %u, not %.3f", i, found.weight, weight);
        }
    }
    free(given);
}

/* Compares a mesh's area inside the grid with the sum of its pieces, in faces of the grid. */
static void sum_pieces(const svo_mesh *mesh, unsigned depth, const svo_plan_options *options, double *whole,
                       double *pieces)
{
    exact snapped;
    exact_create(mesh, depth, options, &snapped);
    *whole = *pieces = 0.0;
    for (size_t t = 0; t < snapped.triangle_count; ++t) {
        double triangle[3][3];
        double centroid[3];
        for (unsigned k = 0; k < 9; ++k) {
            triangle[k / 3][k % 3] = (double)snapped.fine[(size_t)snapped.indices[t * 3 + k / 3] * 3 + k % 3];
        }
        *whole += oracle_part(triangle, ldexp(1.0, SVO_SUB_LOG2 + (int)depth), centroid);
    }
    for (size_t i = 0; i < snapped.pairs.count; ++i) {
        payload_pair pair;
        int64_t corners[SVO_PART_WORDS];
        payload_pair_open(&snapped, &snapped.pairs.pairs[i], &pair);
        const unsigned axis = payload_pair_axis(pair.corners);
        for (unsigned k = 0; k < 9; ++k) {
            corners[k] = pair.corners[k / 3][(axis + 1 + k % 3) % 3];
        }
        double n[3];
        double_normal(&pair, n);
        const double stretch = n[axis] != 0.0 ? sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / fabs(n[axis]) : 0.0;
        *pieces += ldexp((double)svo_clip(corners).doubled_area * stretch, -2 * (SVO_SUB_LOG2 + (int)depth) - 1);
    }
    exact_destroy(&snapped);
}

static void assert_pieces_add_up(const char *name, const svo_mesh *mesh, unsigned depth,
                                 const svo_plan_options *options)
{
    double whole;
    double pieces;
    sum_pieces(mesh, depth, options, &whole, &pieces);
    print_message("%s at depth %u: %.12g faces of the grid, pieces off by %.2g of that\n", name, depth, whole,
                  whole > 0.0 ? fabs(pieces - whole) / whole : pieces);
    assert_true(fabs(pieces - whole) <= 1e-5 * whole);
}

static void t2_areas_of_the_clipped_pieces_sum_to_the_mesh(void **state)
{
    static const char *const specs[] = {"cube", "knot:2000", "needles:500", "statue:3000", "cornell", "dust:3000"};
    static const unsigned depths[] = {1, 3, 6, 8};
    (void)state;
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; ++i) {
        scene *made = fixture_scene(specs[i]);
        for (size_t k = 0; k < sizeof depths / sizeof depths[0]; ++k) {
            assert_pieces_add_up(specs[i], scene_mesh(made), depths[k], NULL);
        }
        scene_destroy(&made);
    }
    /* Only the part inside the grid counts; one triangle, a few that reach out of it, and many. */
    for (uint64_t seed = 1; seed <= 12; ++seed) {
        owned_mesh made;
        random_mesh(seed, seed <= 4 ? 1 : seed <= 8 ? 20 : 200, seed <= 4 ? 0.0 : seed % 2 == 0 ? 2.0 : 0.3, &made);
        assert_pieces_add_up("random triangles", &made.mesh, 1 + (unsigned)seed % 6, &(svo_plan_options){.edge = 1.0});
        owned_mesh_free(&made);
    }
}

TEST_GROUP(clip)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(opencl_agrees_with_c),
        cmocka_unit_test(glsl_agrees_with_c),
        cmocka_unit_test(eight_lanes_agree_with_c),
        cmocka_unit_test(area_and_centroid_match_the_clipped_triangle),
        cmocka_unit_test(weights_are_stretched_areas),
        cmocka_unit_test(shares_are_exact_quotients),
        cmocka_unit_test(t2_areas_of_the_clipped_pieces_sum_to_the_mesh),
    };
    return cmocka_run_group_tests_name("clip", tests, NULL, NULL);
}
