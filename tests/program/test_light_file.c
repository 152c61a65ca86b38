/* SPDX-License-Identifier: MIT */
/*
 * Light as a user asks for it: `svocl render --view ao, direct, gi, specular, full`, `svocl gather`, and files of
 * lights, in which whatever is wrong is one line with its place.
 */
#include "program_picture.h"
#include "run_program.h"
#include "support/suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SUN "{\"kind\": \"directional\", \"direction\": [-0.3, -1, -0.2], \"value\": [2, 2, 2]}"

/* ---- files ---- */

static void a_wrong_file_is_one_line_with_its_place(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } wrong[] = {
        {"", "lights.json:1: not JSON"},
        {"{\n\"lights\": [\n{\"kind\": \"point\", \"position\": [0, NaN, 0], \"value\": [1, 1, 1]}]}",
         "lights.json:3: not JSON"},
        {"{\n\"lights\": [],\n\"skye\": [1, 1, 1]}",
         "lights.json:3: key 'skye' of the file is none of lights, sky, camera, did you mean 'sky'?"},
        {"{\"lights\": {}}", "lights.json:1: 'lights' is not an array of at most 1024 lights"},
        {"{\"lights\": [\n7]}", "lights.json:2: a light is not an object"},
        {"{\"lights\": [\n{\"value\": [1, 1, 1]}]}", "lights.json:2: 'kind' of a light is missing or not a text"},
        {"{\"lights\": [{\n\"kind\": \"spott\"}]}",
         "lights.json:2: kind 'spott' of a light is none of directional, point, spot, did you mean 'spot'?"},
        {"{\"lights\": [{\"kind\": \"point\",\n\"direction\": [0, 1, 0]}]}",
         "lights.json:2: key 'direction' of a point light is none of kind, position, value"},
        {"{\"lights\": [\n{\"kind\": \"point\", \"value\": [1, 1, 1]}]}",
         "lights.json:2: a point light has no 'position'"},
        {"{\"lights\": [{\"kind\": \"directional\",\n\"direction\": [0, 0, 0], \"value\": [1, 1, 1]}]}",
         "lights.json:2: 'direction' is zero"},
        {"{\"lights\": [{\"kind\": \"directional\", \"direction\": [0, 1],\n\"value\": [1, 1, 1]}]}",
         "lights.json:1: 'direction' is not an array of 3 numbers"},
        {"{\"lights\": [{\"kind\": \"directional\", \"direction\": [0, -1, 0], \"value\":\n[1,\n1,\n-2]}]}",
         "lights.json:4: number 3 of 'value' is -2, below 0"},
        {"{\"lights\": [{\"kind\": \"point\", \"position\": [0, 1e999, 0],\n\"value\": [1, 1, 1]}]}",
         "lights.json:1: number 2 of 'position'"},
        {"{\"lights\": [{\"kind\": \"spot\", \"position\": [0, 0, 0], \"direction\": [0, -1, 0], \"value\": [1, 1, "
         "1],\n"
         "\"inner_angle\": 30,\n\"outer_angle\": 30}]}",
         "lights.json:2: 'inner_angle' 30 is not below 'outer_angle' 30"},
        {"{\"lights\": [{\"kind\": \"spot\", \"position\": [0, 0, 0], \"direction\": [0, -1, 0], \"value\": [1, 1, "
         "1],\n"
         "\"inner_angle\": 30,\n\"outer_angle\": 90}]}",
         "lights.json:3: 'outer_angle' is not a number of degrees within 0 .. 89.9"},
        {"{\n\"sky\": [0, 0, -1]}", "lights.json:2: number 3 of 'sky' is -1, below 0"},
        {"{\n\"camera\": {\"eye\": [0, 0, 1]}}", "lights.json:2: 'camera' has no 'at'"},
        {"{\"camera\": {\"eye\": [0, 0, 1],\n\"target\": [0, 0, 0]}}",
         "lights.json:2: key 'target' of 'camera' is none of"},
        {"{\"camera\": {\"eye\": [0, 0, 1], \"at\": [0, 0, 0],\n\"fov\": 180}}",
         "lights.json:2: 'fov' is not a number of degrees within 0.01 .. 179"},
        {"{\"sky\": [0, 0, 0],\n\"sky\": [0, 0, 0]}", "lights.json:2: a second 'sky'"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        write_text("lights.json", wrong[i].text);
        run_badly("$SVOCL render scene:cube -d 2 --view full --lights lights.json -o a.png", 1, wrong[i].words);
    }
    run_badly("$SVOCL gather scene:cube -d 2 --points 1 --lights none.json -o a.csv", 1, "none.json: No such file");
    static const char *const written[] = {"lights.json"};
    expect_files(written, 1);
}

/* ---- pictures ---- */

static double brightness(const char *view)
{
    char line[256];
    snprintf(line, sizeof line, "$SVOCL render a.svo -q --lights lights.json --size 32x24 --cones 5 -o a.png %s", view);
    run_well(line);
    return take_brightness("a.png");
}

/* Each view by itself, in every form; what is switched off is dark. */
static void views_show_their_light(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:atrium:5000 -d 5 --need color,normal,rays,projected-area -o a.svo -q");
    write_text("lights.json", "{\"lights\": [" SUN "], \"sky\": [0, 0, 0],\n"
                              " \"camera\": {\"eye\": [0, 1.6, 6], \"at\": [0, 1.5, -3], \"fov\": 60}}");
    const double direct = brightness("--view direct");
    const double indirect = brightness("--view gi");
    const double full = brightness("--view full");
    assert_true(direct > 5 && indirect > 5 && full > direct && full > indirect);
    assert_true(brightness("--view ao") > 30);
    assert_float_equal(brightness("--view specular"), 0, 1e-9);
    assert_float_equal(brightness("--view full --gi off"), direct, 1e-9);
    assert_float_equal(brightness("--view gi --photons off"), 0, 1e-9);
    assert_float_equal(brightness("--view full --photons off"), direct, 1e-9);
    assert_true(brightness("--view gi --form bricks") > 5);
    assert_true(brightness("--view gi --form voxels") > 5);
    assert_true(brightness("--view ao --opacity full") < brightness("--view ao") - 1);
    assert_float_equal(brightness("--view ao --opacity area"), brightness("--view ao"), 1e-9);
    assert_true(brightness("--view ao --range 0.5") > brightness("--view ao") + 5);
    assert_true(brightness("--view ao --lambda 4") > brightness("--view ao") + 5);
    assert_true(brightness("--view full --exposure 3") > full + 10);
    run_well("$SVOCL render a.svo -q --view full --lights lights.json --size 32x24 -o a.png");
    run_well("$SVOCL render a.svo -q --view full --lights lights.json --size 32x24 -o b.png && cmp a.png b.png");
    cJSON *document = run_json("$SVOCL render a.svo --view full --lights lights.json --size 16x16 --json -o a.png");
    assert_string_equal(text_of(document, "form"), "faces");
    assert_true(number_of(document, "photons") > 0 && number_of(document, "lit_leaves") > 0);
    assert_true(number_of(document, "lit_nodes") > number_of(document, "lit_leaves"));
    assert_true(number_of(document, "missed_leaves") > 0);
    assert_float_equal(cJSON_GetArrayItem(array_of(document, "eye"), 2)->valuedouble, 6, 1e-6);
    cJSON_Delete(document);
    run_well("rm a.png b.png a.svo lights.json");
}

/* Without a file there is a sun; voxels and meshes are lit alike. */
static void every_input_is_lit(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cube -d 4 --solid winding -o a.svc -q");
    run_well("$SVOCL convert a.svc a.vox -q");
    static const char *const inputs[] = {"scene:cube -d 4", "a.svc", "a.vox"};
    for (size_t i = 0; i < sizeof inputs / sizeof inputs[0]; ++i) {
        char line[256];
        snprintf(line, sizeof line, "$SVOCL render %s -q --view full --cones 5 --size 24x16 -o a.png", inputs[i]);
        run_well(line);
        program_picture picture = read_picture("a.png");
        assert_memory_not_equal(pixel_of(&picture, 12, 8), pixel_of(&picture, 0, 0), 4);
        free_picture(&picture);
    }
    run_well("rm a.png a.svc a.vox");
}

static void what_does_not_apply_is_refused(void **state)
{
    (void)state;
    need_builds();
    run_badly("$SVOCL render scene:cube -d 2 --cones 5 -o a.png", 2, "options of lights and cones require --view ao");
    run_badly("$SVOCL render scene:cube -d 2 --view full --cones 7 -o a.png", 2, "--cones '7' is none of 1, 5, 6, 16");
    run_badly("$SVOCL render scene:cube -d 2 --view full --form brick -o a.png", 2, "did you mean 'bricks'?");
    run_badly("$SVOCL render scene:cube -d 2 --view full --photons no -o a.png", 2,
              "--photons 'no' is none of on, off");
    run_badly("$SVOCL render scene:cube -d 2 --view ao --opacity half -o a.png", 2,
              "--opacity 'half' is none of area, full");
    run_badly("$SVOCL render scene:cube -d 2 --opacity full -o a.png", 2, "options of lights and cones require");
    run_badly("$SVOCL render scene:cube -d 2 --view ao --range=-1 -o a.png", 2, "--range '-1' is not a number");
    run_badly("$SVOCL gather scene:cube -d 2 -o a.csv", 2, "--points FILE is missing");
    run_badly("$SVOCL gather scene:cube -d 2 --points 3", 2, "-o FILE is missing");
    run_badly("$SVOCL verify scene:cube -d 2 --form faces", 2, "--form 'faces' is none of descriptor");
    expect_files(NULL, 0);
}

/* ---- points ---- */

/* A point between two sheets is closed in, one above both is open. Points outside the grid or without a normal are
   open, and counted. */
static void points_are_gathered(void **state)
{
    (void)state;
    need_builds();
    write_text("sheets.obj", "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nv -2 0.4 -2\nv 2 0.4 -2\nv 2 0.4 2\nv -2 0.4 2\n"
                             "f 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\n");
    write_text("points.csv", "x,y,z,nx,ny,nz\n0.1,0,0.1,0,1,0\n0.1,0.4,0.1,0,1,0\n0.1,0,0.1,0,0,0\n9,9,9,0,1,0\n");
    run_well("$SVOCL gather sheets.obj -d 6 --points points.csv -o a.csv");
    assert_non_null(strstr(last.output, "2 points lie outside the grid or have no normal"));
    char text[4096];
    read_text("a.csv", text, sizeof text);
    static const char heading[] = "x,y,z,nx,ny,nz,ao,r,g,b,specular_r,specular_g,specular_b\n";
    assert_memory_equal(text, heading, sizeof heading - 1);
    double openness[4] = {-1, -1, -1, -1};
    const char *line = strchr(text, '\n') + 1;
    for (int i = 0; i < 4; ++i) {
        assert_int_equal(sscanf(line, "%*f,%*f,%*f,%*f,%*f,%*f,%lf", &openness[i]), 1);
        line = strchr(line, '\n') + 1;
    }
    if (!(openness[0] < 0.15 && openness[1] > 0.95)) {
        fail_msg("openness %g between the sheets, %g above", openness[0], openness[1]);
    }
    assert_float_equal(openness[2], 1, 1e-9);
    assert_float_equal(openness[3], 1, 1e-9);
    run_well("rm a.csv points.csv sheets.obj");
}

/* Areas are built where the opacity needs them, and trees without them are opaque from every side. */
static void leaves_are_as_opaque_as_asked(void **state)
{
    (void)state;
    need_builds();
    static const struct {
        const char *arguments, *opacity;
    } cases[] = {{"scene:cornell:500 -d 5", "area"},
                 {"scene:cornell:500 -d 5 --opacity area", "area"},
                 {"scene:cornell:500 -d 5 --opacity full", "full"},
                 {"scene:cornell:500 -d 5 --need normal", "full"}};
    double openness[4];
    for (size_t i = 0; i < 4; ++i) {
        char line[256];
        snprintf(line, sizeof line, "$SVOCL gather %s --points 50 --json -o a.csv", cases[i].arguments);
        cJSON *document = run_json(line);
        assert_string_equal(text_of(document, "opacity"), cases[i].opacity);
        openness[i] = number_of(document, "ao");
        cJSON_Delete(document);
    }
    assert_float_equal(openness[0], openness[1], 1e-9);
    assert_float_equal(openness[2], openness[3], 1e-9);
    assert_true(openness[2] < openness[0] - 1e-3);
    run_well("rm a.csv");
}

static void the_truth_stands_beside(void **state)
{
    (void)state;
    need_builds();
    write_text("lights.json", "{\"lights\": [" SUN "], \"sky\": [0.5, 0.5, 0.5]}");
    cJSON *document = run_json("$SVOCL gather scene:atrium:5000 -d 7 --points 100 --lights lights.json --reference 256 "
                               "--json -o a.csv");
    assert_int_equal((int)number_of(document, "points"), 100);
    const double openness = number_of(document, "ao_rmse");
    const double irradiance = number_of(document, "irradiance_rmse");
    if (!(openness > 0 && openness < 0.2 && irradiance > 0 && irradiance < 0.6)) {
        fail_msg("RMSE of openness %g, of irradiance %g", openness, irradiance);
    }
    cJSON_Delete(document);
    char text[512];
    read_text("a.csv", text, sizeof text);
    assert_non_null(strstr(text, ",specular_b,reference_ao,reference_r,reference_g,reference_b\n"));
    run_well("$SVOCL build scene:cube -d 3 -o a.svo -q");
    run_badly("$SVOCL gather a.svo --points 3 --reference 64 -o b.csv", 2, "a.svo is a finished tree: --reference");
    run_badly("$SVOCL gather a.svo --points 3 -o b.csv", 2, "--points 3 needs a mesh to spread points over");
    run_well("rm a.csv a.svo lights.json");
}

TEST_GROUP(light_file)
{
    const struct CMUnitTest tests[] = {IN_FOLDER(a_wrong_file_is_one_line_with_its_place),
                                       IN_FOLDER(views_show_their_light),
                                       IN_FOLDER(every_input_is_lit),
                                       IN_FOLDER(what_does_not_apply_is_refused),
                                       IN_FOLDER(points_are_gathered),
                                       IN_FOLDER(leaves_are_as_opaque_as_asked),
                                       IN_FOLDER(the_truth_stands_beside)};
    return cmocka_run_group_tests_name("light_file", tests, NULL, NULL);
}
