/* SPDX-License-Identifier: MIT */
/* `svocl render --through probes` as a user runs it: what rays find, what they miss, what stays unknown; and
   `svocl hash --probes`. */
#include "program_picture.h"
#include "run_program.h"
#include "support/suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PIXELS (48 * 32)

/* ---- what a picture shows ---- */

static int count_pixels(const program_picture *picture, const uint8_t color[3])
{
    int count = 0;
    for (int y = 0; y < picture->height; ++y) {
        for (int x = 0; x < picture->width; ++x) {
            count += memcmp(pixel_of(picture, x, y), color, 3) == 0;
        }
    }
    return count;
}

static const uint8_t green[3] = {0, 255, 0};
static const uint8_t red[3] = {255, 0, 0};

/* A pixel is a ray: green ones are the misses, red ones the unknown, and the report counts the same. */
static void colors_are_counted(void **state)
{
    (void)state;
    need_builds();
#define RENDER                                                                                     \
    "$SVOCL render scene:cornell:2000 -d 6 --through probes --probes 3,2,4 --probe-resolution 64 " \
    "--eye 0,1,3.6 --at 0,1,0 --size 48x32 "
    cJSON *document = run_json(RENDER "--json -o a.png");
    const int hits = (int)number_of(document, "hits");
    const int misses = (int)number_of(document, "misses");
    const int unknown = (int)number_of(document, "unknown");
    program_picture picture = read_picture("a.png");
    assert_int_equal(hits + misses + unknown, PIXELS);
    assert_int_equal(count_pixels(&picture, green), misses);
    assert_int_equal(count_pixels(&picture, red), unknown);
    assert_true(hits > PIXELS / 4 && misses > PIXELS / 16);
    assert_int_equal((int)number_of(document, "resolution"), 64);
    assert_int_equal(cJSON_GetArrayItem(array_of(document, "probes"), 2)->valueint, 4);
    free_picture(&picture);
    cJSON_Delete(document);
    run_well(RENDER "-o a.png");
    assert_non_null(strstr(last.output, "probes: 3 x 2 x 4 of 64 x 64 texels"));
    run_well(RENDER "-q -o b.png && cmp a.png b.png");
    assert_string_equal(last.output, "");
    run_well("rm a.png b.png");
#undef RENDER
}

static void expect_view(const char *options, int channel, int low, int high)
{
    char line[256];
    snprintf(line, sizeof line,
             "$SVOCL render a.svo -q --through probes --probes 2,2,2 --size 48x32 -o a.png "
             "--eye 0.5,0.5,0.5 --at 1,0.5,0.5 --fov 40 %s",
             options);
    run_well(line);
    program_picture picture = read_picture("a.png");
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const int value = pixel_of(&picture, x, y)[channel];
            if (value < low || value > high) {
                fail_msg("%s: channel %d of pixel %d, %d is %d, not %d .. %d", options, channel, x, y, value, low,
                         high);
                return;
            }
        }
    }
    free_picture(&picture);
    run_well("rm a.png");
}

/* Walls of a unit cube, whose fronts are inside. */
static void write_room(const char *path)
{
    write_text(path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
                     "f 1 2 4 3\nf 5 7 8 6\nf 1 3 7 5\nf 2 6 8 4\nf 1 5 6 2\nf 3 4 8 7\n");
}

/* Inside of it every ray meets the wall in front, whether probes see triangles or voxels. */
static void a_closed_room_has_no_holes(void **state)
{
    (void)state;
    need_builds();
    static const char *const needs[] = {"normal,rays", "normal"};
    write_room("room.obj");
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        char line[128];
        snprintf(line, sizeof line, "$SVOCL build room.obj -d 5 --need %s -o a.svo -q", needs[i]);
        run_well(line);
        /* The wall's normal is -x, of bytes: within a degree. */
        expect_view("--view normal", 0, 0, 4);
        expect_view("--view normal", 1, 124, 132);
        expect_view("--view depth", 2, 60, 250);
        expect_view("--view steps", 2, 51, 255);
    }
    run_well("rm a.svo room.obj");
}

/* Probes of a scene see the voxels of what it places; lit ones see the triangles of a tree of all of it. */
static void a_scene_that_moves_nothing_looks_like_its_mesh(void **state)
{
    (void)state;
    need_builds();
#define RENDER "$SVOCL render -q -d 5 --through probes --probes 2,2,2 --probe-resolution 64 --size 48x32 "
    write_room("room.obj");
    write_text("scene.json",
               "{\"trees\": {\"room\": {\"path\": \"room.obj\"}}, \"instances\": [{\"tree\": \"room\"}]}");
    run_well(RENDER "--view normal room.obj --need normal -o a.png && " RENDER
                    "--view normal scene.json -o b.png && cmp a.png b.png");
    run_well(RENDER "room.obj --need normal,rays,projected-area -o c.png && " RENDER "scene.json -o b.png && cmp c.png "
                    "b.png");
    run_well("rm room.obj scene.json a.png b.png c.png");
#undef RENDER
}

/* Trees that are placed twice, turned and scaled, are found where they are; -d is of the trees then. */
static void probes_see_what_a_scene_places(void **state)
{
    (void)state;
    need_builds();
#define RENDER                                                                                                 \
    "$SVOCL render scene.json --json -d 4 --through probes --probes 4,3,4 --probe-resolution 64 --size 48x32 " \
    "--eye 0.5,0.5,6 --at 0.5,0.5,0 --fov 50 -o a.png --view normal "
    int hits_before = 0;
    for (int i = 0; i < 2; ++i) {
        static const char *const forms[] = {"built", "shared"};
        char text[512];
        snprintf(text, sizeof text,
                 "{\"form\": \"%s\", \"trees\": {\"cube\": {\"path\": \"scene:cube\"}}, \"instances\": [\n"
                 "{\"tree\": \"cube\", \"translate\": [-2, 0, 0], \"rotate\": [0, 30, 0]},\n"
                 "{\"tree\": \"cube\", \"translate\": [2, 0, 0], \"scale\": 0.5}]}",
                 forms[i]);
        write_text("scene.json", text);
        cJSON *document = run_json(RENDER);
        program_picture picture = read_picture("a.png");
        const int hits = (int)number_of(document, "hits");
        assert_true(hits > PIXELS / 50 && hits < PIXELS / 10);
        assert_true(i == 0 || hits == hits_before); /* every form has the same voxels */
        hits_before = hits;
        assert_int_equal(hits + count_pixels(&picture, green) + count_pixels(&picture, red), PIXELS);
        assert_memory_equal(pixel_of(&picture, 24, 16), green, 3);
        free_picture(&picture);
        cJSON_Delete(document);
    }
    run_well("rm scene.json a.png");
#undef RENDER
}

/* Inside of a solid every probe sees backs alone: all are off, and nothing is known. */
static void probes_in_solids_know_nothing(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL render scene:cube -d 5 --through probes --probes 2,2,2 --probe-resolution 64 "
                               "--view normal --eye 0.5,0.5,0.5 --at 1,0.5,0.5 --size 48x32 --json -o a.png");
    assert_int_equal((int)number_of(document, "off"), 8);
    assert_int_equal((int)number_of(document, "unknown"), PIXELS);
    cJSON_Delete(document);
    run_well("rm a.png");
}

static double brightness(const char *options)
{
    char line[320];
    snprintf(line, sizeof line,
             "$SVOCL render a.svo -q --through probes --probes 2,2,2 --probe-resolution 64 --size 48x32 --cones 1 "
             "--lights lights.json -o a.png %s",
             options);
    run_well(line);
    return take_brightness("a.png");
}

/* Shaded pictures show the light that probes hold. */
static void probes_are_lit(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cornell:2000 -d 6 --need color,normal,rays,projected-area -o a.svo -q");
    write_text("lights.json", "{\"lights\": [{\"kind\": \"point\", \"position\": [0.1, 1.5, 0.1], \"value\": [1, 1, 1]}"
                              "],\n \"camera\": {\"eye\": [0, 1, 0.9], \"at\": [0, 1, -1], \"fov\": 60}}");
    const double lit = brightness("--exposure 1");
    assert_true(lit > 20);
    assert_true(brightness("--exposure 2") > lit + 5);
    const double automatic = brightness("");
    assert_true(automatic > 40 && automatic < 220);
    write_text("lights.json", "{\"camera\": {\"eye\": [0, 1, 0.9], \"at\": [0, 1, -1], \"fov\": 60}}");
    assert_true(brightness("--exposure 1") < lit / 2);
    run_well("rm a.svo lights.json");
}

/* `svocl hash --probes`: the same bytes however the tree was made. */
static void the_hash_is_that_of_what_probes_store(void **state)
{
    (void)state;
    need_builds();
#define TREE   "scene:cornell:60 -d 4 --need rays"
#define PROBES " --probes 2,1,1 --probe-resolution 64 --probe-field 8"
    run_well("$SVOCL build " TREE " -o a.svo --quiet");
    run_well("test $($SVOCL hash " TREE PROBES ") = $($SVOCL hash a.svo" PROBES ")");
    run_well("test $($SVOCL hash a.svo" PROBES ") = $($SVOCL hash " TREE " --builder sorted" PROBES ")");
    run_well("test $($SVOCL hash a.svo" PROBES ") != $($SVOCL hash a.svo --probes 2,1,1 --probe-resolution 80)");
    run_well("test $($SVOCL hash a.svo" PROBES ") != $($SVOCL hash a.svo)");
    cJSON *document = run_json("$SVOCL hash a.svo --json" PROBES);
    assert_string_equal(text_of(document, "probes"), "2,1,1");
    assert_int_equal(strlen(text_of(document, "hash")), 32);
    cJSON_Delete(document);
    run_badly("$SVOCL hash a.svo --nodes" PROBES, 2, "--probes and --nodes exclude each other");
    run_badly("$SVOCL hash a.svo --light faces" PROBES, 2, "--probes and --light exclude each other");
    run_badly("$SVOCL hash a.svo --probe-resolution 64", 2, "options of probes require --probes");
    run_badly("$SVOCL hash a.svo --probes 1,1,1 --probe-resolution 100", 1, "options.resolution 100");
    run_well("rm a.svo");
#undef PROBES
#undef TREE
}

static void what_does_not_apply_is_refused(void **state)
{
    (void)state;
    need_builds();
#define RENDER "$SVOCL render scene:cube -d 3 -o a.png "
    run_badly(RENDER "--probes 2,2,2", 2, "options of probes require --through probes");
    run_badly(RENDER "--probe-field 8", 2, "options of probes require --through probes");
    run_badly(RENDER "--through walls", 2, "--through 'walls' is none of tree, probes");
    run_badly(RENDER "--through probes --probes 2,2", 2, "--probes '2,2' is not X,Y,Z, each 1 to 65534");
    run_badly(RENDER "--through probes --probes 0,2,2", 2, "--probes '0,2,2' is not X,Y,Z");
    run_badly(RENDER "--through probes --probe-resolution 32", 2, "probe-resolution 32 is below 64");
    run_badly(RENDER "--through probes --probe-resolution 100", 1, "resolution 100");
    run_badly(RENDER "--through probes --probes 300,300,1", 1, "65534");
    run_badly(RENDER "--through probes --probes 8,8,8 --probe-resolution 1024", 1, "1073741824");
    run_badly(RENDER "--through probes --view level", 2, "views shaded, normal, depth and steps alone");
    run_badly(RENDER "--through probes --view full", 2, "views shaded, normal, depth and steps alone");
    run_badly(RENDER "--through probes --view normal --lights a.json", 2, "options of lights and cones require");
    run_badly("$SVOCL build scene:cube --through probes", 2, "--through does not apply");
#undef RENDER
    expect_files(NULL, 0);
}

TEST_GROUP(program_probes)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(colors_are_counted),
        IN_FOLDER(a_closed_room_has_no_holes),
        IN_FOLDER(a_scene_that_moves_nothing_looks_like_its_mesh),
        IN_FOLDER(probes_see_what_a_scene_places),
        IN_FOLDER(probes_in_solids_know_nothing),
        IN_FOLDER(probes_are_lit),
        IN_FOLDER(the_hash_is_that_of_what_probes_store),
        IN_FOLDER(what_does_not_apply_is_refused),
    };
    return cmocka_run_group_tests_name("program_probes", tests, NULL, NULL);
}
