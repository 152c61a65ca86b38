/* SPDX-License-Identifier: MIT */
/* `svocl sdf` as a user runs it: its files, what it says of them, refusals. */
#include "run_program.h"
#include "support/suite.h"

#include <stdio.h>
#include <string.h>

#define FILE_BYTES 131072

/* Bytes of a .npy header before its text. */
#define NPY_BEGIN 10

static size_t read_bytes(const char *path, unsigned char bytes[FILE_BYTES])
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t count = fread(bytes, 1, FILE_BYTES, file);
    fclose(file);
    assert_true(count > 0 && count < FILE_BYTES);
    return count;
}

/* A .npy file: header and then the bytes of the .raw file. */
static void compare_files(const char *shape)
{
    static unsigned char npy[FILE_BYTES];
    static unsigned char raw[FILE_BYTES];
    const size_t npy_bytes = read_bytes("a.npy", npy);
    const size_t raw_bytes = read_bytes("a.raw", raw);
    const size_t header = NPY_BEGIN + npy[8] + ((size_t)npy[9] << 8);
    assert_memory_equal(npy, "\x93NUMPY\x01\x00", 8);
    assert_int_equal(header % 64, 0);
    assert_int_equal(npy[header - 1], '\n');
    assert_int_equal(npy_bytes, header + raw_bytes);
    assert_memory_equal(npy + header, raw, raw_bytes);
    npy[header - 1] = '\0';
    assert_non_null(strstr((const char *)npy + NPY_BEGIN, shape));
}

/* The scene is a cube from 0 to 1: centers of voxels in it are inside. */
static void fields_of_a_cube(void **state)
{
    (void)state;
    need_builds();
    static unsigned char raw[FILE_BYTES];
    char shape[64];
    cJSON *document = run_json("$SVOCL sdf scene:cube -d 5 --band 1 -o a.npy --json --origin -0.125,-0.125,-0.125 "
                               "--edge 1.25 --sign parity");
    const unsigned voxels = (unsigned)number_of(document, "voxels");
    assert_string_equal(text_of(document, "sign"), "parity");
    assert_true(number_of(document, "spacing") == 1.25 / 32);
    assert_int_equal((int)number_of(document, "depth"), 5);
    assert_true(number_of(document, "band") == 1);
    assert_int_equal(cJSON_GetArraySize(array_of(document, "first")), 3);
    cJSON_Delete(document);
    run_well("$SVOCL sdf scene:cube -d 5 --band 1 -o a.raw --quiet --origin -0.125,-0.125,-0.125 --edge 1.25");
    (void)snprintf(shape, sizeof shape, "('voxel', '<u2', (3,)), ('distance', '<f4')]");
    compare_files(shape);
    (void)snprintf(shape, sizeof shape, "'shape': (%u,)", voxels);
    compare_files(shape);
    const size_t bytes = read_bytes("a.raw", raw);
    size_t inside = 0;
    assert_int_equal(bytes, 10 * voxels);
    for (size_t i = 0; i < bytes; i += 10) {
        bool within = true;
        for (size_t axis = 0; axis < 3; ++axis) {
            const double at = -0.125 + (raw[i + 2 * axis] + 0.5) * 1.25 / 32;
            within = within && at > 0 && at < 1 && raw[i + 2 * axis + 1] == 0;
        }
        assert_int_equal(raw[i + 9] >> 7, within);
        inside += within;
    }
    assert_true(inside > 1000 && inside < voxels);
    run_well("$SVOCL sdf scene:cube -d 4 --band 0 -o a.npy && $SVOCL sdf scene:cube -d 4 --band 0 -o a.raw");
    assert_non_null(strstr(last.output, "16^3 voxels"));
    assert_non_null(strstr(last.output, "spacing "));
    compare_files("'fortran_order': True, 'shape': (16, 16, 16)");
    assert_int_equal(read_bytes("a.raw", raw), 4 * 16 * 16 * 16);
    run_well("rm a.npy a.raw");
}

/* Trees from files have the field of their mesh in that grid; a margin makes the grid wider. */
static void fields_of_files_and_margins(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:knot:2000 -d 5 --need rays -o a.svo --quiet --origin -2,-2,-2 --edge 4");
    run_well("$SVOCL sdf a.svo --band 2.5 -o a.raw --quiet && $SVOCL sdf scene:knot:2000 -d 5 --band 2.5 -o b.raw "
             "--quiet --origin -2,-2,-2 --edge 4 && cmp a.raw b.raw");
    cJSON *document = run_json("$SVOCL sdf scene:knot:2000 -d 5 --margin 8 -o a.raw --json");
    const double wide = number_of(document, "edge");
    cJSON_Delete(document);
    document = run_json("$SVOCL sdf scene:knot:2000 -d 5 --margin 0 -o a.raw --json");
    assert_true(wide > 1.99 * number_of(document, "edge") && wide < 2.01 * number_of(document, "edge"));
    cJSON_Delete(document);
    run_well("$SVOCL sdf scene:terrain:500 -d 5 -o a.raw");
    assert_non_null(strstr(last.output, "the surface is not closed"));
    run_well("rm a.svo a.raw b.raw");
}

static void what_does_not_apply_is_refused(void **state)
{
    (void)state;
    need_builds();
    run_badly("$SVOCL sdf scene:cube -d 4", 2, "-o FILE is missing");
    run_badly("$SVOCL sdf scene:cube -d 4 -o a.vox", 2, "a.vox");
    run_badly("$SVOCL sdf scene:cube -d 4 -o a.npy --sign wind", 2, "did you mean 'winding'?");
    run_badly("$SVOCL sdf scene:cube -d 4 -o a.npy --band -1", 2, "--band '-1' is not a number of at least 0");
    run_badly("$SVOCL sdf scene:cube -d 4 -o a.npy --band 70000 --margin 1", 1,
              "options.band 70000 is not in 0 .. 65536");
    run_badly("$SVOCL sdf scene:cube -d 4 -o a.npy --band 9", 2,
              "a margin of 10 voxels on each side leaves nothing of 16");
    run_badly("$SVOCL sdf scene:cube -d 4 -o a.npy --margin 2 --origin 0,0,0 --edge 2", 2,
              "does not apply with --margin");
    run_badly("$SVOCL sdf scene:cube -d 4 -o a.npy --need rays", 2, "--need does not apply to distances");
    run_badly("$SVOCL sdf scene:cube -d 4 -o a.npy --coverage thin", 1, "coverage is thin");
    run_badly("$SVOCL sdf scene:cube -d 4 -o a.npy --origin 0,0,0 --edge 0.5", 1, "outside the tree's grid");
    run_well("$SVOCL build scene:cube -d 3 -o a.svo --quiet");
    run_badly("$SVOCL sdf a.svo -o a.npy", 1, "holds no leaf lists");
    run_badly("$SVOCL sdf a.svo -o a.npy --margin 2", 2, "--margin does not apply to a finished tree");
    run_badly("$SVOCL sdf a.svc -o a.npy", 2, "a.svc has no triangles");
    run_well("rm a.svo");
}

TEST_GROUP(program_sdf)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(fields_of_a_cube),
        IN_FOLDER(fields_of_files_and_margins),
        IN_FOLDER(what_does_not_apply_is_refused),
    };
    return cmocka_run_group_tests_name("program_sdf", tests, NULL, NULL);
}
