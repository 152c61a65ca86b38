/* SPDX-License-Identifier: MIT */
/*
 * svocl bench e1 to e5, e7 and e8 on small inputs: svocl's methods have no error beyond one rounding, common methods
 * have their known errors, and every table has its methods. Times are not tested, so that one round is enough.
 */
#include <stdio.h>
#include <string.h>

#include "program/run_program.h"
#include "support/suite.h"

/* The table of one experiment; the document is released by cJSON_Delete. */
static cJSON *measure(const char *subject, const char *id, const cJSON **table)
{
    char line[128];
    snprintf(line, sizeof line, "$SVOCL bench %s --quick --repeat 1 --json", subject);
    cJSON *document = run_json(line);
    *table = table_of(document, id);
    return document;
}

static double cell_of(const cJSON *table, const cJSON *row, const char *name)
{
    const cJSON *cell = cJSON_GetArrayItem(row, column_of(table, name));
    if (!cJSON_IsNumber(cell)) {
        fail_msg("%s: %s is not a number", text_of(table, "id"), name);
    }
    return cell->valuedouble;
}

static const char *word_of(const cJSON *table, const cJSON *row, const char *name)
{
    const cJSON *cell = cJSON_GetArrayItem(row, column_of(table, name));
    if (!cJSON_IsString(cell)) {
        fail_msg("%s: %s is not a text", text_of(table, "id"), name);
    }
    return cell->valuestring;
}

static bool begins(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

/* Rows whose method begins with the text exist, and each value is within the bounds. Returns the largest. */
static double expect_within(const cJSON *table, const char *method, const char *name, double low, double high)
{
    double largest = -1.0;
    size_t count = 0;
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        if (begins(word_of(table, row, "method"), method)) {
            const double value = cell_of(table, row, name);
            if (!(value >= low && value <= high)) {
                fail_msg("%s: %s of %s is %g", text_of(table, "id"), name, word_of(table, row, "method"), value);
            }
            largest = value > largest ? value : largest;
            ++count;
        }
    }
    if (count == 0) {
        fail_msg("%s has no row of %s", text_of(table, "id"), method);
    }
    return largest;
}

/* What svocl did until 0.1. */
#define NEAREST "integers of 20 bits (as until 0.1)"

/* All methods but that have times. */
static void expect_times(const cJSON *table)
{
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        const bool is_timed = !begins(word_of(table, row, "method"), NEAREST);
        assert_true(!is_timed || cell_of(table, row, "time") > 0.0);
    }
}

/* svocl errs nowhere. With vertices rounded to the nearest step, it was a voxel in some thousands. */
static void voxels_are_compared_with_the_mesh_as_given(void **state)
{
    (void)state;
    need_builds();
    const cJSON *table = NULL;
    cJSON *document = measure("e1", "e1-voxelization", &table);
    expect_times(table);
    expect_within(table, "exact integers, cl", "error", 0.0, 0.0);
    if (gl_works()) {
        expect_within(table, "exact integers, gl", "error", 0.0, 0.0);
    }
    assert_true(expect_within(table, NEAREST, "error", 0.0, 0.05) > 0.0);
    assert_true(expect_within(table, "plain rasterization", "false negatives", 1.0, 100.0) > 30.0);
    expect_within(table, "4x multisampling", "false negatives", 1.0, 100.0);
    expect_within(table, "expansion alone", "false positives", 0.1, 1000.0);
    assert_true(expect_within(table, "float32 test, box-centered", "missed", 0.0, 1e9) > 0.0);
    assert_true(expect_within(table, "float32 test, world coordinates", "error", 0.0, 100.0) > 0.0);
    cJSON_Delete(document);
}

static void adversarial_rays_are_right(void **state)
{
    (void)state;
    need_builds();
    const cJSON *table = NULL;
    cJSON *document = measure("e2", "e2-rays", &table);
    expect_times(table);
    expect_within(table, "svocl", "missed", 0.0, 0.0);
    expect_within(table, "svocl", "wrong", 0.0, 0.0);
    expect_within(table, "svocl", "error of t, largest", 0.0, 0x1p-24);
    assert_true(expect_within(table, "Möller-Trumbore", "error", 0.0, 100.0) > 1.0);
    expect_within(table, "watertight", "missed", 0.0, 10.0);
    expect_within(table, "voxels alone, fine", "missed", 0.0, 0.0);
    table = table_of(document, "e2-input");
    expect_within(table, "svocl", "missed", 0.0, 0.0);
    expect_within(table, "svocl", "wrong", 0.0, 0.0);
    expect_within(table, "svocl", "beyond", 0.0, 0.0);
    expect_within(table, "svocl", "rounded", 90.0, 100.0);
    expect_within(table, "svocl", "error of t", 0.0, 1.0);
    cJSON_Delete(document);
}

static void means_by_area_are_within_rounding(void **state)
{
    (void)state;
    need_builds();
    const cJSON *table = NULL;
    cJSON *document = measure("e3", "e3-attributes", &table);
    expect_times(table);
    expect_within(table, "integers", "order, largest", 0.0, 0.0);
    assert_true(expect_within(table, "RGBA8 running average", "error, largest", 1.0, 255.0) > 50.0);
    assert_true(expect_within(table, "RGBA8 running average", "order, largest", 0.0, 255.0) > 1.0);
    assert_true(expect_within(table, "float atomics", "order, largest", 0.0, 0.1) > 0.0);
    expect_within(table, "integers, by area", "error, largest", 0.0, 1.0);
    cJSON_Delete(document);
}

/* A voxel's center is at most half a diagonal from a surface inside the voxel. */
static void levels_of_detail_keep_their_bounds(void **state)
{
    (void)state;
    need_builds();
    const cJSON *table = NULL;
    cJSON *document = measure("e4", "e4-detail", &table);
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        assert_true(cell_of(table, row, "distance of centers, largest") <= 0.86603);
        assert_true(cell_of(table, row, "area by fill, error") < 0.01);
        assert_true(cell_of(table, row, "area by faces, error") > 10.0);
        if (cell_of(table, row, "depth") >= 8.0) {
            assert_true(cell_of(table, row, "volume, error") < 1.0);
        }
    }
    assert_true(cJSON_GetArraySize(array_of(table, "rows")) >= 10);
    cJSON_Delete(document);
}

static void other_methods_fail_on_ill_conditioned_meshes(void **state)
{
    (void)state;
    need_builds();
    const cJSON *table = NULL;
    cJSON *document = measure("e5", "e5-conditioning", &table);
    expect_times(table);
    expect_within(table, "exact integers", "error", 0.0, 0.0);
    assert_true(expect_within(table, NEAREST, "error", 0.0, 0.1) > 0.0);
    expect_within(table, "svocl", "error", 0.0, 0.0);
    assert_true(expect_within(table, "float32 test, world coordinates", "error", 0.0, 1e9) > 50.0);
    assert_true(expect_within(table, "watertight", "error", 0.0, 100.0) > 20.0);
    cJSON_Delete(document);
}

/* More rays err less, to the standard error of the truth; Embree traces the same rays. */
static void expect_rays(const cJSON *table, const char *method)
{
    double before = 1.0;
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        if (begins(word_of(table, row, "method"), method)) {
            const double rays = cell_of(table, row, "cones or rays");
            const double error = cell_of(table, row, "AO, RMSE");
            assert_true(rays == 1.0 || error < before);
            assert_true(rays < 256.0 || error < 0.015);
            before = error;
        }
    }
    expect_within(table, method, "AO, bias", -0.05, 0.05);
}

/* Sets of few exact cones err by a few hundredths, those of 64 hardly. */
static void expect_directions(const cJSON *table)
{
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        const double cones = cell_of(table, row, "cones");
        const double error = cell_of(table, row, "AO, RMSE");
        assert_true(error < (cones < 16 ? 0.06 : cones < 64 ? 0.03 : 0.015));
        assert_true(cones > 6 || error > 0.015);
    }
    assert_int_equal(cJSON_GetArraySize(array_of(table, "rows")), 15);
}

/* Each kind of light has its methods: more paths err less, down to the truth's own error, and without a bias. */
static void expect_kinds(const cJSON *light, const cJSON *equal)
{
    double few = 0;
    size_t kinds = 0;
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(light, "rows"))
    {
        const double number = cell_of(light, row, "cones or paths");
        const double error = cell_of(light, row, "RMSE");
        assert_true(cell_of(light, row, "time") > 0 && error > 0 && cell_of(light, row, "truth's error") > 0);
        if (begins(word_of(light, row, "method"), "rays")) {
            few = number <= 16 ? error : few;
            assert_true(number <= 16 || error < few);
            const double bias = cell_of(light, row, "bias");
            const double bound = 0.3 * error > 0.1 ? 0.3 * error : 0.1; /* of 128 points, three to a standard error */
            assert_true(bias < bound && -bias < bound);
            kinds += number <= 16;
        }
    }
    assert_true(kinds >= (size_t)3 * 4); /* emitters are not in each scene */
    assert_int_equal(cJSON_GetArraySize(array_of(light, "rows")), 9 * kinds);
    assert_int_equal(cJSON_GetArraySize(array_of(equal, "rows")), kinds);
}

static void cones_are_compared_with_paths(void **state)
{
    (void)state;
    need_builds();
    const cJSON *table = NULL;
    cJSON *document = measure("e7", "e7-cones", &table);
    expect_within(table, "cones", "time", 1e-6, 1e9);
    expect_within(table, "exact rays", "time", 1e-6, 1e9);
    expect_within(table, "paths", "time with light", 1e-6, 1e9);
    expect_within(table, "paths", "light, RMSE", 0.001, 1.0);
    expect_within(table, "cones", "AO, RMSE", 0.01, 0.5);
    expect_within(table, "cones", "AO, largest", 0.05, 1.0);
    expect_within(table, "cones", "light, RMSE", 0.01, 10.0);
    expect_within(table, "cones, closed coverage", "AO, RMSE", 0.01, 0.5);
    expect_within(table, "cones, thin coverage", "light, RMSE", 0.01, 10.0);
    expect_within(table, "published march", "light, RMSE", 0.01, 10.0);
    expect_rays(table, "exact rays, svocl");
    expect_directions(table_of(document, "e7-directions"));
    assert_int_equal(cJSON_GetArraySize(array_of(table_of(document, "e7-alternatives"), "rows")), 15);
    expect_kinds(table_of(document, "e7-light"), table_of(document, "e7-equal"));
    const cJSON *peer = table_of(document, "e7-embree");
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(peer, "rows"))
    {
        assert_true(cell_of(peer, row, "differ") < 0.1 && cell_of(peer, row, "ratio") > 0);
    }
    cJSON_Delete(document);
}

/* What is known and what is not are all rays; only what is known can be wrong. */
static void expect_shares(const cJSON *table)
{
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        const double known = cell_of(table, row, "hit") + cell_of(table, row, "miss");
        const double wrong = cell_of(table, row, "wrong hits") + cell_of(table, row, "wrong misses");
        assert_float_equal((float)(known + cell_of(table, row, "unknown")), 100, 1e-3);
        assert_float_equal((float)wrong, (float)cell_of(table, row, "wrong"), 1e-6);
        assert_true(wrong <= known + 1e-9);
        assert_true(cell_of(table, row, "time") > 0 && cell_of(table, row, "exact") > 0);
    }
}

static void probes_are_compared_with_exact_rays(void **state)
{
    (void)state;
    need_builds();
    const cJSON *table = NULL;
    cJSON *document = measure("e8", "e8-probes", &table);
    expect_shares(table);
    expect_within(table, "exact rays", "wrong", 0.0, 0.0);
    expect_within(table, "field", "hit", 10.0, 100.0);
    expect_within(table, "eight", "hit", 10.0, 100.0);
    expect_within(table, "field", "wrong", 0.0, 20.0);
    expect_within(table, "field", "error, median", 0.0, 2.0);
    expect_within(table, "other field", "hit", 10.0, 100.0);
    assert_int_equal(cJSON_GetArraySize(array_of(table_of(document, "e8-choices"), "rows")), 6);
    const cJSON *light = table_of(document, "e8-light");
    expect_within(light, "rays through", "RMSE", 0.01, 10.0);
    expect_within(light, "2³ prefiltered", "RMSE", 0.01, 10.0);
    expect_within(light, "cones", "RMSE", 0.01, 10.0);
    expect_within(light, "paths", "RMSE", 0.001, 2.0); /* of as few as 16 */
    cJSON_Delete(document);
}

TEST_GROUP(errors)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(voxels_are_compared_with_the_mesh_as_given),
        IN_FOLDER(adversarial_rays_are_right),
        IN_FOLDER(means_by_area_are_within_rounding),
        IN_FOLDER(levels_of_detail_keep_their_bounds),
        IN_FOLDER(other_methods_fail_on_ill_conditioned_meshes),
        IN_FOLDER(cones_are_compared_with_paths),
        IN_FOLDER(probes_are_compared_with_exact_rays),
    };
    return cmocka_run_group_tests_name("errors", tests, NULL, NULL);
}
