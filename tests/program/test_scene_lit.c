/* SPDX-License-Identifier: MIT */
/* Scenes lit by cones: svocl render SCENE.json --view full and svocl gather: all that is placed becomes one tree. */
#include "program_picture.h"
#include "run_program.h"
#include "support/suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CAMERA "\"camera\": {\"eye\": [0, 0, 6], \"target\": [0, 0, 0], \"fov\": 50}"

/* A placed tree that did not move is the tree: the pictures have the same bytes. */
static void what_does_not_move_looks_the_same(void **state)
{
    (void)state;
    static const char *const views[] = {"full", "ao", "direct", "gi"};
    need_builds();
    write_text("one.json", "{\"trees\": {\"k\": {\"path\": \"scene:knot:500\"}}, \"instances\": [{\"tree\": \"k\"}]}");
    for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i) {
        char line[256];
        snprintf(line, sizeof line, "$SVOCL render one.json -q -d 5 --view %s --size 32x24 -o a.png", views[i]);
        run_well(line);
        snprintf(line, sizeof line, "$SVOCL render scene:knot:500 -q -d 5 --view %s --size 32x24 -o b.png", views[i]);
        run_well(line);
        run_well("cmp a.png b.png");
    }
    run_well("rm a.png b.png one.json");
}

/* ---- places ---- */

static void write_triangle(void)
{
    write_text("t.obj", "v 0.5 -1 0\nv 2 -1 0\nv 0.5 1.5 0\nf 1 2 3\n");
}

static program_picture picture_of(const char *instances)
{
    char text[512];
    snprintf(text, sizeof text,
             "{\"trees\": {\"t\": {\"path\": \"t.obj\"}}, \"instances\": [%s], %s,\n \"lights\": [{\"direction\": [0, "
             "0, 1]}]}",
             instances, CAMERA);
    write_text("scene.json", text);
    run_well("$SVOCL render scene.json -q -d 6 --view direct --size 48x48 -o a.png");
    program_picture picture = read_picture("a.png");
    run_well("rm a.png scene.json");
    return picture;
}

/* Pixels of one picture whose place in the other, mirrored along x or turned by half, is covered otherwise. */
static int differing(const program_picture *a, const program_picture *b, bool turned)
{
    int count = 0;
    for (int y = 0; y < a->height; ++y) {
        for (int x = 0; x < a->width; ++x) {
            const uint8_t *one = pixel_of(a, x, y);
            const uint8_t *other = pixel_of(b, a->width - 1 - x, turned ? a->height - 1 - y : y);
            count += abs(one[0] - other[0]) > 8 ? 1 : 0;
        }
    }
    return count;
}

static void instances_are_where_they_are_placed(void **state)
{
    (void)state;
    need_builds();
    write_triangle();
    program_picture plain = picture_of("{\"tree\": \"t\"}");
    program_picture mirrored = picture_of("{\"tree\": \"t\", \"scale\": [-1, 1, 1]}");
    program_picture turned = picture_of("{\"tree\": \"t\", \"rotate\": [0, 0, 180]}");
    program_picture both =
        picture_of("{\"tree\": \"t\"}, {\"tree\": \"t\", \"matrix\": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}");
    assert_in_range(differing(&plain, &mirrored, false), 0, 4);
    assert_in_range(differing(&plain, &turned, true), 0, 4);
    assert_in_range(differing(&both, &both, false), 0, 4);
    assert_true(differing(&plain, &plain, false) > 100);
    assert_true(differing(&plain, &both, false) > 100);
    free_picture(&plain);
    free_picture(&mirrored);
    free_picture(&turned);
    free_picture(&both);
    run_well("rm t.obj");
}

/* ---- voxels ---- */

static int count_of(const char *name)
{
    cJSON *document = run_json("$SVOCL render scene.json -d 5 --view ao --cones 5 --size 16x16 -o a.png --json");
    const int count = (int)number_of(document, name);
    cJSON_Delete(document);
    return count;
}

/* A finished tree shows the faces of its voxels, which svocl convert counts too; a mesh its triangles. */
static void finished_trees_show_their_voxels(void **state)
{
    (void)state;
    static const char *const inputs[] = {"k.svo", "k.svc"};
    need_builds();
    run_well("$SVOCL build scene:knot:300 -d 4 -o k.svo -q && $SVOCL convert k.svo k.obj -q");
    run_well("$SVOCL build scene:knot:300 -d 4 --need color,normal,rays --solid winding -o k.svc -q");
    for (size_t i = 0; i < sizeof inputs / sizeof inputs[0]; ++i) {
        char text[256];
        snprintf(text, sizeof text,
                 "{\"trees\": {\"k\": {\"path\": \"%s\"}, \"c\": {\"path\": \"scene:cube\"}},\n"
                 " \"instances\": [{\"tree\": \"k\", \"copies\": {\"count\": [3, 1, 1], \"step\": [4, 0, 0]}},"
                 " {\"tree\": \"c\"}]}",
                 inputs[i]);
        write_text("scene.json", text);
        if (i == 1) {
            run_well("$SVOCL convert k.svc k.svo -q && $SVOCL convert k.svo k.obj -q");
        }
        const int triangles = count_of("triangles");
        snprintf(text, sizeof text, "test $(grep -c ^f k.obj) -eq %d", (triangles - 12) / 6);
        run_well(text);
    }
    assert_int_equal(count_of("instances"), 4);
    assert_int_equal(count_of("trees"), 2);
    assert_int_equal(count_of("depth"), 5);
    assert_true(count_of("tree_bytes") > 0 && count_of("lit_leaves") > 0);
    run_well("rm a.png k.svo k.svc k.obj scene.json");
}

/* ---- light ---- */

/* The scene's own lights, in units of what a white surface shows, its camera, and what --lights says instead. */
static void scenes_have_lights_and_cameras(void **state)
{
    (void)state;
    need_builds();
    write_triangle();
#define SCENE "{\"trees\": {\"t\": {\"path\": \"t.obj\"}}, \"instances\": [{\"tree\": \"t\"}], "
    write_text("own.json", SCENE CAMERA ", \"lights\": [{\"direction\": [0.5, 0, 2], \"color\": [1, 0.5, 0.25]}]}");
    write_text("bare.json", SCENE CAMERA "}");
    write_text("lights.json", "{\"lights\": [{\"kind\": \"directional\", \"direction\": [-0.5, 0, -2],\n"
                              "  \"value\": [3.14159265, 1.570796325, 0.7853981625]}], \"sky\": [0.42, 0.52, 0.66]}");
#define RENDER(input) "$SVOCL render " input " -q -d 5 --view full --size 24x24 "
    run_well(RENDER("own.json") "-o a.png && " RENDER("bare.json") "--lights lights.json -o b.png && cmp a.png b.png");
    run_well(RENDER("own.json") "--lights lights.json -o b.png && cmp a.png b.png");
    run_well(RENDER("bare.json") "-o b.png");
    run_well("! cmp -s a.png b.png");
    cJSON *document = run_json("$SVOCL gather own.json -d 5 --cones 16 --points 20 --reference 64 -o a.csv --json");
    assert_true(number_of(document, "photon_hits") > 0);
    assert_int_equal((int)number_of(document, "triangles"), 1);
    assert_float_equal(number_of(document, "ao"), 1, 0.02);
    cJSON_Delete(document);
#undef RENDER
#undef SCENE
    run_well("rm a.png b.png a.csv own.json bare.json lights.json t.obj");
}

static uint8_t middle_of(const char *scene_text)
{
    write_text("scene.json", scene_text);
    run_well("$SVOCL render scene.json -q -d 5 --view direct --size 24x24 -o a.png");
    program_picture picture = read_picture("a.png");
    const uint8_t red = pixel_of(&picture, 12, 12)[0];
    free_picture(&picture);
    return red;
}

/* Beside a part with a material, one without colors stays clay. */
static void parts_without_colors_are_clay(void **state)
{
    (void)state;
    need_builds();
    write_text("m.mtl", "newmtl red\nKd 1 0 0\n");
    write_text("red.obj", "mtllib m.mtl\nusemtl red\nv 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nf 1 2 3\n");
    write_text("clay.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
#define TREES  "{\"trees\": {\"c\": {\"path\": \"clay.obj\"}, \"r\": {\"path\": \"red.obj\"}}, \"instances\": ["
#define LIGHTS "], " CAMERA ", \"lights\": [{\"direction\": [0, 0, 1], \"color\": [0.5, 0.5, 0.5]}]}"
    const uint8_t alone =
        middle_of("{\"trees\": {\"c\": {\"path\": \"clay.obj\"}}, \"instances\": [{\"tree\": \"c\"}" LIGHTS);
    const uint8_t beside = middle_of(TREES "{\"tree\": \"c\"}, {\"tree\": \"r\", \"translate\": [1.5, 1, 0]}" LIGHTS);
    const uint8_t red = middle_of(TREES "{\"tree\": \"c\", \"translate\": [9, 0, 0]}, {\"tree\": \"r\", \"scale\": 9,"
                                        " \"translate\": [-0.9, -0.9, 0]}" LIGHTS);
#undef TREES
#undef LIGHTS
    assert_true(alone > 100 && alone < 200);
    assert_in_range(beside, alone - 1, alone + 1);
    assert_true(red > alone + 10);
    run_well("rm a.png scene.json m.mtl red.obj clay.obj");
}

static void what_cannot_be_lit_is_one_line(void **state)
{
    (void)state;
    need_builds();
    write_text("many.json", "{\"trees\": {\"k\": {\"path\": \"scene:knot:20000\"}},\n"
                            " \"instances\": [{\"tree\": \"k\", \"copies\": {\"count\": [100, 10, 1]}}]}");
    run_badly("$SVOCL render many.json --view full -o a.png", 1,
              "triangles are above 16777216, the most that views of light take");
    write_text("none.json", "{\"trees\": {\"k\": {\"path\": \"none.obj\"}}, \"instances\": [{\"tree\": \"k\"}]}");
    run_badly("$SVOCL render none.json --view full -o a.png", 1, "none.obj");
    write_text("wrong.json", "{\"trees\": {\"k\": {\"path\": \"none.obj\"}},\n \"instances\": [{\"tree\": \"q\"}]}");
    run_badly("$SVOCL gather wrong.json --points 3 -o a.csv", 1, "wrong.json:2: no tree is called 'q'");
    write_text("flat.json", "{\"trees\": {\"k\": {\"path\": \"scene:knot:500\"}}, \"instances\": [\n"
                            "{\"tree\": \"k\", \"matrix\": [1, 1, 0, 0, 0, 1e-13, 0, 0, 0, 0, 1, 0]}]}");
    run_badly("$SVOCL render flat.json --view direct -o a.png", 1, "flat.json:2: 'matrix' is flat");
    static const char *const written[] = {"many.json", "none.json", "wrong.json", "flat.json"};
    expect_files(written, 4);
}

TEST_GROUP(scene_lit)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(what_does_not_move_looks_the_same), IN_FOLDER(instances_are_where_they_are_placed),
        IN_FOLDER(finished_trees_show_their_voxels),  IN_FOLDER(scenes_have_lights_and_cameras),
        IN_FOLDER(parts_without_colors_are_clay),     IN_FOLDER(what_cannot_be_lit_is_one_line)};
    return cmocka_run_group_tests_name("scene_lit", tests, NULL, NULL);
}
