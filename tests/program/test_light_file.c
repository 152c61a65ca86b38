/* SPDX-License-Identifier: MIT */
/*
 * Light as a user asks for it: `svocl render --view ao, direct, gi, specular, full`, `svocl gather`, what both choose
 * where nothing is given, and files of lights, in which whatever is wrong is one line with its place.
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
         "lights.json:2: kind 'spott' of a light is none of directional, point, spot, disk, did you mean 'spot'?"},
        {"{\"lights\": [{\"kind\": \"point\",\n\"direction\": [0, 1, 0]}]}",
         "lights.json:2: key 'direction' of a point light is none of kind, position, value, radius"},
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
        {"{\"lights\": [{\"kind\": \"point\", \"position\": [0, 0, 0], \"value\": [1, 1, 1],\n\"radius\": -1}]}",
         "lights.json:2: 'radius' is not a number of at least 0"},
        {"{\"lights\": [{\"kind\": \"directional\", \"direction\": [0, 1, 0], \"value\": [1, 1, 1],\n"
         "\"angular_radius\": 90}]}",
         "lights.json:2: 'angular_radius' is not a number of degrees within 0 .. 89.9"},
        {"{\"lights\": [{\"kind\": \"disk\", \"position\": [0, 0, 0], \"value\": [1, 1, 1],\n"
         "\"inner_angle\": 1}]}",
         "lights.json:2: key 'inner_angle' of a disk light is none of kind, position, direction, value, radius"},
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

/* By light that views may be compared by. */
static double plain(const char *view)
{
    char options[128];
    snprintf(options, sizeof options, "--exposure 1 %s", view);
    return brightness(options);
}

/* Each view by itself, in every form; what is switched off is dark. */
static void views_show_their_light(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:atrium:5000 -d 5 --need color,normal,rays,projected-area -o a.svo -q");
    write_text("lights.json", "{\"lights\": [" SUN "], \"sky\": [0, 0, 0],\n"
                              " \"camera\": {\"eye\": [0, 1.6, 6], \"at\": [0, 1.5, -3], \"fov\": 60}}");
    const double direct = plain("--view direct");
    const double indirect = plain("--view gi");
    const double full = plain("--view full");
    assert_true(direct > 5 && indirect > 5 && full > direct && full > indirect);
    assert_true(plain("--view ao") > 30);
    assert_float_equal(plain("--view specular"), 0, 1e-9);
    assert_float_equal(plain("--view full --gi off"), direct, 1e-9);
    assert_float_equal(plain("--view gi --photons off"), 0, 1e-9);
    assert_float_equal(plain("--view full --photons off"), direct, 1e-9);
    assert_true(plain("--view gi --form bricks") > 5);
    assert_true(plain("--view gi --form voxels") > 5);
    assert_true(plain("--view ao --opacity full") < plain("--view ao") - 1);
    assert_float_equal(plain("--view ao --opacity area"), plain("--view ao"), 1e-9);
    assert_true(plain("--view ao --range 0.5") > plain("--view ao --range 0") + 5);
    assert_true(plain("--view ao --range 0 --lambda 4") > plain("--view ao --range 0") + 5);
    assert_true(brightness("--view full --exposure 3") > full + 10);
    run_well("$SVOCL render a.svo -q --view full --lights lights.json --size 32x24 -o a.png");
    run_well("$SVOCL render a.svo -q --view full --lights lights.json --size 32x24 -o b.png && cmp a.png b.png");
    cJSON *document = run_json("$SVOCL render a.svo --view full --cones 5 --lights lights.json --size 16x16 --json "
                               "-o a.png");
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

/* ---- what is chosen ---- */

static void write_lights(double sun, double sky)
{
    char text[320];
    snprintf(text, sizeof text,
             "{\"lights\": [{\"kind\": \"directional\", \"direction\": [-0.3, -1, -0.2], \"value\": [%g, %g, %g]}],\n"
             " \"sky\": [%g, %g, %g], \"camera\": {\"eye\": [0, 1.6, 6], \"at\": [0, 1.5, -3], \"fov\": 60}}",
             sun, sun, sun, sky, sky, sky);
    write_text("lights.json", text);
}

static double exposure_of(const char *options)
{
    char line[256];
    snprintf(line, sizeof line,
             "$SVOCL render a.svo --lights lights.json --size 32x24 --cones 5 --json -o a.png --view full %s", options);
    cJSON *document = run_json(line);
    assert_true(cJSON_IsTrue(cJSON_GetObjectItem(document, "exposure_is_automatic")));
    const double exposure = number_of(document, "exposure");
    cJSON_Delete(document);
    return exposure;
}

/* A dim scene looks as a bright one, and what was chosen can be asked for. */
static void exposure_suits_the_light_in_view(void **state)
{
    (void)state;
    char line[256];
    need_builds();
    run_well("$SVOCL build scene:atrium:5000 -d 5 --need color,normal,rays,projected-area -o a.svo -q");
    write_lights(3, 0.5);
    const double bright = exposure_of("");
    write_lights(0.003, 0.0005);
    const double dim = exposure_of("");
    if (!(dim > 980 * bright && dim < 1020 * bright)) {
        fail_msg("exposure %g, and %g of a thousandth of the light", bright, dim);
    }
    const double shown = brightness("--view full");
    if (!(shown > 70 && shown < 190 && plain("--view full") < 20)) {
        fail_msg("brightness %g", shown);
    }
    run_well("$SVOCL render a.svo --view full --lights lights.json --size 32x24 -o a.png --threads 1");
    assert_non_null(strstr(last.output, "(automatic)"));
    const char *words = strstr(last.output, "; exposure ");
    double printed = 0;
    assert_true(words != NULL && sscanf(words, "; exposure %lf", &printed) == 1);
    snprintf(line, sizeof line,
             "$SVOCL render a.svo --view full --lights lights.json --size 32x24 -o b.png --exposure %g", printed);
    run_well(line);
    assert_null(strstr(last.output, "automatic"));
    run_well("cmp a.png b.png");
    const double turning = exposure_of("--turntable 2");
    run_well("mv a-0001.png c.png && mv a-0002.png d.png");
    snprintf(line, sizeof line,
             "$SVOCL render a.svo -q --view full --lights lights.json --size 32x24 --cones 5 -o a.png --turntable 2 "
             "--exposure %g && cmp a-0001.png c.png && cmp a-0002.png d.png",
             turning);
    run_well(line);
    run_well("$SVOCL render a.svo --view full --lights lights.json --size 32x24 -o a.hdr && rm a.hdr");
    assert_non_null(strstr(last.output, "exposure 1\n"));
    write_lights(0, 0);
    run_well("$SVOCL render a.svo --view full --lights lights.json --size 32x24 -o a.png");
    assert_non_null(strstr(last.output, "exposure 1 (automatic)"));
    assert_non_null(strstr(last.output, "The picture is black"));
    run_well("rm a.png b.png c.png d.png a-0001.png a-0002.png a.svo lights.json");
}

/* Looks from the bottom of a room at its wall. */
static void expect_lit_by(const char *input, const char *expected, float sun[3])
{
    char line[256];
    snprintf(line, sizeof line,
             "$SVOCL render --view full %s --eye 0.5,0.6,0.8 --at 0.5,0.4,0.2 --size 32x24 --cones 5 --json -o a.png",
             input);
    cJSON *document = run_json(line);
    assert_string_equal(text_of(document, "lit_by"), expected);
    for (int axis = 0; axis < 3 && sun != NULL; ++axis) {
        sun[axis] = (float)cJSON_GetArrayItem(array_of(document, "sun"), axis)->valuedouble;
    }
    cJSON_Delete(document);
    const double shown = take_brightness("a.png");
    if (!(shown > 30 && shown < 230)) {
        fail_msg("%s: brightness %g", input, shown);
    }
}

/* Four walls and a floor, 1 x 4 x 1. */
#define WALLS                                                                  \
    "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 4 0\nv 1 4 0\nv 1 4 1\nv 0 4 1\n" \
    "f 1 2 3 4\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"

/* Whatever is in view is lit: by a sun from where it comes in, by what shines in a closed room, or by a lamp. */
static void default_lights_reach_what_is_in_view(void **state)
{
    (void)state;
    float sun[3];
    need_builds();
    write_text("pit.obj", WALLS);
    write_text("room.obj", WALLS "f 5 6 7 8\n");
    write_text("m.mtl", "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0 0 0\nKe 4 4 4\n");
    write_text("lit.obj", "mtllib m.mtl\nusemtl wall\n" WALLS "usemtl lamp\nf 5 6 7 8\n");
    expect_lit_by("pit.obj -d 6", "sun", sun);
    assert_true(sun[1] < -0.9F);
    expect_lit_by("room.obj -d 6", "lamp", NULL);
    expect_lit_by("lit.obj -d 6", "emitters", NULL);
    expect_lit_by("lit.obj -d 6 --view direct", "lamp", NULL);
    run_well("$SVOCL build room.obj -d 5 --need normal -o room.svo -q");
    expect_lit_by("room.svo", "lamp", NULL);
    run_well("$SVOCL render room.obj -d 6 --view full --eye 0.5,0.6,0.8 --at 0.5,0.4,0.2 --size 32x24 -o a.png");
    assert_non_null(strstr(last.output, "the scene is closed: lit by a lamp at the camera; --lights FILE sets others"));
    run_well("$SVOCL render room.obj -d 6 --view full --size 32x24 -o a.png");
    assert_non_null(strstr(last.output, "lit by a sun behind the camera and a sky"));
    run_well("rm a.png pit.obj room.obj room.svo lit.obj m.mtl");
}

/* Ambient occlusion reaches a tenth of the grid's width unless asked otherwise; light comes from anywhere. */
static void occlusion_has_a_range(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cornell:500 -d 5 --need rays,projected-area --origin -1,0,-1 --edge 2 -o a.svo -q");
    cJSON *document = run_json("$SVOCL render a.svo --view ao --size 32x24 --json -o a.png");
    assert_float_equal(number_of(document, "range"), 0.2, 1e-6);
    cJSON_Delete(document);
    run_well("$SVOCL render a.svo --view ao --size 32x24 --range 0.2 -q -o b.png && cmp a.png b.png");
    run_well("$SVOCL render a.svo --view ao --size 32x24 --range 0 -o b.png && ! cmp -s a.png b.png");
    assert_non_null(strstr(last.output, "ambient occlusion reaches any distance"));
    write_text("points.csv", "0.5,0,0.5,0,1,0\n0.8,0,-0.8,0,1,0\n");
    write_text("lights.json", "{\"sky\": [1, 1, 1]}");
#define GATHER "$SVOCL gather a.svo --points points.csv --lights lights.json -q "
    run_well(GATHER "-o a.csv && " GATHER "--range 0.2 -o b.csv && " GATHER "--range 0 -o c.csv");
#undef GATHER
    run_well("test \"$(cut -d, -f7 a.csv)\" = \"$(cut -d, -f7 b.csv)\"");
    run_well("test \"$(cut -d, -f8-10 a.csv)\" = \"$(cut -d, -f8-10 c.csv)\"");
    run_well("test \"$(cut -d, -f7 a.csv)\" != \"$(cut -d, -f7 c.csv)\"");
    run_well("rm a.svo a.png b.png a.csv b.csv c.csv points.csv lights.json");
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
    run_badly("$SVOCL verify scene:cube -d 2 --tree-form faces", 2, "--tree-form 'faces' is none of descriptor");
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
    run_well("$SVOCL gather sheets.obj -d 6 --points points.csv --range 0 -o a.csv");
    assert_non_null(strstr(last.output, "2 points lie outside the grid or have no normal"));
    char text[4096];
    read_text("a.csv", text, sizeof text);
    static const char heading[] = "x,y,z,nx,ny,nz,ao,r,g,b,specular_r,specular_g,specular_b,"
                                  "direct_r,direct_g,direct_b,ao_error,light_error\n";
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

/* What auto becomes follows from the options, and is told. */
static void the_method_is_told(void **state)
{
    (void)state;
    need_builds();
    static const struct {
        const char *options, *method;
    } cases[] = {{"", "rays"},
                 {"--error 0.1", "rays"},
                 {"--method auto --paths 16", "rays"},
                 {"--cones 5", "cones"},
                 {"--method cones", "cones"}};
    char line[200];
    char told[40];
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        (void)snprintf(line, sizeof line, "$SVOCL gather scene:cube -d 3 --points 4 %s -o a.csv", cases[i].options);
        (void)snprintf(told, sizeof told, "of scene:cube by %s in ", cases[i].method);
        run_well(line);
        assert_non_null(strstr(last.output, told));
        (void)strcat(line, " --json");
        cJSON *document = run_json(line);
        assert_string_equal(cJSON_GetObjectItem(document, "method")->valuestring, cases[i].method);
        cJSON_Delete(document);
    }
    run_well("$SVOCL render scene:cube -d 3 --view ao --size 16x16 -o a.png");
    assert_non_null(strstr(last.output, "of scene:cube by rays in "));
    run_well("rm a.csv a.png");
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
        snprintf(line, sizeof line, "$SVOCL gather %s --points 50 --cones 16 --json -o a.csv", cases[i].arguments);
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

/* Below a plate that emits lies one that reflects it: cones that look down see that with photons alone, twice as often
   reflected brighter still. */
static void emitters_shoot_photons(void **state)
{
    (void)state;
    need_builds();
    static const char *const arguments[] = {"", " --emission-photons 65536", " --emission-photons 65536 --bounces 4"};
    write_text("m.mtl", "newmtl wall\nKd 0.9 0.9 0.9\nnewmtl lamp\nKd 0.9 0.9 0.9\nKe 4 4 4\n");
    write_text("lit.obj",
               "mtllib m.mtl\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nv -2 1 -2\nv 2 1 -2\nv 2 1 2\nv -2 1 2\n"
               "usemtl wall\nf 4 3 2 1\nusemtl lamp\nf 5 6 7 8\n");
    write_text("points.csv", "0.1,1,0.1,0,-1,0\n");
    write_text("lights.json", "{\"lights\": []}");
    double red[3] = {-1, -1, -1};
    for (int i = 0; i < 3; ++i) {
        char line[256];
        char text[1024];
        snprintf(line, sizeof line,
                 "$SVOCL gather lit.obj -d 6 --points points.csv --lights lights.json --cones 16 --json -o a.csv%s",
                 arguments[i]);
        cJSON *document = run_json(line);
        assert_float_equal(number_of(document, "photons"), i > 0 ? 65536 : 0, 0);
        assert_true((number_of(document, "sent_photons") > 0) == (i == 2));
        cJSON_Delete(document);
        read_text("a.csv", text, sizeof text);
        assert_int_equal(sscanf(strchr(text, '\n') + 1, "%*f,%*f,%*f,%*f,%*f,%*f,%*f,%lf", &red[i]), 1);
    }
    if (!(red[0] < 0.01 && red[1] > 1 && red[2] > 1.2 * red[1])) {
        fail_msg("a lamp's own light is %g, with photons %g, by bounces %g", red[0], red[1], red[2]);
    }
    run_badly("$SVOCL render lit.obj -d 4 --emission-photons 5 -o a.png", 2, "options of lights and cones require");
    run_well("rm a.csv points.csv lights.json lit.obj m.mtl");
}

static void the_truth_stands_beside(void **state)
{
    (void)state;
    need_builds();
    write_text("lights.json", "{\"lights\": [" SUN "], \"sky\": [0.5, 0.5, 0.5]}");
    static const struct {
        const char *options;
        double openness, irradiance; /* the most */
    } cases[] = {{"--cones 16", 0.2, 0.6}, {"", 0.03, 0.15}, {"--bounces 3 --error .02 --paths 4096", 0.03, 0.1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char line[256];
        snprintf(line, sizeof line,
                 "$SVOCL gather scene:atrium:5000 -d 7 --points 100 --lights lights.json --reference 1024 --range 0 "
                 "--json -o a.csv %s",
                 cases[i].options);
        cJSON *document = run_json(line);
        assert_int_equal((int)number_of(document, "points"), 100);
        const double openness = number_of(document, "ao_rmse");
        const double irradiance = number_of(document, "irradiance_rmse");
        if (!(openness > 0 && openness < cases[i].openness && irradiance > 0 && irradiance < cases[i].irradiance)) {
            fail_msg("%s: RMSE of openness %g, of irradiance %g", cases[i].options, openness, irradiance);
        }
        cJSON_Delete(document);
    }
    char text[512];
    read_text("a.csv", text, sizeof text);
    assert_non_null(strstr(text, ",light_error,reference_ao,reference_r,reference_g,reference_b\n"));
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
                                       IN_FOLDER(exposure_suits_the_light_in_view),
                                       IN_FOLDER(default_lights_reach_what_is_in_view),
                                       IN_FOLDER(occlusion_has_a_range),
                                       IN_FOLDER(what_does_not_apply_is_refused),
                                       IN_FOLDER(points_are_gathered),
                                       IN_FOLDER(the_method_is_told),
                                       IN_FOLDER(leaves_are_as_opaque_as_asked),
                                       IN_FOLDER(emitters_shoot_photons),
                                       IN_FOLDER(the_truth_stands_beside)};
    return cmocka_run_group_tests_name("light_file", tests, NULL, NULL);
}
