/* SPDX-License-Identifier: MIT */
/* `svocl hash --expect` and `svocl diff` as a user runs them: what a hash covers and what a difference is are one. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "program_picture.h"
#include "run_program.h"
#include "support/suite.h"
#include "svocl/io.h"

#define CUBE_HASH "37fb38f4afb5baf0826ecbdd336cad7a" /* scene:cube -d 4 */

/* ---- svocl hash --expect ---- */

static void the_expected_hash_is_printed_and_silent(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL hash scene:cube -d 4 --expect " CUBE_HASH);
    assert_string_equal(last.output, CUBE_HASH "\n");
    assert_string_equal(last.errors, "");
    run_well("$SVOCL hash scene:cube -d 4 --expect $(echo " CUBE_HASH " | tr a-f A-F)");
    run_well("$SVOCL build scene:cube -d 4 -o a.svo -q && $SVOCL hash a.svo --expect " CUBE_HASH);
    run_well("for more in --nodes '--light faces' '--probes 2,2,2 --probe-resolution 64'; do "
             "$SVOCL hash a.svo $more --expect $($SVOCL hash a.svo $more) || exit 1; done; rm a.svo");
}

static void another_hash_fails_with_both(void **state)
{
    (void)state;
    need_builds();
    const char *const words = "scene:cube: the hash is " CUBE_HASH ", and --expect is 00000000000000000000000000000000";
    run_badly("$SVOCL hash scene:cube -d 4 --expect 00000000000000000000000000000000", 1, words);
    run("$SVOCL hash scene:cube -d 4 --json --expect 00000000000000000000000000000000");
    assert_int_equal(last.exit_code, 1);
    assert_non_null(strstr(last.output, CUBE_HASH));
    assert_non_null(strstr(last.errors, words));
    run_badly("$SVOCL hash scene:cube -d 4 --nodes --expect " CUBE_HASH, 1, "and --expect is " CUBE_HASH);
    run_badly("$SVOCL hash scene:cube -d 3 --light faces --expect " CUBE_HASH, 1, "and --expect is " CUBE_HASH);
}

/* Before the input is looked at, which is missing here. */
static void a_malformed_hash_is_wrong_usage(void **state)
{
    (void)state;
    run_badly("$SVOCL hash none.svo --expect 12", 2, "--expect '12' is not a hash, which has 32 hexadecimal digits");
    run_badly("$SVOCL hash none.svo --expect " CUBE_HASH "0", 2, "is not a hash");
    run_badly("$SVOCL hash none.svo --expect 37fb38f4afb5baf0826ecbdd336cad7g", 2, "is not a hash");
    run_badly("$SVOCL hash none.svo other.svo --expect " CUBE_HASH, 2, "unexpected argument 'other.svo'");
}

/* ---- svocl diff ---- */

/* The document of `svocl diff A B --json`, whose exit code must be that of its verdict. */
static cJSON *find_difference(const char *a, const char *b)
{
    char line[1024];
    (void)snprintf(line, sizeof line, "$SVOCL diff %s %s --json", a, b);
    run(line);
    cJSON *document = cJSON_Parse(last.output);
    if (document == NULL) {
        fail_msg("%s: exit code %d: %s", line, last.exit_code, last.errors);
    }
    assert_int_equal(last.exit_code, cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(document, "equal")) ? 0 : 1);
    assert_string_equal(last.errors, "");
    return document;
}

static const cJSON *member(const cJSON *object, const char *name)
{
    const cJSON *found = cJSON_GetObjectItemCaseSensitive(object, name);
    assert_non_null(found);
    return found;
}

static const cJSON *field_of(const cJSON *document, const char *name)
{
    const cJSON *entry = NULL;
    cJSON_ArrayForEach(entry, array_of(document, "payload"))
    {
        if (strcmp(text_of(entry, "field"), name) == 0) {
            return entry;
        }
    }
    fail_msg("no field %s", name);
    return NULL;
}

/* Whether the document names a difference. */
static bool names_one(const cJSON *document)
{
    const cJSON *voxels = member(document, "voxels");
    bool any = cJSON_GetArraySize(array_of(document, "options")) > 0 || number_of(voxels, "only_a") > 0 ||
               number_of(voxels, "only_b") > 0 || number_of(voxels, "changed") > 0;
    const cJSON *entry = NULL;
    cJSON_ArrayForEach(entry, array_of(document, "payload"))
    {
        any = any || number_of(entry, "voxels") > 0 || number_of(entry, "nodes") > 0 ||
              cJSON_IsTrue(member(entry, "in_a")) != cJSON_IsTrue(member(entry, "in_b"));
    }
    return any;
}

/* Trees with equal hashes have no difference, and others one that is named. */
static cJSON *expect_as_hashes(const char *a, const char *b)
{
    cJSON *document = find_difference(a, b);
    char hashes[2][SVO_HASH_TEXT_BYTES + 1];
    for (int i = 0; i < 2; ++i) {
        char line[512];
        (void)snprintf(line, sizeof line, "$SVOCL hash %s", i == 0 ? a : b);
        run_well(line);
        (void)snprintf(hashes[i], sizeof hashes[i], "%.32s", last.output);
        assert_string_equal(hashes[i], text_of(member(document, i == 0 ? "a" : "b"), "hash"));
    }
    const bool is_equal = strcmp(hashes[0], hashes[1]) == 0;
    if (is_equal != cJSON_IsTrue(member(document, "equal")) || is_equal == names_one(document)) {
        fail_msg("%s and %s: hashes %s, %s, but %s", a, b, hashes[0], hashes[1], cJSON_PrintUnformatted(document));
    }
    return document;
}

static void options_of_builds_show(void **state)
{
    static const struct {
        const char *name, *more, *option; /* NULL: another difference, or none */
    } rows[] = {
        {"same", "", NULL},
        {"sorted", "--builder sorted", NULL},
        {"depth", "-d 5", "depth"},
        {"closed", "--coverage closed", "coverage"},
        {"moved", "--origin -2,-2,-2 --edge 4", "origin"},
        {"edge", "--origin -2,-2,-2 --edge 4.5", "edge"},
        {"bare", "--need none", NULL},
        {"rays", "--need normal,rays", NULL},
        {"areas", "--need normal,projected-area", NULL},
        {"payload", "--payload-level 2", "payload_level"},
        {"weights", "--weights uniform", NULL},
        {"finer", "-d 5 --need none --payload-level 2", "depth"},
    };
    (void)state;
    need_builds();
    const size_t count = sizeof rows / sizeof rows[0];
    for (size_t i = 0; i < count; ++i) {
        char line[512];
        (void)snprintf(line, sizeof line, "$SVOCL build scene:knot:300 -d 4 %s -o %s.svo -q", rows[i].more,
                       rows[i].name);
        run_well(line);
    }
    for (size_t i = 0; i < count; ++i) {
        char path[64];
        (void)snprintf(path, sizeof path, "%s.svo", rows[i].name);
        cJSON *document = expect_as_hashes("same.svo", path);
        char *options = cJSON_PrintUnformatted(array_of(document, "options"));
        if (rows[i].option != NULL && strstr(options, rows[i].option) == NULL) {
            fail_msg("%s: %s", rows[i].name, options);
        }
        free(options);
        cJSON_Delete(document);
        cJSON_Delete(expect_as_hashes(path, "edge.svo"));
    }
    run_well("rm *.svo");
}

/* A mesh of two small triangles in two voxels of a grid of 16 units; green: of the first, 0 or 1. */
static void write_two(const char *path, int x, int green)
{
    char text[512];
    (void)snprintf(text, sizeof text,
                   "v 3.2 5.2 7.2 1 %d 1\nv 3.8 5.2 7.2 1 %d 1\nv 3.2 5.8 7.4 1 %d 1\n"
                   "v %d.2 9.2 2.2 1 1 1\nv %d.8 9.2 2.2 1 1 1\nv %d.2 9.8 2.4 1 1 1\n"
                   "f 1 2 3\nf 4 5 6\n",
                   green, green, green, x, x, x);
    write_text(path, text);
}

static void a_moved_voxel_is_found(void **state)
{
    (void)state;
    need_builds();
    write_two("a.obj", 10, 1);
    write_two("b.obj", 11, 1);
    run_well("for i in a b; do $SVOCL build $i.obj -d 4 --origin 0,0,0 --edge 16 --need none -o $i.svo -q; done");
    cJSON *document = expect_as_hashes("a.svo", "b.svo");
    const cJSON *voxels = member(document, "voxels");
    assert_int_equal((int)number_of(voxels, "only_a"), 1);
    assert_int_equal((int)number_of(voxels, "only_b"), 1);
    assert_int_equal((int)number_of(voxels, "both"), 1);
    const cJSON *first = member(document, "first");
    char *cell = cJSON_PrintUnformatted(array_of(first, "cell"));
    assert_string_equal(cell, "[10,9,2]");
    free(cell);
    assert_float_equal(cJSON_GetArrayItem(array_of(first, "center"), 0)->valuedouble, 10.5, 1e-9);
    assert_true(cJSON_IsNull(member(first, "b")));
    assert_false(cJSON_IsNull(member(first, "a")));
    cJSON_Delete(document);
    run("$SVOCL diff a.svo b.obj -d 4 --origin 0,0,0 --edge 16 --need none");
    assert_int_equal(last.exit_code, 1);
    assert_non_null(strstr(last.output, "A a.svo and B b.obj differ"));
    assert_non_null(strstr(last.output, "first difference: voxel 10, 9, 2 of level 4"));
    assert_non_null(strstr(last.output, "not in B"));
    run_well("$SVOCL diff b.svo b.obj -d 4 --origin 0,0,0 --edge 16 --need none");
    assert_string_equal(last.errors, "");
    run_well("rm a.obj b.obj a.svo b.svo");
}

/* An element of an array, on the host. Arrays belong to the tree, which this test alone has. */
typedef struct element {
    const char *field;
    void *at;
    bool is_byte;
    bool of_leaf;
} element;

/* Changes it by 1, writes the tree and compares the file. */
static void expect_element(svo_tree *tree, const element *changed)
{
    char before[SVO_HASH_TEXT_BYTES], after[SVO_HASH_TEXT_BYTES];
    svo_message message = {""};
    assert_int_equal(svo_tree_hash(tree, SVO_HASH_ALL, before), SVO_OK);
    unsigned char *low = changed->at; /* little-endian */
    low[0] ^= 1;
    assert_int_equal(svo_tree_hash(tree, SVO_HASH_ALL, after), SVO_OK);
    assert_string_not_equal(before, after);
    if (svo_tree_save(tree, svo_to_path("b.svo"), NULL, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    cJSON *document = expect_as_hashes("a.svo", "b.svo");
    const cJSON *entry = NULL;
    cJSON_ArrayForEach(entry, array_of(document, "payload"))
    {
        const bool is_it = strcmp(text_of(entry, "field"), changed->field) == 0;
        assert_int_equal((int)number_of(entry, "voxels"), is_it && changed->of_leaf ? 1 : 0);
        assert_int_equal((int)number_of(entry, "nodes"), is_it && !changed->of_leaf ? 1 : 0);
    }
    const cJSON *field = field_of(document, changed->field);
    if (strcmp(changed->field, "material") != 0 && strcmp(changed->field, "list") != 0) {
        assert_int_equal((int)number_of(field, "largest"), 1);
    }
    assert_int_equal((int)number_of(member(document, "first"), "level"), changed->of_leaf ? 3 : 0);
    cJSON_Delete(document);
    low[0] ^= 1;
}

static void one_bit_of_payload_is_found(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:atrium:2000 -d 3 --need color,normal,rays,material,fill,projected-area -o a.svo -q");
    svo_tree *tree = NULL;
    svo_message message = {""};
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    assert_int_equal(svo_tree_load(svo_from_path("a.svo"), NULL, &tree, &message), SVO_OK);
    assert_int_equal(svo_tree_get_info(tree, &info), SVO_OK);
    assert_int_equal(svo_tree_get_arrays(tree, &arrays), SVO_OK);
    assert_int_equal(info.constant, 0);
    const size_t last_node = info.node_count - 1;
    /* A list of one triangle, so that it stays in order; triangle 1 or 0 is in the mesh. */
    size_t leaf = 0;
    while (leaf < info.leaf_count && arrays.list_begin[leaf + 1] - arrays.list_begin[leaf] != 1) {
        ++leaf;
    }
    assert_true(leaf < info.leaf_count);
    const element changes[] = {
        {"color", (void *)(uintptr_t)&arrays.colors[4 * last_node + 3], true, true},
        {"color", (void *)(uintptr_t)&arrays.colors[1], true, false},
        {"normal", (void *)(uintptr_t)&arrays.normals[3 * last_node + 2], false, true},
        {"normal", (void *)(uintptr_t)&arrays.normals[0], false, false},
        {"material", (void *)(uintptr_t)&arrays.materials[last_node], false, true},
        {"material", (void *)(uintptr_t)&arrays.materials[0], false, false},
        {"fill", (void *)(uintptr_t)&arrays.fills[last_node], false, true},
        {"fill", (void *)(uintptr_t)&arrays.fills[0], false, false},
        {"projected-area", (void *)(uintptr_t)&arrays.areas[6 * (size_t)info.leaf_count - 1], false, true},
        {"list", (void *)(uintptr_t)&arrays.list[arrays.list_begin[leaf]], false, true},
    };
    for (size_t i = 0; i < sizeof changes / sizeof changes[0]; ++i) {
        expect_element(tree, &changes[i]);
    }
    svo_tree_destroy(&tree);
    run_well("rm a.svo b.svo");
}

/* Pixels of a hue: the channel that is the greatest by far, or none. */
static int count_pixels(const program_picture *picture, int red, int green, int blue)
{
    int count = 0;
    for (int y = 0; y < picture->height; ++y) {
        for (int x = 0; x < picture->width; ++x) {
            const uint8_t *rgba = pixel_of(picture, x, y);
            const int high = rgba[0] > rgba[2] ? rgba[0] : rgba[2];
            count += (2 * rgba[0] > high) == red && (2 * rgba[1] > high) == green && (2 * rgba[2] > high) == blue;
        }
    }
    return count;
}

static void a_picture_shows_what_is_where(void **state)
{
    (void)state;
    need_builds();
    write_two("a.obj", 10, 1);
    write_two("b.obj", 12, 1);
    write_two("c.obj", 10, 0);
    run_well("for i in a b; do $SVOCL build $i.obj -d 4 --origin 0,0,0 --edge 16 --need color -o $i.svo -q; done");
    run("$SVOCL diff a.svo b.svo --picture p.png --size 96x64");
    assert_int_equal(last.exit_code, 1);
    program_picture picture = read_picture("p.png");
    assert_int_equal(picture.width, 96);
    assert_true(count_pixels(&picture, 1, 0, 0) > 0); /* orange */
    assert_true(count_pixels(&picture, 0, 0, 1) > 0); /* blue */
    assert_int_equal(count_pixels(&picture, 1, 1, 0), 0); /* yellow */
    free_picture(&picture);
    run_well("$SVOCL diff a.svo a.svo --picture p.png --size 96x64 -q");
    picture = read_picture("p.png");
    assert_int_equal(count_pixels(&picture, 1, 1, 1), 96 * 64);
    free_picture(&picture);
    run("$SVOCL diff a.svo c.obj -d 4 --origin 0,0,0 --edge 16 --need color --picture p.png --size 96x64 -q");
    assert_int_equal(last.exit_code, 1);
    assert_string_equal(last.output, "");
    picture = read_picture("p.png");
    assert_true(count_pixels(&picture, 1, 1, 0) > 0);
    assert_int_equal(count_pixels(&picture, 1, 0, 0) + count_pixels(&picture, 0, 0, 1), 0);
    free_picture(&picture);
    run_well("rm a.obj b.obj c.obj a.svo b.svo p.png");
}

/* Failures are 2, so that 1 says one thing. */
static void failures_are_no_differences(void **state)
{
    (void)state;
    run_badly("$SVOCL diff", 2, "A B is missing");
    run_badly("$SVOCL diff a.svo", 2, "B is missing");
    run_badly("$SVOCL diff a.svo b.svo c.svo", 2, "unexpected argument 'c.svo'");
    run_badly("$SVOCL diff a.svo b.svo", 2, "a.svo: cannot be read");
    run_badly("$SVOCL diff a.svo b.svo --picture p.jpg", 2, "output p.jpg does not end in .png");
    run_badly("$SVOCL diff a.svo b.svo --size 8x8", 2, "--size does not apply without --picture");
    run_badly("$SVOCL diff a.svo b.svo --depth 8", 2, "build options do not apply");
    run_badly("$SVOCL diff a.svo b.svo --threads 1", 2, "--threads does not apply to a finished tree");
    run_badly("$SVOCL diff - - <.output", 2, "standard input");
    need_builds();
    run_well("$SVOCL build scene:cube -d 3 -o a.svo -q && head -c 200 a.svo >b.svo");
    run_badly("$SVOCL diff a.svo b.svo", 2, "b.svo: ");
    run_badly("$SVOCL diff - - <a.svo", 2, "A and B both come through pipes");
    run_badly("$SVOCL diff a.svo a.svo --picture a.svo", 2, "would replace a.svo");
    run_badly("$SVOCL diff a.svo a.svo --picture - --json", 2, "--json and --picture - both write");
    run_well("test \"$($SVOCL diff a.svo - <a.svo | cut -d ' ' -f 1-7)\" = 'A a.svo and B standard input are'");
    run_well("$SVOCL diff - a.svo <a.svo");
    run_well("ln a.svo c.png");
    run_badly("$SVOCL diff scene:cube a.svo -d 3 --picture c.png", 2, "would replace a.svo");
    run_well("rm a.svo b.svo c.png");
}

TEST_GROUP(program_diff)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(the_expected_hash_is_printed_and_silent),
        IN_FOLDER(another_hash_fails_with_both),
        IN_FOLDER(a_malformed_hash_is_wrong_usage),
        IN_FOLDER(options_of_builds_show),
        IN_FOLDER(a_moved_voxel_is_found),
        IN_FOLDER(one_bit_of_payload_is_found),
        IN_FOLDER(a_picture_shows_what_is_where),
        IN_FOLDER(failures_are_no_differences),
    };
    return cmocka_run_group_tests_name("program_diff", tests, NULL, NULL);
}
