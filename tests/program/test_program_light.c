/* SPDX-License-Identifier: MIT */
/* `svocl hash --light` as a user runs it: the same opacity however the tree was made, another one for each form. */
#include "run_program.h"
#include "support/suite.h"

#include <string.h>

#define TREE "scene:knot:200 -d 5 --need color,normal,projected-area"

static void the_hash_is_that_of_the_opacity(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build " TREE " -o a.svo --quiet");
    run_well("test $($SVOCL hash " TREE " --light faces) = $($SVOCL hash a.svo --light faces)");
    run_well("test $($SVOCL hash " TREE " --light bricks) = $($SVOCL hash " TREE " --light bricks --builder sorted)");
    run_well("test $($SVOCL hash a.svo --light faces) != $($SVOCL hash a.svo --light voxels)");
    /* Without areas leaves are opaque from every side. */
    run_well("test $($SVOCL hash a.svo --light faces) != "
             "$($SVOCL hash scene:knot:200 -d 5 --need color,normal --light faces)");
    cJSON *document = run_json("$SVOCL hash a.svo --light bricks --json");
    assert_string_equal(text_of(document, "light"), "bricks");
    assert_int_equal(strlen(text_of(document, "hash")), 32);
    cJSON_Delete(document);
    run_well("rm a.svo");
}

/* The second picture has the light of the first. */
static void a_file_keeps_the_light(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:knot:200 -d 5 --need color,normal,rays,projected-area -o a.svo --quiet");
    run_well("$SVOCL render a.svo --view full --size 16x16 --light-file a.svl -o a.png --quiet");
    run_well("$SVOCL render a.svo --view full --size 16x16 --light-file a.svl -o b.png --quiet");
    run_well("$SVOCL render a.svo --view full --size 16x16 -o c.png --quiet");
    run_well("cmp a.png b.png && cmp a.png c.png");
    run_badly("$SVOCL render a.svo --view full --light-file a.svl --form voxels -o d.png", 2,
              "--form has no effect: 'a.svl' holds the light");
    run_badly("$SVOCL render scene:cube -d 4 --view full --light-file a.svl -o d.png", 1,
              "the light is of a tree of hash");
    run_well("rm a.svo a.svl a.png b.png c.png");
}

/* A stored tree has the picture of one that is built, where its mesh is given, and not without. */
static void a_stored_tree_takes_its_mesh(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:knot:200 -d 5 --need color,normal,rays -o a.svo --quiet");
    run_well("$SVOCL render scene:knot:200 -d 5 --view full --size 32x32 -o a.png --quiet");
    run_well("$SVOCL render a.svo --mesh scene:knot:200 --view full --size 32x32 -o b.png --quiet");
    run_well("$SVOCL render a.svo --view full --size 32x32 -o c.png --quiet");
    run_well("cmp a.png b.png && ! cmp -s a.png c.png");
    run_badly("$SVOCL render a.svo --mesh scene:knot:800 --view full -o d.png", 1,
              "triangle 0 is not where the tree of a.svo has it");
    run_badly("$SVOCL render scene:cube -d 4 --mesh scene:cube --view full -o d.png", 2,
              "--mesh is for a finished tree");
    run_badly("$SVOCL render a.svo --mesh scene:knot:200 -o d.png", 2, "options of lights and cones require --view ao");
    run_well("$SVOCL build scene:knot:200 -d 5 -o a.svo --quiet");
    run_badly("$SVOCL render a.svo --mesh scene:knot:200 --view full -o d.png", 1, "has no triangles");
    run_well("rm a.svo a.png b.png c.png");
}

static void wrong_forms_are_refused(void **state)
{
    (void)state;
    need_builds();
    run_badly("$SVOCL hash scene:cube --light cones", 2, "--light 'cones' is none of faces, bricks, voxels");
    run_badly("$SVOCL hash scene:cube --light faces --nodes", 2, "--light and --nodes exclude each other");
    run_badly("$SVOCL info scene:cube --light faces", 2, "--light");
}

TEST_GROUP(program_light)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(the_hash_is_that_of_the_opacity),
        IN_FOLDER(a_file_keeps_the_light),
        IN_FOLDER(a_stored_tree_takes_its_mesh),
        IN_FOLDER(wrong_forms_are_refused),
    };
    return cmocka_run_group_tests_name("program_light", tests, NULL, NULL);
}
