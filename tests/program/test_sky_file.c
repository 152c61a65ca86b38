/* SPDX-License-Identifier: MIT */
/*
 * Skies of files of lights: gradients and pictures, as pictures show them and as points are lit by them, beside the
 * reference; whatever is wrong with them is one line with its place.
 */
#include "program_picture.h"
#include "run_program.h"
#include "support/suite.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI      3.14159265358979323846
#define COLUMNS 8
#define ROWS    4

/* ---- files ---- */

static void write_bytes(const char *path, const void *bytes, size_t count)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, count, file), count);
    assert_int_equal(fclose(file), 0);
}

/* A texel: red is its column, green its row, from 1 on; blue is 1. */
static void make_texel(uint8_t texel[4], int column, int row)
{
    texel[0] = (uint8_t)(16 * (column + 1));
    texel[1] = (uint8_t)(16 * (row + 1));
    texel[2] = 16;
    texel[3] = 136 - 4; /* a byte of 16 is 1 */
}

/* Packed or not, with an exposure. */
static void write_hdr(const char *path, bool is_packed, int exposure)
{
    uint8_t bytes[1024];
    size_t count = (size_t)snprintf((char *)bytes, sizeof bytes,
                                    "#?RADIANCE\n# a test\nEXPOSURE=%d\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n",
                                    exposure, ROWS, COLUMNS);
    for (int row = 0; row < ROWS; ++row) {
        uint8_t texels[COLUMNS][4];
        for (int column = 0; column < COLUMNS; ++column) {
            make_texel(texels[column], column, row);
        }
        if (!is_packed) {
            memcpy(bytes + count, texels, sizeof texels);
            count += sizeof texels;
            continue;
        }
        memcpy(bytes + count, (const uint8_t[]){2, 2, 0, COLUMNS}, 4);
        count += 4;
        for (int channel = 0; channel < 4; ++channel) {
            if (channel > 0) { /* all alike */
                bytes[count++] = 128 + COLUMNS;
                bytes[count++] = texels[0][channel];
                continue;
            }
            bytes[count++] = COLUMNS;
            for (int column = 0; column < COLUMNS; ++column) {
                bytes[count++] = texels[column][channel];
            }
        }
    }
    write_bytes(path, bytes, count);
}

static void wrong_skies_are_one_line_with_their_place(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } wrong[] = {
        {"{\n\"sky\": 7}", "lights.json:2: 'sky' is neither an array of 3 numbers, a gradient nor a picture"},
        {"{\"sky\": [1, 2]}", "lights.json:1: 'sky' is not an array of 3 numbers"},
        {"{\"sky\": {\n\"zenit\": [1, 1, 1]}}",
         "lights.json:2: key 'zenit' of a gradient of the sky is none of zenith, horizon, ground, did you mean"},
        {"{\"sky\": {\"zenith\": [1, 1, 1], \"horizon\": [1, 1, 1]}}",
         "lights.json:1: a gradient of the sky has no 'ground'"},
        {"{\"sky\": {\"zenith\": [1, 1, 1], \"horizon\": [1,\n-1, 1], \"ground\": [0, 0, 0]}}",
         "lights.json:2: number 2 of 'horizon' is -1, below 0"},
        {"{\"sky\": {\"file\": 3}}", "lights.json:1: 'file' is not a text"},
        {"{\"sky\": {\"file\": \"a.hdr\",\n\"scales\": 1}}",
         "lights.json:2: key 'scales' of a picture of the sky is none of file, scale, turn, did you mean 'scale'?"},
        {"{\"sky\": {\"file\": \"a.hdr\",\n\"scale\": -1}}",
         "lights.json:2: 'scale' is not a number within 0 .. 1e+30"},
        {"{\"sky\": {\"file\": \"a.hdr\",\n\"turn\": true}}", "lights.json:2: 'turn' is not a number within"},
        {"{\"sky\": {\"file\":\n\"none.hdr\"}}", "lights.json:1: 'file' none.hdr: No such file or directory"},
        {"{\"sky\": {\"file\": \"lights.json\"}}", "lights.json:1: 'file' lights.json: not a Radiance .hdr file"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        write_text("lights.json", wrong[i].text);
        run_badly("$SVOCL gather scene:cube -d 2 --points 1 --lights lights.json -o a.csv", 1, wrong[i].words);
    }
    run_well("rm lights.json");
}

static void damaged_pictures_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } wrong[] = {{"#?RADIANCE\n", "it ends in its head"},
                 {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd", "its format is '32-bit_rle_xyze'"},
                 {"#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\nabcd", "its exposure is not above 0"},
                 {"#?RADIANCE\n\n+Y 1 +X 1\nabcd", "its size is '+Y 1 +X 1', not '-Y HEIGHT +X WIDTH'"},
                 {"#?RADIANCE\n\n-Y 1 +X 8193\nabcd", "8193 x 1 texels are not within 1 x 1 .. 8192 x 4096"},
                 {"#?RADIANCE\n\n-Y 2 +X 1\nabcd", "it ends too early"},
                 {"#?RADIANCE\n\n-Y 1 +X 8\n\2\2", "it ends too early"},
                 {"#?RGBE\n\n-Y 1 +X 2\nabcd\1\1\1\3", "its rows are packed in an old way"}};
    write_text("lights.json", "{\"sky\": {\"file\": \"a.hdr\"}}");
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        write_text("a.hdr", wrong[i].text);
        run_badly("$SVOCL gather scene:cube -d 2 --points 1 --lights lights.json -o a.csv", 1, wrong[i].words);
    }
    /* Runs of no bytes, and beyond the row's end. */
    static const uint8_t lengths[] = {0, 9, 128 + 9};
    for (size_t i = 0; i < sizeof lengths; ++i) {
        static const char head[] = "#?RADIANCE\n\n-Y 1 +X 8\n";
        const uint8_t row[16] = {2, 2, 0, 8, lengths[i], 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
        uint8_t bytes[sizeof head - 1 + sizeof row];
        memcpy(bytes, head, sizeof head - 1);
        memcpy(bytes + sizeof head - 1, row, sizeof row);
        write_bytes("a.hdr", bytes, sizeof bytes);
        run_badly("$SVOCL gather scene:cube -d 2 --points 1 --lights lights.json -o a.csv", 1,
                  "lights.json:1: 'file' a.hdr: a row of it is damaged");
    }
    write_hdr("a.hdr", true, 1);
    write_text("lights.json", "{\"sky\": {\"file\": \"a.hdr\",\n\"scale\": 1e30}}");
    run_well("$SVOCL gather scene:cube -d 2 --points 1 --lights lights.json -o a.csv -q");
    run_well("rm a.hdr a.csv lights.json");
}

/* ---- pictures ---- */

/* The light in the middle of a picture of what is outside, along a direction. */
static void look(const char *sky, const double direction[3], double light[3])
{
    char text[512];
    int width = 0;
    int height = 0;
    snprintf(text, sizeof text,
             "{\"sky\": %s,\n \"camera\": {\"eye\": [50, 50, 50], \"at\": [%.9g, %.9g, %.9g], \"up\": [0.1, 1, 0], "
             "\"fov\": 0.5}}",
             sky, 50 + direction[0], 50 + direction[1], 50 + direction[2]);
    write_text("lights.json", text);
    run_well("$SVOCL render scene:cube -d 2 --view full --lights lights.json --size 3x3 -o look.hdr -q");
    float *pixels = read_light("look.hdr", &width, &height);
    assert_int_equal(width, 3);
    for (int channel = 0; channel < 3; ++channel) {
        light[channel] = (double)pixels[4 * 4 + channel];
    }
    free(pixels);
    run_well("rm look.hdr lights.json");
}

static void check_near(const char *what, double value, double expected, double bound)
{
    if (!(fabs(value - expected) <= bound)) {
        fail_msg("%s is %g instead of %g, within %g", what, value, expected, bound);
    }
}

static void gradients_go_from_the_zenith_to_the_ground(void **state)
{
    (void)state;
    need_builds();
    static const char sky[] = "{\"zenith\": [1, 0.5, 4], \"horizon\": [0.5, 0.5, 1], \"ground\": [0.25, 0, 0.5]}";
    static const double heights[] = {0.99, 0.5, 0.1, 0, -0.3, -0.9};
    for (size_t i = 0; i < sizeof heights / sizeof heights[0]; ++i) {
        const double h = heights[i];
        const double flat = sqrt(1 - h * h);
        const double direction[3] = {flat * 0.6, h, flat * 0.8};
        double light[3];
        look(sky, direction, light);
        check_near("red", light[0], h > 0 ? 0.5 + 0.5 * h : 0.5 + 0.25 * h, 0.02);
        check_near("green", light[1], h > 0 ? 0.5 : 0.5 + 0.5 * h, 0.02);
        check_near("blue", light[2], h > 0 ? 1 + 3 * h : 1 + 0.5 * h, 0.04);
    }
}

/* Where the camera looks at a texel's center it sees its value, times scale; turned maps a quarter to the right. */
static void pictures_are_seen_from_inside(void **state)
{
    (void)state;
    need_builds();
    static const struct {
        const char *sky;
        double scale;
        int turn; /* columns to the right */
    } cases[] = {{"{\"file\": \"sky.hdr\"}", 1, 0},
                 {"{\"file\": \"sky.hdr\", \"scale\": 2.5, \"turn\": 90}", 2.5, 2},
                 {"{\"file\": \"sky.hdr\", \"turn\": -405}", 1, -1},
                 {"{\"file\": \"packed.hdr\"}", 0.25, 0}};
    write_hdr("sky.hdr", false, 1);
    write_hdr("packed.hdr", true, 4); /* an exposure of 4 makes what is stored four times too bright */
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        for (int row = 1; row < 3; ++row) {
            const int column = 3 * row - 1;
            const double turn = 2 * PI * ((column + 0.5) / COLUMNS - 0.5);
            const double polar = PI * (row + 0.5) / ROWS;
            const double direction[3] = {sin(polar) * sin(turn), cos(polar), -sin(polar) * cos(turn)};
            const int from = (column - cases[i].turn + 2 * COLUMNS) % COLUMNS;
            double light[3];
            look(cases[i].sky, direction, light);
            check_near("red", light[0] / cases[i].scale, from + 1, 0.05);
            check_near("green", light[1] / cases[i].scale, row + 1, 0.05);
            check_near("blue", light[2] / cases[i].scale, 1, 0.01);
        }
    }
    run_well("rm sky.hdr packed.hdr");
}

#ifdef SVOCL_EXR

/* A picture of svocl render as a sky: each texel that a camera looks at is that of the file, one of red, green, blue
   and alpha. Where it ends early it is refused. */
static void exr_pictures_are_skies(void **state)
{
    (void)state;
    need_builds();
    static const char render[] = "$SVOCL render scene:cornell -d 3 --view full --exposure 1 --cones 5 --size 16x8 -q";
    char line[256];
    int width = 0, height = 0;
    snprintf(line, sizeof line, "%s --background transparent -o sky.exr", render);
    run_well(line);
    float *texels = read_light("sky.exr", &width, &height);
    assert_int_equal(width, 16);
    double brightest = 0;
    for (int row = 2; row < 6; row += 3) {
        for (int column = 4; column < 12; column += 3) {
            const double turn = 2 * PI * ((column + 0.5) / 16 - 0.5);
            const double polar = PI * (row + 0.5) / 8;
            const double direction[3] = {sin(polar) * sin(turn), cos(polar), -sin(polar) * cos(turn)};
            const float *texel = texels + 4 * (16 * row + column);
            double light[3];
            look("{\"file\": \"sky.exr\", \"scale\": 3}", direction, light);
            for (int channel = 0; channel < 3; ++channel) {
                const double wanted = 3 * (double)texel[channel];
                check_near("a channel", light[channel], wanted, 0.02 + 0.05 * wanted);
                brightest = fmax(brightest, wanted);
            }
        }
    }
    assert_true(brightest > 0.1);
    free(texels);
    write_text("lights.json", "{\"sky\": {\"file\": \"cut.exr\"}}");
    run_well("head -c 330 sky.exr >cut.exr");
    run_badly("$SVOCL gather scene:cube -d 2 --points 1 --lights lights.json -o a.csv", 1,
              "lights.json:1: 'file' cut.exr: ");
    write_text("cut.exr", "#?RADIANCE\n");
    run_badly("$SVOCL gather scene:cube -d 2 --points 1 --lights lights.json -o a.csv", 1,
              "lights.json:1: 'file' cut.exr: ");
    run_well("rm cut.exr sky.exr lights.json");
}

#else

static void exr_pictures_are_skies(void **state)
{
    (void)state;
    write_text("a.exr", "a");
    write_text("lights.json", "{\"sky\": {\"file\": \"a.exr\"}}");
    run_badly("$SVOCL gather scene:cube -d 2 --points 1 --lights lights.json -o a.csv", 1,
              "lights.json:1: 'file' a.exr: this program was built without OpenEXR (libopenexr-dev)");
    run_well("rm a.exr lights.json");
}

#endif

/* Paths are relative to the file of lights; points are lit as the reference says. */
static void points_are_lit_as_the_reference_says(void **state)
{
    (void)state;
    need_builds();
    static const struct {
        const char *sky;
        double most; /* RMSE of irradiance, as a share of its mean */
    } cases[] = {{"{\"zenith\": [0.2, 0.4, 1], \"horizon\": [1, 0.8, 0.6], \"ground\": [0.1, 0.1, 0.1]}", 0.02},
                 {"{\"file\": \"sky.hdr\", \"scale\": 0.2}", 0.03}};
    run_well("mkdir lights");
    write_hdr("lights/sky.hdr", true, 1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[256];
        snprintf(text, sizeof text, "{\"sky\": %s}", cases[i].sky);
        write_text("lights/lights.json", text);
        cJSON *document = run_json("$SVOCL gather scene:terrain:2000 -d 7 --points 60 --lights lights/lights.json "
                                   "--paths 1024 --bounces 2 --reference 1024 --range 0 --json -o a.csv");
        const double rmse = number_of(document, "irradiance_rmse");
        if (!(rmse > 0 && rmse < cases[i].most)) {
            fail_msg("%s: RMSE of irradiance %g, above %g", cases[i].sky, rmse, cases[i].most);
        }
        cJSON_Delete(document);
    }
    run_well("rm -r lights a.csv");
}

TEST_GROUP(sky_file)
{
    const struct CMUnitTest tests[] = {IN_FOLDER(wrong_skies_are_one_line_with_their_place),
                                       IN_FOLDER(damaged_pictures_are_refused),
                                       IN_FOLDER(gradients_go_from_the_zenith_to_the_ground),
                                       IN_FOLDER(pictures_are_seen_from_inside),
                                       IN_FOLDER(exr_pictures_are_skies),
                                       IN_FOLDER(points_are_lit_as_the_reference_says)};
    return cmocka_run_group_tests_name("sky_file", tests, NULL, NULL);
}
