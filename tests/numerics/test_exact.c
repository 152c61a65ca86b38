/* SPDX-License-Identifier: MIT */
/*
 * Tests the test of kernels/shared/exact.clh beside the exact reference of meshes as given, on triangles that are hard
 * (hard_cases.h): in C, and bit for bit the same in OpenCL C and GLSL.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "agree/probe.h"
#include "hard_cases.h"
#include "support/machine.h"
#include "support/suite.h"

#define CASES       80 /* of each kind in each space */
#define RECORDS_MAX (HARD_KINDS * HARD_SPACES * CASES)
#define FAR_EDGES   512.0 /* vertices beyond are refused */
#define OPENCL      "-cl-std=CL1.2 -DPROBE_EXACT"
#define GLSL        "#define PROBE_EXACT\n"

/* Records and the answers of C. */
typedef struct records {
    hard_case cases[RECORDS_MAX];
    oracle_coverage coverages[RECORDS_MAX];
    probe_input given[RECORDS_MAX];
    probe_output expected[RECORDS_MAX];
    probe_output found[RECORDS_MAX];
    uint32_t count;
} records;

static records *all;

static void put_double(probe_input *out, int place, double value)
{
    memcpy(&out->words[2 * place], &value, sizeof value);
}

static void make_record(const hard_case *s, oracle_coverage coverage, probe_input *out)
{
    *out = (probe_input){{0}};
    for (int i = 0; i < 9; ++i) {
        put_double(out, i, s->triangle.vertices[i / 3][i % 3]);
    }
    for (int k = 0; k < 3; ++k) {
        put_double(out, 9 + k, s->space.origin[k]);
        out->words[27 + k] = s->cell[k];
    }
    put_double(out, 12, s->space.edge);
    out->words[26] = (int32_t)s->space.depth;
    out->words[30] = (int32_t)coverage;
}

static bool is_near(const hard_case *s)
{
    bool near = true;
    for (int i = 0; i < 9; ++i) {
        const double offset = s->triangle.vertices[i / 3][i % 3] - s->space.origin[i % 3];
        near = near && fabs(offset) < FAR_EDGES * s->space.edge;
    }
    return near;
}

__extension__ typedef __int128 wide;

/* The number in units of the grid. Returns false if it is not whole, or does not fit. */
static bool units_of(const hard_case *s, double value, wide *units)
{
    int grid_exponent;
    int exponent;
    (void)frexp(s->space.edge, &grid_exponent);
    const int64_t significand = (int64_t)ldexp(frexp(value, &exponent), 53);
    const int bits = exponent - 53 - (grid_exponent - 74);
    if (value == 0.0 || (bits >= 0 && bits < 72)) {
        *units = value == 0.0 ? 0 : significand * ((wide)1 << bits);
        return true;
    }
    *units = bits > -53 && bits < 0 ? significand / (INT64_C(1) << -bits) : 0;
    return bits > -53 && bits < 0 && significand % (INT64_C(1) << -bits) == 0;
}

/* Whether no offset is rounded. */
static bool is_exact(const hard_case *s)
{
    wide ignored;
    bool exact = true;
    for (int i = 0; i < 9; ++i) {
        exact = exact && units_of(s, s->triangle.vertices[i / 3][i % 3], &ignored) &&
                units_of(s, s->space.origin[i % 3], &ignored);
    }
    return exact;
}

static int make_records(void **state)
{
    (void)state;
    all = calloc(1, sizeof *all);
    assert_non_null(all);
    hard_cases_seed(31);
    for (int kind = 0; kind < HARD_KINDS; ++kind) {
        for (size_t i = 0; i < (size_t)HARD_SPACES * CASES; ++i) {
            hard_case s;
            hard_case_make((hard_kind)kind, i, &s);
            s.cell[i % 3] += s.cell[i % 3] > 0 ? hard_between(-1, 0) : 0;
            if (is_near(&s)) {
                all->cases[all->count] = s;
                all->coverages[all->count] = (oracle_coverage)(i / HARD_SPACES % 3);
                make_record(&s, all->coverages[all->count], &all->given[all->count]);
                ++all->count;
            }
        }
    }
    probe_exact(all->given, all->expected, all->count);
    return 0;
}

static int free_records(void **state)
{
    (void)state;
    free(all);
    return 0;
}

static void c_agrees_with_the_exact_reference(void **state)
{
    unsigned touched = 0;
    unsigned rounded = 0;
    (void)state;
    for (uint32_t i = 0; i < all->count; ++i) {
        const hard_case *s = &all->cases[i];
        const bool truth = oracle_exact_touches(&s->triangle, &s->space, s->cell, all->coverages[i]);
        if (truth != (all->expected[i].words[PROBE_TOUCHES] != 0)) {
            hard_case_print(s, s->cell);
            fail_msg("record %u, coverage %d: touches %d", i, (int)all->coverages[i], truth);
        }
        rounded += !is_exact(s);
        touched += truth;
    }
    print_message("%u records, %u with rounded offsets, %u touch\n", all->count, rounded, touched);
    assert_true(all->count > RECORDS_MAX / 2 && rounded > all->count / 50);
    assert_true(touched > all->count / 5 && touched < all->count / 5 * 4);
}

static void offsets_are_exact(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < all->count; ++i) {
        const hard_case *s = &all->cases[i];
        for (int k = 0; k < 3; ++k) {
            wide vertex;
            wide origin;
            if (units_of(s, s->triangle.vertices[0][k], &vertex) && units_of(s, s->space.origin[k], &origin)) {
                for (int word = 0; word < 3; ++word) {
                    assert_int_equal((uint32_t)all->expected[i].words[PROBE_OFFSETS + 3 * k + word],
                                     (uint32_t)((vertex - origin) >> (32 * word)));
                }
            }
        }
    }
}

/* However little a point lies beside planes, it lies in the voxels where it is. */
static void points_keep_their_side(void **state)
{
    static const double origins[] = {0.0, -0.8, 0x1p-1074, -1e-300, -0x1p-90, -0x1p-62};
    static const double distances[] = {0.0, 0x1p-1074, 1e-300, 0x1p-90, 0x1p-75, 0x1p-62};
    unsigned touched = 0;
    (void)state;
    for (int i = 0; i < 6 * 6 * 2 * 3 * 8; ++i) {
        const double origin = origins[i % 6];
        const double distance = (i / 36 % 2 == 0 ? 1 : -1) * distances[i / 6 % 6];
        const double at = i / 72 % 3 == 0 ? distance : i / 72 % 3 == 1 ? origin + distance : 0.25 + distance;
        hard_case s = {.space = {{origin, origin, origin}, 1.0, 6}};
        probe_input given;
        probe_output found;
        for (int j = 0; j < 9; ++j) {
            s.triangle.vertices[j / 3][j % 3] = at;
        }
        for (int k = 0; k < 3; ++k) {
            const int32_t cell = (int32_t)floor((at - origin) * 64);
            s.cell[k] = cell - (i / 216 >> k & 1) < 0 ? 0 : cell - (i / 216 >> k & 1);
        }
        for (int coverage = 0; coverage < 3; ++coverage) {
            const bool truth = oracle_exact_touches(&s.triangle, &s.space, s.cell, (oracle_coverage)coverage);
            make_record(&s, (oracle_coverage)coverage, &given);
            probe_exact(&given, &found, 1);
            if (truth != (found.words[PROBE_TOUCHES] != 0)) {
                hard_case_print(&s, s.cell);
                fail_msg("coverage %d: touches %d", coverage, truth);
            }
            touched += truth;
        }
    }
    assert_true(touched > 500);
}

static void compare(const char *language)
{
    for (uint32_t i = 0; i < all->count; ++i) {
        for (int word = 0; word < PROBE_EXACT_WORDS; ++word) {
            if (all->found[i].words[word] != all->expected[i].words[word]) {
                hard_case_print(&all->cases[i], all->cases[i].cell);
                fail_msg("record %u: word %d is %x in C, %x in %s", i, word, (unsigned)all->expected[i].words[word],
                         (unsigned)all->found[i].words[word], language);
            }
        }
    }
}

static machine_job make_job(void)
{
    return (machine_job){.input = all->given,
                         .input_bytes = all->count * sizeof *all->given,
                         .output = all->found,
                         .output_bytes = all->count * sizeof *all->found,
                         .item_count = all->count};
}

static void opencl_agrees_with_c(void **state)
{
    (void)state;
    svo_device *device = machine_device_or_skip();
    const machine_job job = make_job();
    machine_run_kernel(device, probe_source_cl, OPENCL, "probe_all", &job);
    compare("OpenCL C");
    svo_device_destroy(&device);
}

static void glsl_agrees_with_c(void **state)
{
    (void)state;
    svo_gl_context *context = machine_any_context_or_skip();
    const machine_job job = make_job();
    machine_run_shader(context, GLSL, probe_source_gl, &job);
    compare("GLSL");
    svo_gl_context_destroy(&context);
}

TEST_GROUP(exact)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(c_agrees_with_the_exact_reference),
        cmocka_unit_test(offsets_are_exact),
        cmocka_unit_test(points_keep_their_side),
        cmocka_unit_test(opencl_agrees_with_c),
        cmocka_unit_test(glsl_agrees_with_c),
    };
    return cmocka_run_group_tests_name("exact", tests, make_records, free_records);
}
