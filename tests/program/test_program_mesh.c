/* SPDX-License-Identifier: MIT */
/* `svocl mesh` as a user runs it: files that every command reads again, offsets, refusals. */
#include "run_program.h"
#include "support/suite.h"

#include <stdio.h>
#include <string.h>

/* The three formats have the same mesh, and a solid of it has the volume of the input's. */
static void formats_hold_the_same_mesh(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL mesh scene:knot:4000 -d 6 --colors -o a.ply --json");
    const double triangles = number_of(document, "triangles");
    assert_true(triangles > 4000);
    assert_true(number_of(document, "vertices") == triangles / 2); /* a torus: vertices - edges + triangles is 0 */
    assert_true(number_of(document, "end_triangles") == 0);
    assert_true(number_of(document, "open_columns") == 0);
    assert_int_equal((int)number_of(document, "depth"), 6);
    assert_string_equal(text_of(document, "sign"), "winding");
    cJSON_Delete(document);
    run_well("$SVOCL mesh scene:knot:4000 -d 6 --colors -o a.obj --quiet");
    run_well("$SVOCL mesh scene:knot:4000 -d 6 --colors -o a.glb");
    assert_non_null(strstr(last.output, "a.glb: "));
    assert_non_null(strstr(last.output, "of 64^3 voxels"));
    assert_null(strstr(last.output, "not closed"));
    run_well(
        "$SVOCL hash a.ply -d 6 >p && $SVOCL hash a.obj -d 6 >o && $SVOCL hash a.glb -d 6 >g && cmp p o && cmp p g");
    run_well("$SVOCL mesh scene:knot:4000 -d 6 --colors -o - >b.ply && cmp a.ply b.ply");
    run_well("$SVOCL sdf a.glb -d 5 -o a.raw --json >a.json && rm a.* b.ply p o g");
}

/* A cube from 0 to 1 and what is within 0.25 of it; a tree's grid is as it is; terrain is open. */
static void offsets_and_open_meshes(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL mesh scene:cube -d 5 --iso 0.25 -o a.ply --json");
    assert_true(number_of(document, "edge") > 1.5 && number_of(document, "edge") < 1.8);
    assert_true(number_of(document, "iso") == 0.25);
    assert_true(number_of(document, "end_triangles") == 0);
    cJSON_Delete(document);
    run_well("$SVOCL mesh scene:cube -d 5 --iso -0.25 -o b.ply --quiet");
    run_well("$SVOCL build scene:cube -d 5 --need rays -o a.svo --quiet && $SVOCL mesh a.svo -o a.ply");
    run_well("$SVOCL mesh a.svo --iso 0.25 -o a.ply");
    assert_non_null(strstr(last.output, "the surface reaches the grid's end and is cut off there"));
    run_well("$SVOCL mesh scene:terrain:500 -d 5 --sign none --iso 0.05 -o a.obj");
    assert_null(strstr(last.output, "not closed"));
    run_well("rm a.svo a.ply b.ply a.obj");
}

static void what_does_not_apply_is_refused(void **state)
{
    (void)state;
    need_builds();
    run_badly("$SVOCL mesh scene:cube -d 4", 2, "-o FILE is missing");
    run_badly("$SVOCL mesh scene:cube -d 4 -o a.stl", 2, "a.stl");
    run_badly("$SVOCL mesh scene:cube -d 4 -o a.ply --iso far", 2, "--iso 'far' is not a number");
    run_badly("$SVOCL mesh scene:cube -d 4 -o a.ply --sign none", 2, "--sign none needs --iso above 0");
    run_badly("$SVOCL mesh scene:cube -d 4 -o a.ply --need rays", 2, "--need does not apply to surfaces");
    run_badly("$SVOCL mesh scene:cube -d 4 -o a.ply --iso -0.6", 1, "scene:cube has no inside at --iso -0.6");
    run_badly("$SVOCL mesh scene:cube -d 4 -o a.ply --margin 2 --origin 0,0,0 --edge 2", 2,
              "does not apply with --margin");
    run_well("$SVOCL build scene:cube -d 3 --need rays -o a.svo --quiet");
    run_badly("$SVOCL mesh a.svo --colors -o a.ply", 1, "the tree's leaves have no colors");
    run_badly("$SVOCL mesh a.svc -o a.ply", 2, "a.svc has no triangles");
    run_well("rm a.svo");
}

TEST_GROUP(program_mesh)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(formats_hold_the_same_mesh),
        IN_FOLDER(offsets_and_open_meshes),
        IN_FOLDER(what_does_not_apply_is_refused),
    };
    return cmocka_run_group_tests_name("program_mesh", tests, NULL, NULL);
}
