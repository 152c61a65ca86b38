/* SPDX-License-Identifier: MIT */
/* `svocl render` as a user runs it: cameras that stand somewhere, of trees, compact trees, meshes and scenes; clay. */
#include "program_picture.h"
#include "run_program.h"
#include "support/suite.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- cameras ---- */

/* Every pixel has one color: the camera sees one wall of the hollow cube. */
static void expect_wall(const char *line, int red, int green, int blue)
{
    run_well(line);
    program_picture picture = read_picture("a.png");
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const uint8_t *pixel = pixel_of(&picture, x, y);
            if (abs(pixel[0] - red) > 1 || abs(pixel[1] - green) > 1 || abs(pixel[2] - blue) > 1) {
                fail_msg("%s: pixel %d, %d is %d %d %d, not %d %d %d", line, x, y, pixel[0], pixel[1], pixel[2], red,
                         green, blue);
                return;
            }
        }
    }
    free_picture(&picture);
    run_well("rm a.png");
}

/* The normals of a cube's walls as colors: the axis that the camera looks along is all or none of its channel. */
static void a_camera_inside_sees_the_walls(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cube -d 5 --need normal -o a.svo -q");
#define RENDER "$SVOCL render a.svo -q --view normal --size 24x16 -o a.png "
    expect_wall(RENDER "--eye 0.5,0.5,0.5 --at 1,0.5,0.5 --fov 40", 255, 128, 128);
    expect_wall(RENDER "--eye 0.5,0.5,0.5 --at=-1,0.5,0.5 --fov 40", 0, 128, 128);
    expect_wall(RENDER "--eye 0.6,0.5,0.6 --at 0.6,1,0.6 --up 0,0,1 --fov 40", 128, 255, 128);
    expect_wall(RENDER "--eye 0.5,0.5,0.2 --at 0.5,0.5,-1", 128, 128, 0);
#undef RENDER
    /* A wide angle sees more than one wall. */
    run_well("$SVOCL render a.svo -q --view normal --size 24x16 -o a.png --eye 0.5,0.5,0.5 --at 1,0.5,0.5 --fov 140");
    program_picture picture = read_picture("a.png");
    assert_memory_not_equal(pixel_of(&picture, 0, 8), pixel_of(&picture, 12, 8), 4);
    free_picture(&picture);
    run_well("rm a.png a.svo");
}

static void expect_vector(const cJSON *document, const char *name, double x, double y, double z)
{
    const cJSON *array = array_of(document, name);
    const double expected[3] = {x, y, z};
    for (int axis = 0; axis < 3; ++axis) {
        assert_float_equal(cJSON_GetArrayItem(array, axis)->valuedouble, expected[axis], 1e-6);
    }
}

/* Without options the camera frames the input, and moves there when asked to, whatever the input is. */
static void every_input_has_the_camera(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL scene cube -o cube.obj -q && $SVOCL build cube.obj -d 4 -o cube.svo -q");
    run_well("$SVOCL build cube.obj -d 4 --solid winding -o cube.svc -q");
    write_text("scene.json", "{\"trees\": {\"c\": {\"path\": \"cube.svo\"}}, \"instances\": [{\"tree\": \"c\"}],\n"
                             " \"camera\": {\"eye\": [0, 0, 5], \"target\": [0, 0, 0]}}");
    static const char *const inputs[] = {"cube.obj", "cube.svo", "cube.svc", "scene.json"};
    for (size_t i = 0; i < sizeof inputs / sizeof inputs[0]; ++i) {
        char line[256];
        snprintf(line, sizeof line, "$SVOCL render %s -o a.png --size 24x16 --json --eye 3,2.5,1 --at 0,0.5,0",
                 inputs[i]);
        cJSON *document = run_json(line);
        expect_vector(document, "eye", 3, 2.5, 1);
        expect_vector(document, "target", 0, 0.5, 0);
        cJSON_Delete(document);
    }
    cJSON *document = run_json("$SVOCL render scene.json -o a.png --size 24x16 --json --at 0,0.25,0");
    expect_vector(document, "eye", 0, 0, 5);
    expect_vector(document, "target", 0, 0.25, 0);
    cJSON_Delete(document);
    run_well("rm a.png cube.obj cube.svo cube.svc scene.json");
}

/* Pictures of levels are white where nothing is. */
static bool is_empty(const program_picture *picture, int x, int y)
{
    const uint8_t *pixel = pixel_of(picture, x, y);
    return pixel[0] == 255 && pixel[1] == 255 && pixel[2] == 255;
}

/* All of the input is in view, with room around it, and it spans two thirds of the picture's width or of its height. */
static void expect_framed(const char *input, const char *more)
{
    char line[512];
    snprintf(line, sizeof line, "$SVOCL render '%s' -q --view level -o a.png %s", input, more);
    run_well(line);
    program_picture picture = read_picture("a.png");
    int low[2] = {picture.width, picture.height};
    int high[2] = {0, 0};
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            if (!is_empty(&picture, x, y)) {
                low[0] = x < low[0] ? x : low[0];
                low[1] = y < low[1] ? y : low[1];
                high[0] = x >= high[0] ? x + 1 : high[0];
                high[1] = y >= high[1] ? y + 1 : high[1];
            }
        }
    }
    const bool is_inside = low[0] > 0 && low[1] > 0 && high[0] < picture.width && high[1] < picture.height;
    if (!is_inside || (3 * (high[0] - low[0]) < 2 * picture.width && 3 * (high[1] - low[1]) < 2 * picture.height)) {
        fail_msg("%s: it is in columns %d .. %d and rows %d .. %d of %d x %d", line, low[0], high[0] - 1, low[1],
                 high[1] - 1, picture.width, picture.height);
    }
    free_picture(&picture);
    run_well("rm a.png");
}

static void a_framed_input_fills_the_picture_whatever_is_up(void **state)
{
    (void)state;
    need_builds();
    static const char *const options[] = {"--size 96x64", "--size 64x96 --up 0,0,1", "--size 96x64 --up=-1,2,0.5",
                                          "--size 128x128 --up 0,-1,0 --fov 100", "--size 200x50 --fov 5"};
    /* A small part of the grid, and long thin things. */
    run_well("$SVOCL build scene:knot -d 8 --origin=-9,-9,-9 --edge 40 --need none -o small.svo -q");
    static const char *const inputs[] = {"scene:knot", "scene:needles", "scene:statue:2000", "small.svo"};
    for (size_t i = 0; i < sizeof inputs / sizeof inputs[0]; ++i) {
        for (size_t k = 0; k < sizeof options / sizeof options[0]; ++k) {
            expect_framed(inputs[i], options[k]);
        }
    }
    run_well("rm small.svo");
}

/* What is in view has the whole range, whatever its size in the world, and a bar says what the ends are. */
static void pictures_of_numbers_have_the_scale_of_what_is_in_view(void **state)
{
    (void)state;
    need_builds();
    static const char *const views[] = {"depth", "steps"};
    write_text("small.obj", "v 0 0 0\nv 0.003 0 0\nv 0 0.003 0\nv 0 0 0.003\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n");
    for (size_t i = 0; i < 2; ++i) {
        char line[256];
        snprintf(line, sizeof line, "$SVOCL render small.obj -d 6 --json -o a.png --size 320x240 --view %s", views[i]);
        cJSON *document = run_json(line);
        const cJSON *range = array_of(document, "range");
        const double low = cJSON_GetArrayItem(range, 0)->valuedouble;
        const double high = cJSON_GetArrayItem(range, 1)->valuedouble;
        assert_string_equal(text_of(document, "range_unit"), i == 0 ? "world units" : "steps");
        /* A tetrahedron of that size is not deeper than its longest edge, and no ray passes more than all cells. */
        assert_true(i == 0 ? low > 0 && high - low > 0.001 && high - low < 0.0045
                           : low == 0 && high >= 1 && high < 200);
        cJSON_Delete(document);
        program_picture picture = read_picture("a.png");
        const uint8_t paper[4] = {255, 255, 255, 255};
        assert_memory_equal(pixel_of(&picture, 6, 234), paper, 4);
        int darkest = 255;
        int brightest = 0;
        for (int y = 0; y < 200; ++y) { /* above the bar */
            for (int x = 0; x < picture.width; ++x) {
                const uint8_t *pixel = pixel_of(&picture, x, y);
                if (memcmp(pixel, paper, 3) != 0) {
                    darkest = pixel[0] < darkest ? pixel[0] : darkest;
                    brightest = pixel[0] > brightest ? pixel[0] : brightest;
                }
            }
        }
        assert_true(darkest < 50 && brightest > 230);
        free_picture(&picture);
    }
    run_well("rm a.png small.obj");
}

static void models_of_other_people_fill_the_picture(void **state)
{
    (void)state;
    need_builds();
    DIR *folder = opendir(SHARED_SCENES "/vox");
    if (folder == NULL) {
        print_message("skipped: %s is not there\n", SHARED_SCENES "/vox");
        skip();
    }
    for (const struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
        if (entry->d_name[0] != '.') {
            char path[1024];
            snprintf(path, sizeof path, "%s/%s", SHARED_SCENES "/vox", entry->d_name);
            expect_framed(path, "--size 96x72");
            expect_framed(path, "--size 96x72 --up 0,0,1");
        }
    }
    closedir(folder);
}

static void a_wrong_camera_is_one_line(void **state)
{
    (void)state;
    need_builds();
#define RENDER "$SVOCL render scene:cube -d 2 -o a.png "
    run_badly(RENDER "--eye 1,2", 2, "--eye '1,2' is not X,Y,Z, each within 1e+18");
    run_badly(RENDER "--at 1,nan,2", 2, "--at '1,nan,2' is not X,Y,Z");
    run_badly(RENDER "--eye 1e19,0,0", 2, "--eye '1e19,0,0' is not X,Y,Z, each within 1e+18");
    run_badly(RENDER "--up 0,0,0", 2, "--up 0,0,0 is along the line of sight");
    run_badly(RENDER "--eye 0,5,0 --at 0,1,0", 2, "--up 0,1,0 is along the line of sight from 0,5,0 to 0,1,0");
    run_badly(RENDER "--eye 1,1,1 --at 1,1,1", 2, "--eye 1,1,1 is where the camera looks at");
    run_badly(RENDER "--fov 0", 2, "--fov '0' is not a number of degrees within 0.01 .. 179");
    run_badly(RENDER "--fov 180", 2, "--fov '180' is not a number of degrees");
    run_badly(RENDER "--fov wide", 2, "--fov 'wide' is not a number of degrees");
    run_badly("$SVOCL build scene:cube -d 2 --eye 1,1,1", 2, "--eye does not apply");
#undef RENDER
    expect_files(NULL, 0);
}

/* ---- what meshes look like ---- */

/* A square that fills the picture and faces the camera, of a material or of none. */
static void write_square(const char *path, const char *head)
{
    char text[512];
    snprintf(text, sizeof text, "%sv -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nf 1 2 3\nf 1 3 4\n", head);
    write_text(path, text);
}

static double brightness(const char *line)
{
    run_well(line);
    return take_brightness("a.png");
}

/* A mesh without colors is clay, darker than a white one, and neither is burnt; a black one stays black. */
static void meshes_without_colors_are_clay(void **state)
{
    (void)state;
    need_builds();
    write_text("m.mtl", "newmtl white\nKd 1 1 0.98\nnewmtl black\nKd 0 0 0\n");
    write_square("clay.obj", "");
    write_square("white.obj", "mtllib m.mtl\nusemtl white\n");
    write_square("black.obj", "mtllib m.mtl\nusemtl black\n");
#define CAMERA " -d 5 -q -o a.png --size 16x16 --eye 0,0,3 --at 0,0,0 --fov 40"
    const double clay = brightness("$SVOCL render clay.obj" CAMERA);
    const double white = brightness("$SVOCL render white.obj" CAMERA);
    const double black = brightness("$SVOCL render black.obj" CAMERA);
    assert_float_equal(brightness("$SVOCL render clay.obj --need color,normal" CAMERA), clay, 1e-9);
#undef CAMERA
    if (!(clay > 130 && clay < white - 10 && white < 254 && black < 1)) {
        fail_msg("clay %g, white %g, black %g", clay, white, black);
    }
    run_well("rm m.mtl clay.obj white.obj black.obj");
}

/* With room for all of the file the picture is that of the whole tree; with less there is one too, and it says so. */
static void a_file_in_pages(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:statue:3000 -d 7 -o a.svo -q && $SVOCL build scene:cube -d 5 -o c.svo --compress -q");
    run_well("$SVOCL render a.svo -q --size 64x48 -o whole.png");
    run_well("$SVOCL render a.svo -q --size 64x48 -o paged.png --paged 1G && cmp whole.png paged.png");
    cJSON *document = run_json("$SVOCL render a.svo --json --size 64x48 -o paged.png --paged 60K");
    const double device_bytes = number_of(document, "device_bytes");
    assert_true(device_bytes > 0 && device_bytes <= 60 * 1024);
    assert_true(number_of(document, "pages") > number_of(document, "held_pages"));
    assert_true(number_of(document, "pictures") > 1);
    assert_true(number_of(document, "missed_pages") > 0);
    cJSON_Delete(document);
    run_badly("$SVOCL render a.svo -o p.png --paged 100", 1, "budget_bytes 100 is below");
    run_badly("$SVOCL render c.svo -o p.png --paged 4K", 1, "is compressed");
    run_badly("$SVOCL render scene:cube -o p.png --paged 1M", 2, "--paged reads a .svo file");
    run_badly("$SVOCL render a.svo -o p.png --paged 1M --levels 3", 2, "--levels with --paged applies to folders");
    run_badly("$SVOCL render a.svo -o p.png --paged 1M --view triangles", 2, "--paged has the views shaded");
    run_badly("$SVOCL render a.svo -o p.png --paged 1M -d 3", 2, "build options do not apply");
    run_well("rm a.svo c.svo whole.png paged.png");
}

TEST_GROUP(program_render)
{
    const struct CMUnitTest tests[] = {IN_FOLDER(a_file_in_pages),
                                       IN_FOLDER(a_camera_inside_sees_the_walls),
                                       IN_FOLDER(every_input_has_the_camera),
                                       IN_FOLDER(a_framed_input_fills_the_picture_whatever_is_up),
                                       IN_FOLDER(pictures_of_numbers_have_the_scale_of_what_is_in_view),
                                       IN_FOLDER(models_of_other_people_fill_the_picture),
                                       IN_FOLDER(a_wrong_camera_is_one_line),
                                       IN_FOLDER(meshes_without_colors_are_clay)};
    return cmocka_run_group_tests_name("program_render", tests, NULL, NULL);
}
