/* SPDX-License-Identifier: MIT */
/* Scenes as files: svocl render SCENE.json. What is placed is seen, and whatever is wrong is one line with its place.
   */
#include "run_program.h"
#include "support/suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A tree and an instance, into which the tests put something wrong. */
#define TREES     "\"trees\": {\"cube\": {\"path\": \"scene:cube\", \"depth\": 3}}"
#define INSTANCES "\"instances\": [{\"tree\": \"cube\"}]"

static void scenes_are_rendered(void **state)
{
    (void)state;
    need_builds();
    run_well("mkdir models && $SVOCL build scene:knot:500 -d 4 -o models/knot.svo");
    write_text("models/scene.json",
               "{\"trees\": {\"a\": {\"path\": \"knot.svo\"}, \"b\": {\"path\": \"scene:cube\", \"depth\": 3}},\n"
               " \"instances\": [\n"
               "   {\"tree\": \"a\", \"translate\": [0, 2, 0], \"rotate\": [0, 90, 0], \"scale\": 0.5},\n"
               "   {\"tree\": \"b\", \"matrix\": [1, 0, 0, 3, 0, -1, 0, 0, 0, 0.5, 1, 0]},\n"
               "   {\"tree\": \"b\", \"scale\": [1, 2, 0.5],\n"
               "    \"copies\": {\"count\": [2, 3, 4], \"step\": [4, 3, 2], \"rotate\": [0, 10, 0]}}],\n"
               " \"lights\": [{\"direction\": [1, 1, 0], \"color\": [1, 0.9, 0.8], \"shadows\": false}],\n"
               " \"occlusion_range\": 2}\n");
    cJSON *document = run_json("$SVOCL render models/scene.json -o a.png --size 32x24 --json");
    assert_int_equal((int)number_of(document, "instances"), 26);
    assert_int_equal((int)number_of(document, "trees"), 2);
    assert_true(number_of(document, "device_bytes") > 0);
    cJSON_Delete(document);
    run_well("$SVOCL render models/scene.json -o b.png --size 32x24 && cmp a.png b.png");
    static const char *const written[] = {"a.png", "b.png", "models"};
    run_well("rm -r models/*");
    run_well("rmdir models");
    expect_files(written, 2);
}

/* A scene of two trees. form: NULL for none; second: the path of the second tree. */
static void write_forms(const char *form, const char *second)
{
    char key[64] = "";
    char text[512];
    if (form != NULL) {
        snprintf(key, sizeof key, "\"form\": \"%s\",", form);
    }
    snprintf(
        text, sizeof text,
        "{%s \"trees\": {\"a\": {\"path\": \"knot.svo\"}, \"b\": {\"path\": \"%s\", \"depth\": 3}},\n"
        " \"instances\": [{\"tree\": \"a\", \"rotate\": [0, 30, 0]}, {\"tree\": \"b\", \"translate\": [2, 0, 0]}]}",
        key, second);
    write_text("scene.json", text);
}

/* The bytes of device memory of a scene, whose picture must be that of the built trees. */
static double render_form(const char *form)
{
    cJSON *document = run_json("$SVOCL render scene.json -o b.png --size 32x24 --json");
    const double bytes = number_of(document, "device_bytes");
    assert_string_equal(cJSON_GetObjectItem(document, "form")->valuestring, form);
    cJSON_Delete(document);
    run_well("cmp a.png b.png");
    return bytes;
}

/* A picture shows the same whatever holds the trees, and every form takes its own number of bytes. */
static void trees_are_held_in_the_form_that_is_asked_for(void **state)
{
    (void)state;
    static const char *const forms[] = {"descriptor", "implied", "shared", "mirrored"};
    need_builds();
    run_well("$SVOCL build scene:knot:500 -d 4 -o knot.svo");
    write_forms("built", "scene:statue:500");
    run_well("$SVOCL render scene.json -o a.png --size 32x24");
    write_forms(NULL, "scene:statue:500");
    double bytes[5] = {render_form("built")};
    for (size_t i = 1; i < 5; ++i) {
        write_forms(forms[i - 1], "scene:statue:500");
        bytes[i] = render_form(forms[i - 1]);
        for (size_t k = 0; k < i; ++k) {
            if (bytes[k] == bytes[i]) {
                fail_msg("%s takes the %.0f bytes of another form", forms[i - 1], bytes[i]);
                return;
            }
        }
    }
    assert_true(bytes[2] < bytes[0]); /* implied */
    static const char *const written[] = {"a.png", "b.png", "knot.svo", "scene.json"};
    expect_files(written, 4);
}

/* A compact file, here a solid, is one of the scene's trees, whether it has the scene's form or another. */
static void paths_may_be_compact_files(void **state)
{
    (void)state;
    static const char *const forms[] = {"built", "descriptor", "implied"};
    need_builds();
    run_well("$SVOCL build scene:knot:500 -d 4 -o knot.svo");
    run_well("$SVOCL build scene:statue:500 -d 3 --need color,normal,rays --solid winding -o statue.svc");
    write_forms(NULL, "statue.svc");
    run_well("$SVOCL render scene.json -o a.png --size 32x24");
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; ++i) {
        write_forms(forms[i], "statue.svc");
        (void)render_form(forms[i]);
    }
    run_well("$SVOCL build scene:cube -d 3 --need rays --solid winding -o bare.svc");
    write_forms("implied", "bare.svc");
    run_badly("$SVOCL render scene.json -o b.png", 1,
              "scene.json:1: the nodes of tree 'b' are alike in color, normal, material and fill, and those of 'a' are "
              "not; form 'implied' cannot hold both");
    run_well("printf x > statue.svc");
    write_forms("implied", "statue.svc");
    run_badly("$SVOCL render scene.json -o b.png", 1, "statue.svc");
    static const char *const written[] = {"a.png", "b.png", "bare.svc", "knot.svo", "scene.json", "statue.svc"};
    expect_files(written, 6);
}

static void a_wrong_file_is_one_line_with_its_place(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } wrong[] = {
        {"", "scene.json:1: not JSON"},
        {"{\n" TREES ",\n" INSTANCES ",\n}\n", "scene.json:4: not JSON at column 1, '}'"},
        {"{\n" TREES ",\n\n" INSTANCES ",\n\"camra\": {}}", "scene.json:5: key 'camra' of the scene is none of"},
        {"{\n" TREES ",\n\n" INSTANCES ",\n\"camra\": {}}", "did you mean 'camera'?"},
        {"{\"a\\\"\\n{\": 1,\n" TREES "}", "scene.json:1: key 'a"},
        {"{" TREES "}", "scene.json:1: 'instances' is missing"},
        {"{" INSTANCES "}", "scene.json:1: 'trees' is missing"},
        {"{\n" TREES ",\n" TREES "}", "scene.json:3: a second 'trees'"},
        {"{\"trees\":\n{\"a\":\n{\"depth\": 3}}}", "scene.json:2: tree 'a' has no 'path'"},
        {"{\"trees\": {\"a\":\n\n{\"path\": \"x\",\n\"depth\": 17}}}", "scene.json:4: 'depth' is not a whole number"},
        {"{\"trees\": {\"a\": {\"path\": 7}}}", "scene.json:1: 'path' is not a text"},
        {"{" TREES ",\n\"instances\": [\n{\"tree\": \"cub\"}]}",
         "scene.json:3: no tree is called 'cub', did you mean 'cube'?"},
        {"{" TREES ",\n\"instances\": [7]}", "scene.json:2: an instance is not an object"},
        {"{" TREES ",\n\"instances\": [\n{\"tree\": \"cube\",\n\n\"matrix\": [1, 2]}]}",
         "scene.json:5: 'matrix' is not an array of 12 numbers"},
        {"{" TREES ",\"instances\": [{\"tree\": \"cube\", \"matrix\": [1,0,0,0,\n0,1,0,0,\n0,0,1,1e999]}]}",
         "scene.json:3: number 12 of 'matrix'"},
        {"{" TREES ",\"instances\": [{\"tree\": \"cube\", \"scale\": \"big\"}]}", "scene.json:1: 'scale' is not"},
        {"{" TREES ",\"instances\": [{\"tree\": \"cube\",\n\"scale\": 1,\n\"matrix\": [1,0,0,0,0,1,0,0,0,0,1,0]}]}",
         "scene.json:2: 'scale' beside 'matrix'"},
        {"{" TREES ",\"instances\": [{\"tree\": \"cube\", \"copies\": {\"count\": [16777216, 16777216, 1]}}]}",
         "scene.json:1: more than 16777216 instances"},
        {"{" TREES ",\"instances\": [{\"tree\": \"cube\", \"motion\": []}]}", "'motion' is not an array of keys"},
        {"{" TREES ",\"instances\": [{\"tree\": \"cube\", \"motion\": [{\"scale\": 2}]}]}", "'time' is missing"},
        {"{" TREES ",\"instances\": [{\"tree\": \"cube\", \"motion\": [{\"time\": 1}, {\"time\": 1}]}]}",
         "'time' is not above that of the key before"},
        {"{" TREES ",\"instances\": [{\"tree\": \"cube\", \"scale\": 2, \"motion\": [{\"time\": 1}]}]}",
         "key 'scale' of an instance with 'motion'"},
        {"{" TREES ",\"instances\": [{\"tree\": \"cube\", \"copies\": {\"count\": [0, 1, 1]}}]}",
         "'count' is not a whole number in 1 .."},
        {"{" TREES "," INSTANCES ",\n\"camera\": {\"eye\": [0, 0, 1]}}", "scene.json:2: 'camera' has no 'eye' or no"},
        {"{" TREES "," INSTANCES ",\n\"camera\": {\"eye\": [0, 0, 1], \"target\": [0, 0, 0], \"fov\": 180}}",
         "scene.json:2: 'fov' is not an angle"},
        {"{" TREES "," INSTANCES ",\n\"camera\": {\"eye\": [0, 0, 1],\n\"target\": [0, 0, 1]}}",
         "scene.json:3: 'target' is where 'eye' is"},
        {"{" TREES "," INSTANCES ",\n\"camera\": {\"eye\": [0, 0, 1], \"target\": [0, 0, 0],\n\"up\": [0, 0, 7]}}",
         "scene.json:3: 'up' is 0 or along the line of sight"},
        {"{" TREES "," INSTANCES ",\n\"camera\": {\"eye\": [0, 1, 0], \"target\": [0, 0, 0]}}",
         "scene.json:2: 'up' is 0 or along the line of sight"},
        {"{" TREES "," INSTANCES ",\n\"camera\": {\"eye\": [0, 0, 1], \"target\": [0, 0, 0],\n\"up\": [0, 0, 0]}}",
         "scene.json:3: 'up' is 0 or along the line of sight"},
        {"{" TREES "," INSTANCES ",\n\"camera\": {\"eye\": [0, 0, 1],\n\"target\": [0, \"1\", 0]}}",
         "scene.json:3: number 2 of 'target' is not a number"},
        {"{" TREES "," INSTANCES ",\n\"camera\": {\"eye\": [0, 0, 1],\n\"target\": [0, 0, 0],\n\"roll\": 1}}",
         "scene.json:4: key 'roll' of 'camera' is none of"},
        {"{" TREES "," INSTANCES ",\"lights\": [\n{\"direction\": [0, 1, 0]},\n{\"direction\": [0, 0, 0]}]}",
         "scene.json:3: 'direction' is 0, 0, 0"},
        {"{" TREES "," INSTANCES ",\"lights\": [\n{\"direction\": [0, 1, 0],\n\"color\": [1, 0.5, -0.1]}]}",
         "scene.json:3: 'color' has a number below 0"},
        {"{" TREES "," INSTANCES ",\"lights\": [\n{\"direction\": [0, 1, 0],\n\"color\": [1, 0.5, 1e39]}]}",
         "scene.json:3: number 3 of 'color' is not a number within the range of floats"},
        {"{" TREES "," INSTANCES ",\"lights\": [\n{\"direction\": [0, 1, 0],\n\"colour\": [1, 1, 1]}]}",
         "scene.json:3: key 'colour' of a light is none of"},
        {"{" TREES "," INSTANCES ",\n\"form\": \"implid\"}",
         "scene.json:2: 'form' is none of built, descriptor, implied, shared, mirrored, did you mean 'implied'?"},
        {"{" TREES "," INSTANCES ",\n\"form\": 7}", "scene.json:2: 'form' is none of built"},
        {"{" TREES ",\"instances\": [\n{\"tree\": \"cube\",\n\"scale\": [1, 0, 1]}]}",
         "scene.json:3: 'scale' is 0 along an axis"},
        {"{" TREES "," INSTANCES ",\"lights\": [\n{\"shadows\": 1}]}", "scene.json:2: the light has no 'direction'"},
        {"{" TREES "," INSTANCES ",\"lights\": [\n{\"direction\": [0, 1, 0], \"shadows\": 1}]}",
         "scene.json:2: 'shadows' is not true or false"},
        {"{" TREES "," INSTANCES ",\"occlusion_range\": -1}", "scene.json:1: 'occlusion_range' is not above 0"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        write_text("scene.json", wrong[i].text);
        run_badly("$SVOCL render scene.json -o a.png", 1, wrong[i].words);
    }
    run_badly("$SVOCL render none.json -o a.png", 1, "none.json: No such file");
    run_badly("$SVOCL render scene.json -o a.png --view steps", 2, "--view does not apply to a scene");
    static const char *const written[] = {"scene.json"};
    expect_files(written, 1);
}

static void what_the_library_refuses_names_the_place(void **state)
{
    (void)state;
    need_builds();
    write_text("scene.json", "{" TREES ",\"instances\": [\n{\"tree\": \"cube\", \"copies\": {\"count\": [3, 1, 1]}},\n"
                             "{\"tree\": \"cube\",\n\"matrix\": [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0]}]}");
    run_badly("$SVOCL render scene.json -o a.png", 1, "scene.json:4: 'matrix' is flat");
    write_text("scene.json", "{" TREES ",\"instances\": [\n{\"tree\": \"cube\"},\n"
                             "{\"tree\": \"cube\", \"translate\": [1e31, 0, 0]},\n{\"tree\": \"cube\"}]}");
    run_badly("$SVOCL render scene.json -o a.png", 1,
              "scene.json:3: the matrix of instance 1 or its inverse leads beyond 2^100");
    write_text("scene.json", "{\"trees\": {\"a\": {\"path\": \"none.svo\"}}, \"instances\": [{\"tree\": \"a\"}]}");
    run_badly("$SVOCL render scene.json -o a.png", 1, "none.svo");
    static const char *const written[] = {"scene.json"};
    expect_files(written, 1);
}

TEST_GROUP(scene_file)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(scenes_are_rendered), IN_FOLDER(trees_are_held_in_the_form_that_is_asked_for),
        IN_FOLDER(paths_may_be_compact_files), IN_FOLDER(a_wrong_file_is_one_line_with_its_place),
        IN_FOLDER(what_the_library_refuses_names_the_place)};
    return cmocka_run_group_tests_name("scene_file", tests, NULL, NULL);
}
