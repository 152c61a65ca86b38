/* SPDX-License-Identifier: MIT */
/* `svocl edit` as a user runs it: scripts, what it says of them, and where they are wrong. */
#include "run_program.h"
#include "support/suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SESSION_HASH "b382b4bdc63294297811d53f2b5bdfe2" /* of the tree of session.txt */

/* Writes a script, runs it on a file, and returns the report. */
static cJSON *edit(const char *lines, const char *arguments)
{
    char command[2048];
    (void)snprintf(command, sizeof command, "printf '%s' >s.txt", lines);
    run_well(command);
    (void)snprintf(command, sizeof command, "$SVOCL edit %s --json", arguments);
    return run_json(command);
}

static void expect_wrong(const char *lines, const char *words)
{
    char command[2048];
    (void)snprintf(command, sizeof command, "printf '%s' >s.txt", lines);
    run_well(command);
    run_badly("$SVOCL edit a.vox s.txt -o b.vox", 1, words);
    run_well("test ! -e b.vox");
}

/* A cube of 8^3 voxels, made by convert. */
static void make_cube(void)
{
    need_builds();
    run_well("$SVOCL convert scene:cube a.vox -d 3 --solid winding --quiet");
}

static void scripts_change_voxels(void **state)
{
    (void)state;
    make_cube();
    cJSON *document = edit("# a comment\\n\\nclear box 0 0 0 8 8 4 # the half\\nset box 0 0 0 2 2 2 color 1 2 3 "
                           "material 7\\ncopy box 0 0 0 2 2 2 by 20 0 0\\n",
                           "a.vox s.txt -o b.vox");
    assert_int_equal((int)number_of(document, "steps"), 3);
    assert_int_equal((int)number_of(document, "voxels_before"), 512);
    assert_int_equal((int)number_of(document, "voxels"), 256 + 8 + 8);
    cJSON_Delete(document);
    /* Back to the same file, byte for byte. */
    document = edit("clear sphere 4 4 4 2.5\\npaint capsule 4 4 0 4 4 8 1 color 9 9 9 128\\nundo 2\\nredo\\nundo\\n",
                    "a.vox s.txt -o c.vox");
    assert_int_equal((int)number_of(document, "steps"), 5);
    cJSON_Delete(document);
    run_well("$SVOCL convert a.vox a.svo --quiet && $SVOCL convert c.vox c.svo --quiet && $SVOCL diff a.svo c.svo");
    /* A tree of the voxels is the tree of the file of them, but for materials, which .vox files number anew. */
    document = edit("set voxels \"b.vox\" at 0 0 -30\\nadd voxels a.svo\\n", "b.vox s.txt -o d.svo");
    assert_int_equal((int)number_of(document, "voxels"), 2 * 272 + 256 - 8);
    cJSON_Delete(document);
    run_well("$SVOCL edit b.vox s.txt -o d.vox --quiet && $SVOCL convert d.vox e.svo --quiet && "
             "test $($SVOCL hash d.svo --nodes) = $($SVOCL hash e.svo --nodes)");
    run_well("$SVOCL edit b.vox s.txt -o d.svc --tree-form shared --quiet && $SVOCL diff d.svc d.svo");
    run_well("$SVOCL edit b.vox s.txt -o d.binvox");
    assert_non_null(strstr(last.output, "2 in "));
    run_well("rm a.vox b.vox c.vox d.vox a.svo c.svo d.svo e.svo d.svc d.binvox s.txt");
}

/* A mesh fills what its solid fills; turned by quarters, placed, painted and taken away. */
static void scripts_take_closed_meshes(void **state)
{
    (void)state;
    make_cube();
    run_well("$SVOCL scene cube -o cube.obj --quiet && $SVOCL convert cube.obj c.vox --voxel-size 0.25 --solid winding "
             "--quiet && $SVOCL convert c.vox c.svo --quiet");
    cJSON *document = edit("clear box 0 0 0 8 8 8\nset mesh cube.obj scale 4\n", "a.vox s.txt -o b.svo");
    assert_int_equal((int)number_of(document, "voxels"), 5 * 5 * 5);
    cJSON_Delete(document);
    run_well("test $($SVOCL hash b.svo --nodes) = $($SVOCL hash c.svo --nodes)");
    /* Faces on planes take the voxel above: x is in 16 .. 20, and 20 .. 22 of the one that is cleared. */
    document = edit("set mesh cube.obj scale 4 turn z 90 turn x -270 turn x -90 at 20 0 0 color 1 2 3 material 5\n"
                    "clear mesh cube.obj parity scale 2 at 20 1 1\n",
                    "a.vox s.txt -o b.vox");
    assert_int_equal((int)number_of(document, "voxels"), 512 + 125 - 9);
    cJSON_Delete(document);
    run_well("printf 'o x\nv 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n' >open.obj && printf 'set mesh open.obj' >s.txt && "
             "$SVOCL edit a.vox s.txt -o b.vox 2>&1");
    assert_non_null(strstr(last.output, "s.txt:1: open.obj is not closed: 36 columns of voxels"));
    run_well("rm a.vox b.vox c.vox b.svo c.svo cube.obj open.obj s.txt");
}

/* A recorded session comes to the same bytes on the host and by kernels; by those of GPUs, too, where SVOCL_LONG_TESTS
   is set, since PoCL takes minutes to compile them. */
static void sessions_are_replayed(void **state)
{
    static const char *const ways[] = {"", "--builder sorted --path cpu", "--builder cl --path gpu"};
    const size_t count = suite_is_long() ? 3 : 2;
    char command[2048];
    (void)state;
    need_builds();
    run_well(
        "$SVOCL scene knot:600 -o knot.obj --quiet && $SVOCL convert scene:cube a.vox -d 3 --solid winding --quiet");
    run_well("cp " EDIT_SESSION " session.txt");
    for (size_t i = 0; i < count; ++i) {
        (void)snprintf(command, sizeof command,
                       "$SVOCL edit a.vox session.txt -o c.svo --quiet %s && test $($SVOCL hash c.svo) = " SESSION_HASH,
                       ways[i]);
        run_well(command);
    }
    run_well("$SVOCL edit a.vox session.txt -o c.svc --tree-form shared --quiet && $SVOCL diff c.svc c.svo");
    run_well("rm a.vox c.svo c.svc knot.obj session.txt");
}

static void wrong_lines_are_named(void **state)
{
    (void)state;
    make_cube();
    expect_wrong("\\nset sphear 0 0 0 1\\n", "s.txt:2: 'sphear' is not box, sphere, capsule, voxels or mesh");
    expect_wrong("sett box 0 0 0 1 1 1", "s.txt:1: 'sett' is not a step: set, add, clear, keep, paint, copy");
    expect_wrong("set box 0 0 0 1 1", "s.txt:1: a coordinate is missing");
    expect_wrong("set sphere 0 0 0 -1", "s.txt:1: '-1' is not a radius");
    expect_wrong("set sphere 0 0 x 1", "s.txt:1: 'x' is not a coordinate");
    expect_wrong("set sphere 0 0 0 1 color 1 2 256", "s.txt:1: '256' is not a color");
    expect_wrong("set sphere 0 0 0 1 color 1 2 3 material 65535", "s.txt:1: '65535' is not a material");
    expect_wrong("clear sphere 0 0 0 1 color 1 2 3", "s.txt:1: unexpected 'color'");
    expect_wrong("copy box 0 0 0 1 1 1", "s.txt:1: 'by' with an offset is missing");
    expect_wrong("copy voxels a.vox by 1 1 1", "s.txt:1: 'voxels' is not box, sphere or capsule");
    expect_wrong("copy box 0 0 0 1 1 1 by 0 0.5 0", "s.txt:1: '0.5' is not a whole number of voxels");
    expect_wrong("set voxels \"a.vox", "s.txt:1: a quote has no end");
    expect_wrong("set voxels", "s.txt:1: the file of voxels is missing");
    expect_wrong("set voxels none.vox", "none.vox");
    expect_wrong("set mesh", "s.txt:1: the file of a mesh is missing");
    expect_wrong("set mesh none.obj", "none.obj");
    expect_wrong("set mesh a.vox", "a.vox is no file of a mesh");
    expect_wrong("set mesh a.obj turn w 90", "s.txt:1: 'w' is not an axis: x, y or z");
    expect_wrong("set mesh a.obj turn x", "s.txt:1: a number of degrees is missing");
    expect_wrong("set mesh a.obj scale 0", "s.txt:1: '0' is not a scale, 1e-9 .. 1e9");
    expect_wrong("copy mesh a.obj by 1 1 1", "s.txt:1: 'mesh' is not box, sphere or capsule");
    expect_wrong("undo", "s.txt:1: there is no step to undo");
    expect_wrong("clear box 0 0 0 1 1 1\\nredo 2", "s.txt:2: there is no step to redo");
    expect_wrong("clear sphere 1e6 0 0 1e5", "s.txt:1: step.begin.x 1e+06 with radius 100000 is not within");
    run_well("printf 'keep box 0 0 0 1 1 1' >s.txt");
    run_badly("$SVOCL edit a.vox -o b.vox", 2, "SCRIPT is missing");
    run_badly("$SVOCL edit a.vox s.txt", 2, "-o OUT is missing");
    run_badly("$SVOCL edit a.vox none.txt -o b.vox", 1, "none.txt: No such file");
    run_badly("$SVOCL edit a.vox s.txt -o a.vox", 2, "a.vox");
    run_badly("$SVOCL edit a.vox s.txt -o s.txt", 2, "s.txt");
    run_badly("$SVOCL edit a.vox s.txt -o b.vox -d 5", 2, "--depth does not apply to OUT that holds voxels");
    run_badly("$SVOCL edit a.obj s.txt -o b.vox", 2, "svocl convert makes one of a mesh");
    run_badly("$SVOCL edit a.vox s.txt -o b.vox --max-memory 1M", 2, "max-memory 1M is below 2097152");
    run_well("printf 'add voxels b.vox' >s.txt && cp a.vox b.vox");
    run_badly("$SVOCL edit a.vox s.txt -o b.vox", 2, "b.vox");
    run_well("cmp a.vox b.vox && rm a.vox b.vox s.txt");
}

TEST_GROUP(program_edit)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(scripts_change_voxels),
        IN_FOLDER(scripts_take_closed_meshes),
        IN_FOLDER(sessions_are_replayed),
        IN_FOLDER(wrong_lines_are_named),
    };
    return cmocka_run_group_tests_name("program_edit", tests, NULL, NULL);
}
