/* SPDX-License-Identifier: MIT */
/* `svocl build --solid` and `svocl verify --solid` as a user runs them: counts, open surfaces, refusals. */
#include "run_program.h"
#include "support/suite.h"

#include <string.h>

static const cJSON *solid_of(const cJSON *document)
{
    const cJSON *solid = cJSON_GetObjectItemCaseSensitive(document, "solid");
    assert_non_null(solid);
    return solid;
}

/* The scene fills its grid: 32^3 voxels, those of the faces on the surface. */
static void build_reports_surface_and_inside_apart(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL build scene:cube -d 5 --solid winding --json");
    const cJSON *solid = solid_of(document);
    assert_string_equal(text_of(solid, "rule"), "winding");
    assert_int_equal((int)number_of(solid, "surface_voxels"), 32 * 32 * 32 - 30 * 30 * 30);
    assert_int_equal((int)number_of(solid, "inside_voxels"), 30 * 30 * 30);
    assert_int_equal((int)number_of(solid, "inside_leaves"),
                     8 + (6 * 6 * 6 - 64) + (14 * 14 * 14 - 12 * 12 * 12) + (30 * 30 * 30 - 28 * 28 * 28));
    assert_int_equal((int)number_of(solid, "ambiguous_cells"), 0);
    assert_int_equal((int)number_of(cJSON_GetObjectItemCaseSensitive(solid, "open_columns"), "z"), 0);
    assert_int_equal((int)number_of(document, "leaves"), 32 * 32 * 32 - 30 * 30 * 30);
    cJSON_Delete(document);
    document = run_json("$SVOCL build scene:cube -d 5 --need rays --json");
    assert_null(cJSON_GetObjectItemCaseSensitive(document, "solid"));
    cJSON_Delete(document);
    /* The file is that of a compact tree. */
    run_well("$SVOCL build scene:cube -d 4 --solid parity -o a.svc && head -c 4 a.svc | tail -c 3 | grep -q SVC");
    run_well("rm a.svc");
    run_well("$SVOCL build scene:cube -d 4 --solid parity");
    assert_non_null(strstr(last.output, "solid by parity"));
    assert_null(strstr(last.output, "not closed"));
}

/* Commands that take a tree expand a compact one: all voxels of the cube, from a file and through a pipe. */
static void files_of_compact_trees_are_expanded(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cube -d 4 --solid winding -o a.svc --quiet");
    cJSON *document = run_json("$SVOCL info a.svc --json");
    assert_int_equal((int)number_of(document, "leaves"), 16 * 16 * 16);
    cJSON_Delete(document);
    run_well("test $($SVOCL hash a.svc) = $(cat a.svc | $SVOCL hash -)");
    run_well("$SVOCL convert a.svc a.binvox --quiet");
    run_well("$SVOCL render a.svc -o a.png --size 16x16 --quiet");
    run_well("head -c 300 a.svc > b.svc");
    run_badly("$SVOCL info b.svc", 1, "b.svc: ");
    run_well("rm a.svc b.svc a.binvox a.png");
}

static void verify_compares_every_voxel(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL verify scene:knot:2000 -d 6 --solid winding --json");
    assert_int_equal((int)number_of(solid_of(document), "wrong_voxels"), 0);
    assert_int_equal((int)number_of(solid_of(document), "split_voxels"), 0);
    assert_true(number_of(solid_of(document), "inside_voxels") > 1000);
    assert_true(cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(solid_of(document), "exact")));
    cJSON_Delete(document);
    /* A sheet has no inside, and is not silent about it. */
    run_well("$SVOCL verify scene:terrain:500 -d 4 --solid winding");
    assert_non_null(strstr(last.output, "the surface is not closed"));
}

/* A tetrahedron without a face has a boundary of three edges. */
static void generalized_numbers_are_reported(void **state)
{
    (void)state;
    run_well("printf 'v 0 0 0\\nv 4 0 0\\nv 0 4 0\\nv 0 0 4\\nf 1 3 2\\nf 1 2 4\\nf 1 4 3\\n' >open.obj");
    cJSON *document = run_json("$SVOCL build open.obj -d 5 --solid generalized --json");
    const cJSON *solid = solid_of(document);
    assert_string_equal(text_of(solid, "rule"), "generalized");
    assert_int_equal((int)number_of(solid, "boundary_edges"), 3);
    assert_true(number_of(solid, "inside_voxels") > 1000);
    cJSON_Delete(document);
    run_well("$SVOCL build open.obj -d 5 --solid generalized -o a.svc");
    assert_non_null(strstr(last.output, "generalized winding numbers beside 3 edges that do not cancel"));
    run_well("rm a.svc open.obj");
}

static void what_does_not_apply_is_refused(void **state)
{
    (void)state;
    need_builds();
    run_badly("$SVOCL build scene:cube -d 4 --solid wind", 2, "did you mean 'winding'?");
    run_badly("$SVOCL build scene:cube -d 4 --solid winding --plan-only", 2, "--solid does not apply");
    run_badly("$SVOCL build scene:cube -d 4 --solid winding --coverage thin", 1, "coverage is thin");
    run_badly("$SVOCL build scene:cube -d 4 --solid winding --origin 0,0,0 --edge 0.25", 1, "outside the tree's grid");
    run_badly("$SVOCL hash scene:cube -d 4 --solid winding", 2, "--solid");
    run_badly("$SVOCL verify none.obj -d 11 --solid winding", 2, "up to depth 10, not at depth 11");
    run_badly("$SVOCL bench voxelize --vs openvdb", 2, "--vs openvdb does not apply");
    run_badly("$SVOCL bench rays --vs openvdb", 2, "--vs openvdb does not apply");
    run_well("$SVOCL build scene:cube -d 3 --need rays -o a.svo");
    run_badly("$SVOCL verify none.obj -d 5 --solid generalized", 2, "--solid generalized is not compared");
    run_badly("$SVOCL verify a.svo --solid winding", 2, "--solid does not apply to a .svo file");
    run_well("rm a.svo");
}

TEST_GROUP(program_solid)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(build_reports_surface_and_inside_apart),
        IN_FOLDER(files_of_compact_trees_are_expanded),
        IN_FOLDER(verify_compares_every_voxel),
        IN_FOLDER(generalized_numbers_are_reported),
        IN_FOLDER(what_does_not_apply_is_refused),
    };
    return cmocka_run_group_tests_name("program_solid", tests, NULL, NULL);
}
