/* SPDX-License-Identifier: MIT */
/* `svocl render` as a user runs it: cameras that stand somewhere, of trees, compact trees, meshes and scenes; clay. */
#include "program_picture.h"
#include "run_program.h"

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
    run_badly("$SVOCL render a.svo -o p.png --paged 1M --levels 3", 2, "--levels does not apply with --paged");
    run_badly("$SVOCL render a.svo -o p.png --paged 1M --view triangles", 2, "--paged has the views shaded");
    run_badly("$SVOCL render a.svo -o p.png --paged 1M -d 3", 2, "build options do not apply");
    run_well("rm a.svo c.svo whole.png paged.png");
}

int main(void)
{
    const struct CMUnitTest tests[] = {IN_FOLDER(a_file_in_pages), IN_FOLDER(a_camera_inside_sees_the_walls),
                                       IN_FOLDER(every_input_has_the_camera), IN_FOLDER(a_wrong_camera_is_one_line),
                                       IN_FOLDER(meshes_without_colors_are_clay)};
    return cmocka_run_group_tests_name("render", tests, NULL, NULL);
}
