/* SPDX-License-Identifier: MIT */
/* svocl bench: tables with their columns and positive values, and usage errors. Times are not tested. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "program/run_program.h"
#include "support/suite.h"

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

/* A mesh file as others have it: without normals, in a folder. */
#define MAKE_OWN_MESH(scene)                       \
    run_well("mkdir folder && $SVOCL scene " scene \
             " -o folder/own.obj && sed -i '/^vn/d; s:/[/0-9]*::g' folder/own.obj")

/* Runs each subject once on a tiny mesh: all tables exist, and those that need no optional library have rows. The child
   processes of some get the whole path. */
static void every_subject_adds_its_tables(void **state)
{
    (void)state;
    need_builds();
    MAKE_OWN_MESH("cornell:200");
    run_well("$SVOCL bench all --quick --repeat 1 --scenes folder/own.obj --depths 3 --ray-count 100 -o all.json");
    assert_non_null(strstr(last.output, "thesis-2016"));
    cJSON *document = run_json("cat all.json");
    static const struct {
        const char *id, *spread;
    } tables[] = {{"voxelize", "voxelize"},
                  {"builders", "list to tree"},
                  {"share", "both"},
                  {"filter", "list to tree"},
                  {"startup", "warm"},
                  {"rays", "svocl time"},
                  {"import", "svocl"},
                  {"convert", "time"},
                  {"e6-leaving-out", "build"},
                  {"scene-sizes", "build"},
                  {"thesis-2020", "structure"},
                  {"compact", "primary ratio"},
                  {"voxel-rays", "ratio to brickmap"},
                  {"scene", "refit"},
                  {"parts", "build"},
                  {"moving", "ratio"},
                  {"moving-rays", "ratio"}};
    for (size_t i = 0; i < sizeof tables / sizeof tables[0]; ++i) {
        const cJSON *table = table_of(document, tables[i].id);
        assert_true(row_count_of(table) > 0);
        expect_spread(table, tables[i].spread);
    }
    expect_positive(table_of(document, "thesis-2016"), "sparse octree");
    assert_int_equal(row_count_of(table_of(document, "startup-needs")),
                     row_count_of(table_of(document, "e6-leaving-out")) - 1);
    expect_positive(table_of(document, "paged"), "picture");
    expect_positive(table_of(document, "parts-large"), "leaves");
    expect_positive(table_of(document, "parts-large"), "peak");
    expect_positive(table_of(document, "startup-needs"), "cold");
    expect_positive(table_of(document, "startup-needs"), "warm");
    expect_positive(table_of(document, "memory"), "tree per leaf");
    expect_positive(table_of(document, "paged"), "picture");
    expect_positive(table_of(document, "paged"), "complete stops");
    expect_positive(table_of(document, "compact-shared"), "per voxel");
    expect_positive(table_of(document, "compact-shared"), "mirrored records");
    expect_positive(table_of(document, "compact-shared"), "mirrored per voxel");
    expect_spread(table_of(document, "compact-shared"), "mirrored primary ratio");
    expect_positive(table_of(document, "compact-packed"), "packed");
    expect_spread(table_of(document, "compact-packed"), "read ratio");
    expect_positive(table_of(document, "e6-leaving-out"), "peak");
    assert_true(row_count_of(table_of(document, "light-stages")) > 3 * 5);
    expect_positive(table_of(document, "light-bytes"), "all");
    expect_positive(table_of(document, "light-bytes"), "lit nodes");
    assert_true(column_of(table_of(document, "light-bytes"), "missed leaves") > 0); /* may be none */
    expect_positive(table_of(document, "light-frames"), "cones");
    expect_positive(table_of(document, "light-bytes"), "RGBA8 pyramid, passes");
    expect_spread(table_of(document, "peer-embree"), "svocl");
    expect_spread(table_of(document, "peer-openvdb"), "OpenVDB");
    cJSON_Delete(document);
    run_well("rm -r folder");
    static const char *const kept[] = {"all.json"};
    expect_files(kept, 1);
}

/* The row's cell in that column, which is a number. */
static double number_in_row(const cJSON *row, const cJSON *table, const char *column)
{
    const cJSON *cell = cJSON_GetArrayItem(row, column_of(table, column));
    assert_true(cJSON_IsNumber(cell));
    return cell->valuedouble;
}

/* The text of a row's cell in that column; "" where it is absent. */
static const char *text_in_row(const cJSON *row, const cJSON *table, const char *column)
{
    const char *text = cJSON_GetStringValue(cJSON_GetArrayItem(row, column_of(table, column)));
    return text != NULL ? text : "";
}

/* What does not work here is a row with its reason, and nothing is wrong: the hashes are those of other machines. */
static void a_machine_is_measured_step_by_step(void **state)
{
    (void)state;
    need_builds();
    if (!suite_is_long()) { /* half a minute */
        skip();
    }
    run_well("$SVOCL bench gpu --quick --path gpu -q -o gpu.json");
    cJSON *document = run_json("cat gpu.json");
    const cJSON *table = table_of(document, "gpu");
    const cJSON *row = NULL;
    int ok_count = 0;
    int counted = 0;
    assert_true(strlen(text_of(cJSON_GetObjectItem(document, "machine"), "device")) > 0);
    assert_true(row_count_of(table_of(document, "gpu-pairs")) > 0 || !gl_works());
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        const char *verdict = text_in_row(row, table, "verdict");
        const char *step = text_in_row(row, table, "step");
        const bool is_ok = strcmp(verdict, "ok") == 0;
        const bool by_cl = strncmp(text_in_row(row, table, "method"), "cl", 2) == 0;
        ok_count += is_ok;
        if (!is_ok && (by_cl || strcmp(verdict, "absent") != 0 || text_in_row(row, table, "reason")[0] == '\0')) {
            fail_msg("%s, %s: %s, %s", step, text_in_row(row, table, "method"), verdict,
                     text_in_row(row, table, "reason"));
        }
        if (is_ok && by_cl && strcmp(step, "build") == 0) {
            assert_true(number_in_row(row, table, "build") > 0.0);
            assert_true(number_in_row(row, table, "wall") > 0.0);
            counted += number_in_row(row, table, "launches") > 0.0 && number_in_row(row, table, "allocations") > 0.0 &&
                       number_in_row(row, table, "reading") >= 0.0;
        }
    }
    assert_true(ok_count >= 14); /* devices, verify, stress, forms; light, probes; four builds by cl; rays, solid */
    assert_true(counted == 4 || counted == 0); /* with static libraries, or none */
    expect_positive(table_of(document, "gpu-devices"), "compute units");
    expect_positive(table_of(document, "gpu-devices"), "memory");
    const cJSON *kernels = table_of(document, "gpu-kernels");
    assert_true(row_count_of(kernels) > 40 || counted == 0);
    expect_positive(kernels, "multiple");
    cJSON_Delete(document);
    static const char *const kept[] = {"gpu.json"};
    expect_files(kept, 1);
}

/* Steps that fail do not end the run: all of them do here, and each says why. */
static void failing_steps_are_rows(void **state)
{
    (void)state;
    run_badly("$SVOCL bench gpu --quick --device 'no such device' -q -o gpu.json", 1,
              "the first: verify scene:knot:8000");
    cJSON *document = run_json("cat gpu.json");
    const cJSON *table = table_of(document, "gpu");
    const cJSON *row = NULL;
    assert_true(row_count_of(table) >= 10);
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        if (strcmp(text_in_row(row, table, "step"), "devices") != 0) {
            assert_string_equal(text_in_row(row, table, "verdict"), "failed");
            assert_non_null(strstr(text_in_row(row, table, "reason"), "OpenCL"));
        }
    }
    cJSON_Delete(document);
    run_badly("$SVOCL bench gpu --scenes cube", 2, "--scenes");
}

/* Merged spheres take fewer bytes, and the ratio stands beside them alone. */
static void minimized_spheres_are_smaller(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL bench convert --quick --repeat 2 --json");
    const cJSON *table = table_of(document, "convert");
    const int ratio = column_of(table, "ratio");
    const cJSON *row = NULL;
    double plain = 0.0;
    int minimized_count = 0;
    expect_spread(table, "time");
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        const char *step = cJSON_GetArrayItem(row, column_of(table, "step"))->valuestring;
        const bool minimized = strcmp(step, "minimized") == 0;
        assert_int_equal(cJSON_IsNumber(cJSON_GetArrayItem(row, ratio)), minimized);
        if (strcmp(step, "descriptor") == 0) {
            plain = number_in_row(row, table, "bytes");
        }
        if (minimized) {
            ++minimized_count;
            assert_true(number_in_row(row, table, "bytes") > 0.0 && number_in_row(row, table, "bytes") < plain);
            assert_true(number_in_row(row, table, "ratio") > 0.0);
        }
    }
    assert_int_equal(minimized_count, 2);
    cJSON_Delete(document);
}

/* The grid finds the triangles that svocl finds, but for ties, at depths with and without whole bricks. */
static void rays_are_compared_with_a_grid(void **state)
{
    (void)state;
    need_builds();
    static const int depths[] = {2, 7, 3};
    double wrong = 0;
    for (size_t i = 0; i < (suite_is_long() ? 3 : 2); ++i) {
        char line[128];
        snprintf(line, sizeof line,
                 "$SVOCL bench rays scene:knot:2000 -d %d --vs grid --ray-count 3000 --repeat 1 --json", depths[i]);
        cJSON *document = run_json(line);
        assert_string_equal(text_of(document, "vs"), "grid");
        assert_true(number_of(document, "ours_bytes") > 0);
        assert_true(number_of(document, "grid_cell_bytes") >= 4.0 * (depths[i] < 3 ? 1 + 64 + 1 : 1 + 512 + 1));
        assert_true(number_of(document, "grid_bytes") > number_of(document, "grid_cell_bytes") + 2000 * 12);
        const cJSON *set = NULL;
        int set_count = 0;
        cJSON_ArrayForEach(set, array_of(document, "sets"))
        {
            ++set_count;
            assert_true(number_of(set, "hits") > 0);
            assert_true(number_of(set, "ours_mrays") > 0 && number_of(set, "grid_mrays") > 0);
            assert_true(number_of(set, "ratio") > 0);
            assert_int_equal((int)number_of(set, "wrong_ids"), 0);
            assert_int_equal((int)number_of(set, "missed"), 0);
            wrong += number_of(set, "grid_wrong_ids") + number_of(set, "grid_missed");
        }
        assert_int_equal(set_count, 2);
        cJSON_Delete(document);
    }
    assert_true(wrong <= 2); /* of 18,000 rays; the test of triangles is in float */
    run_well("$SVOCL bench rays scene:knot:2000 -d 7 --vs grid --ray-count 1000 --repeat 1");
    assert_non_null(strstr(last.output, "grid wrong"));
    run_badly("$SVOCL bench rays scene:cube -d 12 --vs grid --ray-count 10", 2, "up to 11, not 12");
    run_badly("$SVOCL bench convert --vs grid", 2, "--vs grid");
    expect_files(NULL, 0);
}

/* Embree's calls are beside svocl, on both instruction sets where the processor has them; a mesh of one point and rays
   that lead away from a mesh are no failure of either. */
static void rays_are_compared_with_embree(void **state)
{
    (void)state;
    need_builds();
    run("$SVOCL bench rays scene:cube --vs embree --ray-count 100 --repeat 1 --isa avx2 --json");
    if (strstr(last.errors, "without libembree-dev") != NULL || strstr(last.errors, "lacks it") != NULL) {
        print_message("%s", last.errors);
        skip();
    }
    assert_int_equal(last.exit_code, 0);
    static const char *const sets[] = {"avx2", "sse2"};
    for (size_t i = 0; i < (suite_is_long() ? 2 : 1); ++i) {
        char line[160];
        snprintf(line, sizeof line,
                 "$SVOCL bench rays scene:knot:2000 --vs embree --isa %s --ray-count 1001 --repeat 1 --json", sets[i]);
        cJSON *document = run_json(line);
        assert_string_equal(text_of(document, "embree_native_widths"), i == 0 ? "1, 4, 8" : "1, 4");
        assert_int_equal(cJSON_GetArraySize(array_of(document, "sets")), 9);
        const cJSON *set = NULL;
        cJSON_ArrayForEach(set, array_of(document, "sets"))
        {
            const bool misses = strncmp(text_of(set, "name"), "misses", 6) == 0;
            assert_true(misses ? number_of(set, "hits") == 0 : number_of(set, "hits") > 0);
            assert_int_equal(cJSON_GetArraySize(array_of(set, "calls")), 3 + 3);
            assert_int_equal((int)number_of(set, "wrong_ids") + (int)number_of(set, "missed"), 0);
            assert_true(number_of(set, "embree_mrays") > 0 && number_of(set, "ratio") > 0);
        }
        cJSON_Delete(document);
    }
    write_text("point.obj", "v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n");
    run_well("$SVOCL bench rays point.obj --vs embree --ray-count 100 --repeat 1");
    run_badly("$SVOCL bench rays scene:cube --isa mmx", 2, "--isa 'mmx'");
    cJSON *document = run_json("$SVOCL bench rays --quick --scenes scene:cube,point.obj --depths 4 --vs embree "
                               "--ray-count 100 --repeat 1 --json");
    const cJSON *tables = array_of(document, "tables");
    assert_true(cJSON_GetArraySize(array_of(cJSON_GetArrayItem(tables, 0), "rows")) > 9);
    cJSON_Delete(document);
    run_badly("$SVOCL bench rays --scenes cube --vs grid", 2, "--vs grid");
    static const char *const kept[] = {"point.obj"};
    expect_files(kept, 1);
}

/* The process that measures another instruction set runs where this one does. */
static void children_run_on_the_same_device(void **state)
{
    (void)state;
    need_builds();
    run_well("LD_PRELOAD=$SHIM SHIM_ARGUMENTS=list.txt ASAN_OPTIONS=verify_asan_link_order=0 $SVOCL bench rays "
             "--scenes cube --depths 3 --ray-count 10 --repeat 1 --device 0.0 --path gpu --threads 1");
    run("cat list.txt");
    if (last.exit_code != 0) {
        print_message("skipped: no AVX-512, or built without libembree-dev\n");
        skip();
    }
    assert_non_null(strstr(last.output, "svocl bench rays --isa avx2 "));
    assert_non_null(strstr(last.output, " --depths 3 --threads 1 --device 0.0 --path gpu"));
    static const char *const kept[] = {"list.txt"};
    expect_files(kept, 1);
}

/* Whether a column of figures that are the same on every run must be equal in both documents. Bytes of the device
   depend on the driver. */
static bool is_pinned(const char *column, bool same_driver)
{
    static const char *const counts[] = {"triangles", "depth", "fragments", "nodes", "leaves"};
    static const char *const bytes[] = {"tree", "fragment list", "peak"};
    bool found = false;
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        found = found || strcmp(column, counts[i]) == 0;
    }
    for (size_t i = 0; i < sizeof bytes / sizeof bytes[0]; ++i) {
        found = found || (same_driver && strcmp(column, bytes[i]) == 0);
    }
    return found;
}

static size_t compare_pinned(const cJSON *stored, const cJSON *now, bool same_driver)
{
    size_t compared = 0;
    assert_int_equal(row_count_of(stored), row_count_of(now));
    const cJSON *column = NULL;
    cJSON_ArrayForEach(column, array_of(now, "columns"))
    {
        const char *name = text_of(column, "name");
        for (int row = 0; is_pinned(name, same_driver) && row < row_count_of(now); ++row, ++compared) {
            const double was = number_in_row(cJSON_GetArrayItem(array_of(stored, "rows"), row), stored, name);
            const double is = number_in_row(cJSON_GetArrayItem(array_of(now, "rows"), row), now, name);
            if (was != is) {
                fail_msg("docs/results.json, table %s, row %d: %s %.0f, now %.0f", text_of(now, "id"), row, name, was,
                         is);
            }
        }
    }
    return compared;
}

/* A file of JSON of any length; cJSON_Delete. */
static cJSON *read_document(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    const size_t bytes = (size_t)ftell(file);
    rewind(file);
    char *text = calloc(bytes + 1, 1);
    assert_non_null(text);
    assert_int_equal(fread(text, 1, bytes, file), bytes);
    cJSON *document = cJSON_Parse(text);
    assert_non_null(document);
    free(text);
    fclose(file);
    return document;
}

/* What the documents show of bytes and counts is what the program of today measures. */
static void stored_figures_are_those_of_today(void **state)
{
    (void)state;
    need_builds();
    static const struct {
        const char *subject, *table;
    } subjects[] = {{"memory", "memory"}, {"leaving-out", "e6-leaving-out"}};
    cJSON *stored = read_document(DOCS_RESULTS);
    for (size_t i = 0; i < (suite_is_long() ? sizeof subjects / sizeof subjects[0] : 1); ++i) {
        char line[128];
        snprintf(line, sizeof line, "$SVOCL bench %s --repeat 1 --json", subjects[i].subject);
        cJSON *now = run_json(line);
        const cJSON *machines[] = {cJSON_GetObjectItemCaseSensitive(stored, "machine"),
                                   cJSON_GetObjectItemCaseSensitive(now, "machine")};
        const bool same_driver = strcmp(text_of(machines[0], "driver"), text_of(machines[1], "driver")) == 0;
        assert_true(compare_pinned(table_of(stored, subjects[i].table), table_of(now, subjects[i].table), same_driver) >
                    16);
        cJSON_Delete(now);
    }
    cJSON_Delete(stored);
    expect_files(NULL, 0);
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
    static const double totals[3][4] = {
        {592, 2921, 30266, 255455}, {512, 1909, 15811, 163345}, {1481, 9372, 88597, 1182155}};
    static const double structures[3] = {255150, 162059, 1181685};
    const int depth = column_of(table, "depth");
    const int total = column_of(table, "published total");
    const int structure = column_of(table, "published structure");
    const cJSON *row = NULL;
    int index = 0;
    cJSON_ArrayForEach(row, array_of(table, "rows"))
    {
        const bool deepest = (int)cJSON_GetArrayItem(row, depth)->valuedouble == 5;
        assert_int_equal((int)number_in_row(row, table, "published depth"), 3 + index % 4);
        assert_true(cJSON_GetArrayItem(row, total)->valuedouble == totals[index / 4][index % 4]);
        assert_int_equal(cJSON_IsNumber(cJSON_GetArrayItem(row, structure)), deepest);
        assert_true(!deepest || cJSON_GetArrayItem(row, structure)->valuedouble == structures[index / 4]);
        ++index;
    }
    cJSON_Delete(document);
}

/* Rows of 1 and 3 workers are measured; those of more are the model's. */
static void workers_are_measured_beside_a_model(void **state)
{
    (void)state;
    need_builds();
    run_badly("$SVOCL bench parts --workers 0", 2, "--workers '0'");
    run_badly("$SVOCL bench parts --workers 2,", 2, "--workers '2,'");
    run_badly("$SVOCL bench parts --workers 65", 2, "--workers '65'");
    run_badly("$SVOCL bench build --workers 2", 2, "--workers");
    cJSON *document = run_json("$SVOCL bench parts --quick --repeat 1 --scenes cube --depths 6 --workers 3 --json");
    const cJSON *table = table_of(document, "parts-workers");
    const cJSON *rows = cJSON_GetObjectItemCaseSensitive(table, "rows");
    static const unsigned workers[] = {1, 3, 4, 8, 16};
    assert_int_equal(row_count_of(table), sizeof workers / sizeof workers[0]);
    for (int i = 0; i < row_count_of(table); ++i) {
        const cJSON *row = cJSON_GetArrayItem(rows, i);
        assert_int_equal((unsigned)number_in_row(row, table, "workers"), workers[i]);
        assert_int_equal((unsigned)number_in_row(row, table, "runs"), i < 2);
        assert_true(number_in_row(row, table, "parts") > 1);
        /* More workers are never slower in the model, and at most so many times as fast. */
        assert_true(number_in_row(row, table, "model speedup") >= 1 - 1e-9);
        assert_true(number_in_row(row, table, "model speedup") <= workers[i] + 1e-9);
    }
    cJSON_Delete(document);
    expect_files(NULL, 0);
}

/* Limits that are too small have no rows, and the note says why, of each by itself. */
static void limits_that_are_too_small_are_named(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL bench parts --quick --repeat 1 --scenes cube --depths 2 --workers 1 --json");
    const cJSON *table = table_of(document, "parts");
    assert_int_equal(row_count_of(table), 1);
    const char *found = text_of(table, "note");
    for (int i = 0; i < 3; ++i) {
        found = strstr(found, "is too small for the least part");
        assert_non_null(found);
        ++found;
    }
    table = table_of(document, "parts-workers");
    assert_int_equal(row_count_of(table), 0);
    assert_non_null(strstr(text_of(table, "note"), "no parts of"));
    cJSON_Delete(document);
    expect_files(NULL, 0);
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
    run_badly("$SVOCL bench rays --vs openvdb", 2, "--vs");
    run_badly("$SVOCL bench solid --vs grid", 2, "--vs grid");
    run_badly("$SVOCL build scene:cube --depths 5", 2, "--depths");
    run_badly("$SVOCL bench memory --quick -o nowhere/a.json", 1, "nowhere");
    expect_files(NULL, 0);
}

/* Experiments measure files too. */
static void errors_of_files_are_measured(void **state)
{
    (void)state;
    need_builds();
    MAKE_OWN_MESH("knot:500");
    static const struct {
        const char *subject, *table;
    } subjects[] = {{"e1", "e1-voxelization"}, {"e3", "e3-attributes"}, {"e4", "e4-detail"}};
    for (size_t i = 0; i < sizeof subjects / sizeof subjects[0]; ++i) {
        char line[256];
        snprintf(line, sizeof line, "$SVOCL bench %s --quick --repeat 1 --scenes folder/own.obj --json",
                 subjects[i].subject);
        cJSON *document = run_json(line);
        assert_true(row_count_of(table_of(document, subjects[i].table)) > 0);
        cJSON_Delete(document);
    }
    run_badly("$SVOCL bench e1 --depths 5", 2, "--depths does not apply to bench e1");
    run_well("rm -r folder");
    expect_files(NULL, 0);
}

/* Of many subjects, one that fails leaves its reason, and the others go on. */
static void subjects_that_fail_leave_a_reason(void **state)
{
    (void)state;
    need_builds();
    write_text("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"); /* no points can be spread over it */
    run("$SVOCL bench errors --quick --repeat 1 --scenes line.obj -o some.json");
    assert_int_equal(last.exit_code, 1);
    assert_non_null(strstr(last.errors, "2 subjects failed; the tables have the reasons"));
    cJSON *document = run_json("cat some.json");
    assert_non_null(strstr(text_of(table_of(document, "e7-cones"), "note"), "Not measured to the end: "));
    assert_non_null(strstr(text_of(table_of(document, "e8-probes"), "note"), "line.obj: no triangle has an area"));
    assert_true(row_count_of(table_of(document, "e1-voxelization")) > 0);
    cJSON_Delete(document);
    static const char *const kept[] = {"line.obj", "some.json"};
    expect_files(kept, 2);
}

static void unknown_scenes_are_named(void **state)
{
    (void)state;
    need_builds();
    run_badly("$SVOCL bench memory --quick --scenes castle.obj", 1, "castle.obj");
    run_badly("$SVOCL bench memory --quick --scenes cube:none", 2, "cube:none");
    run_badly("$SVOCL bench errors --quick --scenes scene:castle", 2, "castle");
    expect_files(NULL, 0);
}

/* One INPUT of a list that cannot be read fails before the others are measured. */
static void bad_inputs_fail_before_anything_is_measured(void **state)
{
    static const char *const subjects[] = {"e7", "e8", "light"};
    (void)state;
    need_builds();
    write_text("torn.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    for (size_t i = 0; i < sizeof subjects / sizeof subjects[0]; ++i) {
        char line[128];
        (void)snprintf(line, sizeof line, "$SVOCL bench %s --scenes atrium,torn.obj -o some.json", subjects[i]);
        run_badly(line, 1, "torn.obj");
        (void)snprintf(line, sizeof line, "$SVOCL bench %s --scenes atrium,knot:many -o some.json", subjects[i]);
        run_badly(line, 2, "knot:many");
    }
    static const char *const kept[] = {"torn.obj"};
    expect_files(kept, 1);
}

/* At the least depth that holds them, whatever --depths says; and by no subject that needs a mesh. */
static void voxel_files_are_measured_once(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL convert scene:knot:500 a.vox -d 4 -q");
    cJSON *document =
        run_json("$SVOCL bench compact --quick --repeat 1 --scenes a.vox --depths 3,5,6 --ray-count 100 --json");
    const cJSON *shared = table_of(document, "compact-shared");
    const cJSON *packed = table_of(document, "compact-packed");
    assert_int_equal(row_count_of(shared), 1);
    assert_true(number_in_row(cJSON_GetArrayItem(array_of(shared, "rows"), 0), shared, "depth") == 4.0);
    assert_int_equal(row_count_of(packed), 3); /* colors, in three ways; voxels have no normals */
    expect_positive(packed, "zstd -19");
    cJSON_Delete(document);
    run_badly("$SVOCL bench voxelize --scenes a.vox", 2, "a.vox holds voxels");
    run_well("rm a.vox");
    expect_files(NULL, 0);
}

TEST_GROUP(bench)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER_ANY_KERNELS(front_ends_are_measured),
        IN_FOLDER_ANY_KERNELS(a_machine_is_measured_step_by_step),
        IN_FOLDER(failing_steps_are_rows),
        IN_FOLDER_ANY_KERNELS(every_subject_adds_its_tables),
        IN_FOLDER_ANY_KERNELS(minimized_spheres_are_smaller),
        IN_FOLDER(rays_are_compared_with_a_grid),
        IN_FOLDER_ANY_KERNELS(rays_are_compared_with_embree),
        IN_FOLDER_ANY_KERNELS(children_run_on_the_same_device),
        IN_FOLDER_ANY_KERNELS(published_values_name_their_hardware),
        IN_FOLDER(usage_errors_exit_with_code_2),
        IN_FOLDER(unknown_scenes_are_named),
        IN_FOLDER(bad_inputs_fail_before_anything_is_measured),
        IN_FOLDER(voxel_files_are_measured_once),
        IN_FOLDER(stored_figures_are_those_of_today),
        IN_FOLDER(errors_of_files_are_measured),
        IN_FOLDER(subjects_that_fail_leave_a_reason),
        IN_FOLDER_ANY_KERNELS(workers_are_measured_beside_a_model),
        IN_FOLDER_ANY_KERNELS(limits_that_are_too_small_are_named),
    };
    return cmocka_run_group_tests_name("bench", tests, NULL, NULL);
}
