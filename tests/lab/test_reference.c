/* SPDX-License-Identifier: MIT */
/* `svocl reference` as a user runs it: points from a file, from standard input and spread by area; refusals. */
#include "program/run_program.h"
#include "support/suite.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The number in a column of a line, both counted from 0; line 0 is the heading. */
static double value_at(const char *path, size_t line, size_t column)
{
    char text[4096];
    const char *at = text;
    read_text(path, text, sizeof text);
    for (size_t i = 0; i < line; ++i) {
        at = strchr(at, '\n');
        assert_non_null(at);
        ++at;
    }
    for (size_t i = 0; i < column; ++i) {
        at = strchr(at, ',');
        assert_non_null(at);
        ++at;
    }
    return strtod(at, NULL);
}

/* Points on the outside of a cube are open, whatever the range; below it and looking up they are not. */
static void points_of_a_file_get_their_light(void **state)
{
    (void)state;
    need_builds();
    write_text("points.csv", "x,y,z,nx,ny,nz\n0.5,1,0.5,0,1,0\n0.5,0.25,0.5,0,2,0\n9,9,9,0,1,0\n0.5,0.5,0.5,0,0,0\n");
    cJSON *document = run_json("$SVOCL reference scene:cube --points points.csv --samples 256 -o light.csv --json");
    assert_int_equal((int)number_of(document, "points"), 4);
    assert_int_equal((int)number_of(document, "left_out"), 2);
    assert_int_equal((int)number_of(document, "samples"), 256);
    assert_true(number_of(document, "ao_error") <= 0.01);
    cJSON_Delete(document);
    assert_true(value_at("light.csv", 1, 6) == 1);
    assert_true(value_at("light.csv", 2, 6) == 0);
    assert_true(value_at("light.csv", 3, 6) == 1);
    assert_true(value_at("light.csv", 4, 6) == 1);
    run_well(
        "$SVOCL reference scene:cube --points - --samples 256 -o again.csv <points.csv && cmp light.csv again.csv");
    assert_non_null(strstr(last.output, "2 points lie outside the grid or have no normal"));
    run_well("$SVOCL reference scene:cube --points points.csv --samples 256 --range 0.01 -o light.csv");
    assert_true(value_at("light.csv", 2, 6) == 1);
    run_well("$SVOCL reference scene:cube --points points.csv --samples 256 --lambda 2 -o light.csv");
    assert_true(value_at("light.csv", 2, 6) > 0.5 && value_at("light.csv", 2, 6) < 0.7);
    run_well("rm points.csv light.csv again.csv");
}

/* The seed chooses points and paths; the standard error falls with the samples. */
static void points_are_spread_over_the_mesh(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL reference scene:cornell --points 20 --samples 64 -o a.csv -q && wc -l <a.csv | grep -qx 21");
    run_well("$SVOCL reference scene:cornell --points 20 --samples 64 --seed 1 -o b.csv -q && cmp a.csv b.csv");
    run_well("$SVOCL reference scene:cornell --points 20 --samples 64 --seed 2 -o b.csv -q && ! cmp -s a.csv b.csv");
    cJSON *document = run_json("$SVOCL reference scene:cornell --points 20 --samples 64 -o a.csv --json");
    const double few = number_of(document, "ao_error");
    cJSON_Delete(document);
    document = run_json("$SVOCL reference scene:cornell --points 20 -o a.csv --json");
    assert_int_equal((int)number_of(document, "samples"), 16384);
    assert_true(number_of(document, "largest_ao_error") <= 0.004);
    assert_true(number_of(document, "ao_error") < few / 8);
    cJSON_Delete(document);
    run_well("rm a.csv b.csv");
}

static void what_is_wrong_is_named(void **state)
{
    (void)state;
    need_builds();
    write_text("bad.csv", "1,2,3,0,1,0\n1,2,3\n");
    run_badly("$SVOCL reference scene:cube --points bad.csv -o none.csv", 1, "bad.csv:2: not x,y,z,nx,ny,nz");
    write_text("bad.csv", "x,y,z,nx,ny,nz\n");
    run_badly("$SVOCL reference scene:cube --points bad.csv -o none.csv", 1, "bad.csv: no point");
    run_badly("$SVOCL reference scene:cube --points nowhere.csv -o none.csv", 1, "nowhere.csv");
    run_badly("$SVOCL reference scene:cube -o none.csv", 2, "--points FILE is missing");
    run_badly("$SVOCL reference scene:cube --points 4", 2, "-o FILE is missing");
    run_badly("$SVOCL reference scene:cube --points 4 --samples 300000 -o none.csv", 2, "samples 300000 is above");
    run_badly("$SVOCL reference scene:cube --points 4 --range -1 -o none.csv", 2, "--range '-1' is not a number");
    run_badly("$SVOCL reference scene:cube --points 4 --lambda nan -o none.csv", 2, "--lambda 'nan' is not a number");
    run_badly("$SVOCL scene cube -o - -q | $SVOCL reference - --points - -o none.csv", 2, "both read standard input");
    run_well("$SVOCL build scene:cube -d 3 --need rays -o a.svo");
    run_badly("$SVOCL reference a.svo --points 4 -o none.csv", 2, "a.svo is a finished tree");
    run_well("rm a.svo bad.csv");
}

TEST_GROUP(reference)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(points_of_a_file_get_their_light),
        IN_FOLDER(points_are_spread_over_the_mesh),
        IN_FOLDER(what_is_wrong_is_named),
    };
    return cmocka_run_group_tests_name("reference", tests, NULL, NULL);
}
