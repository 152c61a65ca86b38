/* SPDX-License-Identifier: MIT */
/* svocl bench: tables with their columns and positive values, and usage errors. Times are not tested. */
#include <stdio.h>
#include <string.h>

#include "run_program.h"

static int row_count_of(const cJSON *table)
{
    return cJSON_GetArraySize(array_of(table, "rows"));
}

/* Every row has a positive number in that column. */
static void expect_positive(const cJSON *table, const char *name)
{
    const int index = column_of(table, name);
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        const cJSON *cell = cJSON_GetArrayItem(row, index);
        assert_int_equal(cJSON_GetArraySize(row), cJSON_GetArraySize(array_of(table, "columns")));
        if (!cJSON_IsNumber(cell) || cell->valuedouble <= 0.0) {
            fail_msg("%s: %s is not positive", text_of(table, "id"), name);
        }
    }
}

/* A median lies between its quartiles. */
static void expect_spread(const cJSON *table, const char *name)
{
    char low[64];
    char high[64];
    snprintf(low, sizeof low, "%s q1", name);
    snprintf(high, sizeof high, "%s q3", name);
    expect_positive(table, name);
    expect_positive(table, low);
    expect_positive(table, high);
    const int column = column_of(table, name);
    const int low_column = column_of(table, low);
    const int high_column = column_of(table, high);
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        const double median = cJSON_GetArrayItem(row, column)->valuedouble;
        assert_true(cJSON_GetArrayItem(row, low_column)->valuedouble <= median);
        assert_true(cJSON_GetArrayItem(row, high_column)->valuedouble >= median);
    }
}

static void front_ends_are_measured(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL bench voxelize --quick --scenes knot:2000,scene:cube --depths 4,5 --json");
    const cJSON *machine = cJSON_GetObjectItem(document, "machine");
    assert_true(number_of(machine, "cpu_threads") >= 1);
    assert_true(strlen(text_of(machine, "device")) > 0 && strlen(text_of(machine, "driver")) > 0);
    assert_true(strlen(text_of(machine, "renderer")) > 0);
    const cJSON *table = table_of(document, "voxelize");
    assert_true(row_count_of(table) >= 4);
    column_of(table, "scene");
    column_of(table, "frontend");
    column_of(table, "share");
    column_of(table, "clock");
    expect_positive(table, "triangles");
    expect_positive(table, "depth");
    expect_positive(table, "fragments");
    expect_positive(table, "first");
    expect_positive(table, "rate");
    expect_spread(table, "voxelize");
    expect_spread(table, "transfer");
    expect_spread(table, "ratio");
    cJSON_Delete(document);
}

/* Runs each subject once on a tiny scene: all tables exist, and those that need no optional library have rows. */
static void every_subject_adds_its_tables(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL bench all --quick --repeat 1 --scenes cornell:200 --depths 3 --ray-count 100 -o all.json");
    assert_non_null(strstr(last.output, "thesis-2016"));
    cJSON *document = run_json("cat all.json");
    static const struct {
        const char *id, *spread;
    } tables[] = {{"voxelize", "voxelize"},   {"builders", "list to tree"}, {"share", "both"},
                  {"filter", "list to tree"}, {"startup", "warm"},          {"rays", "svocl time"},
                  {"import", "svocl"},        {"convert", "time"},          {"e6-leaving-out", "build"},
                  {"scene-sizes", "build"},   {"thesis-2020", "structure"}, {"compact", "primary ratio"},
                  {"scene", "refit"}};
    for (size_t i = 0; i < sizeof tables / sizeof tables[0]; ++i) {
        const cJSON *table = table_of(document, tables[i].id);
        assert_true(row_count_of(table) > 0);
        expect_spread(table, tables[i].spread);
    }
    expect_positive(table_of(document, "thesis-2016"), "sparse octree");
    expect_positive(table_of(document, "memory"), "tree per leaf");
    expect_positive(table_of(document, "compact-shared"), "per voxel");
    expect_positive(table_of(document, "e6-leaving-out"), "peak");
    expect_spread(table_of(document, "peer-embree"), "svocl");
    expect_spread(table_of(document, "peer-openvdb"), "OpenVDB");
    cJSON_Delete(document);
    static const char *const kept[] = {"all.json"};
    expect_files(kept, 1);
}

/* Tables contain the published values and name their hardware. */
static void published_values_name_their_hardware(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL bench thesis-2020 --quick --repeat 1 --json");
    const cJSON *table = table_of(document, "thesis-2020");
    assert_int_equal(row_count_of(table), 12);
    assert_non_null(strstr(text_of(table, "note"), "GTX 960"));
    const int depth = column_of(table, "depth");
    const int published = column_of(table, "published structure, most");
    const cJSON *row = NULL;
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        const bool deepest = (int)cJSON_GetArrayItem(row, depth)->valuedouble == 6;
        assert_int_equal(cJSON_IsNumber(cJSON_GetArrayItem(row, published)), deepest);
    }
    cJSON_Delete(document);
}

static void usage_errors_exit_with_code_2(void **state)
{
    (void)state;
    run_badly("$SVOCL bench", 2, "voxelize");
    run_badly("$SVOCL bench sums", 2, "'sums'");
    run_badly("$SVOCL bench voxelize scene:cube", 2, "--scenes");
    run_badly("$SVOCL bench voxelize -d 5", 2, "--depths");
    run_badly("$SVOCL bench voxelize --depths 5,17", 2, "'5,17'");
    run_badly("$SVOCL bench voxelize --depths 5,", 2, "'5,'");
    run_badly("$SVOCL bench voxelize --depths 0", 2, "'0'");
    run_badly("$SVOCL bench voxelize --scenes cube,,cube", 2, "'cube,,cube'");
    run_badly("$SVOCL bench voxelize --repeat 0", 2, "repeat 0 is below 1");
    run_badly("$SVOCL bench build --need none", 2, "--need");
    run_badly("$SVOCL bench build --builder sorted", 2, "--builder");
    run_badly("$SVOCL bench filter --weights uniform", 2, "--weights");
    run_badly("$SVOCL bench all --vs embree", 2, "--vs");
    run_badly("$SVOCL build scene:cube --depths 5", 2, "--depths");
    run_badly("$SVOCL bench memory --quick -o nowhere/a.json", 1, "nowhere");
    expect_files(NULL, 0);
}

static void unknown_scenes_are_named(void **state)
{
    (void)state;
    need_builds();
    run_badly("$SVOCL bench memory --quick --scenes castle.obj", 1, "castle.obj");
    run_badly("$SVOCL bench memory --quick --scenes cube:none", 2, "cube:none");
    expect_files(NULL, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(front_ends_are_measured),
        IN_FOLDER(every_subject_adds_its_tables),
        IN_FOLDER(published_values_name_their_hardware),
        IN_FOLDER(usage_errors_exit_with_code_2),
        IN_FOLDER(unknown_scenes_are_named),
    };
    return cmocka_run_group_tests_name("bench", tests, NULL, NULL);
}
